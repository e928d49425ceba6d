"""Which constants may be free where nobody chose: what a record of a muscle's pull could tell.

Begun from nothing, the muscle as it is given; then its sizes, its rubber, both, each with a dead
band. The rubber's two constants are free together: one held at a value that nobody measured would
make the others look surer than they are. Then every other constant that moves the pull is tried
beside the best of them: each alone, again while one of them is worth it, and all together, of
which what isn't worth it is taken away again. What is known only as a product stays as given: the
wall beside them.
"""

from collections.abc import Callable, Collection, Sequence

from ...muscle import Muscle
from ...muscle.laws import LAWS, OMIT_IF_DEFAULT
from ...muscle.materials import MooneyRivlin
from ..problem.parameters import RUBBER, of_muscle


BAND, WALL, ACTIVE = "dead_band", "wall_thickness", "active_length"
_ROUNDS = 4  # of taking one more, or one less

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


def widened(muscle: Muscle) -> Muscle:
    """A `muscle` [-] with constants where its own laws have none to free: of kinds of law that
    nobody chose, such as rigid ends, the first that has some. Its defaults change nothing.
    """
    for kind in OMIT_IF_DEFAULT:
        names = [name for name, law in LAWS[kind].items() if law.constants()]
        if names and not getattr(muscle, kind).constants():
            muscle = muscle.replace(**{kind: names[0]})
    return muscle


def with_laws(muscle: Muscle, names: Collection[str]) -> Muscle:
    """The `muscle` [-], or where `names` [-] aren't all its own as `widened` has it."""
    return muscle if set(names) <= of_muscle(muscle).keys() else widened(muscle)


def grown(
    best: Callable[[], Names],
    others: Sequence[str],
    kept: Collection[str],
    tried: Callable[[Names], object],
) -> None:
    """Try more constants beside the best ones, and fewer again.

    **Arguments:**

    - `best`: says which of all that was tried are best by now [-].
    - `others`: constants that may be taken beside them [-].
    - `kept`: those that are always free [-].
    - `tried`: is called with what to try [-]; what was tried already it leaves.
    """
    for _ in range(_ROUNDS):
        before = best()
        for name in others:
            tried(_with(before, (name,)))
        if best() == before:
            break
    tried(_with(best(), others))  # two may be worth it that alone are not
    for _ in range(_ROUNDS):
        before = best()
        for name in before:
            if name in others and name not in kept:
                tried(tuple(one for one in before if one != name))
        if best() == before:
            break


def _with(names: Names, always: Collection[str]) -> Names:
    return (*names, *(one for one in always if one not in names))
