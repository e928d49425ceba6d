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

import kinds
from quick import compile_in_a_hurry


_MANY_MAPS = 20_000

# tracing makes so many objects that to look for those which nobody needs took a tenth of the time
gc.set_threshold(50_000, 10, 10)

jaxtyping.jaxtyped = kinds.checked_once
jaxtyping.install_import_hook("fascicle", "beartype.beartype")

# compiling is most of the time: workers share it, and the next run finds it. Here, since JAX reads
# it when a folder's own conftest imports it
_folder = compile_in_a_hurry(Path(__file__).parents[1])
# what commands remember of files that they wrote isn't the user's own
os.environ["XDG_STATE_HOME"] = str(_folder.parent / "state")


def pytest_configure(config):
    """The slow ones look at each call."""
    if config.option.markexpr == "slow":
        kinds.look_at_each()


def pytest_collection_finish():
    """What is imported by now stays: nobody needs to look through it each time."""
    gc.collect()
    gc.freeze()


def pytest_runtest_setup():
    """What one test calls often is looked at again in the next."""
    kinds.begin()


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
