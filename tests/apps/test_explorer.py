"""The explorer in a browser: its widgets work, and show what the laws give."""

import contextlib
import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import fascicle as fs
from fascicle import records
from fascicle.files import dumps, load, loads


BROWSERS = ("chromium", "chromium-browser", "google-chrome")
BROWSER = next((path for name in BROWSERS if (path := shutil.which(name))), None)
pytestmark = [
    pytest.mark.skipif(BROWSER is None, reason="no chromium: apt-get install chromium"),
    # the server's own process, and the browser's, end after their sockets
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]
OPTIONS = ["--no-sandbox", "--disable-gpu"]
READY = """window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle
  && Bokeh.documents[0].get_model_by_name('explorer')"""
SOURCE = """name => {
  const model = Bokeh.documents[0].get_model_by_name(name);
  if (!model) return null;
  return Object.fromEntries(Object.entries(model.data).map(([k, v]) => [k, Array.from(v, x =>
    x && x.length !== undefined && typeof x !== 'string' ? Array.from(x) : x)]));
}"""
SLOW = 180_000  # ms: a law's first compilation on a busy machine
POLLING = 50  # ms: at each frame it would keep a core busy


@contextlib.contextmanager
def serving(*arguments):
    """A server's address, its process, and the lines that it printed first."""
    command = [sys.executable, "-m", "fascicle", "explore", "--no-show", *arguments]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=os.environ,
    )  # fmt: skip
    try:
        lines = []
        for line in process.stdout:
            lines.append(line)
            if match := re.search(r"http://\S+", line):
                break
        else:
            pytest.fail("".join(lines))
        yield match.group(), process, lines
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()


@pytest.fixture(scope="module")
def server():
    with serving("kim2021_figure_6") as (url, _, _):
        yield url


@pytest.fixture(scope="module")
def chromium():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        yield playwright.chromium


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    """One profile for all pages: its next page has Bokeh's code compiled, a third of its time."""
    context = chromium.launch_persistent_context(
        tmp_path_factory.mktemp("profile"), executable_path=BROWSER, args=OPTIONS
    )
    yield context
    context.close()


@pytest.fixture(scope="module")
def idle():
    """Pages that were visited: the next visit from one is a quarter cheaper than from a new one."""
    return []


@pytest.fixture
def visit(browser, server, idle):
    """Open an address of the explorer; there is no error, and no request to another machine."""
    pages, errors = [], []

    def on_console(message):
        if message.type == "error":
            errors.append(f"console: {message.text}")

    def on_error(error):
        errors.append(f"page: {error}")

    def on_request(request):
        if request.url.startswith(("http", "ws")) and "://127.0.0.1:" not in request.url:
            errors.append(f"outside: {request.url}")

    listeners = {"console": on_console, "pageerror": on_error, "request": on_request}

    def open_page(query="", width=1280, height=800):
        page = idle.pop() if idle else browser.new_page()
        pages.append(page)
        page.bring_to_front()
        page.mouse.move(0, 0)
        page.set_viewport_size({"width": width, "height": height})
        page.set_default_timeout(SLOW)
        for event, listener in listeners.items():
            page.on(event, listener)
        page.goto(server + query)
        until(page, READY)
        return page

    open_page.pages = pages
    yield open_page
    for page in pages:
        for event, listener in listeners.items():
            page.remove_listener(event, listener)
        idle.append(page)
    assert not errors


def until(page, expression, arg=None):
    """Wait until an `expression` of the page is true."""
    page.wait_for_function(expression, arg=arg, polling=POLLING, timeout=SLOW)


def source(page, name, ready="d => d.xs ? d.xs.length : Object.values(d)[0].length"):
    """Data of a figure's source, once it is `ready`."""
    until(
        page,
        f"""name => {{ const model = Bokeh.documents[0].get_model_by_name(name);
          return model && ({ready})(model.data); }}""",
        name,
    )
    return page.evaluate(SOURCE, name)


def handle(page, label):
    """Handle of the first visible slider with a `label`."""
    return page.locator(
        f".bk-input-group:has(.bk-slider-title:has-text('{label}')) .noUi-handle"
    ).first


def field(page, label):
    return page.get_by_label(label).first


MUSCLE = fs.example("kim2021_figure_6")


def test_a_slider_moves_by_keyboard_and_the_curve_is_the_laws(visit):
    page = visit()
    source(page, "curve")
    slider = handle(page, "Pressure P")
    slider.focus()
    for _ in range(3):
        slider.press("ArrowRight")
    # 137.9 kPa at first, a step of 1 kPa: when all three have come
    third = float(MUSCLE.force(140.4e3, 0.0))
    until(page, f"least => ({SOURCE})('curve').force[0] > least", arg=third)
    typed = page.locator("input[type=text]").evaluate_all("all => all.map(x => x.value)")
    pressure = float(next(x for x in typed if x.endswith("kPa")).split()[0]) * 1e3
    assert pressure > 140.4e3
    after = source(page, "curve")
    strain = np.array(after["strain"])
    np.testing.assert_allclose(after["force"], MUSCLE.force(pressure, strain), rtol=1e-9, atol=1e-9)
    assert len(source(page, "marks")["label"]) == 3
    assert source(page, "solid")["x"]


def test_units_convert_the_numbers_shown(visit):
    from playwright.sync_api import expect

    page = visit("?pressure=137.9kPa&strain=0.1")
    in_newtons = np.array(source(page, "curve")["force"])
    field(page, "Force").select_option("lbf")
    field(page, "Pressure").select_option("psi")
    field(page, "Length").select_option("in")
    until(page, f"old => ({SOURCE})('curve').force[0] < old / 4", arg=in_newtons[0])
    in_pounds = np.array(source(page, "curve")["force"])
    np.testing.assert_allclose(in_pounds * 4.4482216152605, in_newtons, rtol=1e-12)
    expect(field(page, "Length at rest")).to_have_value("5 in", timeout=SLOW)


