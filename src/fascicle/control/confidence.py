r"""Crossings of bundles that could be the one at hand: in how many there is one without a dip.

For each of the `draws` the hand-over is sought as for the model, (X5). The margin $m$ of a
controller's hand-over, (X6), follows from the reserve that draws lack: 95 % of them have

$$\frac{(D - F_{max})_{draw} - (D - F_{max})_{model}}{D_{model}} \le m, \tag{X7}$$

at the strain where the model crosses.

**Source:** derived here.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ..bundle.bundle import Bundle
from ..bundle.states import resolve_supply_pressure
from ..core.types import Values
from .crossing import Crossing, Path, crossing
from .transition import transition
from .uncertainty import draw_bundles
from .units import SLACK


CONFIDENCE = 0.95  # share of draws that counts as sure, as in `fascicle.design`


class CrossingConfidence(NamedTuple):
    """Confidence in a crossing: the model's `crossing`; the `share` of draws that have one, or need
    none [-]; the `margin` $m$ of the dip that 95 % of them keep [-], nan without a crossing.
    """

    crossing: Crossing
    share: float
    margin: float

    @property
    def sure(self) -> bool:
        """True if at least 95 % of the draws have a crossing."""
        return self.share >= CONFIDENCE


def crossing_confidence(
    bundle: Bundle,
    path: Path,
    valves: Any,
    unit: int = 2,
    draws: Sequence[Bundle] | None = None,
    supply_pressure: Values = None,
    slack: float = SLACK,
    lag: float = 0.0,
) -> CrossingConfidence:
    """Confidence in the crossing of a model along a path: share of bundles around it that have a
    hand-over without a dip too, and their margin.

    **Arguments:**

    - `bundle`: the model.
    - `path`: demand [N] and strain [-] over time [s].
    - `valves`: as of `crossing`.
    - `unit`: number of the recruited unit, counted from 1.
    - `draws`: bundles that it could be; left out, `draw_bundles`.
    - `supply_pressure`: the supply's [Pa]; left out, the bundle's own.
    - `slack`: factor on the valves' time [-], as of `crossing`.
    - `lag`: of the pressures behind a controller's demand [s].

    **Raises:** `InvalidInputError` as `crossing` does.
    """
    supply = resolve_supply_pressure(bundle, supply_pressure)
    options: dict[str, Any] = {"slack": slack, "lag": lag}
    model = crossing(bundle, path, valves, unit, supply, **options)
    draws = draw_bundles(bundle) if draws is None else draws
    crossings = [crossing(b, path, valves, unit, supply, **options) for b in draws]
    share = float(np.mean([candidate.is_resolved for candidate in crossings]))
    if model.strain is None:
        return CrossingConfidence(model, share, np.nan)
    base, *states = (transition(b, model.strain, unit, supply) for b in (bundle, *draws))
    lacks = [(s.dip - s.largest_force) - (base.dip - base.largest_force) for s in states]
    # N: a transition may have no dip
    margin = float(np.quantile(lacks, CONFIDENCE)) / max(float(base.dip), 1e-12)
    return CrossingConfidence(model, share, margin)
