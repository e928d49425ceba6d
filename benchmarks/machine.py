"""The machine and the versions that a table of times belongs to."""

import datetime as dt
import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path


def describe() -> dict[str, str]:
    """What to write above the table."""
    return {
        "date": dt.datetime.now(tz=dt.UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "processor": processor(),
        "cores": f"{cores()} (load {os.getloadavg()[0]:.2f} before the run)",
        "memory": f"{memory() / 2**30:.0f} GiB",
        "system": f"{platform.system()} {platform.machine()}",
        "Python": sys.version.split()[0],
        **{name: version(name) for name in ("fascicle", "jax", "jaxlib", "numpy", "scipy")},
    }


def processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text().splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def cores() -> int:
    """Those this process may use."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def memory() -> int:
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
