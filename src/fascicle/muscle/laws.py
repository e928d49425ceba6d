"""All laws, by the kind of law and by name: what files, fits, tables and pages read."""

from collections.abc import Mapping
from types import MappingProxyType

from .buckling import BUCKLING_LAWS
from .collapse import COLLAPSE_LAWS
from .law import AbstractLaw
from .post_collapse import POST_COLLAPSE_LAWS
from .tension import TENSION_LAWS


# a kind's name is that of the muscle's argument, and of the key in files
LAWS: Mapping[str, Mapping[str, type[AbstractLaw]]] = MappingProxyType({
    "tension": TENSION_LAWS,
    "buckling": BUCKLING_LAWS,
    "collapse": COLLAPSE_LAWS,
    "post_collapse": POST_COLLAPSE_LAWS,
})  # fmt: skip
