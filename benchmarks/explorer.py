"""The explorer in headless chromium: answers to a slider, and first pictures.

From the keydown on a slider to the curve's new data; each tab's first
picture, from the address entered to the picture's data in an idle page, of a new server with an
empty cache; and how long the standalone page of `fascicle export --page` draws, with its layout.

    python benchmarks/explorer.py
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from timing import Quartiles, Row, run


BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
BUNDLE = "kim2021_bundle_1_4"
# of each tab, the source that has the data of its first picture
FIRST_SOURCE = {"muscle": "curve", "bundle": "regions", "data": "untuned"}
MINUTES = 120_000  # ms until chromium gives up
READY = """name => window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle
  && Object.values(Bokeh.documents[0].get_model_by_name(name)?.data ?? {}).some(x => x.length)"""
# notes the milliseconds from a key to the data
WATCH = """() => {
  window.times = []; window.pressed = 0;
  const source = Bokeh.documents[0].get_model_by_name('curve');
  document.addEventListener('keydown', () => { window.pressed = performance.now(); }, true);
  source.properties.data.change.connect(() => {
    if (!window.pressed) return;
    window.times.push(performance.now() - window.pressed);
    window.pressed = 0;
  });
}"""
# a frame for each strain; reading a height completes the layout
REDRAW = """async count => {
  const times = [];
  for (let i = 0; i < count; i++) {
    await new Promise(requestAnimationFrame);
    view.strain = 0.3 * (i + 1) / count;
    const begin = performance.now();
    render();
    document.body.offsetHeight;
    times.push(performance.now() - begin);
  }
  return times;
}"""


@contextmanager
def serve() -> Iterator[str]:
    """Address of a new server with an empty cache."""
    with (
        tempfile.TemporaryDirectory() as folder,
        subprocess.Popen(  # noqa: S603 this package's own command
            [sys.executable, "-m", "fascicle", "explore", BUNDLE, "--no-show"],
            stdout=subprocess.PIPE, text=True, env=os.environ | {"XDG_CACHE_HOME": folder},
        ) as process,
    ):  # fmt: skip
        assert process.stdout is not None
        try:
            yield next(url[0] for line in process.stdout
                       if (url := re.search(r"http://\S+", line)))  # fmt: skip
        finally:
            process.terminate()
            process.wait(30)


def open_page(browser: Any, url: str) -> Any:
    """A page of the browser at an address."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.on("pageerror", lambda error: sys.exit(f"the page has an error: {error}"))
    page.goto(url)
    return page


def slider_answers(browser: Any, url: str, keys: int) -> list[float]:
    """Milliseconds from each keydown to the curve's data."""
    page = open_page(browser, url)
    page.wait_for_function(READY, arg="curve", timeout=MINUTES)
    page.evaluate(WATCH)
    page.locator(".noUi-handle").first.focus()
    for i in range(keys):
        page.keyboard.press("ArrowRight" if i % 40 < 20 else "ArrowLeft")
        page.wait_for_function("n => window.times.length >= n", arg=i + 1, polling=20)
    times = page.evaluate("window.times")
    page.close()
    return times


def first_picture(browser: Any, tab: str) -> float:
    """Seconds to a tab's first picture, on a new server."""
    with serve() as url:
        begin = time.perf_counter()
        page = open_page(browser, f"{url}?tab={tab}")
        page.wait_for_function(READY, arg=FIRST_SOURCE[tab], polling=20, timeout=MINUTES)
        seconds = time.perf_counter() - begin
        page.close()
    return seconds


def redraws(browser: Any, count: int) -> list[float]:
    """Milliseconds in which the standalone page draws a bundle at each of many strains."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        command = [sys.executable, "-m", "fascicle", "export", BUNDLE, "--page", str(path)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # noqa: S603 as above
        page = open_page(browser, path.as_uri())
        page.wait_for_selector("body[data-state=ready]", timeout=MINUTES)
        times = page.evaluate(REDRAW, count)
        page.close()
    return times


def browser_rows(url: str, keys: int, tabs: list[str]) -> list[Row]:
    """Rows of chromium."""
    if BROWSER is None:
        return [Row("explorer: in a browser", None, "ms", note="it needs chromium")]
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
        answers = Quartiles.of(slider_answers(browser, url, keys))
        drawing = Quartiles.of(redraws(browser, keys))
        pictures = {tab: Quartiles.of([first_picture(browser, tab)]) for tab in tabs}
        browser.close()
    return [
        Row("explorer: key on a slider to the curve's data", answers, "ms", at_most=60),
        Row("explorer: redraw of the standalone page", drawing, "ms"),
        *(Row(f"explorer: first picture of the tab {tab}", seconds, "s", note="of a new server")
          for tab, seconds in pictures.items()),
    ]  # fmt: skip


def rows(small: bool = False) -> list[Row]:
    """Times in a browser."""
    with serve() as url:
        return browser_rows(url, 3 if small else 100, list(FIRST_SOURCE)[: 1 if small else None])


if __name__ == "__main__":
    run(rows, __doc__)
