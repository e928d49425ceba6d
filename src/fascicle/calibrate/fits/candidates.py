"""Which constants may be free where nobody chose: what a record of a muscle's pull could tell.

Begun from nothing, the muscle as it is given; then its sizes, its rubber, both, each with a dead
band; and for the best of them another length that works. The rubber's two constants are free
together: one held at a value that nobody measured would make the others look surer than they are.
What is known only as a product stays as given: the wall beside them.
"""

from collections.abc import Collection, Iterator

from ...muscle import Muscle
from ...muscle.materials import MooneyRivlin
from ..problem.parameters import RUBBER


BAND, LENGTH = "dead_band", "active_length"

Names = tuple[str, ...]


def sets(muscle: Muscle, always: Collection[str] = ()) -> list[Names]:
    """Sets of constants to try on a `muscle` [-] one after the other; those that are `always` free
    [-] are in each.
    """
    usual = muscle.tension.usually_free()
    sizes = tuple(name for name in usual if name not in RUBBER)
    if len(sizes) == len(usual) or not isinstance(muscle.material, MooneyRivlin):
        bases = [sizes]
    else:
        bases = [sizes, RUBBER, (*RUBBER, *sizes)]
    found = [(), *bases, *((*base, BAND) for base in bases)]
    return list(dict.fromkeys(_with(names, always) for names in found))


def longer(names: Names) -> Iterator[Names]:
    """What to try once `names` [-] were the best: another length, and with it the dead band."""
    if LENGTH not in names:
        yield _with(names, (LENGTH,))
        if BAND not in names:
            yield _with(names, (BAND, LENGTH))


def _with(names: Names, always: Collection[str]) -> Names:
    return (*names, *(one for one in always if one not in names))
