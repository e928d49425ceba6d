"""The page computes what Python does, offline, in the browser."""

import re
import shutil

import numpy as np
import pytest

import fascicle as fs
from fascicle.core.errors import InvalidInputError
from fascicle.export.page import page_text, write_page
from fascicle.export.page_law import POINTS, manifest, muscle_data
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.ends import Compliant
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS


BROWSER = shutil.which("chromium")
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium: apt-get install chromium")
MUSCLES, EACH = 25, 40  # of each choice of laws, and points of each: 1000
# of the largest force: both round a root in its last bits, and the slope of a bowed muscle's
# moment carries that to some 1e-11
TOLERANCE = 1e-9
DISTANCE = 1e-6  # of strain, from a kink or a jump, beside which rounding chooses the side
FORCES = """async ([muscles, entries, points]) => {
  const module = await loadModule(document.getElementById("law").textContent);
  const laws = Object.fromEntries(Object.entries(entries).map(
    ([key, entry]) => [key, new LawFunctions(module, entry, points)]));
  return muscles.map(([data, pressures, strains]) => pressures.map((pressure, i) => {
    const muscle = new PressurizedMuscle(laws[data.law], data, pressure);
    const shape = muscle.shape(strains[i]);
    const finite = x => Number.isFinite(x) ? x : 9;
    return [muscle.force(strains[i]), muscle.force(0), muscle.free, finite(muscle.collapse),
            shape.deflection];
  }));
}"""


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(
            executable_path=BROWSER, args=["--no-sandbox", "--disable-gpu"]
        )
        yield chromium
        chromium.close()


@pytest.fixture
def visit(browser, tmp_path):
    """Open the page of a muscle or bundle from its file, offline; there is no error."""
    errors, contexts = [], []

    def open_page(target, **options):
        path = write_page(target, tmp_path / "page.html", "test")
        context = browser.new_context(offline=True, **options)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: errors.append(f"{error}"))
        page.on("console", lambda message: errors.append(message.text))
        page.goto(path.as_uri())
        page.wait_for_selector("body[data-state=ready]", timeout=60_000)  # ms, on a busy machine
        return page

    yield open_page
    for context in contexts:
        context.close()
    assert not errors


def random_muscle(rng, key):
    """A muscle with all that its data can hold: a tuning's table, factors, laws of the collapse."""
    buckling, tension, ends = key.split("/")
    length = rng.uniform(0.08, 0.3)
    radius = length / rng.uniform(14, 30)
    ends = (
        Compliant(rng.uniform(0, 0.1) * length, rng.uniform(0, 5e-6))
        if ends == "compliant"
        else "rigid"
    )
    table = rng.uniform(1e4, 1e5) * np.arange(1, 4)
    return fs.Muscle(
        length,
        radius,
        rng.uniform(0.1, 0.3) * radius,
        np.radians(rng.uniform(22, 40)),
        material=fs.MooneyRivlin(*rng.uniform(5e4, 2e5, 2), rng.uniform(5e5, 3e6)),
        tension=tension,
        buckling=buckling,
        collapse=rng.choice(list(COLLAPSE_LAWS)),
        post_collapse=rng.choice(list(POST_COLLAPSE_LAWS)),
        transition_rate=rng.uniform(10, 100),
        tuning=fs.Tuning(
            table,
            rng.uniform(0, 1, 3),
            rng.uniform(0.8, 1.1, 3),
            youngs_modulus_factor=rng.uniform(0.8, 1.2),
            collapse_moment_factor=rng.uniform(0.5, 1.2),
            hinge_stiffness_slope=rng.uniform(0, 1e-5),
            dead_band=rng.choice([0.0, 2e4]),
        ),
        ends=ends,
    )


@needs_browser
@pytest.mark.filterwarnings("ignore:The tuning was measured up to")  # beyond, too, they must agree
@pytest.mark.parametrize("key", manifest())
def test_the_module_is_of_todays_formulas(visit, key):
    rng = np.random.default_rng(7)
    page = visit(fs.example("kim2021_figure_6"))
    muscles = [random_muscle(rng, key) for _ in range(MUSCLES)]
    points = [(rng.uniform(0, 4e5, EACH), rng.uniform(0, 0.35, EACH)) for _ in muscles]
    data = [
        (muscle_data(muscle), P.tolist(), eps.tolist())
        for muscle, (P, eps) in zip(muscles, points, strict=True)
    ]
    entries = {key: manifest()[key]}
    forces = np.array(page.evaluate(FORCES, [data, entries, POINTS]))
    assert forces.shape == (MUSCLES, EACH, 5)
    compared = 0
    for muscle, (P, eps), found in zip(muscles, points, forces, strict=True):
        law = muscle.at(P)
        kinks = np.stack([law.free_strain, law.onset, law.collapse_strain])
        smooth = np.all(np.abs(kinks - eps) > DISTANCE, axis=0)
        compared += smooth.sum()
        expected = np.stack([
            muscle.force(P, eps), muscle.blocked_force(P), law.free_strain,
            np.where(np.isfinite(law.collapse_strain), law.collapse_strain, 9.0),
            muscle.deflection(P, eps),
        ], axis=-1)  # fmt: skip
        scale = np.abs(expected).max(axis=0) + 1e-3  # of a deflection of zero
        error = np.abs(found - expected)[smooth] / scale
        assert error.max() < TOLERANCE, (key, error.max(axis=0))
    assert compared > 0.99 * MUSCLES * EACH


