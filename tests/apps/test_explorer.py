"""The explorer in a browser: its widgets work, and show what the laws give."""

import contextlib
import io
import math
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


def shared(page, label):
    """Path of a file that the menu Share gives by a button with a `label`."""
    button = page.get_by_text(label, exact=True).first
    if not button.is_visible():
        page.get_by_role("button", name="Share").click()
    with page.expect_download() as download:
        button.click()
    return Path(download.value.path())


def drag(page, box, start, end):
    """Drag the mouse from a `start` to an `end`, shares of a bounding `box`."""
    places = [(box["x"] + x * box["width"], box["y"] + y * box["height"]) for x, y in (start, end)]
    page.mouse.move(*places[0])
    page.mouse.down()
    page.mouse.move(*places[1], steps=12)
    page.mouse.up()


MUSCLE = fs.example("kim2021_figure_6")


def test_sliders_and_hands_move_the_point_and_the_curve_is_the_laws(visit):
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
    # a hand drags the point in the figure, and pulls the muscle's end cap
    strain = source(page, "point")["x"][0]
    figure, scene = (each.bounding_box() for each in page.locator(".bk-Figure").all()[:2])
    drag(page, figure, (0.3, 0.5), (0.6, 0.5))
    until(page, f"old => ({SOURCE})('point').x[0] > old + 0.05", arg=strain)
    strain = source(page, "point")["x"][0]
    drag(page, scene, (0.9, 0.4), (0.95, 0.4))  # the muscle is stretched
    until(page, f"old => ({SOURCE})('point').x[0] < old - 0.01", arg=strain)
    turned = page.evaluate(
        "() => Bokeh.documents[0].get_model_by_name('solid_drawn').data.xs[0][0]"
    )
    drag(page, scene, (0.5, 0.9), (0.7, 0.9))  # elsewhere it turns the view
    until(
        page,
        "old => Bokeh.documents[0].get_model_by_name('solid_drawn').data.xs[0][0] !== old",
        arg=turned,
    )


def test_an_error_is_at_its_field_and_a_file_opens_and_saves(visit, tmp_path):
    from fascicle.explorer.widgets import page_message

    page = visit()
    before = source(page, "curve")
    angle = field(page, "Braid angle")
    angle.fill("60 deg")
    angle.press("Enter")
    message = page.get_by_role("alert")
    message.wait_for()
    with pytest.raises(ValueError, match="braid_angle") as error:
        fs.Muscle(0.127, 6.35e-3, 1.6e-3, np.radians(60))
    assert message.inner_text() == page_message(error.value)
    assert abs(message.bounding_box()["y"] - angle.bounding_box()["y"]) < 60
    assert source(page, "curve") == before
    angle.fill("25")  # a bare number is in the unit shown
    angle.press("Enter")
    until(page, f"old => ({SOURCE})('curve').force[0] > 1.1 * old", arg=before["force"][0])
    message.wait_for(state="hidden")
    muscle = fs.Muscle(0.2, 8e-3, 1.5e-3, np.radians(28))
    path = tmp_path / "mine.toml"
    fs.save(muscle, path)
    page.locator("input[type=file]").first.set_input_files(path)
    page.get_by_text("mine.toml").first.wait_for()
    until(page, "() => location.search.includes('file=')")
    text = shared(page, "Muscle or bundle (TOML)").read_text()
    assert dumps(loads(text).motor_units[0].muscle) == dumps(load(path))