def test_an_error_is_at_its_field_and_the_picture_stays(visit):
    from fascicle.explorer.widgets import page_message

    page = visit()
    before = source(page, "curve")
    angle = field(page, "Braid angle")
    angle.fill("60 deg")
    angle.press("Enter")
    message = page.get_by_role("alert")
    message.wait_for()
    with pytest.raises(ValueError, match="braid_angle") as error:
        fs.Muscle.from_dimensions(0.127, 6.35e-3, 1.6e-3, np.radians(60))
    assert message.inner_text() == page_message(error.value)
    assert abs(message.bounding_box()["y"] - angle.bounding_box()["y"]) < 60
    assert source(page, "curve") == before
    angle.fill("25")  # a bare number is in the unit shown
    angle.press("Enter")
    until(page, f"old => ({SOURCE})('curve').force[0] > 1.1 * old", arg=before["force"][0])
    message.wait_for(state="hidden")


def test_a_link_reproduces_a_view(visit):
    page = visit("?muscle=kim2021_slenderness_10&pressure=200kPa&strain=0.15")
    length = field(page, "Length at rest")
    length.fill("150 mm")
    length.press("Enter")
    until(page, "() => location.search.includes('file=')")
    again = visit(page.evaluate("() => location.search"))
    assert field(again, "Length at rest").input_value() == "150 mm"
    assert source(again, "curve") == source(page, "curve")


def test_a_file_opens_and_saves(visit, tmp_path):
    muscle = fs.Muscle.from_dimensions(0.2, 8e-3, 1.5e-3, np.radians(28))
    path = tmp_path / "mine.toml"
    fs.save(muscle, path)
    page = visit()
    page.locator("input[type=file]").first.set_input_files(path)
    page.get_by_text("mine.toml").first.wait_for()
    until(page, "() => location.search.includes('file=')")
    with page.expect_download() as download:
        page.get_by_text("Save the file").first.click()
    text = Path(download.value.path()).read_text()
    assert dumps(loads(text).motor_units[0].muscle) == dumps(load(path))


def test_a_broken_file_is_refused_with_its_key_and_value(visit, tmp_path):
    path = tmp_path / "broken.toml"
    text = dumps(MUSCLE).replace('"127 mm"', '"127 kPa"')
    assert "127 kPa" in text
    path.write_text(text)
    page = visit()
    page.locator("input[type=file]").first.set_input_files(path)
    message = page.get_by_role("alert")
    message.wait_for()
    with pytest.raises(ValueError, match="127 kPa") as error:
        loads(path.read_text(), source="broken.toml")
    # the label on the page stands for the name in Python
    expected = str(error.value).replace("`length` must", "Length at rest must")
    assert message.inner_text() == expected


def test_downloads_parse(visit):
    page = visit()
    for label, check in (
        ("Download SVG", lambda raw: ET.fromstring(raw).tag.endswith("svg")),  # noqa: S314 ours
        ("Download PNG", lambda raw: raw.startswith(b"\x89PNG")),
        (
            "Download CSV",
            lambda raw: np.genfromtxt(io.BytesIO(raw), delimiter=",").shape == (202, 9),
        ),
        ("Download netCDF", lambda raw: raw[1:4] == b"HDF"),
        ("Download Python", lambda raw: compile(raw, "muscle.py", "exec")),
    ):
        with page.expect_download() as download:
            page.get_by_text(label).first.click()
        assert check(Path(download.value.path()).read_bytes()), label


def test_the_bundles_tab_shows_its_space_and_pressures_for_a_point(visit):
    page = visit("?muscle=kim2021_bundle_1_4&tab=bundle&pressures=344.7kPa,69kPa&strain=0.2")
    bundle = fs.example("kim2021_bundle_1_4")
    shown = source(page, "bundle_force")
    force = bundle.force([344.7e3, 69e3], np.array(shown["strain"]))
    np.testing.assert_allclose(shown["force"], force, rtol=1e-9, atol=1e-9)
    assert source(page, "regions")["label"] == ["recruitment state 1", "recruitment state 2"]
    assert source(page, "bundle")["x"]
    # a click in the middle of the space
    figure = page.locator(".bk-Figure").first
    box = figure.bounding_box()
    figure.click(position={"x": 0.35 * box["width"], "y": 0.6 * box["height"]})
    solution = page.get_by_role("button", name=re.compile(r"^Set state \d")).first
    solution.wait_for()
    target = source(page, "target")
    # slider, fields and address follow
    load = float(field(page, "Load").input_value().removesuffix(" N"))
    assert load == pytest.approx(target["y"][0], rel=1e-4)
    assert page.get_by_role("cell", name="reached, cheapest").count() <= 1
    pointed = field(page, "Contraction ε, typed")
    assert float(pointed.input_value()) == pytest.approx(target["x"][0], abs=1e-4)
    slid = float(handle(page, "Contraction ε").get_attribute("aria-valuenow"))
    assert slid == pytest.approx(target["x"][0], abs=1e-3)  # a step of it
    until(
        page,
        "x => Math.abs(new URLSearchParams(location.search).get('strain') - x) < 1e-4",
        arg=target["x"][0],
    )
    solution.click()
    until(
        page,
        f"old => Math.abs(({SOURCE})('bundle_force').force[0] - old) > 1e-6",
        arg=shown["force"][0],
    )
    now = source(page, "bundle_force")
    reached = np.interp(target["x"][0], now["strain"], now["force"])
    assert reached == pytest.approx(target["y"][0], rel=0.02)


def test_reversal_and_efficiency_show_what_the_library_gives(visit):
    from fascicle.explorer.reversal_tab import split_curves

    page = visit("?tab=reversal&splits=1-4&supply=344.7kPa")
    shown = source(page, "reversal_resisted")
    (curve,) = split_curves(MUSCLE, ((1, 4),), 344.7e3)
    drawn = np.array(shown["ys"][0], float)
    np.testing.assert_allclose(drawn, curve.drawn[1], atol=1e-9)
    assert source(page, "turns")["y"] == pytest.approx([curve.turn.free_strain])
    page = visit("?muscle=kim2021_bundle_1_1&tab=efficiency&path=isotonic")
    source(page, "efficiency")
    means = source(page, "average_true")["y"]
    assert len(means) == 5
    assert means == sorted(means)


