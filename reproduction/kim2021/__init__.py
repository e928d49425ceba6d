"""Kim, Mazzoleni and Bryant (2021): a module a figure, and the report of them all."""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from ..claims import Claim


def run(out: Path, progress: Callable[[int, int, str], object] | None = None) -> list[Claim]:
    """Make every figure, its data, the claims as `claims.json`, and the report of it all.

    **Arguments:**

    - `out`: the folder [-]; made if it isn't there, files in it are replaced.
    - `progress`: told how many steps are done, of how many, and which one it is at [-].

    **Returns:** the claims, in the order of the figures [-].

    **Raises:** `OSError` where something can't be written.
    """
    # the figures' modules are many and heavy: only now
    return import_module(".reproduction", __name__).run(out, progress)
