"""The explorer in headless chromium: how long from a key to the new picture.

From the keydown on a slider until the source of the curve holds the new data in the browser,
one key after another; how long the server takes to say where it is, warm, and the page until it
is idle. With `--clients` as many visitors move their sliders at once, each as fast as it is
answered, and the time is taken from a move to the new data. They speak the browser's protocol
but draw nothing: twenty browsers wouldn't share this machine with the server. `--cycles` opens
and closes pages and looks at the server's memory before and after, once closed sessions are
freed.

    python benchmarks/explorer.py --clients 20 --cycles 200
"""

import argparse
import asyncio
import json
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import numpy as np


BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
PATIENCE = 60  # s
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


def keyed(page: Any, keys: int) -> list[float]:
    """Milliseconds of `keys` keydowns, one after another."""
    page.evaluate(WATCH)
    page.locator(".noUi-handle").first.focus()
    for i in range(keys):
        page.keyboard.press("ArrowRight" if i % 40 < 20 else "ArrowLeft")
        page.wait_for_function("n => window.times.length >= n", arg=i + 1, polling=20)
    return page.evaluate("window.times")


def together(url: str, clients: int, moves: int) -> list[float]:
    """Milliseconds of `moves` of a slider by each of `clients`, all at once."""
    with ThreadPoolExecutor(clients) as pool:
        meet = Barrier(clients)
        runs = [pool.submit(moved, url, moves, meet) for _ in range(clients)]
        return [x for run in runs for x in run.result()]


def moved(url: str, moves: int, meet: Barrier) -> list[float]:
    """One client's: from a move of the pressure's slider to the curve's new data."""
    from bokeh.client import pull_session

    asyncio.set_event_loop(asyncio.new_event_loop())
    session = pull_session(url=url)
    document = session.document
    slider = next(
        model for model in document.models
        if type(model).__name__ == "Slider" and str(model.title).startswith("Pressure P")
    )  # fmt: skip
    source = document.get_model_by_name("chosen")
    arrived: list[float] = []
    source.on_change("data", lambda *_: arrived.append(time.perf_counter()))
    meet.wait()
    times = []
    for i in range(moves):
        arrived.clear()
        begun = time.perf_counter()
        slider.value += slider.step * (1 if i % 40 < 20 else -1)
        while not arrived:
            session.force_roundtrip()
            if time.perf_counter() - begun > PATIENCE:
                raise TimeoutError(f"no new curve within {PATIENCE} s")
        times.append(1e3 * (arrived[0] - begun))
    session.close()
    return times


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
                found[f"slider_ms_{clients}_clients"] = spread(together(url, clients, keys // 4))
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
