"""The README's animation of the explorer: its muscle's tab while a strain is swept, in chromium.

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
from playwright.sync_api import sync_playwright


STRAINS = np.r_[np.linspace(0.02, 0.26, 17), np.linspace(0.24, 0.04, 6)]
VIEW = {"width": 1280, "height": 800}
SHOWN, COLORS = 0.7, 255  # of its size, and how many colors
READY = "window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle"
HERE = "strain => Bokeh.documents[0].get_model_by_name('here').data.x[0] === strain"


def frames(url: str) -> list[Image.Image]:
    """The page at each of the strains."""
    taken = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox"]
        )
        page = browser.new_page(viewport=VIEW)
        page.goto(f"{url}?pressure=69kPa")
        page.wait_for_function(READY)
        field = page.get_by_label("Contraction ε, typed").first
        for strain in STRAINS.round(3).tolist():
            field.fill(str(strain))
            field.press("Enter")
            page.wait_for_function(HERE, arg=strain)
            page.wait_for_timeout(200)
            taken.append(Image.open(io.BytesIO(page.screenshot())).convert("RGB"))
        browser.close()
    return taken


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
    # one palette, so that only what moves is stored again
    palette = small[len(small) // 2].quantize(COLORS, kmeans=2)
    first, *rest = (one.quantize(palette=palette, dither=Image.Dither.NONE) for one in small)
    first.save(path, save_all=True, append_images=rest, duration=140, loop=0, optimize=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    main(parser.parse_args().out)
