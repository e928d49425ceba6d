// What the page does in the browser alone. Argument: `largest` file in bytes.

// the address follows every change as one entry of the history, so that Back leaves the page
history.pushState = history.replaceState;

// a line at the top of the page, or none for an empty text; a `passing` one is good news
window.fascicleNotice = (id, text, passing = false) => {
  document.getElementById(id)?.remove();
  if (!text) return;
  const line = document.createElement("div"), color = passing ? "var(--good)" : "var(--bad)";
  line.id = id; line.textContent = text; line.setAttribute("role", passing ? "status" : "alert");
  line.style.cssText = "position:fixed;inset:0 0 auto 0;z-index:9999;padding:8px 14px;"
    + `font:14px/1.4 var(--sans);color:${color};border-bottom:2px solid ${color};`
    + `background:${passing ? "var(--raised)" : "var(--alarm)"}`;
  document.body.append(line);
  if (passing) setTimeout(() => line.remove(), 8000);
};
// the same view in other colors
window.fascicleTheme = (theme) => {
  const address = new URL(location);
  address.searchParams.set("theme", theme);
  location.assign(address);
};
// without the clipboard, which browsers give to this machine's pages and encrypted ones alone
window.fascicleCopy = () => {
  const local = /^(127\.|localhost$|\[::1\]$)/.test(location.hostname);
  const place = local ? "on this machine, while fascicle explore runs at this address"
    : "while fascicle explore runs at this address";
  const copied = () => fascicleNotice("copied", `Link copied. It opens ${place}.`, true);
  const show = () => prompt(`Link. It opens ${place}`, location.href);
  navigator.clipboard ? navigator.clipboard.writeText(location.href).then(copied, show) : show();
};
// Ctrl+Z and Ctrl+Y take back and repeat a change, but in a text that is being typed
addEventListener("keydown", (event) => {
  const key = event.key.toLowerCase();
  if (!(event.ctrlKey || event.metaKey) || !["z", "y"].includes(key)
      || deepest(document.activeElement)?.matches?.("input[type=text], textarea")) return;
  event.preventDefault();
  findButton(find(key === "y" || event.shiftKey ? ".redo" : ".undo"))?.click();
});
// a refused file is past with the next input
addEventListener("input", () => fascicleNotice("size", ""), {capture: true});

// a field in focus is not overwritten: what the server shows meanwhile comes when the focus leaves,
// and its answer to a text that was entered comes at once
const value = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value");
const guard = (input) => {
  if (Object.hasOwn(input, "value")) return;
  let entered = false, shown = null;
  input.addEventListener("change", () => { entered = true; shown = null; });
  input.addEventListener("blur", () => {
    if (shown !== null) value.set.call(input, shown);
    shown = null;
  });
  Object.defineProperty(input, "value", {
    get() { return value.get.call(this); },
    set(text) {
      if (!entered && this.getRootNode().activeElement === this) { shown = text; return; }
      entered = false;
      value.set.call(this, text);
    },
  });
};

// a file that is larger than a message may be would break the connection without a word
const read = FileReader.prototype.readAsDataURL;
FileReader.prototype.readAsDataURL = function (file) {
  fascicleNotice("size", "");
  if (file.size <= largest) return read.call(this, file);
  fascicleNotice("size", `${(file.name ?? "file").slice(-60)}: a file may have ${largest} bytes `
    + `here, got ${file.size}: thin it out, or use the command line.`);
};

// the first Tab key goes to the tabs, and arrows from one to the next; from then on keys follow the
// page as it reads: header, tabs, content
const find = (selector, root = document) => root.querySelector(selector)
  ?? [...root.querySelectorAll("*")].reduce(
    (found, node) => found ?? (node.shadowRoot ? find(selector, node.shadowRoot) : null), null);
const findActive = () => find(".bk-tab.bk-active");
const deepest = (node) =>
  node?.shadowRoot?.activeElement ? deepest(node.shadowRoot.activeElement) : node;
const sibling = {ArrowRight: "nextElementSibling", ArrowLeft: "previousElementSibling"};

// the story: its offer is shown until it is dismissed in this browser; the focus follows its buttons
// as they come and go; figures leave room for it
const findButton = (host) => find("button", host.shadowRoot ?? host);
const page = document.documentElement.style;
const SEEN = "fascicle-story";
let seen = null;
try { seen = localStorage.getItem(SEEN); } catch {}  // a browser may refuse its storage
page.setProperty("--offer", seen ? "none" : "flex");
window.fascicleDismiss = () => {
  try { localStorage.setItem(SEEN, "dismissed"); } catch {}
  page.setProperty("--offer", "none");
  findActive()?.focus();
};
// on a narrow page the scenes have room for the muscle, the curve and the sliders, all on the screen
const SCENE = {"--figure-height": "230px", "--scene-height": "190px", "--picture-order": "-1",
  "--pinned": "sticky", "--pinned-order": "1", "--aside": "none"};
