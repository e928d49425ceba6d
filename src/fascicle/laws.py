"""Names for authors of laws: base classes, declarations of constants, and parts of a muscle.

A package of your own has its laws under the entry point `fascicle.laws`; `docs/laws.md` shows one.
Functions such as `sqrt` and `where` come from `array_namespace(x)`, the library of an array `x`.
"""

from .core.array_namespace import array_namespace
from .core.parameters import (
    POSITIVE,
    SHARE,
    Constant,
    Switch,
    Transform,
    log1p_scale,
    symmetric_scale,
)
from .core.roots import root
from .core.types import Batch, BatchLike, BoolBatch
from .muscle import LAWS
from .muscle.bladder import Bladder
from .muscle.braid import Braid
from .muscle.buckling import AbstractBuckling, BucklingColumn, Centerline, Push
from .muscle.collapse import AbstractCollapse
from .muscle.ends import AbstractEnds
from .muscle.post_collapse import AbstractPostCollapse
from .muscle.tension import AbstractTension, Offset, Pull, solved_free_strain


__all__ = [
    "AbstractBuckling",
    "AbstractCollapse",
    "AbstractEnds",
    "AbstractPostCollapse",
    "AbstractTension",
    "Batch",
    "BatchLike",
    "Bladder",
    "BoolBatch",
    "Braid",
    "BucklingColumn",
    "Centerline",
    "Constant",
    "LAWS",
    "Offset",
    "POSITIVE",
    "Pull",
    "Push",
    "SHARE",
    "Switch",
    "Transform",
    "array_namespace",
    "log1p_scale",
    "root",
    "solved_free_strain",
    "symmetric_scale",
]
