"""All laws, by the kind of law and by name: for files, fits, tables and pages."""

from collections.abc import Mapping
from types import MappingProxyType

from .buckling import BUCKLING_LAWS
from .collapse import COLLAPSE_LAWS
from .ends import ENDS_LAWS
from .law import AbstractLaw, LawRegistry
from .post_collapse import POST_COLLAPSE_LAWS
from .tension import TENSION_LAWS


# a kind's name is that of the muscle's argument, and of the key in files
LAWS: Mapping[str, LawRegistry] = MappingProxyType(
    {
        "tension": TENSION_LAWS,
        "buckling": BUCKLING_LAWS,
        "collapse": COLLAPSE_LAWS,
        "post_collapse": POST_COLLAPSE_LAWS,
        "ends": ENDS_LAWS,
    }
)

# kinds of law that files and tables leave out where it is the default: most muscles have rigid ends
OMIT_IF_DEFAULT = frozenset({"ends"})


def is_written_out(kind: str, law: AbstractLaw) -> bool:
    """True where files and tables name this law of a muscle: all but default ends."""
    return kind not in OMIT_IF_DEFAULT or type(law) is not LAWS[kind].default
