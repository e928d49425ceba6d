"""The README's animation of the explorer, ten seconds of it in chromium: a muscle whose strain is
swept until it buckles and folds, then a bundle whose second unit loses pressure until it folds.

python docs/explorer_picture.py docs/_static/explorer.gif
"""

import argparse
import io
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright


STRAINS = np.r_[np.linspace(0.02, 0.26, 22), np.linspace(0.25, 0.06, 9)]
PRESSURES = np.r_[np.linspace(210, 21, 22), np.linspace(40, 200, 9)]  # kPa
VIEW = {"width": 1280, "height": 760}
SHOWN, COLORS = 0.62, 128  # of its size, and how many colors
SECONDS = 10.0
FIRST = "Bokeh.documents[0].get_model_by_name(name)?.data[column]?.[0]"
READY = f"""([name, column]) => window.Bokeh && Bokeh.documents.length
  && Bokeh.documents[0].is_idle && {FIRST} !== undefined"""
CHANGED = f"([name, column, before]) => {FIRST} !== before"


def swept(
    page: Page, address: str, label: str, source: list[str], texts: list[str]
) -> list[Image.Image]:
    """The page at an `address`, for each of the `texts` in the field of a `label`: when a
    `source`'s column, which the scene changes with, has another first number.
    """
    page.goto(address)
    page.wait_for_function(READY, arg=source)
    page.wait_for_timeout(1500)
    field, taken = page.get_by_label(label).first, []
    for text in texts:
        before = page.evaluate(f"([name, column]) => {FIRST}", source)
        field.fill(text)
        field.press("Enter")
        page.wait_for_function(CHANGED, arg=[*source, before])
        page.wait_for_timeout(250)
        taken.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
    return taken


def frames(url: str) -> list[Image.Image]:
    """The page, moment by moment."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = browser.new_page(viewport=VIEW)
        page.set_default_timeout(120_000)
        muscle = swept(
            page, f"{url}?pressure=69kPa&strain=0.01", "Contraction ε, typed", ["point", "x"],
            [f"{strain:.4g}" for strain in STRAINS],
        )  # fmt: skip
        bundle = swept(
            page,
            f"{url}?muscle=kim2021_bundle_1_4&tab=bundle&strain=0.2&pressures=344.7kPa,220kPa",
            "Pressure P2, typed", ["bundle_force", "force"],
            [f"{pressure:.4g} kPa" for pressure in PRESSURES],
        )  # fmt: skip
        browser.close()
    return muscle + bundle


def main(path: Path) -> None:
    """Serve, visit and write the animation."""
    command = [sys.executable, "-m", "fascicle", "explore", "kim2021_figure_6", "--no-show"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)  # noqa: S603 our own
    try:
        assert server.stdout is not None
        url = next(
            found.group() for line in server.stdout if (found := re.search(r"http\S+", line))
        )
        taken = frames(url)
    finally:
        server.terminate()
        server.wait(30)
    size = (round(VIEW["width"] * SHOWN), round(VIEW["height"] * SHOWN))
    small = [one.resize(size, Image.Resampling.LANCZOS) for one in taken]
    # one palette of both tabs, so that only what moves is stored again
    both = Image.new("RGB", (size[0], 2 * size[1]))
    both.paste(small[len(small) // 4], (0, 0))
    both.paste(small[-len(small) // 4], (0, size[1]))
    palette = both.quantize(COLORS, kmeans=2)
    first, *rest = (one.quantize(palette=palette, dither=Image.Dither.NONE) for one in small)
    each = round(1e3 * SECONDS / len(small))
    first.save(path, save_all=True, append_images=rest, duration=each, loop=0, optimize=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    main(parser.parse_args().out)
