"""Pages are executed in a warm kernel, each in an empty namespace; the longest come first.

Starting a kernel, and importing what nearly every page imports, takes longer than most pages do:
each of the processes that read pages has one. A page may count on nothing of the one before it: its
names are gone, its figures closed, its folder left. A page with cells needs no header: here it gets
that of a notebook.
"""

import functools
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any

from jupyter_cache.executors.utils import ExecutionResult, single_nb_execution
from jupyter_client.manager import AsyncKernelManager
from jupyter_core.utils import run_sync
from myst_nb.core.execute import direct
from nbformat.v4 import new_code_cell
from sphinx import builders
from sphinx.application import Sphinx
from sphinx.util.parallel import make_chunks


# seconds that pages take, as measured, where that is more than three: a page's code doesn't tell
_LONG = {
    "design": 11, "api": 10, "calibrate": 8, "control": 8, "dynamics": 5, "export": 5,
    "how-to/mujoco": 5, "how-to/plc": 4, "how-to/train": 4, "cli": 4, "theory/crossing": 3,
}  # fmt: skip

HEADER = """---
file_format: mystnb
kernelspec:
  name: python3
language_info:
  name: ipython3
---

"""
# one batch for each process: another one would begin with another kernel
_chunks = functools.partial(make_chunks, maxbatch=1_000)

# `%reset` comes last: it takes these names along
BEGIN = """import gc, os
from matplotlib import pyplot
gc.set_threshold(50_000, 10, 10)
os.chdir({folder!r})
pyplot.close("all")
%reset -f"""


@functools.cache
def kernel() -> tuple[AsyncKernelManager, Any]:
    """The kernel of a process, which ends with it, and who talks to it."""
    started = AsyncKernelManager(kernel_name="python3")
    run_sync(started.start_kernel)()
    Finalize(None, run_sync(started.shutdown_kernel), kwargs={"now": True}, exitpriority=1)
    client = started.client()
    client.start_channels()
    run_sync(client.wait_for_ready)()
    client.allow_stdin = False
    return started, client


def execute(page: Any, cwd: str, **options: Any) -> ExecutionResult:
    """Execute a page in its folder."""
    started, client = kernel()
    page.cells.insert(0, new_code_cell(BEGIN.format(folder=cwd)))
    done = single_nb_execution(page, cwd, km=started, kc=client, **options)
    page.cells.pop(0)
    return done


def dealt(times: dict[str, float], sizes: list[int]) -> list[list[str]]:
    """Names, by how long they take, in batches of these sizes: the longest first, each to the batch
    that has least to do so far.
    """
    batches: list[list[str]] = [[] for _ in sizes]
    for name in sorted(times, key=lambda name: -times[name]):
        open_ones = [x for x, size in zip(batches, sizes, strict=True) if len(x) < size]
        min(open_ones, key=lambda batch: sum(times[one] for one in batch)).append(name)
    return batches


def put_in_order(app: Sphinx, _: Any, names: list[str]) -> None:
    """Spread the pages that take long over the batches that processes take in turn."""

    def time(name: str) -> float:
        cells = Path(app.env.doc2path(name)).read_text(encoding="utf-8").count("{code-cell}")
        return _LONG.get(name, 0.5 + 0.1 * cells)

    sizes = [len(batch) for batch in _chunks(names, app.parallel)]
    batches = dealt({name: time(name) for name in names}, sizes)
    names[:] = [name for batch in batches for name in batch]


def add_header(_: Sphinx, __: str, source: list[str]) -> None:
    """Make a page with cells a notebook."""
    if "```{code-cell}" in source[0]:
        source[0] = HEADER + source[0]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx, and with it and myst-nb, which have no option for it."""
    direct.single_nb_execution = execute
    builders.make_chunks = _chunks
    app.connect("env-before-read-docs", put_in_order)
    app.connect("source-read", add_header)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
