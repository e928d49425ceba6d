r"""A bundle with its chambers, valves, supply and load, and their state.

Every muscle of a unit shares its unit's chamber, whose volume is that of hose and fittings and
$n_i V^*_i(P_i, \varepsilon_i)$. A valve joins it to the supply and to the room. A unit's strain is
linear in the load's coordinate,

$$\varepsilon_i = \varepsilon_{0,i} + g_i\, q, \tag{T3}$$

also if muscles are of unequal length (B7), or pull against each other on a pulley.

**Assumes** that hoses have no inertia, that a chamber's fluid is well mixed, and that the
muscles of a unit are equal.
"""

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from ..bundle.bundle import Bundle
from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Whole
from ..core.validation import HIGHEST_PRESSURE, check_choice, is_concrete
from ..fluid import (
    AbstractChamber,
    AbstractSpool,
    AbstractSupply,
    Direct,
    LiquidChamber,
    Orifice,
    SonicValve,
)
from ..muscle.braid import Braid
from ..muscle.hysteresis import AbstractHysteresis, Damping
from .linearize import linearize
from .loads import AbstractLoad
from .muscles import AbstractMuscles, ExactMuscles, GeometricMuscles, MuscleTables


_ABOVE_SUPPLY = 1.2  # pressure of a closed chamber that is stretched, over its supply's, at most
LAWS = ("table", "exact")  # values of the argument `law`
_VALVES = ("valve", "exhaust_valve", "spool")
_PARTS = ("load", "supply", "chamber", *_VALVES, "hysteresis", "damping")
VOLUMES = ("conjugate", "geometric")  # values of the argument `volume`


class Plant(Module):
    """One bundle, or two on a joint, with chambers, valves, supply and load.

    Its parts are its arguments; `muscles`: of all units. Of each unit: `counts` of its muscles [-],
    their `lengths` at rest [m], the `distances` of its plates at rest [m], the index of its bundle
    among `sides`.
    """

    bundles: tuple[Bundle, ...]
    load: AbstractLoad
    supply: AbstractSupply
    chamber: AbstractChamber
    valve: SonicValve | Orifice
    exhaust_valve: SonicValve | Orifice
    spool: AbstractSpool
    hysteresis: AbstractHysteresis | None
    damping: Damping | None
    muscles: AbstractMuscles
    counts: Numbers
    lengths: Numbers
    distances: Numbers
    sides: tuple[int, ...] = static()

    def __init__(
        self,
        bundle: Bundle | Sequence[Bundle],
        load: AbstractLoad,
        supply: AbstractSupply,
        chamber: AbstractChamber,
        valve: SonicValve | Orifice,
        exhaust_valve: SonicValve | Orifice | None = None,
        spool: AbstractSpool | None = None,
        hysteresis: AbstractHysteresis | None = None,
        damping: Damping | None = None,
        law: str = "table",
        volume: str = "conjugate",
        shape: tuple[int, int] = (161, 201),
    ):
        """**Arguments:**

        - `bundle`: the bundle, or two on an `AntagonisticJoint`.
        - `load`, `supply` and `chamber`: of each unit's fluid; numbers may be one for each unit.
        - `valve`, `exhaust_valve`: from the supply and to the room; by default alike.
        - `spool`: from commands to openings; by default, `Direct`.
        - `hysteresis`, `damping`: friction of each muscle; by default, none.
        - `law`: "table" of the muscles' co-energy, or "exact", which is slow.
        - `volume`: "conjugate", which goes with the force, or "geometric".
        - `shape`: nodes of the tables in pressure and strain.

        **Raises:** `ValueError` for parts that don't go together, and for a liquid in chambers
        without compliance.
        """
        bundles = tuple(bundle) if isinstance(bundle, Sequence) else (bundle,)
        exhaust_valve = valve if exhaust_valve is None else exhaust_valve
        spool = Direct() if spool is None else spool
        units = [(unit, side) for side, b in enumerate(bundles) for unit in b.motor_units]
        muscles = [unit.muscle for unit, _ in units]
        parts = load, supply, chamber, valve, exhaust_valve, spool, hysteresis, damping
        _check_fit(bundles, dict(zip(_PARTS, parts, strict=True)))
        check_choice(law, LAWS, "law")
        check_choice(volume, VOLUMES, "volume")
        supply_pressure = float(supply.pressure_at(supply.initial_state()))
        top = min(_ABOVE_SUPPLY * supply_pressure, HIGHEST_PRESSURE)
        unit_laws: AbstractMuscles = MuscleTables.from_muscles(muscles, top, shape)
        if law == "exact":
            unit_laws = ExactMuscles.from_muscles(muscles, top, unit_laws.strains)
        if volume == "geometric":
            sizes = ("length", "outer_radius", "braid_angle")
            braid = Braid(*(np.array([float(getattr(m, x)) for m in muscles]) for x in sizes))
            walls = np.array([float(muscle.bladder.volume) for muscle in muscles])
            unit_laws = GeometricMuscles(unit_laws, braid, walls)
        self.__attrs_init__(
            bundles,
            *parts,
            unit_laws,
            counts=np.array([float(unit.count) for unit, _ in units]),
            lengths=np.array([float(muscle.length) for muscle in muscles]),
            distances=np.array([float(bundles[side].length) for _, side in units]),
            sides=tuple(side for _, side in units),
        )

    @property
    def units(self) -> int:
        """Number of motor units of all bundles."""
        return len(self.sides)

    @property
    def liquid(self) -> bool:
        """True if its fluid is a liquid."""
        return isinstance(self.chamber, LiquidChamber)

    @property
    def supply_pressure(self) -> float:
        """Gauge pressure [Pa] of its supply at the start."""
        return float(self.supply.pressure_at(self.supply.initial_state()))

    def unit_indices(self, side: int) -> Whole:
        """Indices of the units of the bundle `side`, counted from 0 [-]."""
        return np.flatnonzero(np.array(self.sides) == side)

    @property
    def gains(self) -> Numbers:
        """Slope $g_i$ of each unit's strain by the load's coordinate [SI]: 1/m, or 1/rad."""
        return self._arms(1) / self.lengths

    @property
    def offsets(self) -> Numbers:
        """Strain $\\varepsilon_{0,i}$ [-] of each unit's muscles with the load at zero."""
        return 1 - (self.distances - self._arms(0)) / self.lengths

    def _arms(self, index: int) -> Numbers:
        """Of each unit's bundle the shortening at $q = 0$ [m], `index` 0, or its arm [SI], 1."""
        arms = [self.load.arms[side][index] for side in self.sides]
        return array_namespace(*arms).stack([arm + 0.0 for arm in arms])

    def check_commands(self, commands: Numbers) -> Numbers:
        """The `commands` [-], refused unless they have a column for each motor unit."""
        if commands.shape[-1] != self.units:
            rule = f"must have {self.units} columns, one for each motor unit"
            raise InvalidInputError("commands", rule, commands.shape[-1])
        return commands

    def chambers_at(self, pressures: Numbers, position: Batch) -> Numbers:
        """States of its chambers [SI] at `pressures` [Pa], with the load at `position` [SI]."""
        with np.errstate(all="ignore"):  # of branches that aren't taken
            eps = self.strains(np.asarray(position)[..., None])
            P = pressures + 0.0 * eps
            V, _, _ = self.muscles.volumes(self.muscles.at(P, eps), eps, self.lengths)
            state = self.chamber.state_at(P, self.counts * np.asarray(V))
        return np.array(np.broadcast_to(state, (*np.shape(P), self.chamber.count)))

    def strains(self, position: Batch) -> Numbers:
        """Strain of each unit's muscles [-] at the load's `position` [SI], (T3)."""
        return self.offsets + self.gains * position

    linearize = linearize

    @property
    def stroke(self) -> tuple[float, float]:
        """Ends of the load's coordinate [SI] between which all muscles' strains are tabulated."""
        low, high = self.muscles.strains
        ends = np.stack([(end - self.offsets) / self.gains for end in (low, high)])
        return float(np.max(np.min(ends, axis=0))), float(np.min(np.max(ends, axis=0)))