const setScene = (running) => {
  page.setProperty("--reversal-order", running ? -1 : 0);  // before the figure of the force
  for (const [name, value] of Object.entries(SCENE))
    if (running && narrow.matches) page.setProperty(name, value);
    else page.removeProperty(name);
};
window.fascicleStory = (running, ifLost = false) => setTimeout(() => {
  setScene(running);
  if (ifLost && document.activeElement !== document.body) return;
  const next = running ? find(".story-next") : null;
  (next ? findButton(next) : findActive())?.focus({preventScroll: running});
}, 50);  // ms: the button is laid out by then
// a new scene's figure is in view: on a narrow page the tab's content is right below the story; its
// text, which comes some moments after the press, may change the story's height
const narrow = matchMedia("(max-width: 1000px)");
let pressTime = -Infinity;
const showFigure = () => {
  const tabs = find(".bk-header");
  if (narrow.matches) tabs?.nextElementSibling?.scrollIntoView({block: "start"});
  else tabs?.scrollIntoView({block: "nearest"});
};
window.fascicleTop = () => { pressTime = performance.now(); showFigure(); };
const height = new ResizeObserver(([story]) => {
  page.setProperty("--story", `${Math.ceil(story.borderBoxSize[0].blockSize)}px`);
  if (performance.now() - pressTime < 5000) showFigure();  // ms: longer than a text takes
});

// a tab that a key opened may draw the tabs anew: the focus stays on the open one
let keyed = false;
addEventListener("pointerdown", () => { keyed = false; }, {capture: true});

let first = true;
for (const kind of ["pointerdown", "focusin"])
  addEventListener(kind, () => { first = false; }, {capture: true, once: true});
addEventListener("keydown", (event) => {
  const here = deepest(document.activeElement);
  const there = event.key === "Enter" || event.key === " " ? here : here?.[sibling[event.key]];
  if (here?.matches?.(".bk-tab") && there?.matches?.(".bk-tab")) {
    event.preventDefault();
    there.click();
    there.focus();
    keyed = true;
  } else keyed &&= event.key !== "Tab";
  if (!first || event.key !== "Tab" || event.shiftKey) return;
  const offer = find(".offer");
  const target = offer?.checkVisibility() ? findButton(offer) : findActive();
  if (!target) return;
  event.preventDefault();
  target.focus();
});

// roles and names for screen readers, which Bokeh's widgets show but don't expose
const name = (node, text) => { if (text && !node.ariaLabel) node.ariaLabel = text.trim(); };
const labelOf = (node) =>
  node.closest(".bk-input-group")?.querySelector(".bk-slider-title, label");
const annotate = (root) => {
  for (const live of root.querySelectorAll(".live")) {
    live.ariaLive = "polite"; live.ariaAtomic = "true";
  }
  for (const story of root.querySelectorAll(".story")) height.observe(story);
  // a slider's label ends in a colon where its value isn't in it
  for (const title of root.querySelectorAll(".bk-slider-title"))
    if (!title.children.length && /:\s*$/.test(title.textContent))
      title.textContent = title.textContent.replace(/:\s*$/, "");
  for (const tab of root.querySelectorAll(".bk-tab")) {
    const active = tab.matches(".bk-active");
    tab.role = "tab"; tab.ariaSelected = active; tab.tabIndex = active ? 0 : -1;
    tab.parentElement.role = "tablist";
    if (active && keyed && document.activeElement === document.body) tab.focus();
  }
  // Bokeh has the tabs after their content: keys and readers meet them before it
  const strip = [...root.children].find((node) => node.matches(".bk-header"));
  if (strip) document.getElementById("frame")?.remove();
  const content = [...root.children].find((node) => node.shadowRoot);
  if (strip && content
      && content.compareDocumentPosition(strip) & Node.DOCUMENT_POSITION_FOLLOWING)
    content.before(strip);
  for (const handle of root.querySelectorAll(".noUi-handle")) {
    name(handle, labelOf(handle)?.textContent.replace(/:.*/s, ""));
    // noUiSlider exposes one decimal, whatever is shown
    const value = Number(handle.closest(".noUi-target")?.noUiSlider?.get(true));
    const text = String(Number(value.toPrecision(6)));
    for (const attribute of ["aria-valuenow", "aria-valuetext"])
      if (isFinite(value) && handle.getAttribute(attribute) !== text)
        handle.setAttribute(attribute, text);
  }
  for (const box of root.querySelectorAll("input[type=checkbox]"))
    name(box, box.nextElementSibling?.textContent);
  for (const input of root.querySelectorAll("input[type=text]")) guard(input);
  // no key does anything in a figure
  for (const layer of root.querySelectorAll(".bk-events")) layer.tabIndex = -1;
};
const attach = Element.prototype.attachShadow;
Element.prototype.attachShadow = function (...options) {
  const root = attach.apply(this, options);
  new MutationObserver(() => annotate(root)).observe(
    root, {childList: true, subtree: true, attributes: true,
    attributeFilter: ["class", "aria-valuenow", "aria-valuetext"]});
  return root;
};
document.querySelector("[data-root-id]")?.setAttribute("role", "main");
