r"""What a run was worth: how deep the force dipped, how far off and how late it was, its price.

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
    """At each step what a reference asks of the muscles, `wanted`, and the `least` and `most` that
    they can do then, forces or moments [SI]; whether it asks for a place on the load's way,
    `inside` [-].
    """

    wanted: Numbers
    least: Numbers
    most: Numbers
    inside: Marks

    @property
    def can(self) -> Marks:
        """Whether it could be done [-]."""
        return self.inside & (self.short == 0)

    @property
    def short(self) -> Numbers:
        """By how much it is more than they can, or less than they must [SI]."""
        return np.maximum(np.maximum(self.wanted - self.most, self.least - self.wanted), 0.0)


def control_metrics(controller: Cascade, run: Trajectory, reference: Values) -> ControlMetrics:
    """What a run of a controller was worth.

    **Arguments:**

    - `controller`: that it was run with [-].
    - `run`: one run [SI].
    - `reference`: what was demanded, one for each step [SI].

    **Returns:** a `Worth` [SI].

    **Raises:** `ValueError` for a reference of another length.
    """
    seen = run.seen
    wanted = np.asarray(reference, float)
    if wanted.shape != (len(run.time) - 1,):
        raise InvalidInputError("reference", "must have one for each step", wanted.size)
    # what a step led to is compared with what was demanded at its beginning
    y = controlled_output(controller, run)[1:]
    reach = reachability(controller, seen, wanted)
    can, beyond = reach.can, np.flatnonzero(~reach.can)
    first, last = (float(run.time[beyond[end]]) if beyond.size else np.nan for end in (0, -1))
    error = np.where(can, y - wanted, 0.0)
    many = max(1, int(can.sum()))
    drawn = np.maximum(np.asarray(seen.drawn)[:-1], 0.0).sum() * float(run.time[1] - run.time[0])
    spent = np.asarray(run.account)[:, LEDGER.index("supplied")]
    dip, recruited = _units(controller, run)
    return ControlMetrics(
        drawdown(y, wanted, can), dip, float(np.sqrt(np.sum(error**2) / many)),
        float(np.max(np.abs(error))), _lag(y, wanted, can) * float(controller.dt),
        float(spent[-1] - spent[0]), float(drawn), recruited, len(beyond), len(can), first, last,
        float(np.max(reach.short)),
    )  # fmt: skip


def controlled_output(controller: Cascade, run: Trajectory) -> Numbers:
    """What a `controller` [-] is to bring to its demand, at each moment of a `run` [SI]: the
    position, or the pull of all muscles on the load [SI].
    """
    if controller.of == "position":
        return np.asarray(run.seen.position)
    plant = controller.plant
    return np.sum(plant.lengths * plant.gains * np.asarray(run.seen.forces), axis=-1)


def drawdown(values: Numbers, demand: Numbers, counted: Marks) -> float:
    """Equation (K4) of `values` [SI], where what is in `demand` [SI] doesn't fall and is `counted`
    [-].
    """
    deepest, top = 0.0, -np.inf
    before = -np.inf
    for y, wanted, can in zip(values, demand, counted, strict=True):
        top = max(top, y) if can and wanted >= before else -np.inf
        before = wanted
        deepest = max(deepest, top - y)
    return float(deepest)


def reachability(controller: Cascade, seen: PlantOutputs, reference: Numbers) -> Reachability:
    """What the bundles could do, standing still, of what the `reference` [SI] asks of the
    `controller` [-] at each step of a run that was `seen` [SI]: a `Reach` [SI].
    """
    plant, supply = controller.plant, np.asarray(seen.supply_pressure)[:-1]
    position, wanted = np.asarray(seen.position)[:-1], np.asarray(reference, float)
    if controller.of == "position":
        low, high = plant.way
        position = np.clip(wanted, low, high)
        inside = (wanted >= low) & (wanted <= high)
        wanted = -np.asarray(plant.load.force(wanted))
    else:
        inside = np.full(wanted.shape, True)
    strains = plant.strains(position[:, None])
    highest = np.minimum(supply, float(controller.highest_pressure))
    least, most = 0.0, 0.0
    for side, units in enumerate(controller.units):
        places = plant.places(side)
        eps, arm = strains[:, places], float(plant.load.arms[side][1])
        pulls = [
            np.sum(units.counts * units.branches.force(P[:, None] + 0.0 * eps, eps), axis=-1)
            for P in (0.0 * highest, highest)
        ]
        low, high = np.minimum(*pulls), np.maximum(*pulls)
        least = least + np.minimum(arm * low, arm * high)
        most = most + np.maximum(arm * low, arm * high)
    return Reachability(wanted, np.asarray(least), np.asarray(most), inside)


def _units(controller: Cascade, run: Trajectory) -> tuple[float, int]:
    """The deepest dip [N] that was passed, and how often a unit was recruited [-]."""
    plant, deepest, often = controller.plant, 0.0, 0
    for side, units in enumerate(controller.units):
        places = plant.places(side)
        eps, P = np.asarray(run.seen.strains)[:, places], np.asarray(run.seen.pressures)[:, places]
        depth, _ = units.branches.dip(eps)
        deepest = max(deepest, float(np.max((units.counts * depth)[:, 1:], initial=0.0)))
        least = _LEAST * float(units.branches.top)
        on = np.maximum(_FED * units.branches.onset(eps), least) < P
        often += int(np.sum(on[1:] & ~on[:-1]))
    return deepest, often


def _lag(y: Numbers, wanted: Numbers, counted: Marks) -> int:
    """By how many steps [-] what is done follows best what was wanted."""
    if np.ptp(wanted) == 0 or not counted.any():
        return 0
    most = min(_LAGS, len(y) // 4)
    misses = [
        np.mean(((y[n:] - wanted[: len(wanted) - n]) ** 2)[counted[: len(counted) - n]])
        if counted[: len(counted) - n].any()
        else np.inf
        for n in range(most + 1)
    ]
    return int(np.argmin(misses))