def test_a_reload_keeps_the_other_laws(visit):
    page = visit()
    source(page, "curve")
    field(page, "Compare with").select_option(["buckling: elastica", "tension: ideal"])
    both = "d => d.xs && d.xs.length === 2"
    shown = source(page, "alternatives", both)
    index = shown["label"].index("buckling: elastica")
    force = MUSCLE.replace(buckling="elastica").force(137.9e3, np.array(shown["xs"][index]))
    np.testing.assert_allclose(shown["ys"][index], force, rtol=1e-9, atol=1e-9)
    until(page, "() => location.search.includes('compare=')")
    page.reload()
    until(page, READY)
    assert source(page, "alternatives", both) == shown


def test_a_solid_turns_by_pointer_and_slider_and_back(visit):
    page = visit()
    source(page, "solid")
    stage = page.locator(".bk-Figure").nth(1)
    slider = handle(page, "Turn the view")
    value = "element => Number(element.getAttribute('aria-valuenow'))"
    assert slider.evaluate(value) == 30
    box = stage.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    before = source(page, "solid_drawn")
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] - 80, middle[1], steps=8)
    page.mouse.up()
    # half a degree a pixel
    until(page, f"element => ({value})(element) === 70", arg=slider.element_handle())
    assert source(page, "solid_drawn") != before
    stage.dblclick()
    until(page, f"element => ({value})(element) === 30", arg=slider.element_handle())
    assert source(page, "solid_drawn") == before
    slider.press("ArrowRight")
    until(page, f"element => ({value})(element) === 31", arg=slider.element_handle())
    assert source(page, "solid_drawn") != before


def test_a_click_in_the_muscles_picture_moves_the_point(visit):
    page = visit("?strain=0.2&pressure=137.9kPa")
    newtons = source(page, "point")["y"][0]
    field(page, "Force").select_option("lbf")
    until(page, f"newtons => ({SOURCE})('point').y[0] !== newtons", arg=newtons)
    figure = page.locator(".bk-Figure").first
    box = figure.bounding_box()
    figure.click(position={"x": 0.4 * box["width"], "y": 0.3 * box["height"]})
    until(page, f"() => ({SOURCE})('point').x[0] < 0.19")
    pointed = source(page, "point")
    typed = float(field(page, "Contraction ε, typed").input_value())
    assert typed == pytest.approx(pointed["x"][0], abs=1e-9)
    force = float(MUSCLE.force(137.9e3, typed)) / 4.4482216152605
    assert pointed["y"][0] == pytest.approx(force, rel=1e-9)
    # the pointer is far above the curve, and its tooltip has the curve's force with its unit
    tooltip = page.locator(".bk-tooltip-row-value").last
    number, unit = tooltip.inner_text().split()
    assert unit == "lbf" and float(number) == pytest.approx(force, abs=0.02)
    # a long click
    figure.click(position={"x": 0.7 * box["width"], "y": 0.3 * box["height"]}, delay=600)
    until(page, f"() => ({SOURCE})('point').x[0] > 0.2")


def test_a_bundles_last_pressure_can_be_swept(visit):
    page = visit("?muscle=kim2021_bundle_1_4&tab=bundle&pressures=344.7kPa,69kPa&strain=0.2")
    before = source(page, "bundle_force")["force"]
    sweep = page.get_by_role("button", name="Sweep P2")
    sweep.click()
    until(page, f"old => ({SOURCE})('bundle_force').force[0] > old", arg=before[0])
    sweep.click()


def test_figures_of_efficiency_load_until_they_are_computed(monkeypatch):
    from fascicle.explorer.efficiency_tab import EfficiencyView
    from fascicle.explorer.state import Session, view_of
    from fascicle.explorer.tab import LatestResult
    from fascicle.plot.theme import LIGHT

    requests = []
    monkeypatch.setattr(LatestResult, "request", lambda *call: requests.append(call))
    tab = EfficiencyView(Session(view_of(fs.example("kim2021_bundle_1_1"), "b")), LIGHT)
    tab.refresh()
    for i, figure in enumerate(tab.figures):
        assert figure.loading
        latest, compute = requests[i]
        latest._show(compute())
        assert not figure.loading


LABEL = """() => { let at = document.activeElement;
  while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
  const named = at.ariaLabel || at.labels?.[0]?.textContent || at.getAttribute('label')
    || at.closest('.bk-input-group')?.querySelector('label')?.textContent || at.textContent;
  return at.tagName + ' ' + named.trim().slice(0, 40); }"""


def move_to(page, label, key="Tab"):
    """Press a key until the focus is at a widget with a `label`."""
    labels = []
    for _ in range(60):
        labels.append(page.evaluate(LABEL))
        if label in labels[-1]:
            return
        page.keyboard.press(key)
    pytest.fail(f"{label!r} can't be reached by {key}: {labels}")


def test_the_tabs_are_one_stop_between_header_and_content(visit):
    page = visit("?tab=bundle")
    source(page, "bundle_force")
    labels = []
    for _ in range(60):
        page.keyboard.press("Tab")
        labels.append(page.evaluate(LABEL))
    # at first the tabs, then their content
    assert labels[0] == "DIV Bundle" and "Recruitment" in labels[1]
    # and then around the page as it reads, with one stop at the tabs
    header = next(i for i, label in enumerate(labels) if "Example" in label)
    assert labels[header + 6] == "BUTTON Copy link"  # nothing to undo or to reset
    assert labels[header + 7] == "BUTTON Use dark page"
    assert labels[header + 8] == "DIV Bundle" and "Recruitment" in labels[header + 9]
    assert not any(label.startswith("DIV Bundle") for label in labels[1 : header + 8])
    page.locator(".bk-tab").nth(1).focus()
    page.keyboard.press("Shift+Tab")
    assert page.evaluate(LABEL) == "BUTTON Use dark page"


