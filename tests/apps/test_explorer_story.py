"""The story in a browser, by keyboard alone: offered once, and left as it was found."""

import re

import pytest

from tests.apps import test_explorer as explorer


pytestmark = explorer.pytestmark
server, chromium, browser = explorer.server, explorer.chromium, explorer.browser
idle, visit = explorer.idle, explorer.visit
OFFER = "See in four steps"


def scene(page, number):
    page.get_by_role("heading", name=f"{number} of 4").wait_for()


def focus(page, label):
    """Wait until the focus is on a widget with a `label`, whose outline is visible."""
    explorer.until(page, f"label => ({explorer.LABEL})() === label", arg=label)
    style = page.evaluate("""() => { let at = document.activeElement;
      while (at?.shadowRoot?.activeElement) at = at.shadowRoot.activeElement;
      const { outlineStyle, outlineWidth } = getComputedStyle(at);
      return `${outlineStyle} ${outlineWidth}`; }""")
    assert re.match(r"solid [1-9]", style)


@pytest.fixture
def first_visit(visit):
    """Open an address as in a browser that has not seen the offer."""

    def open_page(query="", **size):
        page = visit(query, **size)
        page.evaluate("() => localStorage.removeItem('fascicle-story')")
        page.reload()
        explorer.until(page, explorer.READY)
        return page

    return open_page


def test_the_story_goes_by_keyboard_alone_and_leaves_the_inputs(first_visit):
    page = first_visit()
    page.get_by_role("button", name=OFFER).wait_for()
    before = explorer.source(page, "point")
    page.keyboard.press("Tab")
    assert OFFER in page.evaluate(explorer.LABEL)
    page.keyboard.press("Enter")
    live = page.locator(".scene-text")
    scene(page, 1)
    assert live.get_attribute("aria-live") == "polite"
    explorer.until(page, f"() => ({explorer.SOURCE})('point').y[0] > 0")
    focus(page, "BUTTON Next")
    page.keyboard.press("Enter")
    scene(page, 2)
    explorer.until(page, f"() => ({explorer.SOURCE})('point').y[0] < 0")
    # the sentences follow a slider
    explorer.move_to(page, "Contraction ε")
    page.keyboard.press("Home")
    page.get_by_text("is straight and pulls").wait_for()
    explorer.move_to(page, "BUTTON Next", "Shift+Tab")
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
    turn = explorer.source(page, "turn")["x"][0]
    point = f"({explorer.SOURCE})('free_strain_point').x[0]"
    assert page.evaluate(f"() => {point}") < turn
    explorer.until(page, f"turn => {point} >= turn", arg=turn)
    reach = explorer.source(page, "equilibria")["x"]
    page.get_by_text(f"reaches only {reach[0]:.3f}").wait_for()
    focus(page, "BUTTON Done")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="4 of 4").wait_for(state="hidden")
    explorer.until(page, f"() => ({explorer.LABEL})() === 'DIV Muscle'")
    explorer.until(page, f"x => ({explorer.SOURCE})('point').x[0] === x", arg=before["x"][0])
    # the next visit has no offer, but a button
    page.evaluate("() => history.replaceState(null, '', '/')")
    page.reload()
    explorer.until(page, explorer.READY)
    page.get_by_role("button", name="The story in four steps").wait_for()
    assert not page.get_by_role("button", name=OFFER).is_visible()


def test_scenes_on_a_phone_are_tidy_and_have_no_barriers_that_axe_finds(visit):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="no axe: make setup")
    width, height = 390, 844
    page = visit("?strain=0.1", width=width, height=height)
    page.get_by_role("button", name="The story in four steps").click()
    for number in (1, 2, 3, 4):
        scene(page, number)
        explorer.source(page, "bundle" if number == 4 else "solid")
        # curve and muscle, or bundle and its free strain, are in view with the sentences
        explorer.wait_for_layout(page)
        for figure in page.locator(".bk-Figure").all()[slice(1, 3) if number == 4 else slice(2)]:
            box = figure.bounding_box()
            assert box["y"] > 0 and box["y"] + box["height"] / 2 < height
        page.set_viewport_size({"width": width, "height": 3000})  # where nothing is covered
        for _ in range(20):  # figures shrink a while after the scene's text has come
            explorer.wait_for_layout(page)
            if not (faults := explorer.untidy(page, width)):
                break
            page.wait_for_timeout(250)  # ms
        assert (number, faults) == (number, [])
        page.set_viewport_size({"width": width, "height": height})
        if number in (1, 4):  # other scenes have the same parts
            violations = axe.Axe().run(page).response["violations"]
            grave = [fault["id"] for fault in violations
                     if fault["impact"] in ("serious", "critical")]  # fmt: skip
            assert (number, grave) == (number, [])
        page.get_by_role("button", name="Done" if number == 4 else "Next").click()
