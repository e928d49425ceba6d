"""Which constants may be free where nobody chose: what a record of a muscle's pull could tell.

Begun from nothing, the muscle as it is given; then its sizes, its rubber, both, each with a dead
band; and for the best of them another length that works. The rubber's two constants are free
together: one held at a value that nobody measured would make the others look surer than they are.
What is known only as a product stays as given: the wall beside them.
"""

from collections.abc import Collection, Iterator

from ..muscle import Muscle
from ..muscle.materials import MooneyRivlin


_SIZES = ("braid_angle", "outer_radius")
_RUBBER = ("c10", "c01")
# free constants of the laws that have no such bladder: two for each correction of the ideal law
_OTHERS = {
    "ideal": _SIZES,
    "tondu_lopez": ("strain_factor", "outer_radius"),
    "meller2014": ("strain_factor", "force_factor"),
    "kothera2009": ("youngs_modulus", *_SIZES),
}
BAND, LENGTH = "dead_band", "active_length"

Names = tuple[str, ...]


def sets(muscle: Muscle, always: Collection[str] = ()) -> list[Names]:
    """Sets of constants to try on a `muscle` [-] one after the other; those that are `always` free
    [-] are in each.
    """
    law = muscle.tension.name
    if law in _OTHERS or not isinstance(muscle.material, MooneyRivlin):
        own = tuple(muscle.tension.parameters)
        bases = [_OTHERS.get(law, (*own, *_SIZES))]
    else:
        bases = [_SIZES, _RUBBER, (*_RUBBER, *_SIZES)]
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
