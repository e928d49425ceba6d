"""What a command's arrays would take, said before they are made.

Not a number of units is too large, but what it needs here. Sizes are of the largest arrays that
are alive at once, measured and rounded up; a system that promises memory which it doesn't have
would end the command without a word.
"""

from pathlib import Path

from ..bundle.zeros import together
from .problems import UserError


_BASE = 0.7e9  # B: 0.2 of Python and JAX, 0.5 of compiling, which is done for many points alone
_GROUP = Path("/sys/fs/cgroup")


def check_memory(needed: float, what: str) -> None:
    """Refuse what doesn't fit.

    **Arguments:**

    - `needed`: for arrays [B].
    - `what`: that is computed, such as "9 motor units in 9 states" [-].
    """
    there = free()
    if there is not None and _BASE + needed > there:
        raise UserError(
            f"{what} would need about {(_BASE + needed) / 1e9:.2g} GB of memory, and"
            f" {there / 1e9:.2g} GB are free here: take fewer motor units, states or points."
        )


def free() -> float | None:
    """Memory [B] that may still be taken; `None` where the system doesn't tell."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        sizes = {line.split(":")[0]: line.split()[1] for line in lines}
        there = 1024.0 * int(sizes["MemAvailable"])
    except (OSError, ValueError, KeyError, IndexError):
        return None
    try:  # in a container
        most, used = ((_GROUP / f"memory.{name}").read_text() for name in ("max", "current"))
        return min(there, float(most) - float(used))
    except (OSError, ValueError):  # "max": without a limit
        return there


def of_equilibria(units: int, states: int) -> float:
    """For all zeros of so many `states` of so many motor `units` [-], [B]."""
    # measured: 0.6 to 3 kB for each pair of units in each state
    return 3e3 * units**2 * min(states, together(units))


def of_recruitment(units: int) -> float:
    """For one demand's solutions in so many motor `units` [-], [B]."""
    return 4e3 * units + 1e3 * units**2


def of_space(units: int, levels: int, strains: int) -> float:
    """For regions and overlaps of so many `units`, `levels` and `strains` [-], [B]."""
    return 8.0 * strains * (4 * units * (241 + levels) + 12 * units**2)


def of_efficiency(units: int, forces: int, strains: int) -> float:
    """For a map of so many `forces` and `strains` [-] with so many motor `units` [-], [B]."""
    return 8.0 * 129 * strains * (6 * units + 4 * forces)
