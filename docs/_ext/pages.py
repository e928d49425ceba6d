"""Pages are executed in a warm kernel, each in an empty namespace; those with most code come first.

Starting a kernel, and importing what nearly every page imports, takes longer than most pages do:
each of the processes that read pages has one. A page may count on nothing of the one before it: its
names are gone, its figures closed, its folder left.
"""

import functools
from collections import deque
from multiprocessing.util import Finalize
from pathlib import Path
from typing import Any

from jupyter_cache.executors.utils import ExecutionResult, single_nb_execution
from jupyter_client.manager import AsyncKernelManager
from jupyter_core.utils import run_sync
from myst_nb.core.execute import direct
from nbformat.v4 import new_code_cell, new_notebook
from sphinx.application import Sphinx
from sphinx.util.parallel import make_chunks


# `%reset` comes last: it takes these names along
BEGIN = """import gc, os
from matplotlib import pyplot
gc.set_threshold(50_000, 10, 10)
os.chdir({folder!r})
pyplot.close("all")
%reset -f"""


@functools.cache
def kernel() -> AsyncKernelManager:
    """The kernel of a process, which ends with it."""
    started = AsyncKernelManager(kernel_name="python3")
    run_sync(started.start_kernel)()
    Finalize(None, run_sync(started.shutdown_kernel), kwargs={"now": True}, exitpriority=1)
    return started


def execute(page: Any, cwd: str, **options: Any) -> ExecutionResult:
    """Execute a page in its folder."""
    begin = new_notebook(cells=[new_code_cell(BEGIN.format(folder=cwd))])
    begun = single_nb_execution(begin, cwd, timeout=60, allow_errors=False, km=kernel())
    if begun.err is not None:
        return begun
    return single_nb_execution(page, cwd, km=kernel(), **options)


def dealt(names: list[str], sizes: list[int]) -> list[list[str]]:
    """Names, dealt in turn to batches of these sizes."""
    batches: list[list[str]] = [[] for _ in sizes]
    left = deque(names)
    while left:
        for batch, size in zip(batches, sizes, strict=True):
            if left and len(batch) < size:
                batch.append(left.popleft())
    return batches


def put_in_order(app: Sphinx, _: Any, names: list[str]) -> None:
    """Spread the pages with most code over the batches that processes take in turn."""

    def cells(name: str) -> int:
        return Path(app.env.doc2path(name)).read_text(encoding="utf-8").count("{code-cell}")

    sizes = [len(batch) for batch in make_chunks(names, app.parallel)]
    batches = dealt(sorted(names, key=cells, reverse=True), sizes)
    names[:] = [name for batch in batches for name in batch]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx, and with myst-nb, which has no option for it."""
    direct.single_nb_execution = execute
    app.connect("env-before-read-docs", put_in_order)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
