r"""Energy and mass balances of a run, each term an integral of its own.

Of a gas, in exergy, what a room at $p_a$, $T_a$ would let it still do; of a liquid, in energy,

$$E_{supplied} = E_{valve} + E_{exhaust} + E_{mixing} + E_{wall} + W + \Delta E_{fluid}; \tag{A1}$$

the muscles, which store and give back what their law says,

$$W = \int F\,\mathrm{d}x + \Delta(P V^* - \Pi^*) + E_{mismatch}, \tag{A2}$$

where the last is what a volume makes that isn't the conjugate one: work out of nothing, so that it
is left over, by its name, and no such run is trusted; and the motion,

$$\int F\,\mathrm{d}x + W_{motor} = \Delta E_{kinetic} + \Delta U + E_{damper} + E_{stop}
  + E_{friction} + \Delta E_{friction}. \tag{A3}$$

With them go a liquid supply's own energy, with what drives it, the fluid's mass, and where a wall
is simulated the first law. No term is what the others leave, so that what is left says how well a
run can be believed.

**Source:** first and second law for open systems: Bejan (2016).
"""

from typing import Any, NamedTuple

import numpy as np

from ..core.errors import InvalidInputError
from ..fluid import AdiabaticWall
from .energy_ledger import LEDGER, STORES
from .hysteresis import MaxwellSlip
from .muscles import Exact
from .outputs import STATUS
from .plant import Plant
from .simulate import Trajectory


# of the largest term: what Runge-Kutta's steps leave where the law is smooth, where a table's cells
# are crossed, and where springs begin to slip or a stop is met, a kink of force within a step
SMOOTH, TABULATED, KINKED, COUNTED = 1e-6, 1e-5, 1e-4, 1e-12

WORDS = {
    "folded": "a muscle's volume fell with pressure by more than its fluid and hose give way:"
    " its pressure isn't unique; give the chamber more dead volume or compliance",
    "cavitates": "a unit was sucked empty: its fluid can't follow",
    "off_table": "a strain or pressure left what the muscles are known at; forces go on linearly"
    " there",
    "unsettled": "a pressure wasn't found to rounding in two steps; take a smaller `dt`",
    "supply_empty": "the supply has nothing left to give",
    "stop": "the load touched its stop",
    "stiff": "it would have needed more than 64 substeps; take a smaller `dt`",
    "broken": "numbers that are none came up; take a smaller `dt`",
}
_SPENT = {"pump_lost": "lost in the pump", "relief_lost": "lost in the relief valve"}
_BY_VOLUME = "made by the volume"
_CONJUGATE = "the straight braid's doesn't go with the force, take volume = \"conjugate\""
# what happened, but is no reason to doubt the run
_HARMLESS = ("supply_empty", "stop")


class Balance(NamedTuple):
    """One balance. `name`; `unit`; what came `into` it and where it `went`, each by its name [J or
    kg]; what is `left` over [J or kg], and as a `share` of the largest term [-]; up to which share
    it `closes_within` [-]; where it doesn't, and the reason is known, what to do, its `remedy` [-].
    """

    name: str
    unit: str
    into: dict[str, float]
    went: dict[str, float]
    left: float
    share: float
    closes_within: float
    remedy: str = ""

    @property
    def closes(self) -> bool:
        """True if the rest is small enough."""
        return bool(self.share <= self.closes_within)


class Event(NamedTuple):
    """Event of a run: `name`; `first` and `last` time [s]; number of `moments` [-]; a sentence in
    `words`; `trusted`, true if the run can be trusted all the same.
    """

    name: str
    first: float
    last: float
    moments: int
    words: str
    trusted: bool


class Audit(NamedTuple):
    """Balances of a run and what happened in it."""

    balances: tuple[Balance, ...]
    events: tuple[Event, ...]

    @property
    def closes(self) -> bool:
        """True if all balances close and every event can be trusted."""
        return all(balance.closes for balance in self.balances) and all(
            e.trusted for e in self.events
        )

    def __str__(self) -> str:
        """A table in words."""
        lines = []
        for balance in self.balances:
            verdict = "closes" if balance.closes else "DOES NOT CLOSE"
            lines.append(
                f"{balance.name}: {verdict}, {balance.share:.1e} of its largest term is left over"
            )
            lines += [f"  {balance.remedy}"] if balance.remedy else []
            for side, terms in (("in", balance.into), ("out", balance.went)):
                lines += [
                    f"  {side:>3} {name:<28} {value:>14.6g} {balance.unit}"
                    for name, value in terms.items()
                ]
        lines += [f"{e.name} from {e.first:.4g} s: {e.words}" for e in self.events]
        return "\n".join(lines)


