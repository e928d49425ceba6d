"""All laws, by the kind of law and by name: what files, fits, tables and pages read."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from .buckling import BUCKLING_LAWS
from .collapse import COLLAPSE_LAWS
from .ends import ENDS_LAWS
from .entry import chosen
from .law import AbstractLaw
from .post_collapse import POST_COLLAPSE_LAWS
from .tension import TENSION_LAWS


# a kind's name is that of the muscle's argument, and of the key in files
LAWS: Mapping[str, Mapping[str, type[AbstractLaw]]] = MappingProxyType({
    "tension": TENSION_LAWS,
    "buckling": BUCKLING_LAWS,
    "collapse": COLLAPSE_LAWS,
    "post_collapse": POST_COLLAPSE_LAWS,
    "ends": ENDS_LAWS,
})  # fmt: skip


def law(value: Any, kind: type, what: str) -> Any:
    """A law by object or by name [-], of a `kind` [-] that is called `what` [-]."""
    return chosen(value, kind, LAWS[what], what)


# where the first of them is chosen, files and sheets don't say so
UNSAID = frozenset({"ends"})


def said(kind: str, law: AbstractLaw) -> bool:
    """Whether files and sheets say that a muscle has this `law` of a `kind` [-]."""
    return kind not in UNSAID or law.name != next(iter(LAWS[kind]))
