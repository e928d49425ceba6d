"""Fluid that the motor units of a bundle take in while it contracts."""

import warnings
from collections.abc import Iterable

import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.types import PerUnit, Values
from ..core.validation import is_concrete
from ..muscle import Muscle
from .bundle import Bundle
from .plates import muscle_strain


def told_by_strain(muscles: Iterable[Muscle]) -> None:
    """Refuse `muscles` [-] whose ends give: what fluid they take in depends on their force, too.
    Warn of those whose braid swells by its pressure.
    """
    for muscle in muscles:
        if muscle.tension.stretches:
            warnings.warn(
                "fluid is counted in the braid as it is without pressure: what fibers that"
                " stretch let it swell by isn't in it.",
                stacklevel=3,
            )
        give = muscle.ends.compliance
        if is_concrete(give) and np.any(np.asarray(give) > 0):
            raise InvalidInputError(
                "end_compliance",
                "must be 0 where strain alone says what fluid a muscle takes in, as for"
                " efficiencies, designs and the least fluid",
                float(np.max(np.asarray(give))),
                "leave it out there; simulations and `conjugate_volume` count fluid at its"
                " pressure",
                shown=f"{1e6 * float(np.max(np.asarray(give))):g} mm/kN",
            )


def unit_volume_change(bundle: Bundle, strain: Values) -> PerUnit:
    """Fluid taken in by each motor unit from rest length on.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: contraction [-].

    **Returns:** $n_i (V_i(\\varepsilon) - V_i(0))$ [m³], motor units on the last axis.

    **Raises:** `ValueError` for muscles whose ends give under load.
    """
    told_by_strain(unit.muscle for unit in bundle.motor_units)
    rests, ends = [0.0] * len(bundle.motor_units), [strain] * len(bundle.motor_units)
    if bundle.ratios is not None:
        eps = bundle._strain(strain)
        ratios = [bundle.ratios[..., i] for i in range(len(bundle.motor_units))]
        rests = [muscle_strain(ratio, 0.0) for ratio in ratios]
        ends = [muscle_strain(ratio, eps) for ratio in ratios]
    taken = [
        unit.count * (unit.muscle.volume(end) - unit.muscle.volume(rest))
        for unit, rest, end in zip(bundle.motor_units, rests, ends, strict=True)
    ]
    return array_namespace(*taken).stack(taken, axis=-1)
