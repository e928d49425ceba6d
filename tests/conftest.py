"""Turns the package's annotations into checks, before anything imports it."""

import gc
import os
import sys
from pathlib import Path


# workers share the cores: each one's linear algebra on all of them would wait for the others'
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import jaxtyping
import pytest


sys.path.insert(0, str(Path(__file__).parent))

from kinds import checked_once
from quick import compile_in_a_hurry


_MANY_MAPS = 20_000

# tracing makes so many objects that to look for those which nobody needs took a tenth of the time
gc.set_threshold(50_000, 10, 10)

jaxtyping.jaxtyped = checked_once
jaxtyping.install_import_hook("fascicle", "beartype.beartype")


def pytest_configure(config):
    """Compiling is most of the time: workers share it, and the next run finds it. What commands
    remember of files that they wrote isn't the user's own.
    """
    folder = compile_in_a_hurry(config.rootpath)
    os.environ["XDG_STATE_HOME"] = str(folder.parent / "state")


@pytest.fixture(autouse=True, scope="module")
def memory_maps_are_freed():
    """Compiled functions each take several memory maps, of which a process may have 65530: a
    worker that keeps all of them ends in a segmentation fault.
    """
    yield
    import jax  # after the hook, and only in workers that used it

    maps = Path("/proc/self/maps")
    if maps.exists() and maps.read_bytes().count(b"\n") > _MANY_MAPS:
        jax.clear_caches()
        gc.collect()
