"""The explorer: how soon each tab's first picture is there, how fast a slider is answered, and
what many visitors take of the server's time and memory.

In headless chromium: each tab's first picture, from the address entered until the page is idle
and the picture's data are in it, on a server that was just started and has computed nothing, its
cache of compiled functions empty; and from the keydown on a slider until the curve's new data.

Without a browser (`visitors`): `--clients` move their sliders at once, each as soon as it is
answered, and the time is the server's own, from a move sent to its curve received; `--sessions`
are opened and left one after another, every tab in turn, and the server's memory is told as it
goes. Its processor time is told as well, which a busy machine lengthens less.

The standalone page of `fascicle export --page` is drawn again at other strains, layout included.

    python benchmarks/explorer.py --clients 20 --sessions 300
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from visitors import SHOWN, opened, together


BROWSER = shutil.which("chromium") or shutil.which("google-chrome")
READY = """name => window.Bokeh && Bokeh.documents.length && Bokeh.documents[0].is_idle
  && Object.values(Bokeh.documents[0].get_model_by_name(name)?.data ?? {}).some(x => x.length)"""
# resolves with the milliseconds from the key to the data, and paints once more
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

# a frame at each of so many strains; reading a height completes the layout
REDRAW = """async count => {
  const times = [];
  for (let i = 0; i < count; i++) {
    await new Promise(requestAnimationFrame);
    view.strain = 0.3 * (i + 1) / count;
    const begun = performance.now();
    render();
    document.body.offsetHeight;
    times.push(performance.now() - begun);
  }
  return times;
}"""


def served(target: str, folder: str) -> tuple[subprocess.Popen, str, float]:
    """A server that keeps what it compiles in a `folder`, its address, and the seconds until it
    said so.
    """
    begun = time.perf_counter()
    process = subprocess.Popen(  # noqa: S603 this package's own command
        [sys.executable, "-m", "fascicle", "explore", target, "--no-show"],
        stdout=subprocess.PIPE, text=True, env=os.environ | {"XDG_CACHE_HOME": folder},
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


def first_pictures(browser: Any) -> tuple[dict[str, float], list[str]]:
    """Seconds to each tab's first picture, each on a server of its own; and what went wrong."""
    found, wrong = {}, []
    for tab, name in SHOWN.items():
        with tempfile.TemporaryDirectory() as folder:
            process, url, _ = served("kim2021_bundle_1_4", folder)
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.on("pageerror", lambda error: wrong.append(str(error)))
            begun = time.perf_counter()
            page.goto(f"{url}?tab={tab}")
            page.wait_for_function(READY, arg=name, polling=20, timeout=120_000)
            found[tab] = time.perf_counter() - begun
            page.close()
            process.terminate()
            process.wait(30)
    return found, wrong


def keyed(page: Any, keys: int) -> list[float]:
    """Milliseconds of `keys` keydowns, one after another."""
    page.evaluate(WATCH)
    page.locator(".noUi-handle").first.focus()
    for i in range(keys):
        page.keyboard.press("ArrowRight" if i % 40 < 20 else "ArrowLeft")
        page.wait_for_function("n => window.times.length >= n", arg=i + 1, polling=20)
    return page.evaluate("window.times")


def page_redraws(browser: Any, folder: str, count: int) -> list[float]:
    """Milliseconds in which the standalone page draws a bundle at each of `count` strains."""
    path = Path(folder) / "page.html"
    subprocess.run(  # noqa: S603 this package's own command
        [sys.executable, "-m", "fascicle", "export", "kim2021_bundle_1_4", "--page", str(path)],
        check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.goto(path.as_uri())
    page.wait_for_selector("body[data-state=ready]", timeout=120_000)
    times = page.evaluate(REDRAW, count)
    page.close()
    return times


def measure(clients: int, sessions: int, keys: int) -> dict:
    from playwright.sync_api import sync_playwright

    with tempfile.TemporaryDirectory() as folder:
        process, url, up = served("kim2021_bundle_1_4", folder)
        found: dict = {"server_up_s": up, "server_MB": resident(process.pid)}
        try:
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"])
                page = browser.new_page(viewport={"width": 1280, "height": 800})
                page.goto(url)
                page.wait_for_function(READY, arg="curve", timeout=120_000)
                found["slider_ms"] = spread(keyed(page, keys))
                page.close()
                found["page_redraw_ms"] = spread(page_redraws(browser, folder, keys))
                found["first_picture_s"], found["errors"] = first_pictures(browser)
                browser.close()
            if clients:
                times, spent = together(
                    url, clients, max(keys // 4, 5), lambda: worked(process.pid)
                )
                found[f"slider_ms_{clients}_clients"] = spread([1e3 * one for one in times])
                found["server_ms_a_move"] = 1e3 * spent / len(times)
            if sessions:
                found["session_s"], found["server_MB_after_sessions"] = grown(
                    url, sessions, process.pid
                )
        finally:
            process.terminate()
            process.wait(30)
    return found


def grown(url: str, sessions: int, pid: int) -> tuple[dict[str, float], dict[int, float]]:
    """How long sessions take to their first picture, one after another; and the server's memory
    in megabytes after so many.
    """
    times, memory, done = [], {}, 0
    while done < sessions:
        several = min(50, sessions - done)
        times += opened(url, several)
        done += several
        memory[done] = resident(pid)
    return spread(times), memory


def spread(times: list[float]) -> dict[str, float]:
    median, high = np.percentile(times, [50, 95])
    return {"median": float(median), "p95": float(high), "count": len(times)}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clients", type=int, default=0)
    parser.add_argument("--sessions", type=int, default=0)
    parser.add_argument("--keys", type=int, default=100)
    given = parser.parse_args()
    print(json.dumps(measure(given.clients, given.sessions, given.keys), indent=2))