def test_pictures_have_a_text_and_are_no_stops_of_the_tab_key(visit):
    page = visit("?pressure=137.9kPa&strain=0.1")
    source(page, "curve")
    free, force = (
        f"{float(x):.4f}" for x in (MUSCLE.free_strain(137.9e3), MUSCLE.force(137.9e3, 0.1))
    )
    chart, scene = page.get_by_role("figure").all()
    text = chart.get_attribute("aria-label")
    assert f"free {free}" in text and f"{float(force):.4g} N at a contraction of 0.1" in text
    assert "in tension" in scene.get_attribute("aria-label")
    field(page, "Contraction ε, typed").fill("0.3")
    page.keyboard.press("Enter")
    page.get_by_role("figure", name="contraction of 0.3, collapsed").first.wait_for()
    labels = []
    for _ in range(40):
        page.keyboard.press("Tab")
        labels.append(page.evaluate(LABEL))
    assert len(set(labels)) > 25
    assert "DIV" not in [label.strip() for label in labels]


def test_back_leaves_the_page(visit, server):
    page = visit("?tab=reversal")
    page.goto(f"{server}?strain=0.1")
    until(page, READY)
    source(page, "curve")
    for strain in ("0.11", "0.12"):
        typed = field(page, "Contraction ε, typed")
        typed.fill(strain)
        typed.press("Enter")
        until(page, "to => location.search.includes(`strain=${to}`)", arg=strain)
    page.go_back()
    until(page, READY)
    assert "tab=reversal" in page.url


def test_the_docs_five_minutes_go_by_keyboard_alone(visit):
    page = visit()
    press = page.keyboard.press
    source(page, "curve")
    # resistance: pressure and contraction by arrows
    press("Tab")
    move_to(page, "Pressure P")
    before = source(page, "curve")["force"][0]
    press("ArrowLeft")
    until(page, f"old => ({SOURCE})('curve').force[0] < old", arg=before)
    move_to(page, "Contraction ε")
    at = source(page, "point")["x"][0]
    press("PageUp")
    until(page, f"old => ({SOURCE})('point').x[0] > old", arg=at)
    # buckling: the sweep, and another law
    move_to(page, "Sweep the strain")
    press("Space")
    at = source(page, "point")["x"][0]
    until(page, f"old => ({SOURCE})('point').x[0] !== old", arg=at)
    press("Space")
    move_to(page, "Compare with", "Shift+Tab")
    press("ArrowDown")
    source(page, "alternatives")
    # overlap: another example, the next tab, a point and pressures for it
    move_to(page, "Example", "Shift+Tab")
    page.keyboard.type("kim2021_bundle_1_4", delay=5)
    until(page, "() => location.search.includes('bundle_1_4')")
    move_to(page, "Muscle")
    press("ArrowRight")
    page.get_by_role("button", name="Try a point").wait_for()
    move_to(page, "Try a point")
    press("Enter")
    page.get_by_role("button", name=re.compile(r"^Set state \d")).first.wait_for()
    old = source(page, "bundle_force")["force"][0]
    press("Tab")
    move_to(page, "Set state", "Shift+Tab")
    press("Enter")
    until(page, f"old => ({SOURCE})('bundle_force').force[0] !== old", arg=old)
    # reversal: other splits
    move_to(page, "Bundle", "Shift+Tab")
    press("ArrowRight")
    source(page, "reversal_resisted")
    field(page, "Splits").wait_for()
    move_to(page, "Splits")
    press("Control+a")
    page.keyboard.type("1+3")
    press("Enter")
    source(page, "reversal_resisted", "d => d.label.length === 1 && d.label[0] === '1 + 3'")
    # efficiency: the loss due to resistance
    move_to(page, "Reversal", "Shift+Tab")
    press("ArrowRight")
    source(page, "efficiency")
    field(page, "Map").wait_for()
    move_to(page, "Map")
    whole = page.evaluate(SOURCE, "efficiency")["image"]
    page.keyboard.type("loss", delay=5)
    until(
        page,
        f"old => JSON.stringify(({SOURCE})('efficiency').image) !== old",
        arg=json.dumps(whole),
    )


# faults of visible widgets and figures: one lies over another, leaves the page, or has words that
# don't fit into it
UNTIDY = """() => {
  const FITS = ".bk-btn, .bk-tab, .bk-slider-title, label";
  const nodes = [], wrong = [], wide = document.documentElement.clientWidth;
  const walk = (root) => { for (const node of root.querySelectorAll("*")) {
    if (node.matches(`${FITS}, .bk-input, .bk-Figure, .noUi-base, h1, th, td`)) nodes.push(node);
    if (node.shadowRoot) walk(node.shadowRoot);
  } };
  walk(document);
  const name = (one) => `${one.className || one.tagName} ${one.textContent.trim().slice(0, 30)}`;
  const rolled = (one) => {  // its visible part in a column that scrolls
    let { left, right, top, bottom } = one.getBoundingClientRect();
    for (let at = one; at; at = at.assignedSlot ?? at.parentNode ?? at.host) {
      if (!(at instanceof Element) || getComputedStyle(at).overflowY !== "auto") continue;
      const hole = at.getBoundingClientRect();
      top = Math.max(top, hole.top); bottom = Math.min(bottom, hole.bottom);
    }
    return { left, right, top, bottom };
  };
  const seen = nodes.filter((one) => one.checkVisibility({ visibilityProperty: true }))
    .map((one) => [one, rolled(one)]).filter(([, r]) => r.right > r.left && r.bottom > r.top);
  for (const [one, box] of seen) {
    if (box.right < -1000) continue;  // read aloud only
    if (box.left < -1 || box.right > wide + 1) wrong.push(`leaves the page: ${name(one)}`);
    if (one.matches(FITS) && one.scrollWidth > one.clientWidth + 1)
      wrong.push(`doesn't fit: ${name(one)}`);
  }
  seen.forEach(([one, p], i) => seen.slice(i + 1).forEach(([other, q]) => {
    if (one.contains(other) || other.contains(one)) return;
    const x = Math.min(p.right, q.right) - Math.max(p.left, q.left);
    const y = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
    if (x > 2 && y > 2) wrong.push(`overlap: ${name(one)} and ${name(other)}`);
  }));
  return seen.length < 12 ? ["too little was found"] : wrong;
}"""


