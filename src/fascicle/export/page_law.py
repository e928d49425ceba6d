"""The law of a page: one WebAssembly module with every constant of a muscle as a number.

`make page` traces a muscle on symbols and compiles the formulas (`tools/page_law.py`); a page
passes the numbers. Laws that differ by a factor or a power are one law with a `choice`. A tuning's
table is read at the pressure by the page, so that the muscle has a table of one row. Other laws are
chosen by the module's function.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..core.array_namespace import where
from ..core.errors import InvalidInputError
from ..core.module import tree_leaves, with_fields
from ..core.types import Batch, BatchLike
from ..muscle import Muscle
from ..muscle.bladder import Bladder
from ..muscle.buckling import BucklingColumn
from ..muscle.collapse import COLLAPSE_LAWS, AbstractCollapse
from ..muscle.post_collapse import POST_COLLAPSE_LAWS, AbstractPostCollapse
from ..muscle.tension import LEAST_PRESSURE


FOLDER = Path(__file__).with_name("page")
MODULE = FOLDER / "law.wasm.gz"
MANIFEST = FOLDER / "law.json"
POINTS = 61  # of a centerline: odd, so that a hinge lies on one
_DIVIDING = ("ideal", "tondu_lopez", "meller2014")  # laws that divide C₁ by the pressure


class AnyCollapse(AbstractCollapse):
    """The collapse law whose number among all of them is `choice`, with a `factor`."""

    factor: Batch
    choice: Batch

    def moment(self, bladder: Bladder, youngs_modulus: BatchLike, pressure: BatchLike) -> Batch:
        """Collapse moment [N·m] at `youngs_modulus` [Pa] and `pressure` [Pa]."""
        laws = [law() for law in COLLAPSE_LAWS.values()]
        moments = [law.moment(bladder, youngs_modulus, pressure) for law in laws]
        return self.factor * _select_value(self.choice, moments)


class AnyPostCollapse(AbstractPostCollapse):
    """The post-collapse law whose number among all of them is `choice`."""

    choice: Batch

    @property
    def slope_factor(self) -> Batch:
        """Slope of the hinge over that of the derived law [-]."""
        return _select_value(self.choice, [law.slope_factor for law in POST_COLLAPSE_LAWS.values()])

    def bending_force(self, column: BucklingColumn, compression: Batch) -> tuple[Batch, Batch]:
        """Bending force $B$ of both halves [N] at `compression` [m], and its slope [N/m]."""
        pairs = [law().bending_force(column, compression) for law in POST_COLLAPSE_LAWS.values()]
        force, slope = (
            _select_value(self.choice, list(values)) for values in zip(*pairs, strict=True)
        )
        return force, slope


def function_key(muscle: Muscle) -> str:
    """Name of the WebAssembly module's function for a `muscle`: its laws but those of collapse,
    such as `kim2021/klute_hannaford/rigid`.
    """
    shear = getattr(muscle.buckling, "shear", "none")
    names = [muscle.buckling.name, muscle.tension.name, muscle.ends.name]
    return "/".join([*names, *([] if shear == "none" else [shear])])


def general_muscle(muscle: Muscle) -> Muscle:
    """The `muscle` with one row of tuning, and with collapse laws chosen by a number."""
    collapse, post_collapse = (
        float(list(laws).index(law.name))
        for laws, law in (
            (COLLAPSE_LAWS, muscle.collapse),
            (POST_COLLAPSE_LAWS, muscle.post_collapse),
        )
    )
    return with_fields(
        muscle,
        collapse=AnyCollapse(muscle.collapse.factor, collapse),
        post_collapse=AnyPostCollapse(post_collapse),
        transition_rate=muscle.law.rate,
        tuning=with_fields(
            muscle.tuning,
            pressures=np.zeros(1),
            c1=np.zeros(1),
            c2=np.ones(1),
            transition_rate=None,
        ),
    )


@cache
def manifest() -> dict[str, Any]:
    """Functions of the WebAssembly module: their names, and the sizes of constants and states."""
    return json.loads(MANIFEST.read_text(encoding="utf-8"))


def muscle_data(muscle: Muscle) -> dict[str, Any]:
    """Data of a `muscle` for the WebAssembly module [SI], such as `law`, its function, `constants`
    and the tuning's `table`; `InvalidInputError` for laws that the module has not.
    """
    key = function_key(muscle)
    if key not in manifest():
        parts = key.split("/")
        nearest = max(manifest(), key=lambda k: [a == b for a, b in zip(k.split("/"), parts)])  # noqa: B905 shear is no part of most
        rule = "has laws that a page can't compute"
        remedy = f"write C (--c) or a table (--table), or take {nearest}"
        raise InvalidInputError("muscle", rule, key, remedy, shown=key)
    general, table = general_muscle(muscle), muscle.tuning
    leaves = tree_leaves(general)
    return {
        "law": key,
        "constants": [float(np.ravel(leaf)[0]) for leaf in leaves],
        "c1": next(i for i, leaf in enumerate(leaves) if leaf is general.tuning.c1),
        "dead_band": float(table.dead_band),
        "least_pressure": LEAST_PRESSURE if muscle.tension.name in _DIVIDING else 0.0,
        "inactive_length": float(getattr(muscle.ends, "inactive_length", 0.0)),
        "table": [list(map(float, rows)) for rows in (table.pressures, table.c1, table.c2)],
    }


def _select_value(choice: Batch, values: list[Any]) -> Any:
    """Entry of `values` [any unit] whose number is `choice` [-]."""
    result = values[0]
    for number, value in enumerate(values[1:], start=1):
        result = where(choice == number, value, result)
    return result
