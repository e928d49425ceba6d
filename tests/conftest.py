"""What all tests share: few threads, a folder of compiled functions, and freed memory maps."""

import gc
import os
import re
import sys
from importlib.util import find_spec
from pathlib import Path


# workers share the cores: each one's linear algebra on all of them would wait for the others'
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

sys.path.insert(0, str(Path(__file__).parent))

from quick import compile_fast


_MANY_MAPS = 20_000

# tracing makes so many objects that to look for those which nobody needs took a tenth of the time
gc.set_threshold(50_000, 10, 10)

# compiling is most of the time: workers share it, and the next run finds it. Here, since JAX reads
# it when a folder's own conftest imports it
_folder = compile_fast(Path(__file__).parents[1])
# what commands remember of files that they wrote isn't the user's own
os.environ["XDG_STATE_HOME"] = str(_folder.parent / "state")


_EXTRA = re.compile(
    r"^\s*(?:import|from) (?:jax|equinox|diffrax|xarray|pandas|matplotlib)\b", re.MULTILINE
)
_CORE_ALONE = find_spec("jax") is None
if not _CORE_ALONE:  # tests pass arrays of JAX; that they are refused otherwise has its own test
    import fascicle.jax  # noqa: F401


def pytest_ignore_collect(collection_path):
    """Where the core is installed alone, files of tests that need an extra stay out."""
    if _CORE_ALONE and collection_path.suffix == ".py":
        return bool(_EXTRA.search(collection_path.read_text(encoding="utf-8"))) or None
    return None


def pytest_collection_finish():
    """What is imported by now stays: nobody needs to look through it each time."""
    gc.collect()
    gc.freeze()


def pytest_runtest_teardown(item, nextitem):
    """Compiled functions each take several memory maps, of which a process may have 65530: a
    worker that keeps all of them ends in a segmentation fault. Slow tests make many.
    """
    if pyplot := sys.modules.get("matplotlib.pyplot"):  # a library may have imported it
        pyplot.close("all")
    jax, maps = sys.modules.get("jax"), Path("/proc/self/maps")
    if nextitem and nextitem.path == item.path and not item.get_closest_marker("slow"):
        return
    if jax and maps.exists() and maps.read_bytes().count(b"\n") > _MANY_MAPS:
        jax.clear_caches()
        gc.collect()