def wait_for_layout(page):
    """Wait until no figure moves from one frame to the next but one."""
    before = None
    while before != (now := [figure.bounding_box() for figure in page.locator(".bk-Figure").all()]):
        before = now
        page.evaluate(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )


def tabs_one_by_one(page):
    """Names of tabs, each when it is open and laid out; the data's without and with a record."""
    shown = {"Muscle": "solid", "Bundle": "bundle", "Reversal": "turns",
             "Efficiency": "average_true", "Data": "untuned", "record": "readings"}  # fmt: skip
    for tab, name in shown.items():
        if tab == "record":
            page.get_by_role("button", name="Try an example record").click()
        else:
            page.get_by_text(tab, exact=True).first.click()
        source(page, name)
        wait_for_layout(page)
        yield tab


def untidy(page, width):
    """Faults of the layout of a page of this `width`."""
    total = page.evaluate("() => document.documentElement.scrollWidth")
    return page.evaluate(UNTIDY) + [f"is {total} wide"] * (total != width)


def background(page):
    """Red, green and blue behind the page."""
    color = page.evaluate("() => getComputedStyle(document.body).backgroundColor")
    return [int(channel) for channel in re.findall(r"\d+", color)[:3]]


@pytest.fixture
def phone(chromium, server):
    """A page as a phone shows it."""
    browser = chromium.launch(executable_path=BROWSER, args=OPTIONS)
    screen = {"width": 390, "height": 844}
    page = browser.new_page(viewport=screen, is_mobile=True, has_touch=True, device_scale_factor=2)
    page.set_default_timeout(SLOW)
    page.goto(f"{server}?muscle=kim2021_bundle_1_4&strain=0.1")
    until(page, READY)
    yield page
    browser.close()


def move_finger(page, x, y, dx, dy):
    """Put a finger on a page, move it by `dx` and `dy` pixels, and lift it."""
    send = page.context.new_cdp_session(page).send
    for step in range(21):
        point = {"x": x + dx * step / 20, "y": y + dy * step / 20}
        kind = "touchMove" if step else "touchStart"
        send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
    send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def test_only_a_page_with_a_pointer_speaks_of_a_key(phone, visit):
    text = "node => getComputedStyle(node, '::after').content"
    for page, hint in ((phone, "none"), (visit(), '" (Ctrl for several)"')):
        label = page.get_by_text("Compare with")
        label.first.wait_for()
        assert "Ctrl" not in label.first.inner_text()
        assert label.first.evaluate(text) == hint


def test_nothing_leaves_a_phones_page_or_overlaps(phone):
    for tab in tabs_one_by_one(phone):
        assert (tab, untidy(phone, 390)) == (tab, [])


@pytest.mark.parametrize("width", [900, 1010, 1265])  # the last: 1280 beside a scroll bar
def test_nothing_leaves_a_page_of_another_width(visit, width):
    page = visit("?muscle=kim2021_bundle_1_4&strain=0.1", width=width)
    source(page, "solid")
    wait_for_layout(page)
    assert untidy(page, width) == []


def test_a_finger_on_a_figure_scrolls_a_phones_page(phone):
    source(phone, "curve")
    wait_for_layout(phone)
    ranges = """() => { const model = Bokeh.documents[0].get_model_by_name('curve');
      const figure = [...Bokeh.documents[0].all_models].find(m => m.type === 'Figure'
        && m.renderers.some(r => r.data_source === model));
      return [figure.x_range, figure.y_range].flatMap(r => [r.start, r.end]); }"""
    before, box = phone.evaluate(ranges), phone.locator(".bk-Figure").first.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + 0.5 * box["height"]
    move_finger(phone, *middle, 0, -200)
    until(phone, "() => scrollY > 150")
    move_finger(phone, *middle, -120, 0)
    assert phone.evaluate(ranges) == before
    assert source(phone, "point")["x"] == [0.1]
    phone.locator(".bk-Figure").first.tap(position={"x": 0.7 * box["width"], "y": 30})
    until(phone, f"() => ({SOURCE})('point').x[0] > 0.1")


def test_the_frame_of_the_page_is_there_before_its_scripts(browser, server):
    page = browser.new_page()
    page.route("**/*.js*", lambda route: route.abort())
    page.goto(f"{server}?tab=bundle")
    frame = page.locator("#frame")
    assert frame.get_by_role("heading").inner_text() == "fascicle"
    assert frame.locator("b").inner_text() == "Bundle"
    assert frame.get_by_role("status").inner_text() == "computing …"
    page.unroute("**/*.js*")
    page.reload()
    until(page, READY)
    frame.wait_for(state="detached")
    page.close()


@pytest.mark.parametrize(
    ("theme", "width", "height"), [("default", 1280, 800), ("dark", 1920, 1080)]
)
def test_a_page_is_tidy_and_has_no_barriers_that_axe_finds(visit, theme, width, height):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: make setup")
    page = visit(f"?muscle=kim2021_bundle_1_4&theme={theme}", width=width, height=height)
    assert (max(background(page)) < 60) == (theme == "dark")
    for number, tab in enumerate(tabs_one_by_one(page)):
        assert (tab, untidy(page, width)) == (tab, [])
        if theme == "default" and number > 1:  # colors are every tab's; the dark page has all tabs
            continue
        assert page.get_by_role("figure").count() == page.locator(".bk-Figure:visible").count()
        violations = axe.Axe().run(page).response["violations"]
        grave = [f"{fault['id']}: {fault['nodes'][0]['html']}" for fault in violations
                 if fault["impact"] in ("serious", "critical")]  # fmt: skip
        assert (tab, grave) == (tab, [])


