"""What the page does in the browser alone: it says when nobody answers it any more.

A page whose server is gone still looks alive, and a file that is larger than a message may be
would break the connection without a word.
"""

from typing import Any

from bokeh.models import CustomJS

from .measured import LARGEST_FILE


_LOST = (
    "The connection to fascicle is lost: what you see no longer follows. Start it again and load"
    " this page anew, its address keeps the view."
)
_SAY = """
const say = (id, text) => {
  document.getElementById(id)?.remove();
  if (!text) return;
  const line = document.createElement("div");
  line.id = id; line.textContent = text; line.setAttribute("role", "alert");
  line.style.cssText = "position:fixed;inset:0 0 auto 0;z-index:9999;padding:8px 14px;"
    + "font:14px/1.4 var(--sans);color:var(--bad);background:var(--alarm);"
    + "border-bottom:2px solid var(--bad)";
  document.body.append(line);
};
"""
_GONE = _SAY + "say('lost', text);"
_BACK = _SAY + "say('lost', '');"
_SIZES = (
    _SAY
    + """
const read = FileReader.prototype.readAsDataURL;
FileReader.prototype.readAsDataURL = function (file) {
  say("size", "");
  if (file.size <= largest) return read.call(this, file);
  say("size", `${(file.name ?? "file").slice(-60)}: a file may have ${largest} bytes here, `
    + `got ${file.size}: thin it out, or use the command line.`);
};
"""
)


_PREFERS = """
const address = new URL(location);
if (matchMedia("(prefers-color-scheme: dark)").matches && !address.searchParams.has("theme")) {
  address.searchParams.set("theme", "dark");
  location.replace(address);
}
"""

# the address follows every change: as one entry of the history, so that Back leaves the page
_REPLACED = "history.pushState = history.replaceState;"

# the page's first key that moves goes to the tabs, and arrows from one to the next; from then on
# the keys go as the page reads: header, tabs, content
_TABS_FIRST = """
const sought = (at) => at.querySelector(".bk-tab.bk-active")
  ?? [...at.querySelectorAll("*")].reduce(
    (found, one) => found ?? (one.shadowRoot ? sought(one.shadowRoot) : null), null);
const deepest = (at) => at?.shadowRoot?.activeElement ? deepest(at.shadowRoot.activeElement) : at;
const aside = {ArrowRight: "nextElementSibling", ArrowLeft: "previousElementSibling"};
let first = true;
for (const kind of ["pointerdown", "focusin"])
  addEventListener(kind, () => { first = false; }, {capture: true, once: true});
addEventListener("keydown", (event) => {
  const here = deepest(document.activeElement);
  const there = event.key === "Enter" || event.key === " " ? here : here?.[aside[event.key]];
  if (here?.matches?.(".bk-tab") && there?.matches?.(".bk-tab")) {
    event.preventDefault();
    there.click();
    there.focus();
  }
  if (!first || event.key !== "Tab" || event.shiftKey) return;
  const tab = sought(document);
  if (!tab) return;
  event.preventDefault();
  tab.focus();
});
"""

# names for those who hear the page: its widgets show them, and don't say them
_NAMED = """
const name = (one, text) => { if (text && !one.ariaLabel) one.ariaLabel = text.trim(); };
const told = (one) => one.closest(".bk-input-group")?.querySelector(".bk-slider-title, label");
const look = (root) => {
  for (const handle of root.querySelectorAll(".noUi-handle"))
    name(handle, told(handle)?.textContent.replace(/:.*/s, ""));
  for (const spin of root.querySelectorAll(".bk-spin-btn"))
    name(spin, (spin.matches(".bk-spin-btn-up") ? "More: " : "Fewer: ") + told(spin)?.textContent);
  for (const tab of root.querySelectorAll(".bk-tab")) {
    const active = tab.matches(".bk-active");
    tab.role = "tab"; tab.ariaSelected = active; tab.tabIndex = active ? 0 : -1;
    tab.parentElement.role = "tablist";
  }
  // Bokeh has the tabs after what they show: keys and readers meet them before it
  const strip = [...root.children].find((one) => one.matches(".bk-header"));
  const shown = [...root.children].find((one) => one.shadowRoot);
  if (strip && shown && shown.compareDocumentPosition(strip) & Node.DOCUMENT_POSITION_FOLLOWING)
    shown.before(strip);
  for (const handle of root.querySelectorAll(".noUi-handle")) {
    // noUiSlider tells one decimal, whatever is shown
    const at = handle.closest(".noUi-target")?.noUiSlider?.get(true);
    const told = String(Number(Number(at).toPrecision(6)));
    for (const name of ["aria-valuenow", "aria-valuetext"])
      if (isFinite(at) && handle.getAttribute(name) !== told) handle.setAttribute(name, told);
  }
  for (const box of root.querySelectorAll("input[type=checkbox]"))
    name(box, box.nextElementSibling?.textContent);
};
const attach = Element.prototype.attachShadow;
Element.prototype.attachShadow = function (...given) {
  const root = attach.apply(this, given);
  new MutationObserver(() => look(root)).observe(
    root, {childList: true, subtree: true, attributes: true,
    attributeFilter: ["class", "aria-valuenow", "aria-valuetext"]});
  return root;
};
document.querySelector("[data-root-id]")?.setAttribute("role", "main");
"""


def attach(doc: Any, prefers: bool = False) -> None:
    """Let the page of a Bokeh document [-] say what it can't; and take the system's own preference
    of light or dark, where it `prefers` [-] that to an address that says nothing of it. Sliders and
    boxes get names that are read aloud. What is shown is one entry of the browser's history.
    """
    doc.js_on_event("document_ready", CustomJS(code=_NAMED))
    doc.js_on_event("document_ready", CustomJS(code=_REPLACED))
    doc.js_on_event("document_ready", CustomJS(code=_TABS_FIRST))
    if prefers:
        doc.js_on_event("document_ready", CustomJS(code=_PREFERS))
    doc.js_on_event("connection_lost", CustomJS(args={"text": _LOST}, code=_GONE))
    doc.js_on_event("client_reconnected", CustomJS(code=_BACK))
    doc.js_on_event("document_ready", CustomJS(args={"largest": LARGEST_FILE}, code=_SIZES))
