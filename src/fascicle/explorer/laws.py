"""A muscle with another law: the alternatives that are laid over its own curve."""

from collections.abc import Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from .._refused import Refused
from ..muscle import Muscle, Tuning
from ..muscle.buckling import BUCKLING_LAWS
from ..muscle.collapse import COLLAPSE_LAWS, POST_COLLAPSE_LAWS
from ..muscle.tension import TENSION_LAWS


LAWS: Mapping[str, Mapping[str, Any]] = MappingProxyType({
    "tension": TENSION_LAWS,
    "buckling": BUCKLING_LAWS,
    "collapse": COLLAPSE_LAWS,
    "post_collapse": POST_COLLAPSE_LAWS,
})  # fmt: skip
UNTUNED = "untuned"


def replaced(muscle: Muscle, **parts: Any) -> Muscle:
    """The same muscle [-] with other `parts` [SI]; `ValueError` where they can't be."""
    own = {one.name: getattr(muscle, one.name) for one in fields(muscle)}
    return Muscle(**{**own, **parts})


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
        return replaced(muscle, tuning=Tuning())
    kind, _, name = key.partition(":")
    return replaced(muscle, **{kind: name})


def is_tuned(muscle: Muscle) -> bool:
    """Whether anything of its tuning differs from none [-]."""
    from ..describe import dumps

    return ".tuning]" in dumps(muscle)


def check_compared(keys: tuple[str, ...]) -> tuple[str, ...]:
    """The `keys` [-] again; `ValueError` where one names no law."""
    for key in keys:
        kind, _, name = key.partition(":")
        if key != UNTUNED and name not in LAWS.get(kind, {}):
            raise Refused("compare", "must name laws such as buckling:elastica", key[:40])
    return keys