@needs_browser
def test_a_changed_size_and_pressure_show_what_python_computes(visit):
    muscle = fs.example("kim2021_figure_6")
    page = visit(muscle)
    page.fill("#outer_radius-0", "7.5")
    page.fill("#braid_angle-0", "30")
    page.fill("#pressure-number-0", "180")
    page.fill("#strain-number", "0.15")
    changed = muscle.replace(outer_radius=7.5e-3, braid_angle=np.radians(30))
    for name, value in {
        "force": changed.force(180e3, 0.15),
        "blocked": changed.blocked_force(180e3),
        "free": changed.free_strain(180e3),
        "collapse": changed.collapse_strain(180e3),
    }.items():
        expression = f"document.getElementById('{name}-value').textContent.split(' ')[0]"
        page.wait_for_function(f"{expression} === '{value:.4g}'", timeout=10_000)  # ms, a frame


@needs_browser
def test_a_wrong_size_is_explained_and_the_figures_stay(visit):
    page = visit(fs.example("kim2021_figure_6"))
    before = page.inner_text("#force-value")
    page.fill("#wall_thickness-0", "9")
    assert page.inner_text("#message") == "The wall must be thinner than the bladder's radius."
    assert page.get_attribute("#wall_thickness-0", "aria-invalid") == "true"
    page.fill("#pressure-number-0", "5000")
    assert "must lie in 0 to 400 kPa" in page.inner_text("#message")
    page.click("#reset")
    page.wait_for_function("document.getElementById('wall_thickness-0').value === '1.6'")
    assert page.inner_text("#force-value") == before


@needs_browser
def test_a_bundles_units_and_reversal_are_the_librarys(visit):
    bundle = fs.example("kim2021_bundle_1_4")
    page = visit(bundle)
    assert page.evaluate("view.pressures[0]") == float(bundle.supply_pressure)
    page.wait_for_function("reversal && reversal.key === reversalKey()", timeout=60_000)  # ms
    turn = fs.reversal.reversal(bundle)
    pressure, free = page.evaluate("reversal.turn")
    # a search on nodes, zoomed to 1e-6 of its bracket, at a minimum or beside a jump
    assert pressure == pytest.approx(turn.pressure, rel=1e-4)
    assert free == pytest.approx(turn.free_strain, rel=1e-6)
    pressures = np.array([[413.7e3, 1e3 * x] for x in page.evaluate("reversal.x")])
    away = np.abs(pressures[:, 1] - turn.pressure) > 5e3  # Pa: from the jump
    expected = bundle.free_strain(pressures)[away]
    # both searches end within rounding of the strain
    np.testing.assert_allclose(np.array(page.evaluate("reversal.y"))[away], expected, rtol=1e-9)


@needs_browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_phones_page_scrolls_and_drags(visit, scheme):
    size = {"width": 390, "height": 844}
    page = visit(
        fs.example("kim2021_bundle_1_4"), viewport=size, color_scheme=scheme, has_touch=True,
        is_mobile=True,
    )  # fmt: skip
    assert page.evaluate("document.documentElement.scrollWidth") == size["width"]
    assert (
        page.evaluate("getComputedStyle(document.getElementById('force')).touchAction") == "pan-y"
    )
    box = page.locator("#force").bounding_box()
    session = page.context.new_cdp_session(page)
    x, y = box["x"] + 200, box["y"] + 150

    def swipe(dx, dy):
        """One finger from the middle of the curves, in steps."""
        for kind, k in (("Start", 0), *(("Move", k) for k in range(1, 11)), ("End", None)):
            points = [] if k is None else [{"x": x + dx * k / 10, "y": y + dy * k / 10}]
            session.send(
                "Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points}
            )

    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: make setup")
    violations = axe.Axe().run(page).response["violations"]
    assert [(one["id"], [node["html"] for node in one["nodes"]]) for one in violations] == []
    before = page.evaluate("view.strain")
    swipe(80, 0)
    page.wait_for_function(f"view.strain > {before}")
    dragged = page.evaluate("view.strain")
    swipe(0, -120)
    page.wait_for_function("window.scrollY > 50")
    assert page.evaluate("view.strain") == dragged


@needs_browser
def test_sliders_move_by_keyboard_and_a_picture_is_saved(visit):
    page = visit(fs.example("kim2021_figure_6"))
    for slider, value in (("strain", "view.strain"), ("pressure-0", "view.pressures[0]"),
                          ("turn-view", "view.azimuth")):  # fmt: skip
        before = page.evaluate(value)
        page.focus(f"#{slider}")
        page.keyboard.press("ArrowRight")
        page.wait_for_function(f"{value} > {before}")
    assert "force" in page.get_attribute("#strain", "aria-valuetext")
    with page.expect_download() as download:
        page.click("#save")
    assert download.value.suggested_filename == "test.png"
    assert download.value.path().read_bytes().startswith(b"\x89PNG")


def test_a_page_loads_nothing():
    text = page_text(fs.example("kim2021_bundle_1_4"), "</script> & more")
    assert not re.search(r"https?://|@import|url\(", text)
    assert re.findall(r'(?:src|href)="([^"]*)"', text) == ["data:,"]
    assert text.count("</script>") == 3  # the page's own
    assert "<h1>&lt;/script&gt; &amp; more</h1>" in text


def test_laws_that_the_module_has_not_are_refused():
    muscle = fs.example("kim2021_figure_6")
    for changes in (
        {"tension": "elastic_braid"},
        {"buckling": "elastica", "ends": "compliant"},
        {"buckling": fs.buckling.Kim2021(shear="engesser")},
    ):
        with pytest.raises(InvalidInputError) as error:
            page_text(muscle.replace(**changes))
        assert error.value.argument == "muscle" and "--c" in str(error.value)
    with pytest.raises(InvalidInputError):
        page_text(muscle, pressures=[2e6])
