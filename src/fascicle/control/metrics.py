r"""Metrics of a controlled run: drawdown of force, tracking error, lag and energy.

The drawdown of what is controlled, along each stretch on which its demand doesn't fall,

$$\max_t \left[\max_{s \le t} y(s) - y(t)\right], \tag{K4}$$

stands beside the dip $D$ of the transition. Demands that no policy could reach are counted, with
the force that they lack, and left out of the root mean square, the largest error and the lag.

**Source:** drawdown as of a price: Magdon-Ismail and Atiya (2004).
"""

from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Marks, Numbers, Values
from ..dynamics import Trajectory
from ..dynamics.energy_ledger import LEDGER
from ..dynamics.outputs import PlantOutputs
from .cascade import Cascade


_LAGS = 500  # steps at most, by which a run may be late
_FED = 0.5  # of its onset, from which on a unit is counted as recruited
_LEAST = 0.02  # of the supply, where the onset is lower


class ControlMetrics(NamedTuple):
    """`drawdown` while the demand rose [SI], and the deepest `dip` of a unit at the strains that
    were passed [N]; root mean square of the error, `rms`, and `largest_error` [SI]; the `lag` at
    which it follows best [s]; `supply_energy` [J] and `fluid` [kg] that were drawn; how often a
    unit was `recruited`; of how many `moments` the demand was `unreachable` [-], `first` and
    `last` when [s], nan where it never was, and by how much force or moment at most it was out of
    reach, `short` [SI].
    """

    drawdown: float
    dip: float
    rms: float
    largest_error: float
    lag: float
    supply_energy: float
    fluid: float
    recruited: int
    unreachable: int
    moments: int
    first: float
    last: float
    short: float


class Reachability(NamedTuple):
    """Reachability at each step: the reference's `target` for the muscles, and the `lower` and
    `upper` ends of their range, forces or moments [SI]; `inside`, true where the reference is on
    the load's way.
    """

    target: Numbers
    lower: Numbers
    upper: Numbers
    inside: Marks

    @property
    def can(self) -> Marks:
        """True where the target could be reached."""
        return self.inside & (self.short == 0)

    @property
    def short(self) -> Numbers:
        """By how much it is more than they can, or less than they must [SI]."""
        return np.maximum(np.maximum(self.target - self.upper, self.lower - self.target), 0.0)


def control_metrics(controller: Cascade, run: Trajectory, reference: Values) -> ControlMetrics:
    """Metrics of a run of a controller.

    **Arguments:**

    - `controller`: that it was run with [-].
    - `run`: one run [SI].
    - `reference`: what was demanded, one for each step [SI].

    **Returns:** a `Worth` [SI].

    **Raises:** `ValueError` for a reference of another length.
    """
    outputs = run.outputs
    target = np.asarray(reference, float)
    if target.shape != (len(run.time) - 1,):
        raise InvalidInputError("reference", "must have one for each step", target.size)
    # what a step led to is compared with what was demanded at its beginning
    y = controlled_output(controller, run)[1:]
    reach = reachability(controller, outputs, target)
    can, out_of_reach = reach.can, np.flatnonzero(~reach.can)
    first, last = (
        float(run.time[out_of_reach[end]]) if out_of_reach.size else np.nan for end in (0, -1)
    )
    error = np.where(can, y - target, 0.0)
    count = max(1, int(can.sum()))
    drawn = np.maximum(np.asarray(outputs.drawn)[:-1], 0.0).sum() * float(run.time[1] - run.time[0])
    spent = np.asarray(run.ledger)[:, LEDGER.index("supplied")]
    dip, recruited = _units(controller, run)
    return ControlMetrics(
        drawdown(y, target, can),
        dip,
        float(np.sqrt(np.sum(error**2) / count)),
        float(np.max(np.abs(error))),
        _lag(y, target, can) * float(controller.dt),
        float(spent[-1] - spent[0]),
        float(drawn),
        recruited,
        len(out_of_reach),
        len(can),
        first,
        last,
        float(np.max(reach.short)),
    )


def controlled_output(controller: Cascade, run: Trajectory) -> Numbers:
    """Controlled output of a `controller` at each moment of a `run` [SI]: the
    position, or the pull of all muscles on the load [SI].
    """
    if controller.of == "position":
        return np.asarray(run.outputs.position)
    plant = controller.plant
    return np.sum(plant.lengths * plant.gains * np.asarray(run.outputs.forces), axis=-1)


def drawdown(values: Numbers, demand: Numbers, counted: Marks) -> float:
    """Equation (K4) of `values` [SI], where what is in `demand` [SI] doesn't fall and is `counted`
    [-].
    """
    deepest, top = 0.0, -np.inf
    before = -np.inf
    for y, target, can in zip(values, demand, counted, strict=True):
        top = max(top, y) if can and target >= before else -np.inf
        before = target
        deepest = max(deepest, top - y)
    return float(deepest)


def reachability(controller: Cascade, outputs: PlantOutputs, reference: Numbers) -> Reachability:
    """Range that the bundles of a `controller` can reach at rest, beside the `reference` [SI], at
    each step of a run with these `outputs` [SI].
    """
    plant, supply = controller.plant, np.asarray(outputs.supply_pressure)[:-1]
    position, target = np.asarray(outputs.position)[:-1], np.asarray(reference, float)
    if controller.of == "position":
        low, high = plant.stroke
        position = np.clip(target, low, high)
        inside = (target >= low) & (target <= high)
        target = -np.asarray(plant.load.force(target))
    else:
        inside = np.full(target.shape, True)
    strains = plant.strains(position[:, None])
    highest = np.minimum(supply, float(controller.highest_pressure))
    lower, upper = 0.0, 0.0
    for side, units in enumerate(controller.units):
        indices = plant.unit_indices(side)
        eps, arm = strains[:, indices], float(plant.load.arms[side][1])
        pulls = [
            np.sum(units.counts * units.branches.force(P[:, None] + 0.0 * eps, eps), axis=-1)
            for P in (0.0 * highest, highest)
        ]
        low, high = np.minimum(*pulls), np.maximum(*pulls)
        lower = lower + np.minimum(arm * low, arm * high)
        upper = upper + np.maximum(arm * low, arm * high)
    return Reachability(target, np.asarray(lower), np.asarray(upper), inside)


def _units(controller: Cascade, run: Trajectory) -> tuple[float, int]:
    """The deepest dip [N] that was passed, and how often a unit was recruited [-]."""
    plant, deepest, switches = controller.plant, 0.0, 0
    for side, units in enumerate(controller.units):
        indices = plant.unit_indices(side)
        eps, P = (
            np.asarray(run.outputs.strains)[:, indices],
            np.asarray(run.outputs.pressures)[:, indices],
        )
        depth, _ = units.branches.dip(eps)
        deepest = max(deepest, float(np.max((units.counts * depth)[:, 1:], initial=0.0)))
        lower = _LEAST * float(units.branches.top)
        on = np.maximum(_FED * units.branches.onset(eps), lower) < P
        switches += int(np.sum(on[1:] & ~on[:-1]))
    return deepest, switches


def _lag(y: Numbers, target: Numbers, counted: Marks) -> int:
    """By how many steps [-] what is done follows best what was wanted."""
    if np.ptp(target) == 0 or not counted.any():
        return 0
    upper = min(_LAGS, len(y) // 4)
    misses = [
        np.mean(((y[n:] - target[: len(target) - n]) ** 2)[counted[: len(counted) - n]])
        if counted[: len(counted) - n].any()
        else np.inf
        for n in range(upper + 1)
    ]
    return int(np.argmin(misses))
