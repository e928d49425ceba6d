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

from functools import partial
from typing import NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..core.findings import Finding, Severity
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

_HARMLESS = ("supply_empty", "stop")  # events that are no reason to doubt the run
_MADE = "made by the volume"  # name of a term, as JSON has it


class Balance(NamedTuple):
    """Balance of energy or mass over a run.

    Its `inputs` and `outputs` by name, and the `residual`, inputs less outputs, in its `unit`; the
    `relative_residual`, over the largest term, 0 where it is a rounding of the energies at play,
    and the `tolerance` at which it closes [-]; `mismatch`: the part of the residual that a volume
    makes that isn't the conjugate one, in `unit`; 0 within the tolerance.
    """

    name: str
    unit: str
    inputs: dict[str, float]
    outputs: dict[str, float]
    residual: float
    relative_residual: float
    tolerance: float
    mismatch: float = 0.0

    @property
    def closes(self) -> bool:
        """True if the residual is small enough."""
        return bool(self.relative_residual <= self.tolerance)


class Event(NamedTuple):
    """Event of a run: its `name`, one of `STATUS`, `first` and `last` time [s], number of `samples`
    [-], and true if the run can be `trusted` all the same.
    """

    name: str
    first: float
    last: float
    samples: int
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
    def doubts(self) -> list[Finding]:
        """Reasons to doubt the run: its findings that are errors."""
        return [finding for finding in self.findings if finding.severity is Severity.ERROR]

    @property
    def findings(self) -> list[Finding]:
        """A `Finding` for each balance that doesn't close, nonconjugate volume, and event.

        Codes: "run.unbalanced", "run.volume_not_conjugate", and "run." with an event's name.
        """
        findings = []
        for x in self.balances:
            if not x.closes:
                data = {"residual": x.relative_residual, "tolerance": x.tolerance}
                code = "run.unbalanced"
                findings.append(Finding(code, Severity.ERROR, {"balance": x.name, **data}))
            if x.mismatch:
                data = {"balance": x.name, "energy": x.mismatch}
                findings.append(Finding("run.volume_not_conjugate", Severity.ERROR, data))
        for event in self.events:
            severity = Severity.NOTE if event.trusted else Severity.ERROR
            data = {"first": event.first, "last": event.last, "samples": event.samples}
            findings.append(Finding(f"run.{event.name}", severity, data))
        return findings

    def __str__(self) -> str:
        """Table of the balances' terms, and of the events."""
        lines = []
        for x in self.balances:
            lines.append(f"{x.name}: {x.relative_residual:.1e} of at most {x.tolerance:.0e}")
            for side, terms in (("in", x.inputs), ("out", x.outputs)):
                lines += [f"  {side:>3} {key:<28} {y:>14.6g} {x.unit}" for key, y in terms.items()]
        lines += [f"{x.name}: {x.first:.4g} to {x.last:.4g} s" for x in self.events]
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
    # in each substep a work p dV adds a rounding of the fluid's p V, also where nothing moves
    p = np.asarray(run.outputs.pressures) + plant.chamber.room_pressure
    V = np.asarray(run.outputs.volumes) + plant.chamber.dead_volume
    pV = np.sum(p * V, axis=-1)
    rounding = float(np.finfo(float).eps * np.max(pV) * len(pV) * max(run.substeps, 1))
    balance = partial(_balance, rounding=rounding)
    balances = [
        balance(f"{quantity} of the fluid", law, {"supplied": ledger["supplied"]},
                {**{name: ledger[name] for name in losses},
                 "work on the muscles": ledger["fluid_work"],
                 "stored in the fluid": stores["fluid"]}),
        balance("energy of the muscles", law, {"work of the fluid": ledger["fluid_work"]},
                {"pull on the load": ledger["pull"], "stored in the muscles": stores["muscles"]},
                mismatch=ledger["mismatch"]),
        balance("energy of the motion", KINKED if is_kinked else law,
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
        balances.append(balance("energy of the supply", SMOOTH, inputs, outputs))
    if isinstance(plant.chamber, AdiabaticWall):
        # U = p V/(γ − 1), from the outputs rather than from the state that was integrated
        U = pV / (plant.chamber.gas.heat_capacity_ratio - 1)
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
            result.append(Event(name, *span, name in _HARMLESS))
    return tuple(sorted(result, key=lambda event: event.first))


def _balance(
    name: str,
    tolerance: float,
    inputs: dict[str, Numbers],
    outputs: dict[str, Numbers],
    unit: str = "J",
    size: float = 0.0,
    mismatch: Numbers | None = None,
    rounding: float = 0.0,
) -> Balance:
    """Balance of rows in time, over the largest change of any of them or a given `size`; a
    `mismatch` is named, but is part of the residual all the same: it comes from nowhere. What is
    no more than their `rounding`, in `unit`, is zero. With numbers that aren't finite it is open.
    """
    rows = [*inputs.values(), *outputs.values()]
    with np.errstate(invalid="ignore"):  # of infinite numbers
        size = float(np.max([size, *(np.max(np.abs(row - row[0])) for row in rows)]))
    ends_in, ends_out = (
        {key: float(row[-1] - row[0]) for key, row in side.items()} for side in (inputs, outputs)
    )
    residual, made = sum(ends_in.values()) - sum(ends_out.values()), 0.0
    is_finite = np.isfinite(size) and np.isfinite(rounding)
    if mismatch is not None:
        ends_out[_MADE] = made = float(mismatch[-1] - mismatch[0])
        is_finite = is_finite and np.isfinite(made)
        made = made if abs(made) > max(tolerance * size, rounding) else 0.0
    relative = np.nan
    if is_finite:
        is_zero = abs(residual) <= rounding or size == 0
        relative = 0.0 if is_zero else float(abs(residual) / size)
    return Balance(name, unit, ends_in, ends_out, residual, relative, tolerance, made)
