r"""Metrics of a controlled run: drawdown of force, tracking error, lag, energy, and their front.

The drawdown of the output, along each stretch on which its demand doesn't fall,

$$\max_t \left[\max_{s \le t} y(s) - y(t)\right], \tag{K4}$$

is compared with the dip $D$ of the transition. Demands that no policy could reach are counted, with
the force that they lack, and left out of the root mean square, the largest error and the lag.

**Source:** drawdown as of a price: Magdon-Ismail and Atiya (2004).
"""

from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Marks, Numbers, Values
from ..dynamics import Trajectory
from ..dynamics.outputs import LEDGER, PlantOutputs
from .controller import Cascade


_LAGS = 500  # steps, the largest lag: half a second of 1 ms steps, longer than any loop's
_RECRUITED = 0.5  # of its onset, from which a unit counts as recruited: far above noise
_LEAST = 0.02  # of the supply, if the onset is lower: above a valve's noise
_EQUAL = 1e-6  # of the larger one: runs that differ by less are as good as each other


class ControlMetrics(NamedTuple):
    """Metrics of a controlled run: tracking, dips, and supply.

    At the ends of steps, without the start, which no controller chose: `drawdown` while the demand
    rose, root mean square `rms` and `largest_error` of the error [SI], and the `lag` with the least
    error [s]. Deepest `dip` of a unit at the run's strains [N];
    `supply_energy` [J] and `fluid` [kg] from the supply; how often a unit was `recruited`. Of the
    run's `moments`, the number of those whose demand was `unreachable`, the `first` and `last` of
    them [s], nan if there are none, and the largest distance from reach, `short` [SI].
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
    `upper` ends of their range, forces or moments [SI]; `in_stroke`, true if the load can go there.
    """

    target: Numbers
    lower: Numbers
    upper: Numbers
    in_stroke: Marks

    @property
    def is_reachable(self) -> Marks:
        """True where the target is within the range, and the load can go there."""
        return self.in_stroke & (self.shortfall == 0)

    @property
    def shortfall(self) -> Numbers:
        """Force or moment that the target lies outside of the range [SI]; zero inside."""
        return np.maximum(np.maximum(self.target - self.upper, self.lower - self.target), 0.0)


def control_metrics(controller: Cascade, run: Trajectory, reference: Values) -> ControlMetrics:
    """Metrics of a `run` by a `controller` with a demand at each step, the `reference` [SI], which
    is refused if it has another length; energies are in [J], forces in [N].
    """
    outputs = run.outputs
    target = np.asarray(reference, float)
    if target.shape != (len(run.time) - 1,):
        raise InvalidInputError("reference", "must have one for each step", target.size)
    # the output at a step's end is compared with the demand at its beginning
    y = controlled_output(controller, run)[1:]
    reach = reachability(controller, outputs, target)
    can, out_of_reach = reach.is_reachable, np.flatnonzero(~reach.is_reachable)
    first, last = run.time[out_of_reach[[0, -1]]] if out_of_reach.size else (np.nan, np.nan)
    error = np.where(can, y - target, 0.0)
    dt = float(run.time[1] - run.time[0])
    spent = np.asarray(run.ledger)[:, LEDGER.index("supplied")]
    dip, recruited = _dip_and_recruitments(controller, run)
    rms = float(np.sqrt(np.sum(error**2) / max(1, int(can.sum()))))
    errors = rms, float(np.max(np.abs(error))), _lag_steps(y, target, can) * float(controller.dt)
    fluid = float(np.maximum(np.asarray(outputs.drawn)[:-1], 0.0).sum() * dt)
    costs = float(spent[-1] - spent[0]), fluid, recruited
    missed = len(out_of_reach), len(can), float(first), float(last), float(np.max(reach.shortfall))
    return ControlMetrics(drawdown(y, target, can), dip, *errors, *costs, *missed)


def controlled_output(controller: Cascade, run: Trajectory) -> Numbers:
    """Controlled output at each moment of a `run`: position, or force of all muscles on the load
    [SI].
    """
    if controller.of == "position":
        return np.asarray(run.outputs.position)
    plant = controller.plant
    return np.sum(plant.lengths * plant.gains * np.asarray(run.outputs.forces), axis=-1)


def drawdown(values: Numbers, demand: Numbers, counted: Marks) -> float:
    """Drawdown of `values` [SI]: their largest fall below an earlier one, (K4), on one stretch of
    steps that are `counted` and on which the `demand` [SI] doesn't fall.
    """
    deepest, top, before = 0.0, -np.inf, -np.inf
    for y, target, can in zip(values, demand, counted, strict=True):
        top = max(top, y) if can and target >= before else -np.inf
        before = target
        deepest = max(deepest, top - y)
    return float(deepest)


def reachability(controller: Cascade, outputs: PlantOutputs, reference: Numbers) -> Reachability:
    """Reachability of a `reference` [SI] at rest, at each step of a run with `outputs` [SI]."""
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


def _dip_and_recruitments(controller: Cascade, run: Trajectory) -> tuple[float, int]:
    """Deepest dip [N] of units but the first at the run's strains; number of recruitments."""
    plant, deepest, switches = controller.plant, 0.0, 0
    for side, units in enumerate(controller.units):
        indices = plant.unit_indices(side)
        eps = np.asarray(run.outputs.strains)[:, indices]
        P = np.asarray(run.outputs.pressures)[:, indices]
        depth, _ = units.branches.dip(eps)
        deepest = max(deepest, float(np.max((units.counts * depth)[:, 1:], initial=0.0)))
        lower = _LEAST * float(units.branches.top)
        on = np.maximum(_RECRUITED * units.branches.onset(eps), lower) < P
        switches += int(np.sum(on[1:] & ~on[:-1]))
    return deepest, switches


def _lag_steps(y: Numbers, target: Numbers, counted: Marks) -> int:
    """Steps by which `y` lags the `target` with the least error; zero for a constant target."""
    if np.ptp(target) == 0 or not counted.any():
        return 0
    upper = min(_LAGS, len(y) // 4)
    errors = []
    for n in range(upper + 1):
        mask = counted[: len(counted) - n]
        squares = ((y[n:] - target[: len(target) - n]) ** 2)[mask]
        errors.append(np.mean(squares) if mask.any() else np.inf)
    return int(np.argmin(errors))


def pareto_front(dips: Values, energies: Values) -> Marks:
    """Mask of the runs on the Pareto front of dip or drawdown [SI] and energy [J] of each run: no
    other run is better in one of them without being worse in the other.
    """
    costs = np.stack([np.asarray(dips, float), np.asarray(energies, float)], axis=-1)
    tolerance = _EQUAL * np.max(np.abs(costs), axis=0)
    run, rival = costs[:, None, :], costs[None, :, :]
    as_good = np.all(rival <= run + tolerance, axis=-1)
    better = np.any(rival < run - tolerance, axis=-1)
    return ~np.any(as_good & better, axis=1)
