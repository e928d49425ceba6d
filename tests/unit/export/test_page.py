"""The page interpolates as Python's table does, offline, in the browser."""

import re
import shutil

import numpy as np
import pytest

import fascicle as fs
from fascicle.core.errors import InvalidInputError
from fascicle.export.c_table import SHAPES
from fascicle.export.page import page_text, write_page


BROWSER = shutil.which("chromium")
needs_browser = pytest.mark.skipif(BROWSER is None, reason="no chromium: apt-get install chromium")
STATES = """([pressures, strains]) => pressures.map((pressure, i) => {
  const muscle = new PressurizedMuscle(tables[0], pressure);
  return [muscle.force(strains[i]), muscle.deflection(strains[i]), muscle.onset, muscle.collapse];
})"""


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


@needs_browser
@pytest.mark.parametrize("laws", [{}, {"buckling": "elastica", "tension": "elastic_braid"}])
def test_the_page_interpolates_as_the_table(visit, laws):
    muscle = fs.example("kim2021_figure_6").replace(**laws)
    page, table = visit(muscle), muscle.table(4e5, shape=SHAPES["double"])
    rng = np.random.default_rng(7)
    P, eps = rng.uniform(0, 4e5, 1000), rng.uniform(-0.1, 0.38, 1000)
    P[:300] = 4e5 * rng.uniform(0, 1, 300) ** 4  # in the first lines, too
    found = np.array(page.evaluate(STATES, [P.tolist(), eps.tolist()])).T
    # both evaluate one polynomial, whose co-energy of some 10 J is divided by a cell of 1 mm
    np.testing.assert_allclose(found[0], table.force(P, eps), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(found[1], table.deflection(P, eps), rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found[2], table.onset(P), rtol=1e-12)
    np.testing.assert_allclose(found[3], table.collapse_strain(P), rtol=1e-12)


@needs_browser
def test_a_pressure_and_strain_show_the_table_and_wrong_ones_are_explained(visit):
    muscle = fs.example("kim2021_figure_6")
    page, table = visit(muscle), muscle.table(4e5, shape=SHAPES["double"])
    page.fill("#pressure-number-0", "180")
    page.fill("#strain-number", "0.15")
    for name, value in {
        "force": table.force(180e3, 0.15),
        "blocked": table.force(180e3, 0.0),
        "collapse": table.collapse_strain(180e3),
        "deflection": 1e3 * table.deflection(180e3, 0.15),
    }.items():
        expression = f"document.getElementById('{name}-value').textContent.split(' ')[0]"
        page.wait_for_function(
            f"{expression} === '{float(f'{value:.4g}'):g}'", timeout=10_000
        )  # ms
    free = float(page.inner_text("#free-value"))
    assert free == pytest.approx(float(muscle.free_strain(180e3)), abs=2e-4)
    assert "Error of the table" in page.inner_text("footer")
    page.fill("#pressure-number-0", "5000")
    assert page.get_attribute("#pressure-number-0", "aria-invalid") == "true"
    assert page.locator(".error:visible").inner_text()


@needs_browser
def test_a_bundles_units_and_reversal_are_the_librarys(visit):
    bundle = fs.example("kim2021_bundle_1_4")
    page = visit(bundle)
    assert page.evaluate("view.pressures[0]") == float(bundle.supply_pressure)
    turn = fs.reversal.reversal(bundle)
    assert page.evaluate("reversal.turn") == [turn.pressure, turn.free_strain]
    jump = page.evaluate("reversal.jump")
    assert jump["x"][0] == turn.pressure / 1e3 and jump["y"][1] - jump["y"][0] > 0.03
    # at another pressure of unit 1 it is the table's
    page.fill("#pressure-number-0", "400")
    page.wait_for_function("reversal.key === reversalKey()", timeout=60_000)  # ms
    turn = fs.reversal.reversal(bundle, 2, 400e3)
    pressure, free = page.evaluate("reversal.turn")
    # no force, within the table's error, 5 N of 1 + 4 muscles, at a slope of some 4 kN
    assert abs(float(bundle.force([400e3, pressure], free))) < 5.0
    assert free == pytest.approx(turn.free_strain, abs=1.5e-3)
    jump = page.evaluate("reversal.jump")
    assert jump["x"][0] == pytest.approx(jump["x"][1], abs=1e-3)  # kPa
    assert jump["x"][0] <= pressure / 1e3 + 1e-3
    assert jump["y"][0] - jump["y"][1] > 0.03
    pressures = np.array([[400e3, 1e3 * x] for x in page.evaluate("reversal.x")])
    away = np.abs(pressures[:, 1] - turn.pressure) > 5e3  # Pa: from the jump
    found = np.array(page.evaluate("reversal.y"), dtype=float)
    np.testing.assert_allclose(found[away], bundle.free_strain(pressures)[away], atol=1.5e-3)


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
    for slider, value in (("strain", "view.strain"), ("pressure-0", "view.pressures[0]")):
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
    assert text.count("</script>") == 2  # the page's own
    assert "<h1>&lt;/script&gt; &amp; more</h1>" in text


def test_pressures_off_the_domain_are_refused():
    with pytest.raises(InvalidInputError):
        page_text(fs.example("kim2021_figure_6"), pressures=[2e6])