def audit(plant: Plant, run: Trajectory) -> Audit:
    """The balances of a run, (A1) to (A3), and what happened in it.

    **Arguments:**

    - `plant`: that ran [-].
    - `run`: one run, not a batch of them [-].

    **Returns:** an `Audit` [J].

    **Raises:** `ValueError` for a chamber that is a fit, not physics, and for a batch.
    """
    if not plant.chamber.physical:
        kind = type(plant.chamber).__name__
        remedy = "take AdiabaticWall or Isothermal"
        raise InvalidInputError(
            "chamber", f"{kind} is a fit that keeps no balance", kind, remedy, shown=""
        )
    if np.ndim(run.time) != 1 or np.ndim(run.account) != 2:
        raise InvalidInputError("run", "must be one run", np.shape(run.account), shown="a batch")
    rows = np.asarray(run.account)
    a: dict[str, Any] = dict(zip(LEDGER, rows[-1] - rows[0], strict=True))
    largest: dict[str, Any] = dict(zip(LEDGER, np.abs(rows - rows[0]).max(axis=0), strict=True))
    store = np.asarray(run.seen.store)
    d = dict(zip(STORES, store[-1] - store[0], strict=True))
    largest |= {
        f"Δ{name}": x for name, x in zip(STORES, np.abs(store - store[0]).max(axis=0), strict=True)
    }

    exact = isinstance(plant.muscles, Exact)
    law = SMOOTH if exact else TABULATED
    what = "energy" if plant.liquid else "exergy"
    lost = ("valve",) if plant.liquid else ("valve", "exhaust", "mixing", "wall")
    balances = [
        _balance(f"{what} of the fluid", law, largest, {"supplied": a["supplied"]},
                 {**{name: a[name] for name in lost}, "work on the muscles": a["fluid_work"],
                  "stored in the fluid": d["fluid"]}, ("supplied", *lost, "fluid_work", "Δfluid")),
        _balance("energy of the muscles", law, largest, {"work of the fluid": a["fluid_work"]},
                 {"pull on the load": a["pull"], "stored in the muscles": d["muscles"]},
                 ("fluid_work", "pull", "Δmuscles"), volume=a["mismatch"]),
        _balance("energy of the motion", _motion_tolerance(plant, law), largest,
                 {"pull of the muscles": a["pull"], "motor": a["motor"]},
                 {"kinetic": d["motion"], "potential": d["load"], "damper": a["damper"],
                  "stop, lost": a["stop"], "stop, stored": d["stop"],
                  "friction, lost": a["friction"], "friction, stored": d["friction"]},
                 ("pull", "motor", "Δmotion", "Δload")),
        _mass_balance(run, a, largest),
    ]  # fmt: skip
    if plant.liquid and plant.supply.count:
        balances.append(_supply_balance(plant, run, a, largest))
    if isinstance(plant.chamber, AdiabaticWall):
        balances.append(_first_law_balance(plant, run, a, largest))
    return Audit(tuple(balances), events(run))


def events(run: Trajectory) -> tuple[Event, ...]:
    """Events of a run, by their first time."""
    status, time, seen = np.asarray(run.seen.status), np.asarray(run.time), []
    for bit, name in enumerate(STATUS):
        indices = np.flatnonzero(status & (1 << bit))
        if indices.size:
            first, last = float(time[indices[0]]), float(time[indices[-1]])
            count = int(indices.size)
            seen.append(Event(name, first, last, count, WORDS[name], name in _HARMLESS))
    return tuple(sorted(seen, key=lambda event: event.first))


def _balance(
    name: str, tolerance: float, largest: dict[str, Any], into: dict[str, Any],
    went: dict[str, Any], terms: tuple[str, ...], unit: str = "J", volume: float | None = None,
) -> Balance:  # fmt: skip
    into = {key: float(value) for key, value in into.items()}
    went = {key: float(value) for key, value in went.items()}
    left = sum(into.values()) - sum(went.values())
    # of the most that any term was meanwhile: at the end of a cycle all may be zero again
    size = max(
        [largest[term] for term in terms] + [abs(x) for x in (*into.values(), *went.values())]
    )
    remedy = ""
    if volume is not None:  # named, and left over all the same: it came from nowhere
        went[_BY_VOLUME] = volume = float(volume)
        if abs(volume) > tolerance * size:
            remedy = f"{volume:.3g} J of it are {_BY_VOLUME}: {_CONJUGATE}"
    share = abs(left) / size if size > 0 else 0.0
    return Balance(name, unit, into, went, left, share, tolerance, remedy)


def _motion_tolerance(plant: Plant, law: float) -> float:
    kinked = isinstance(plant.hysteresis, MaxwellSlip) or plant.load.stop is not None
    return KINKED if kinked else law


def _mass_balance(run: Trajectory, a: dict[str, Any], largest: dict[str, Any]) -> Balance:
    stored = np.sum(np.asarray(run.seen.masses), axis=-1)
    into, went = {"flowed in": a["mass"]}, {"held": stored[-1] - stored[0]}
    largest = largest | {"held": float(np.max(stored))}
    return _balance("mass of the fluid", COUNTED, largest, into, went, ("mass", "held"), unit="kg")


def _supply_balance(
    plant: Plant, run: Trajectory, a: dict[str, Any], largest: dict[str, Any]
) -> Balance:
    reserve = np.asarray(run.seen.reserve)
    stored = np.asarray(plant.supply.stored(reserve))
    spent = {name: x[-1] - x[0] for name, x in plant.supply.spent(reserve).items()}
    into = {"shaft": spent.pop("shaft_work", 0.0)}
    spent = {_SPENT.get(name, name): x for name, x in spent.items()}
    went = {"supplied": a["supplied"], "stored in the supply": stored[-1] - stored[0], **spent}
    largest = largest | {"held": float(np.max(np.abs(stored - stored[0])))}
    return _balance("energy of the supply", SMOOTH, largest, into, went, ("supplied", "held"))


def _first_law_balance(
    plant: Plant, run: Trajectory, a: dict[str, Any], largest: dict[str, Any]
) -> Balance:
    # U = p V/(γ − 1), from what is seen rather than from the state that was integrated
    p = np.asarray(run.seen.pressures) + plant.chamber.room_pressure
    V = np.asarray(run.seen.volumes) + plant.chamber.dead_volume
    U = np.sum(p * V, axis=-1) / (plant.chamber.gas.heat_capacity_ratio - 1)
    went = {"heat through the wall": a["heat"], "work, absolute": a["displaced"],
            "internal energy": U[-1] - U[0]}  # fmt: skip
    terms = ("enthalpy", "heat", "displaced", "held")
    largest = largest | {"held": float(np.max(U))}
    return _balance("first law", SMOOTH, largest, {"enthalpy": a["enthalpy"]}, went, terms)