def test_the_bundles_tab_shows_its_space_and_pressures_for_a_point(visit):
    page = visit("?muscle=kim2021_bundle_1_4&tab=bundle&pressures=344.7kPa,69kPa&strain=0.2")
    bundle = fs.example("kim2021_bundle_1_4")
    shown = source(page, "bundle_force")
    force = bundle.force([344.7e3, 69e3], np.array(shown["strain"]))
    np.testing.assert_allclose(shown["force"], force, rtol=1e-9, atol=1e-9)
    assert source(page, "regions")["label"] == ["recruitment state 1", "recruitment state 2"]
    assert source(page, "bundle")["x"]
    turn = bundle.reversal(2, 344.7e3)
    assert source(page, "turn")["y"] == pytest.approx([turn.free_strain])
    reach = float(bundle.free_strain([344.7e3, 69e3]))
    assert source(page, "free_strain_point")["y"] == pytest.approx([reach])
    # a hand opens the valve of unit 2, and the bundle's free strain follows the curve
    drag(page, page.locator(".bk-Figure").nth(1).bounding_box(), (0.3, 0.3), (0.6, 0.3))
    until(page, f"() => ({SOURCE})('free_strain_point').x[0] > 120")
    until(page, f"() => ({SOURCE})('free_strain_point').y[0] !== {reach!r}")
    page.wait_for_timeout(500)  # ms: the last step of the hand
    valve = source(page, "free_strain_point")
    reach = float(bundle.free_strain([344.7e3, 1e3 * valve["x"][0]]))
    assert valve["y"] == pytest.approx([reach])
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
    before = source(page, "bundle_force")["force"][0]
    solution.click()
    until(
        page,
        f"old => Math.abs(({SOURCE})('bundle_force').force[0] - old) > 1e-6",
        arg=before,
    )
    now = source(page, "bundle_force")
    reached = np.interp(target["x"][0], now["strain"], now["force"])
    assert reached == pytest.approx(target["y"][0], rel=0.02)


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
    # overlap: another example, the next tab, a point and pressures for it
    move_to(page, "Example", "Shift+Tab")
    page.keyboard.type("Five muscles of slenderness 10 as two", delay=5)
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
    # efficiency: the loss due to resistance
    move_to(page, "More: efficiency")
    press("Enter")
    page.get_by_alt_text("Efficiency lost to resistance").wait_for()
    # a change is taken back and repeated
    before = page.evaluate(SOURCE, "bundle_force")["force"][0]
    page.keyboard.press("Control+z")
    until(page, f"old => ({SOURCE})('bundle_force').force[0] !== old", arg=before)
    page.keyboard.press("Control+Shift+z")
    until(page, f"old => ({SOURCE})('bundle_force').force[0] === old", arg=before)


UNTIDY = (Path(__file__).parent / "untidy.js").read_text(encoding="utf-8")


