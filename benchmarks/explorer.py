"""The explorer in headless chromium: how long from a key to the new picture.

From the keydown on a slider until the source of the curve holds the new data in the browser,
one key after another; how long the server takes to say where it is, warm, and the page until it
is idle. With `--clients` as many pages move their sliders at once, each as fast as it is
answered, and the time is taken from a move to the new data. They draw nothing, but still share
this machine with the server, which twenty visitors don't: its own processor time for each move
is told as well. `--cycles` opens and closes pages and looks at the
server's memory before and after, once closed sessions are freed.

    python benchmarks/explorer.py --clients 20 --cycles 200
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np


BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
READY = "window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle"
# resolves with the milliseconds from the key to the data, and paints once more
WATCH = """() => {
  window.times = []; window.pressed = 0;
  const source = Bokeh.documents[0].get_model_by_name('chosen');
  document.addEventListener('keydown', () => { window.pressed = performance.now(); }, true);
  source.properties.data.change.connect(() => {
    if (!window.pressed) return;
    window.times.push(performance.now() - window.pressed);
    window.pressed = 0;
  });
}"""


# the pressure's slider, moved by itself as soon as the curve holds what the last move gave
DRIVE = """moves => {
  document.body.style.display = 'none';
  const models = [...Bokeh.documents[0]._all_models.values()];
  const slider = models.find(one => one.type === 'Slider' && one.title.startsWith('Pressure P'));
  const source = Bokeh.documents[0].get_model_by_name('chosen');
  let begun, count = 0;
  window.times = []; window.moves = moves;
  window.move = () => {
    if (count === moves) return;
    begun = performance.now();
    slider.value += slider.step * (count % 40 < 20 ? 1 : -1);
    count += 1;
  };
  source.properties.data.change.connect(() => {
    window.times.push(performance.now() - begun);
    setTimeout(window.move, 0);
  });
}"""


def served(target: str) -> tuple[subprocess.Popen, str, float]:
    """A server, its address, and the seconds until it said so."""
    begun = time.perf_counter()
    process = subprocess.Popen(  # noqa: S603 this package's own command
        [sys.executable, "-m", "fascicle", "explore", target, "--no-show"],
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stdout is not None
    for line in process.stdout:
        if found := re.search(r"http://\S+", line):
            return process, found.group(), time.perf_counter() - begun
    raise RuntimeError("the server has ended")


def resident(pid: int) -> float:
    """Memory of a process, in megabytes."""
    text = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    return int(re.search(r"VmRSS:\s+(\d+)", text)[1]) / 1024  # type: ignore[index]


def worked(pid: int) -> float:
    """Seconds of processor time that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def keyed(page: Any, keys: int) -> list[float]:
    """Milliseconds of `keys` keydowns, one after another."""
    page.evaluate(WATCH)
    page.locator(".noUi-handle").first.focus()
    for i in range(keys):
        page.keyboard.press("ArrowRight" if i % 40 < 20 else "ArrowLeft")
        page.wait_for_function("n => window.times.length >= n", arg=i + 1, polling=20)
    return page.evaluate("window.times")


def together(pages: list, moves: int) -> list[float]:
    """Milliseconds of `moves` of a slider on each page, all pages at once."""
    for page in pages:
        page.evaluate(DRIVE, moves)
    for page in pages:
        page.evaluate("window.move()")
    for page in pages:
        page.wait_for_function("window.times.length >= window.moves", timeout=300_000)
    return [x for page in pages for x in page.evaluate("window.times")]


def measure(clients: int, cycles: int, keys: int) -> dict:
    from playwright.sync_api import sync_playwright

    first, *_ = served("kim2021_figure_6")  # fills the cache of compiled functions
    first.terminate()
    first.wait()
    process, url, up = served("kim2021_figure_6")
    found: dict = {"server_up_s": up}
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])

            def opened() -> tuple:
                page = browser.new_page(viewport={"width": 1280, "height": 800})
                errors: list[str] = []
                page.on("pageerror", lambda error: errors.append(str(error)))
                begun = time.perf_counter()
                page.goto(url)
                page.wait_for_function(READY, timeout=120_000)
                return page, errors, time.perf_counter() - begun

            page, errors, found["first_load_s"] = opened()
            keyed(page, 5)
            page.reload()
            page.wait_for_function(READY)
            times = keyed(page, keys)
            found["slider_ms"] = spread(times)
            page.close()
            if clients:
                several = [opened() for _ in range(clients)]
                spent = worked(process.pid)
                times = together([one for one, _, _ in several], keys // 4)
                found[f"slider_ms_{clients}_clients"] = spread(times)
                spent = worked(process.pid) - spent
                found["server_ms_a_move"] = 1e3 * spent / len(times)
                errors += [text for _, more, _ in several for text in more]
                for one, _, _ in several:
                    one.close()
            if cycles:
                for _ in range(10):
                    opened()[0].close()
                time.sleep(20)
                before = resident(process.pid)
                for _ in range(cycles):
                    one, more, _ = opened()
                    errors += more
                    one.close()
                time.sleep(25)
                found[f"grown_MB_{cycles}_cycles"] = resident(process.pid) - before
            found["errors"] = errors
            browser.close()
    finally:
        process.terminate()
        process.wait(30)
    return found


def spread(times: list[float]) -> dict[str, float]:
    median, high = np.percentile(times, [50, 95])
    return {"median": float(median), "p95": float(high), "count": len(times)}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clients", type=int, default=0)
    parser.add_argument("--cycles", type=int, default=0)
    parser.add_argument("--keys", type=int, default=100)
    given = parser.parse_args()
    print(json.dumps(measure(given.clients, given.cycles, given.keys), indent=2))
