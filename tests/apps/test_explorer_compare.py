"""Pinned curves in a browser: two braid angles are compared, named, linked and downloaded."""

import math

import numpy as np
from playwright.sync_api import expect

import fascicle as fs
from tests.apps import test_explorer as explorer


pytestmark = explorer.pytestmark
server, chromium, browser = explorer.server, explorer.chromium, explorer.browser
idle, visit = explorer.idle, explorer.visit
MUSCLE = fs.example("kim2021_figure_6")
TWO = "d => d.xs.length === 2"


def test_two_braid_angles_are_compared(visit):
    page = visit("?pressure=137.9kPa&strain=0.1")
    explorer.source(page, "curve")
    page.get_by_role("button", name="Pin this curve").first.click()
    page.get_by_text("Pinned in Compare as").wait_for()
    angle = explorer.field(page, "Braid angle")
    angle.fill("28 deg")
    angle.press("Enter")
    blocked = float(MUSCLE.force(137.9e3, 0.0))
    explorer.until(page, f"old => ({explorer.SOURCE})('curve').force[0] > 1.2 * old", arg=blocked)
    page.get_by_role("button", name="Pin this curve").first.click()
    page.get_by_text("“braid angle 28 deg”").wait_for()
    page.get_by_text("Compare", exact=True).first.click()
    shown = explorer.source(page, "compared", TWO)
    other = MUSCLE.replace(braid_angle=math.radians(28))
    for muscle, strain, force in zip((MUSCLE, other), shown["xs"], shown["ys"], strict=True):
        law = muscle.force(137.9e3, np.array(strain))
        np.testing.assert_allclose(force, law, rtol=1e-9, atol=1e-9)
    assert shown["dash"][0] != shown["dash"][1] and shown["color"][0] != shown["color"][1]
    # the table, and another contraction
    percent = 100 * (float(other.force(137.9e3, 0.0)) / blocked - 1)
    expect(page.locator("table").first).to_contain_text(f"(+{percent:.1f} %)")
    typed = explorer.field(page, "Contraction ε to compare at, typed")
    typed.fill("0.2")
    typed.press("Enter")
    force = f"{float(other.force(137.9e3, 0.2)):.4g}"
    expect(page.locator("table").last).to_contain_text("Force at ε = 0.2 [N]")
    expect(page.locator("table").last).to_contain_text(force)
    # a name, which stays in the link
    name = explorer.field(page, "Name of curve 2")
    name.fill("28°")
    name.press("Enter")
    explorer.source(page, "compared", "d => d.label[1] === '28°'")
    explorer.until(page, "() => location.search.includes('tab=compare')")
    shown = explorer.source(page, "compared", TWO)
    page.wait_for_timeout(1_000)  # ms: the address follows when nothing has changed for a while
    again = visit(page.evaluate("() => location.search"))
    assert explorer.source(again, "compared", TWO) == shown
    rows = explorer.shared(again, "Data (CSV)").read_text().splitlines()
    assert len(rows) == 2 * 201 + 1
    again.get_by_role("button", name="Remove 1").click()
    left = explorer.source(again, "compared", "d => d.xs.length === 1")
    assert left["label"] == ["28°"]