def wait_for_layout(page):
    """Wait until no figure moves from one frame to the next but one."""
    before = None
    while before != (now := [figure.bounding_box() for figure in page.locator(".bk-Figure").all()]):
        before = now
        page.evaluate(
            "() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )


def tabs_one_by_one(page):
    """Names of tabs, each when it is open and laid out, with its example."""
    shown = {
        "Muscle": "solid", "Bundle": "bundle", "More: efficiency": "bundle",
        "Compare": None, "Try two braid angles": "compared",
        "Data": None, "Try an example record (synthetic)": "readings",
        "Time": None, "Run": "time_frames",
    }  # fmt: skip
    for label, name in shown.items():
        named = page.locator(".bk-tab, button").filter(has_text=re.compile(f"^{re.escape(label)}$"))
        named.locator("visible=true").first.click()
        if name is None:  # a tab without a figure as yet
            page.locator(".bk-Figure:visible").first.wait_for(state="hidden")
            page.get_by_role("button", name=re.compile("^(Try|Run)")).first.wait_for()
        else:
            source(page, name)
        wait_for_layout(page)
        yield label


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


def test_a_finger_on_a_figure_scrolls_a_phones_page(phone):
    source(phone, "curve")
    wait_for_layout(phone)
    figure = """[...Bokeh.documents[0].all_models].find(m => m.type === 'Figure'
      && m.renderers.some(r => r.data_source.name === 'curve'))"""
    ranges = f"""() => {{ const figure = {figure};
      return [figure.x_range, figure.y_range].flatMap(r => [r.start, r.end]); }}"""
    before, box = phone.evaluate(ranges), phone.locator(".bk-Figure").first.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + 0.5 * box["height"]
    move_finger(phone, *middle, 0, -200)
    until(phone, "() => scrollY > 150")
    move_finger(phone, *middle, 0, 0)  # a tap
    strain = f"({SOURCE})('point').x[0]"
    until(phone, f"() => {strain} !== 0.1")
    start, width = phone.evaluate(f"() => [{strain}, {figure}.inner_width]")
    move_finger(phone, *middle, -100, 0)
    assert phone.evaluate(ranges) == before
    # the point is where the finger left it; a pixel has a strain of 0.0015
    until(
        phone, f"() => Math.abs({strain} - {start - 100 / width * (before[1] - before[0])}) < 3e-3"
    )
    phone.locator(".bk-Figure").first.tap(position={"x": 0.9 * box["width"], "y": 30})
    until(phone, f"() => ({SOURCE})('point').x[0] > 0.3")


def barriers(page):
    """Serious faults of a page that axe finds."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: make setup")
    faults = axe.Axe().run(page).response["violations"]
    grave = [fault for fault in faults if fault["impact"] in ("serious", "critical")]
    return [f"{fault['id']}: {fault['nodes'][0]['html']}" for fault in grave]


@pytest.mark.parametrize(
    ("theme", "width", "height"),
    [
        ("default", 390, 844),
        pytest.param("dark", 1280, 800, marks=pytest.mark.slow),
        pytest.param("default", 1920, 1080, marks=pytest.mark.slow),
        pytest.param("dark", 1920, 1080, marks=pytest.mark.slow),
        pytest.param("dark", 390, 844, marks=pytest.mark.slow),
        pytest.param("default", 1280, 800, marks=pytest.mark.slow),
    ],
)
def test_a_page_is_tidy_and_has_no_barriers_that_axe_finds(visit, theme, width, height):
    query = f"?muscle=kim2021_bundle_1_4&theme={theme}&scenario=lift_gas"
    page = visit(query, width=width, height=height)
    assert (max(background(page)) < 60) == (theme == "dark")
    for tab in tabs_one_by_one(page):
        assert (tab, untidy(page, width)) == (tab, [])
        assert page.get_by_role("figure").count() == page.locator(".bk-Figure:visible").count()
        assert (tab, barriers(page)) == (tab, [])


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
    rows = np.genfromtxt(shared(page, "Data (CSV)"), delimiter=",", names=True)
    np.testing.assert_allclose(rows["force_N"], record.force, rtol=1e-12)
    assert float(tuned_file.blocked_force(P[-1])) == pytest.approx(float(force[-1, 0]), rel=0.02)
    page.get_by_role("button", name="Use the tuned muscle").click()
    page.get_by_text("tuned muscle", exact=True).first.wait_for()


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
    with page.expect_download() as download:
        page.get_by_text("Save scenario", exact=True).click()
    download.value.save_as(tmp_path / "saved.toml")
    saved = str(tmp_path / "saved.toml")
    command = [sys.executable, "-m", "fascicle", "simulate", saved, "--csv"]
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
    assert shared(page, "Data (CSV)").read_text() == done.stdout
    assert ET.parse(shared(page, "Picture (SVG)")).getroot().tag.endswith("svg")  # noqa: S314 ours
    # another tab and back, by arrow keys: the focus stays, and the drawing is there again
    page.locator(".bk-tab").last.focus()
    for key, tab in (("ArrowLeft", "Data"), ("ArrowLeft", "Compare"), ("ArrowRight", "Data"),
                     ("ArrowRight", "Time")):  # fmt: skip
        page.keyboard.press(key)
        until(page, f"label => ({LABEL})() === label", arg=f"DIV {tab}")
    source(page, "time_tubes", "d => d.xs && d.xs.length > 1 && d.xs.length")


TWO = "d => d.xs.length === 2"


def test_two_braid_angles_are_compared(visit):
    from playwright.sync_api import expect

    page = visit("?pressure=137.9kPa&strain=0.1")
    source(page, "curve")
    page.get_by_role("button", name="Pin this curve").first.click()
    page.get_by_text("Pinned in Compare as").wait_for()
    angle = field(page, "Braid angle")
    angle.fill("28 deg")
    angle.press("Enter")
    blocked = float(MUSCLE.force(137.9e3, 0.0))
    until(page, f"old => ({SOURCE})('curve').force[0] > 1.2 * old", arg=blocked)
    page.get_by_role("button", name="Pin this curve").first.click()
    page.get_by_text("“braid angle 28 deg”").wait_for()
    page.get_by_text("Compare", exact=True).first.click()
    shown = source(page, "compared", TWO)
    other = MUSCLE.replace(braid_angle=math.radians(28))
    for muscle, strain, force in zip((MUSCLE, other), shown["xs"], shown["ys"], strict=True):
        law = muscle.force(137.9e3, np.array(strain))
        np.testing.assert_allclose(force, law, rtol=1e-9, atol=1e-9)
    assert shown["dash"][0] != shown["dash"][1] and shown["color"][0] != shown["color"][1]
    # the table, and another contraction
    percent = 100 * (float(other.force(137.9e3, 0.0)) / blocked - 1)
    expect(page.locator("table").first).to_contain_text(f"(+{percent:.1f} %)")
    typed = field(page, "Contraction ε to compare at, typed")
    typed.fill("0.2")
    typed.press("Enter")
    force = f"{float(other.force(137.9e3, 0.2)):.4g}"
    expect(page.locator("table").last).to_contain_text("Force at ε = 0.2 [N]")
    expect(page.locator("table").last).to_contain_text(force)
    rows = shared(page, "Data (CSV)").read_text().splitlines()
    assert len(rows) == 2 * 201 + 1
    page.get_by_role("button", name="Remove kim2021_figure_6").click()
    left = source(page, "compared", "d => d.xs.length === 1")
    assert left["label"] == ["braid angle 28 deg"]


OFFER = "See in four steps"


def scene(page, number):
    page.get_by_role("heading", name=f"{number} of 4").wait_for()


def focus(page, label):
    """Wait until the focus is on a widget with a `label`, whose outline is visible."""
    until(page, f"label => ({LABEL})() === label", arg=label)
    style = page.evaluate("""() => { let at = document.activeElement;
      while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
      const { outlineStyle, outlineWidth } = getComputedStyle(at);
      return `${outlineStyle} ${outlineWidth}`; }""")
    assert re.match(r"solid [1-9]", style)


def test_the_story_goes_by_keyboard_alone_and_leaves_the_inputs(visit):
    page = visit()
    page.evaluate("() => localStorage.removeItem('fascicle-story')")  # of the offer, as if new
    page.reload()
    until(page, READY)
    page.get_by_role("button", name=OFFER).wait_for()
    before = source(page, "point")
    page.keyboard.press("Tab")
    assert OFFER in page.evaluate(LABEL)
    page.keyboard.press("Enter")
    live = page.locator(".scene-text")
    scene(page, 1)
    assert live.get_attribute("aria-live") == "polite"
    until(page, f"() => ({SOURCE})('point').y[0] > 0")
    focus(page, "BUTTON Next")
    page.keyboard.press("Enter")
    scene(page, 2)
    until(page, f"() => ({SOURCE})('point').y[0] < 0")
    # the sentences follow a slider
    move_to(page, "Contraction ε")
    page.keyboard.press("Home")
    page.get_by_text("is straight and pulls").wait_for()
    move_to(page, "BUTTON Next", "Shift+Tab")
    page.keyboard.press("Enter")
    scene(page, 3)
    page.keyboard.press("Shift+Tab")
    focus(page, "BUTTON Back")
    page.keyboard.press("Enter")
    scene(page, 2)
    page.keyboard.press("Tab")
    for number in (3, 4):
        focus(page, "BUTTON Next")
        page.keyboard.press("Enter")
        scene(page, number)
    # the second unit is filled from zero up to the reversal
    turn = source(page, "turn")["x"][0]
    point = f"({SOURCE})('free_strain_point').x[0]"
    assert page.evaluate(f"() => {point}") < turn
    until(page, f"turn => {point} >= turn", arg=turn)
    reach = source(page, "equilibria")["x"]
    page.get_by_text(f"reaches only {reach[0]:.3f}").wait_for()
    focus(page, "BUTTON Done")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="4 of 4").wait_for(state="hidden")
    until(page, f"() => ({LABEL})() === 'DIV Muscle'")
    until(page, f"x => ({SOURCE})('point').x[0] === x", arg=before["x"][0])
    # the next visit has no offer, but a button
    page.evaluate("() => history.replaceState(null, '', '/')")
    page.reload()
    until(page, READY)
    page.get_by_role("button", name="The story in four steps").wait_for()
    assert not page.get_by_role("button", name=OFFER).is_visible()


@pytest.mark.slow
def test_scenes_on_a_phone_are_tidy_and_have_no_barriers_that_axe_finds(visit):
    width, height = 390, 844
    page = visit("?strain=0.1", width=width, height=height)
    page.get_by_role("button", name="The story in four steps").click()
    for number in (1, 2, 3, 4):
        scene(page, number)
        source(page, "bundle" if number == 4 else "solid")
        # curve and muscle, or bundle and its free strain, are in view with the sentences
        wait_for_layout(page)
        for figure in page.locator(".bk-Figure").all()[slice(1, 3) if number == 4 else slice(2)]:
            box = figure.bounding_box()
            assert box["y"] > 0 and box["y"] + box["height"] / 2 < height
        page.set_viewport_size({"width": width, "height": 3000})  # where nothing is covered
        for _ in range(20):  # figures shrink a while after the scene's text has come
            wait_for_layout(page)
            if not (faults := untidy(page, width)):
                break
            page.wait_for_timeout(250)  # ms
        assert (number, faults) == (number, [])
        page.set_viewport_size({"width": width, "height": height})
        if number in (1, 4):  # other scenes have the same parts
            assert (number, barriers(page)) == (number, [])
        page.get_by_role("button", name="Done" if number == 4 else "Next").click()
