r"""Energy and mass balances of a run, each term an integral of its own.

Of a gas, in exergy, the work that it can do in a room at $p_a$, $T_a$; of a liquid, in energy,

$$E_{supplied} = E_{valve} + E_{exhaust} + E_{mixing} + E_{wall} + W + \Delta E_{fluid}; \tag{A1}$$

of the muscles, which store energy by their law,

$$W = \int F\,\mathrm{d}x + \Delta(P V^* - \Pi^*) + E_{mismatch}, \tag{A2}$$

with the $E_{mismatch}$ that a volume makes that isn't the conjugate one: work out of nothing, so it
is part of the residual, is named, and no such run can be trusted; and of the motion,

$$\int F\,\mathrm{d}x + W_{motor} = \Delta E_{kinetic} + \Delta U + E_{damper} + E_{stop}
  + E_{friction} + \Delta E_{friction}. \tag{A3}$$

Further balances are those of a liquid supply's own energy with its drive, of the fluid's mass, and
with a simulated wall the first law. No term is the remainder of others, so that the residual
measures how far a run can be trusted.

**Source:** first and second law for open systems: Bejan (2016).
"""

from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.types import Numbers
from ..fluid import AdiabaticWall
from ..muscle.hysteresis import MaxwellSlip
from .muscles import ExactMuscles
from .outputs import LEDGER, STATUS, STORES
from .plant import Plant
from .simulate import Trajectory


# largest residual of a balance that closes, over its largest term: what Runge-Kutta's steps leave
# for a smooth law, when a table's cells are crossed, for a kink of force within a step (springs
# that begin to slip, a stop), and where terms are counted: rounding
SMOOTH, TABULATED, KINKED, COUNTED = 1e-6, 1e-5, 1e-4, 1e-12

_MESSAGES = {  # of events, by their names in `STATUS`
    "folded": "a muscle's volume fell with pressure by more than its fluid and hose expand:"
    " its pressure isn't unique; give the chamber more dead volume or compliance",
    "cavitates": "a unit was sucked empty: its fluid can't follow",
    "off_table": "a strain or pressure left the muscles' tables; forces go on linearly there",
    "unsettled": "a pressure wasn't found to rounding in two steps; take a smaller `dt`",
    "supply_empty": "the supply has nothing left to give",
    "stop": "the load touched its stop",
    "stiff": "it would have needed more than 64 substeps; take a smaller `dt`",
    "broken": "numbers are not finite; take a smaller `dt`",
}
_HARMLESS = ("supply_empty", "stop")  # events that are no reason to doubt the run
_MADE = "made by the volume"  # name of a term, as JSON has it


class Balance(NamedTuple):
    """Balance of energy or mass over a run.

    Its `inputs` and `outputs` by name, and the `residual`, inputs less outputs, in its `unit`; the
    `relative_residual`, over the largest term, and the `tolerance` at which it closes [-]; a
    `remedy` if it doesn't close for a known reason.
    """

    name: str
    unit: str
    inputs: dict[str, float]
    outputs: dict[str, float]
    residual: float
    relative_residual: float
    tolerance: float
    remedy: str = ""

    @property
    def closes(self) -> bool:
        """True if the residual is small enough."""
        return bool(self.relative_residual <= self.tolerance)


class Event(NamedTuple):
    """Event of a run: its `name`, `first` and `last` time [s], number of `samples` [-], `message`,
    and true if the run can be `trusted` all the same.
    """

    name: str
    first: float
    last: float
    samples: int
    message: str
    trusted: bool


class Audit(NamedTuple):
    """Check of a run: its balances of energy and mass, and its events."""

    balances: tuple[Balance, ...]
    events: tuple[Event, ...]

    @property
    def closes(self) -> bool:
        """True if all balances close and no event is a reason to doubt the run."""
        return not self.doubts

    @property
    def doubts(self) -> list[str]:
        """Reasons to doubt the run."""
        doubts = [
            f"the {x.name} doesn't close: its residual is {x.relative_residual:.1e} of its largest"
            f" term, more than {x.tolerance:g}" + (f": {x.remedy}" if x.remedy else "")
            for x in self.balances
            if not x.closes
        ]
        doubtful = [event for event in self.events if not event.trusted]
        return doubts + [f"{x.name} from {x.first:g} s, {x.message}" for x in doubtful]

    def __str__(self) -> str:
        lines = []
        for balance in self.balances:
            verdict = "closes" if balance.closes else "DOES NOT CLOSE"
            residual = f"residual {balance.relative_residual:.1e} of its largest term"
            lines += [f"{balance.name}: {verdict}, {residual}"]
            lines += [f"  {balance.remedy}"] if balance.remedy else []
            for side, terms in (("in", balance.inputs), ("out", balance.outputs)):
                rows = [f"  {side:>3} {name:<28} {x:>14.6g}" for name, x in terms.items()]
                lines += [f"{row} {balance.unit}" for row in rows]
        lines += [f"{x.name} from {x.first:.4g} s: {x.message}" for x in self.events]
        return "\n".join(lines)


