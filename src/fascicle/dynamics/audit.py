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

from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..fluid import AdiabaticWall
from ..muscle.hysteresis import MaxwellSlip
from .energy_ledger import LEDGER, STORES
from .muscles import ExactMuscles
from .outputs import STATUS
from .plant import Plant
from .simulate import Trajectory


# largest residual of a balance that closes, over its largest term: what Runge-Kutta's steps leave
# for a smooth law, when a table's cells are crossed, for a kink of force within a step (springs
# that begin to slip, a stop), and where terms are counted: rounding
SMOOTH, TABULATED, KINKED, COUNTED = 1e-6, 1e-5, 1e-4, 1e-12

MESSAGES = {  # of events, by their names in `STATUS`
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
# names of a supply's losses in its balance
_LOSSES = {"pump_lost": "lost in the pump"}
_BY_VOLUME = "made by the volume"  # name of a term, as JSON has it
_CONJUGATE = "the straight braid's doesn't go with the force, take volume = \"conjugate\""
_HARMLESS = ("supply_empty", "stop")  # events that are no reason to doubt the run


class Balance(NamedTuple):
    """Balance of energy or mass over a run.

    `name` and `unit`; its `inputs` and `outputs`, by name [J or kg]; the `residual`, inputs less
    outputs [J or kg], and the `relative_residual`, over the largest term [-]; `tolerance`: the
    largest relative residual at which it closes [-]; a `remedy` if
    it doesn't close for a known reason.
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
    """Event of a run: `name`; `first` and `last` time [s]; number of `samples` [-]; its
    `message`, a sentence; `trusted`, true if the run can be trusted all the same.
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
        return all(x.closes for x in self.balances) and all(x.trusted for x in self.events)

    def __str__(self) -> str:
        """Balances and events as text."""
        lines = []
        for balance in self.balances:
            verdict = "closes" if balance.closes else "DOES NOT CLOSE"
            residual = f"residual {balance.relative_residual:.1e} of its largest term"
            lines += [f"{balance.name}: {verdict}, {residual}"]
            lines += [f"  {balance.remedy}"] if balance.remedy else []
            for side, terms in (("in", balance.inputs), ("out", balance.outputs)):
                lines += [
                    f"  {side:>3} {name:<28} {value:>14.6g} {balance.unit}"
                    for name, value in terms.items()
                ]
        lines += [
            f"{event.name} from {event.first:.4g} s: {event.message}" for event in self.events
        ]
        return "\n".join(lines)


def audit(plant: Plant, run: Trajectory) -> Audit:
    """Check the balances of a run, (A1) to (A3), and list its events.

    **Arguments:** `plant`: the plant of the run; `run`: one run, not a batch of them.

    **Returns:** an `Audit` [J].

    **Raises:** `ValueError` for a batch.
    """
    if np.ndim(run.time) != 1 or np.ndim(run.ledger) != 2:
        raise InvalidInputError("run", "must be one run", np.shape(run.ledger), shown="a batch")
    ledger, largest = _changes(LEDGER, run.ledger)
    stores, largest_stores = _changes(STORES, run.outputs.store)
    largest |= {f"Δ{name}": value for name, value in largest_stores.items()}

    law = SMOOTH if isinstance(plant.muscles, ExactMuscles) else TABULATED
    is_kinked = isinstance(plant.hysteresis, MaxwellSlip) or plant.load.stop is not None
    quantity = "energy" if plant.liquid else "exergy"
    losses = ("valve",) if plant.liquid else ("valve", "exhaust", "mixing", "wall")
    balances = [
        _balance(f"{quantity} of the fluid", law, largest, {"supplied": ledger["supplied"]},
                 {**{name: ledger[name] for name in losses},
                  "work on the muscles": ledger["fluid_work"],
                  "stored in the fluid": stores["fluid"]},
                 ("supplied", *losses, "fluid_work", "Δfluid")),
        _balance("energy of the muscles", law, largest, {"work of the fluid": ledger["fluid_work"]},
                 {"pull on the load": ledger["pull"], "stored in the muscles": stores["muscles"]},
                 ("fluid_work", "pull", "Δmuscles"), volume=ledger["mismatch"]),
        _balance("energy of the motion", KINKED if is_kinked else law, largest,
                 {"pull of the muscles": ledger["pull"], "motor": ledger["motor"]},
                 {"kinetic": stores["motion"], "potential": stores["load"],
                  "damper": ledger["damper"], "stop, lost": ledger["stop"],
                  "stop, stored": stores["stop"], "friction, lost": ledger["friction"],
                  "friction, stored": stores["friction"]},
                 ("pull", "motor", "Δmotion", "Δload")),
    ]  # fmt: skip
    mass = np.sum(np.asarray(run.outputs.masses), axis=-1)
    outputs = {"held": mass[-1] - mass[0]}
    balances.append(
        _balance("mass of the fluid", COUNTED, largest | {"held": float(np.max(mass))},
                 {"flowed in": ledger["mass"]}, outputs, ("mass", "held"), unit="kg")
    )  # fmt: skip
    if plant.liquid and plant.supply.count:
        balances.append(_supply_balance(plant, run, ledger, largest))
    if isinstance(plant.chamber, AdiabaticWall):
        # U = p V/(γ − 1), from the outputs rather than from the state that was integrated
        p = np.asarray(run.outputs.pressures) + plant.chamber.room_pressure
        V = np.asarray(run.outputs.volumes) + plant.chamber.dead_volume
        U = np.sum(p * V, axis=-1) / (plant.chamber.gas.heat_capacity_ratio - 1)
        outputs = {"heat through the wall": ledger["heat"], "work, absolute": ledger["displaced"],
                "internal energy": U[-1] - U[0]}  # fmt: skip
        terms = ("enthalpy", "heat", "displaced", "held")
        largest = largest | {"held": float(np.max(U))}
        inputs = {"enthalpy": ledger["enthalpy"]}
        balances.append(_balance("first law", SMOOTH, largest, inputs, outputs, terms))
    return Audit(tuple(balances), events(run))


def audit_run(plant: Plant, run: Trajectory) -> tuple[Audit | None, list[str]]:
    """Audit of a run, `None` for a batch; reasons to doubt it."""
    audited, doubts = None, []
    try:
        audited = audit(plant, run)
    except ValueError as error:
        doubts.append(str(error).rstrip("."))
    doubts += [
        f"the {balance.name} doesn't close: its residual is {balance.relative_residual:.1e} of its"
        f" largest term, more than {balance.tolerance:g}"
        + (f": {balance.remedy}" if balance.remedy else "")
        for balance in (audited.balances if audited else ())
        if not balance.closes
    ]
    doubts += [
        f"{event.name} from {event.first:g} s, {event.message}"
        for event in events(run)
        if not event.trusted
    ]
    return audited, doubts


def events(run: Trajectory) -> tuple[Event, ...]:
    """Events of a run, such as an empty supply, ordered by their first time."""
    status, time, result = np.asarray(run.outputs.status), np.asarray(run.time), []
    for bit, name in enumerate(STATUS):
        times = time[np.flatnonzero(status & (1 << bit))].tolist()
        if times:
            number, harmless = len(times), name in _HARMLESS
            result.append(Event(name, times[0], times[-1], number, MESSAGES[name], harmless))
    return tuple(sorted(result, key=lambda event: event.first))


def _changes(names: tuple[str, ...], rows: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Changes of named quantities from a run's start to its end, and their largest meanwhile."""
    change = np.asarray(rows) - np.asarray(rows)[0]
    largest = np.abs(change).max(axis=0)
    return dict(zip(names, change[-1], strict=True)), dict(zip(names, largest, strict=True))


def _balance(
    name: str, tolerance: float, largest: dict[str, Any], inputs: dict[str, Any],
    outputs: dict[str, Any], terms: tuple[str, ...], unit: str = "J", volume: float | None = None,
) -> Balance:  # fmt: skip
    """Balance of a store's `inputs` and `outputs`, over the largest of its `terms`."""
    inputs = {key: float(value) for key, value in inputs.items()}
    outputs = {key: float(value) for key, value in outputs.items()}
    residual = sum(inputs.values()) - sum(outputs.values())
    # the largest of any term meanwhile: at the end of a cycle all may be zero again
    size = max(
        [*(largest[term] for term in terms), *map(abs, (*inputs.values(), *outputs.values()))]
    )
    remedy = ""
    if volume is not None:  # named, but part of the residual all the same: it comes from nowhere
        outputs[_BY_VOLUME] = volume = float(volume)
        if abs(volume) > tolerance * size:
            remedy = f"{volume:.3g} J of it are {_BY_VOLUME}: {_CONJUGATE}"
    relative = abs(residual) / size if size > 0 else 0.0
    return Balance(name, unit, inputs, outputs, residual, relative, tolerance, remedy)


def _supply_balance(
    plant: Plant, run: Trajectory, ledger: dict[str, Any], largest: dict[str, Any]
) -> Balance:
    """Energy balance of the supply [J]: in, its shaft work; out, what the bundle drew, what the
    supply lost, and the rise of its stored energy.
    """
    reserve = np.asarray(run.outputs.reserve)
    stored = np.asarray(plant.supply.stored_energy(reserve))
    spent = {name: x[-1] - x[0] for name, x in plant.supply.drive_energies(reserve).items()}
    inputs = {"shaft": spent.pop("shaft_work", 0.0)}
    losses = {_LOSSES.get(name, name): x for name, x in spent.items()}
    outputs = {"supplied": ledger["supplied"], "stored in the supply": stored[-1] - stored[0]}
    largest = largest | {"held": float(np.max(np.abs(stored - stored[0])))}
    terms = ("supplied", "held")
    return _balance("energy of the supply", SMOOTH, largest, inputs, outputs | losses, terms)