def _check_fit(bundles: tuple[Bundle, ...], parts: dict[str, Any]) -> None:
    """Refuse `parts` of a wrong type or for another fluid, or unlike the load in `bundles`."""
    for name, part in parts.items():
        kind: Any = getattr(attrs.fields(Plant), name).type
        if not isinstance(part, kind):
            types = getattr(kind, "__args__", (kind,))
            names = " or ".join(item.__name__.removeprefix("Abstract") for item in types)
            rule = f"must be a {names}".replace("NoneType", "None")
            raise InvalidInputError(name, rule, part, shown=type(part).__name__)
    if not all(isinstance(bundle, Bundle) for bundle in bundles):
        kinds = ", ".join(type(bundle).__name__ for bundle in bundles)
        raise InvalidInputError("bundle", "must be a Bundle", bundles, shown=kinds)
    sides, chamber = len(parts["load"].arms), parts["chamber"]
    if len(bundles) != sides:
        kind = type(parts["load"]).__name__
        raise InvalidInputError("bundle", f"must be {sides} for {kind}", len(bundles))
    liquid = isinstance(chamber, LiquidChamber)
    fluid, flow = ("a liquid", Orifice) if liquid else ("a gas", SonicValve)
    for name in ("valve", "exhaust_valve"):
        if not isinstance(valve := parts[name], flow):
            rule = f"must be of {flow.__name__} for {fluid}"
            raise InvalidInputError(name, rule, valve, shown=type(valve).__name__)
    compliance: Numbers = chamber.compliance if liquid else 1.0
    if is_concrete(compliance) and not np.all(np.asarray(compliance) > 0):
        least = float(np.min(compliance))
        rule = "must be positive for a liquid, which hardly gives way itself"
        remedy = "write 2e-11 m^3/Pa, as of bladder, hose and fittings of each motor unit"
        raise InvalidInputError("compliance", rule, least, remedy, f"{least:g} m³/Pa")
