"""A muscle with another law: the alternatives that are laid over its own curve."""

from ...core.errors import InvalidInputError
from ...muscle import Muscle, Tuning
from ...muscle.laws import LAWS


UNTUNED = "untuned"
MOST_COMPARED = 4  # at once: as many more colors and dashes as can be told apart


def alternatives(muscle: Muscle) -> list[str]:
    """What else its laws could be [-], as `buckling:elastica`; and `untuned` where it is tuned."""
    out = [
        f"{kind}:{name}"
        for kind, known in LAWS.items()
        for name, law in known.items()
        if type(getattr(muscle, kind)) is not law
    ]
    return [*out, UNTUNED] if is_tuned(muscle) else out


def alternative(muscle: Muscle, key: str) -> Muscle:
    """The muscle [-] with the law that a `key` of `alternatives` [-] names."""
    if key == UNTUNED:
        return muscle.replace(tuning=Tuning())
    kind, _, name = key.partition(":")
    return muscle.replace(**{kind: name})


def is_tuned(muscle: Muscle) -> bool:
    """Whether anything of its tuning differs from none [-]."""
    return muscle.tuning != Tuning()


def check_compared(keys: tuple[str, ...]) -> tuple[str, ...]:
    """The `keys` [-] again; `ValueError` where one names no law."""
    if len(keys) > MOST_COMPARED:
        raise InvalidInputError(
            "compare",
            f"must be {MOST_COMPARED} laws at most, as many as can be told apart",
            len(keys),
        )
    for key in keys:
        kind, _, name = key.partition(":")
        if key != UNTUNED and name not in LAWS.get(kind, {}):
            raise InvalidInputError("compare", "must name laws such as buckling:elastica", key[:40])
    return keys