def audit(plant: Plant, run: Trajectory) -> Audit:
    """Check the balances of a `plant`'s `run` [J], (A1) to (A3), and list its events; `ValueError`
    for a batch of runs.
    """
    if np.ndim(run.time) != 1 or np.ndim(run.ledger) != 2:
        raise InvalidInputError("run", "must be one run", np.shape(run.ledger), shown="a batch")
    law = SMOOTH if isinstance(plant.muscles, ExactMuscles) else TABULATED
    is_kinked = isinstance(plant.hysteresis, MaxwellSlip) or plant.load.stop is not None
    quantity = "energy" if plant.liquid else "exergy"
    losses = ("valve",) if plant.liquid else ("valve", "exhaust", "mixing", "wall")
    # every term as a row in time: at the end of a cycle all may be zero again
    ledger = dict(zip(LEDGER, np.asarray(run.ledger).T, strict=True))
    stores = dict(zip(STORES, np.asarray(run.outputs.store).T, strict=True))
    balances = [
        _balance(f"{quantity} of the fluid", law, {"supplied": ledger["supplied"]},
                 {**{name: ledger[name] for name in losses},
                  "work on the muscles": ledger["fluid_work"],
                  "stored in the fluid": stores["fluid"]}),
        _balance("energy of the muscles", law, {"work of the fluid": ledger["fluid_work"]},
                 {"pull on the load": ledger["pull"], "stored in the muscles": stores["muscles"]},
                 mismatch=ledger["mismatch"]),
        _balance("energy of the motion", KINKED if is_kinked else law,
                 {"pull of the muscles": ledger["pull"], "motor": ledger["motor"]},
                 {"kinetic": stores["motion"], "potential": stores["load"],
                  "damper": ledger["damper"], "stop, lost": ledger["stop"],
                  "stop, stored": stores["stop"], "friction, lost": ledger["friction"],
                  "friction, stored": stores["friction"]}),
    ]  # fmt: skip
    mass = np.sum(np.asarray(run.outputs.masses), axis=-1)
    counted = {"flowed in": ledger["mass"]}, {"held": mass}
    balances.append(_balance("mass of the fluid", COUNTED, *counted, unit="kg", size=np.max(mass)))
    if plant.liquid and plant.supply.count:
        reserve = np.asarray(run.outputs.reserve)
        spent = plant.supply.drive_energies(reserve)
        stored = np.asarray(plant.supply.stored_energy(reserve))
        inputs = {"shaft": spent.get("shaft_work", 0.0 * mass)}
        outputs = {"supplied": ledger["supplied"], "stored in the supply": stored}
        if "pump_lost" in spent:
            outputs["lost in the pump"] = spent["pump_lost"]
        balances.append(_balance("energy of the supply", SMOOTH, inputs, outputs))
    if isinstance(plant.chamber, AdiabaticWall):
        # U = p V/(γ − 1), from the outputs rather than from the state that was integrated
        p = np.asarray(run.outputs.pressures) + plant.chamber.room_pressure
        V = np.asarray(run.outputs.volumes) + plant.chamber.dead_volume
        U = np.sum(p * V, axis=-1) / (plant.chamber.gas.heat_capacity_ratio - 1)
        lost = {"heat through the wall": ledger["heat"], "work, absolute": ledger["displaced"]}
        sides = {"enthalpy": ledger["enthalpy"]}, lost | {"internal energy": U}
        balances.append(_balance("first law", SMOOTH, *sides, size=np.max(U)))
    return Audit(tuple(balances), events(run))


def events(run: Trajectory) -> tuple[Event, ...]:
    """Events of a run, such as an empty supply, ordered by their first time."""
    status, time, result = np.asarray(run.outputs.status), np.asarray(run.time), []
    for bit, name in enumerate(STATUS):
        times = time[np.flatnonzero(status & (1 << bit))].tolist()
        if times:
            span = times[0], times[-1], len(times)
            result.append(Event(name, *span, _MESSAGES[name], name in _HARMLESS))
    return tuple(sorted(result, key=lambda event: event.first))


def _balance(
    name: str,
    tolerance: float,
    inputs: dict[str, Numbers],
    outputs: dict[str, Numbers],
    unit: str = "J",
    size: float = 0.0,
    mismatch: Numbers | None = None,
) -> Balance:
    """Balance of rows in time, over the largest change of any of them or a given `size`; a
    `mismatch` is named, but is part of the residual all the same: it comes from nowhere.
    """
    rows = [*inputs.values(), *outputs.values()]
    size = max(size, *(float(np.max(np.abs(row - row[0]))) for row in rows))
    ends_in, ends_out = (
        {key: float(row[-1] - row[0]) for key, row in side.items()} for side in (inputs, outputs)
    )
    residual, remedy = sum(ends_in.values()) - sum(ends_out.values()), ""
    if mismatch is not None:
        ends_out[_MADE] = made = float(mismatch[-1] - mismatch[0])
        if abs(made) > tolerance * size:
            advice = "the straight braid's doesn't go with the force, take volume = \"conjugate\""
            remedy = f"{made:.3g} J of it are {_MADE}: {advice}"
    relative = float(abs(residual) / size) if size > 0 else 0.0
    return Balance(name, unit, ends_in, ends_out, residual, relative, tolerance, remedy)