@pytest.mark.parametrize("tab", ["muscle", "bundle"])
def test_the_muscle_is_as_large_as_its_curves(visit, tab):
    page = visit(f"?muscle=kim2021_bundle_1_4&tab={tab}", width=1280, height=800)
    source(page, {"muscle": "solid", "bundle": "bundle"}[tab])
    figures = page.locator(".bk-Figure")
    before = figures.first.bounding_box()["width"]
    for width, height in ((1280, 800), (1920, 1080)):
        if width != 1280:
            page.set_viewport_size({"width": width, "height": height})
            until(page, "([at, old]) => at.clientWidth > old + 50",
                                   arg=[figures.first.element_handle(), before])  # fmt: skip
            wait_for_layout(page)
        curves, stage = (figure.bounding_box() for figure in figures.all()[:2])
        assert stage["width"] == pytest.approx(curves["width"], abs=2)
        # the page is filled: only the downloads are below the curves
        assert height - curves["y"] - curves["height"] < 130
        assert page.evaluate("() => document.documentElement.scrollHeight") <= height + 40


def test_a_bundles_fibers_bend_and_fold_with_pressure(visit):
    page = visit("?muscle=kim2021_bundle_1_4&tab=bundle&strain=0.2&pressures=344.7kPa,300kPa")
    source(page, "bundle")
    straight = np.array(source(page, "bundle_fibers")["y"])
    field(page, "Pressure P2, typed").fill("40 kPa")
    page.keyboard.press("Enter")
    until(
        page,
        f"old => ({SOURCE})('bundle_fibers').y[old[0]] !== old[1]",
        arg=[len(straight) // 2, straight[len(straight) // 2]],
    )
    folded = np.array(source(page, "bundle_fibers")["y"])
    # five muscles of as many fibers, moved by millimeters
    assert folded.size == straight.size and np.abs(folded - straight).max() > 2e-3


@pytest.mark.parametrize(("width", "height"), [(1280, 800), (1920, 1080)])
def test_without_a_record_the_data_tab_shows_the_muscles_curves(visit, width, height):
    page = visit("?tab=data", width=width, height=height)
    shown = source(page, "untuned")
    assert len(shown["ys"]) == 5
    for pressure, strain, force in zip(np.arange(5) * 1e5, shown["xs"], shown["ys"], strict=True):
        given = MUSCLE.force(pressure, np.array(strain))
        np.testing.assert_allclose(force, given, rtol=1e-9, atol=1e-9)
    box = page.locator(".bk-Figure").first.bounding_box()
    # the page is filled but for its margin
    assert 0 < height - box["y"] - box["height"] < 130
    assert box["width"] > 0.6 * width


def test_a_warning_on_another_length_than_the_fits(visit, tmp_path):
    fs.save(MUSCLE, tmp_path / "tuned.toml", {"fitted_length": "127 mm"})
    page = visit()
    page.locator("input[type=file]").first.set_input_files(tmp_path / "tuned.toml")
    page.get_by_text("tuned.toml").first.wait_for()
    until(page, "() => location.search.includes('file=')")
    before = page.evaluate("() => location.search")
    length = field(page, "Length at rest")
    length.fill("200 mm")
    length.press("Enter")
    warning = "The muscle was fitted at a length of 127 mm and its length is now 200 mm"
    page.get_by_text(warning).wait_for()
    until(page, "before => location.search !== before", arg=before)
    # and in its link
    again = visit(page.evaluate("() => location.search"))
    again.get_by_text(warning).wait_for()
    again.get_by_text("Bundle", exact=True).first.click()
    again.get_by_text(warning).last.wait_for()
    field(page, "Tension").select_option("sarosi")
    page.get_by_text("was fitted to a Festo DMSP-20-200N").wait_for()


def test_columns_and_units_of_a_record_have_fields(visit, tmp_path):
    rows = "".join(f"{x},{10 - x},100\n" for x in range(8))
    (tmp_path / "w.csv").write_text("A,B,C\n" + rows)
    page = visit("?tab=data")
    page.locator("input[type=file]").last.set_input_files(tmp_path / "w.csv")
    page.get_by_text("fields below").wait_for()
    for role, column, unit in (("pressure", "C", "kPa"), ("force", "B", "N"),
                               ("displacement", "A", "mm")):  # fmt: skip
        field(page, f"Column of {role}").select_option(column)
        typed = field(page, f"Unit of {role}")
        typed.fill(unit)
        typed.press("Enter")
    shown = source(page, "readings")
    np.testing.assert_allclose(shown["x"], np.arange(8) / 127, atol=1e-12)
    np.testing.assert_allclose(shown["y"], 10.0 - np.arange(8))
    page.get_by_text("strains are taken over the muscle's, 127 mm").wait_for()


def test_a_field_is_not_overwritten_while_it_is_typed_in(visit):
    page = visit("?strain=0.1")
    source(page, "curve")
    typed = field(page, "Contraction ε, typed")
    page.get_by_role("button", name="Sweep the strain").click()
    until(page, f"() => ({SOURCE})('point').x[0] > 0.1")
    typed.focus()
    page.keyboard.press("Control+a")
    page.keyboard.type("0.0")
    at = source(page, "point")["x"][0]
    until(page, f"old => ({SOURCE})('point').x[0] > old + 0.01", arg=at)
    assert typed.input_value() == "0.0"
    page.keyboard.press("Enter")  # an entered text counts
    until(page, f"() => ({SOURCE})('point').x[0] < 0.02")
    page.get_by_role("button", name="Sweep the strain").click()


def test_the_link_is_copied_and_a_word_says_where_it_opens(visit):
    page = visit("?strain=0.1")
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    source(page, "curve")
    page.get_by_role("button", name="Copy link").click()
    page.get_by_text("It opens where fascicle explore runs").wait_for()
    assert page.evaluate("() => navigator.clipboard.readText()") == page.url
    page.context.clear_permissions()


def test_a_fit_can_be_cancelled_and_started_again(visit):
    page = visit("?muscle=kim2021_slenderness_10&tab=data")
    page.get_by_role("button", name="Try an example record").click()
    source(page, "readings")
    start = page.get_by_role("button", name="Calibrate the muscle")
    start.click()
    page.get_by_text("It usually takes 20 to 40 s").wait_for()
    page.get_by_role("button", name="Cancel the fit").click()
    page.get_by_text("The fit was cancelled.").wait_for()
    page.get_by_role("progressbar").wait_for(state="hidden")
    field(page, "What to fit").select_option("constants of your choice")
    field(page, "Constants").select_option("outer radius")
    start.click()
    page.get_by_text("90 % interval").wait_for()
    assert page.get_by_role("cell", name="outer radius").count() == 1
    assert source(page, "tuned")["ys"]


def test_a_bar_moves_while_constants_are_fitted(visit):
    page = visit("?muscle=kim2021_slenderness_10&tab=data")
    page.get_by_role("button", name="Try an example record").click()
    source(page, "readings")
    field(page, "What to fit").select_option("constants of your choice")
    field(page, "Constants").select_option("outer radius")
    page.get_by_role("button", name="Calibrate the muscle").click()
    page.get_by_role("progressbar").wait_for()
    bar = page.locator("[role=progressbar] div")
    arguments = [bar.element_handle(), bar.bounding_box()["x"]]
    until(page, "([bar, x]) => bar.getBoundingClientRect().x != x", arg=arguments)
    page.get_by_text("90 % interval").wait_for()
    page.get_by_role("progressbar").wait_for(state="hidden")
    assert page.get_by_text("outer radius", exact=True).count() >= 1


def test_a_page_follows_the_systems_preference_unless_its_address_has_a_theme(browser, server):
    for query, dark in (("", True), ("?theme=default", False)):
        page = browser.new_page()
        page.emulate_media(color_scheme="dark")
        page.goto(server + query)
        until(page, READY)
        color = "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)"
        until(page, f"dark => ({color}[0] < 60) === dark", arg=dark)
        page.close()


def test_another_theme_keeps_what_can_be_undone(visit):
    page = visit("?strain=0.1&theme=default")
    typed = field(page, "Contraction ε, typed")
    typed.fill("0.2")
    typed.press("Enter")
    until(page, f"() => ({SOURCE})('point').x[0] === 0.2")
    page.get_by_role("button", name="Use dark page").click()
    until(page, "() => location.search.includes('theme=dark')")
    assert max(background(page)) < 60
    page.get_by_role("button", name="Undo").click()
    until(page, f"() => ({SOURCE})('point').x[0] === 0.1")
    page.reload()
    until(page, READY)
    assert max(background(page)) < 60


def test_the_example_record_and_an_error_of_its_rest_length(visit):
    page = visit("?tab=data")
    page.get_by_text("Forces of fluidic artificial muscles").first.wait_for()
    empty_state = page.get_by_text("Your own muscle, as it was measured")
    empty_state.wait_for()
    page.get_by_role("button", name="Try an example record").click()
    empty_state.wait_for(state="hidden")
    assert len(source(page, "readings")["x"]) == 300
    page.get_by_text("300 synthetic readings").wait_for()
    rest = field(page, "Rest length, if the record")
    rest.fill("nonsense")
    rest.press("Enter")
    assert "Rest length" in page.get_by_role("alert").first.inner_text()


def test_a_record_is_calibrated_end_to_end(visit, tmp_path):
    tuned = fs.example("kim2021_slenderness_10")
    P = np.linspace(0, 413.7e3, 5)
    strain = np.linspace(0, float(tuned.free_strain(P[-1])), 24)
    force = np.asarray(tuned.force(P[:, None], strain))
    noise = 0.005 * force.max() * np.random.default_rng(0).normal(size=force.shape)
    record = records.Record.of(P[:, None], strain, force + noise, synthetic=True)
    records.write(record, tmp_path / "d.csv")
    page = visit("?muscle=kim2021_slenderness_10&tab=data")
    page.locator("input[type=file]").last.set_input_files(tmp_path / "d.csv")
    assert len(source(page, "readings")["x"]) == len(record)
    page.get_by_role("button", name="Calibrate the muscle").click()
    page.get_by_text("90 % interval").wait_for()
    assert len(source(page, "tuned")["ys"]) == 5
    with page.expect_download() as download:
        page.get_by_text("Download tuned muscle", exact=True).click()
    tuned_file = loads(Path(download.value.path()).read_text())
    with page.expect_download() as download:
        page.get_by_text("Download CSV").last.click()
    rows = np.genfromtxt(download.value.path(), delimiter=",", names=True)
    np.testing.assert_allclose(rows["force_N"], record.force, rtol=1e-12)
    assert float(tuned_file.blocked_force(P[-1])) == pytest.approx(float(force[-1, 0]), rel=0.02)
    page.get_by_role("button", name="Use the tuned muscle").click()
    page.get_by_text("tuned muscle", exact=True).first.wait_for()


def test_the_page_opens_with_a_link_that_is_nested_too_deep(visit):
    from fascicle.explorer.link import pack

    page = visit(f"?file={pack('a.' * 15_000 + 'a = 1')}&strain=0.2")
    assert "nested too deep" in page.get_by_role("alert").first.inner_text()
    assert source(page, "point")["x"] == [0.2]


def test_hidden_characters_of_a_name_are_shown(visit):
    from fascicle.explorer.link import pack

    page = visit(f"?file={pack(dumps(MUSCLE))}&name=%3Cb%3Ea%E2%80%AEb%3C/b%3E")
    page.get_by_text("<b>a\\u202eb</b>", exact=True).wait_for()


def test_a_file_that_is_too_large_to_send_is_refused(visit, tmp_path):
    (tmp_path / "large.csv").write_bytes(b"1" * 20_000_000)
    page = visit("?tab=data")
    page.locator("input[type=file]").last.set_input_files(tmp_path / "large.csv")
    page.get_by_text("large.csv: a file may have 5000000 bytes here, got 20000000").wait_for()
    # the page still follows: its connection would have been lost
    page.get_by_text("Muscle", exact=True).first.click()
    assert len(source(page, "curve")["force"]) > 0


def test_ctrl_c_ends_a_running_fit(browser, tmp_path):
    tuned = fs.example("kim2021_slenderness_10")
    strain = np.linspace(0, 0.2, 24)
    record = records.Record.of(2e5, strain, np.asarray(tuned.force(2e5, strain)), synthetic=True)
    records.write(record, tmp_path / "d.csv")
    with serving("kim2021_slenderness_10") as (url, process, _):
        page = browser.new_page()
        page.goto(f"{url}?tab=data")
        until(page, READY)
        page.locator("input[type=file]").last.set_input_files(tmp_path / "d.csv")
        page.get_by_role("button", name="Calibrate the muscle").click()
        page.get_by_text("fitting").first.wait_for(timeout=SLOW)
        process.send_signal(signal.SIGINT)
        assert process.wait(5) == 0
        page.close()


def test_a_server_for_other_machines_starts_and_ends(browser, server):
    used = int(server.rsplit(":", 1)[1].strip("/"))
    with serving("--host", "0.0.0.0") as (url, process, lines):  # noqa: S104 what is tested
        assert "without password" in "".join(lines)
        assert int(url.rsplit(":", 1)[1].strip("/")) != used
        page = browser.new_page()
        page.goto(url)
        until(page, READY)
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0
        assert process.stdout.read().strip() == "stopped."
        page.get_by_text("The connection to fascicle is lost").wait_for(timeout=SLOW)
        page.close()


def test_a_run_in_time_is_played_without_the_server(visit, tmp_path):
    sent = []
    page = visit("?tab=time&scenario=ramp_hand_over&policies=threshold,hand_over")
    run_button = page.get_by_role("button", name="Run", exact=True)
    # playwright takes no built-in method
    page.on("websocket", lambda socket: socket.on("framesent", lambda x: sent.append(x)))  # noqa: PLW0108
    page.reload()  # its connection is watched
    until(page, READY)
    run_button.click()
    frames = source(page, "time_frames", "d => d.time.length > 1 && d.time.length")
    # the numbers are those of the command
    command = [sys.executable, "-m", "fascicle", "simulate", "ramp_hand_over", "--csv"]
    done = subprocess.run([*command, "--policy", "threshold"], capture_output=True, text=True)
    run = np.genfromtxt(io.StringIO(done.stdout), delimiter=",", names=True, deletechars="")
    rows = np.searchsorted(run["time_[s]"], np.array(frames["time"]) - 1e-9)
    pressures = source(page, "time_pressures")["ys"]
    for unit in (1, 2):
        expected = run[f"pressure_{unit}_[Pa]"][rows] / 1e3
        np.testing.assert_allclose(pressures[unit - 1], expected, rtol=1e-9, atol=1e-9)
    # the cursor and the drawing move, and the server hears nothing
    cursor = "() => Bokeh.documents[0].get_model_by_name('cursor_force').location"
    drawn = "() => Bokeh.documents[0].get_model_by_name('time_tubes').data.xs[1][12]"
    before, tube = len(sent), page.evaluate(drawn)
    page.get_by_role("button", name="▶ Play").press("Enter")
    until(page, f"() => ({cursor})() > 1.5")
    page.keyboard.press("Space")  # the button has the focus
    stopped = page.evaluate(cursor)
    page.wait_for_timeout(300)
    assert page.evaluate(cursor) == stopped < 2.0
    assert len(sent) == before > 0
    assert abs(page.evaluate(drawn) - tube) > 5.0  # mm: the middle of a muscle that was collapsed
    states = "() => Bokeh.documents[0].get_model_by_name('time_labels').data.label[1]"
    assert page.evaluate(states) == "unit 2\npulling"
    slider = handle(page, "Time")
    slider.focus()
    slider.press("ArrowRight")
    until(page, f"old => ({cursor})() > old", arg=stopped)
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("Space")  # and with no focus at all
    page.get_by_role("button", name="❚❚ Pause").wait_for()
    # the files
    with page.expect_download() as download:
        page.get_by_text("Save table (CSV)").click()
    assert Path(download.value.path()).read_text() == done.stdout
    with page.expect_download() as download:
        page.get_by_text("Save charts (SVG)").click()
    assert ET.parse(download.value.path()).getroot().tag.endswith("svg")  # noqa: S314 ours


@pytest.mark.parametrize(("theme", "width"), [("dark", 390), ("default", 1280)])
def test_a_run_in_time_is_tidy_and_has_no_barriers_that_axe_finds(request, theme, width):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: make setup")
    query = f"?tab=time&scenario=ramp_hand_over&policies=threshold,hand_over&theme={theme}"
    if width == 390:
        page = request.getfixturevalue("phone")
        page.goto(request.getfixturevalue("server") + query)
        until(page, READY)
    else:
        page = request.getfixturevalue("visit")(query, width=width)
    page.get_by_role("button", name="Run", exact=True).click()
    source(page, "time_frames", "d => d.time.length > 1 && d.time.length")
    wait_for_layout(page)
    assert untidy(page, width) == []
    violations = axe.Axe().run(page).response["violations"]
    assert not [f"{fault['id']}: {fault['nodes'][0]['html']}" for fault in violations
                if fault["impact"] in ("serious", "critical")]  # fmt: skip
