r"""A bundle with its chambers, valves, supply and load: what there is, before anything moves.

Every muscle of a unit shares its unit's chamber, whose volume is that of hose and fittings and
$n_i V^*_i(P_i, \varepsilon_i)$. A valve joins it to the supply and to the room. A unit's strain is
linear in the load's coordinate,

$$\varepsilon_i = \varepsilon_{0,i} + g_i\, q, \tag{T3}$$

also where muscles are of unlike length (B7), or pull against each other on a pulley.

**Assumes** that hoses have no inertia, that a chamber's fluid is mixed at once, and that the
muscles of a unit are alike.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..bundle.bundle import Bundle
from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Whole
from ..core.validation import HIGHEST_PRESSURE, check_choice
from ..fluid import AbstractChamber, AbstractSpool, AbstractSupply, Direct, Orifice, SonicValve
from ..fluid.liquid_chamber import LiquidChamber
from ..muscle.braid import Braid
from .hysteresis import AbstractHysteresis
from .loads import AbstractLoad
from .muscles import AbstractMuscles, Exact, Geometric, Tables


# a closed chamber that is stretched rises above its supply: by a fifth is far
_ABOVE_SUPPLY = 1.2
LAWS = ("table", "exact")
VOLUMES = ("conjugate", "geometric")


class Plant(Module):
    """A bundle with its chambers, valves, supply and load.

    `bundles`: as many as the load takes [-]. `chamber`, `valve`, `exhaust_valve`, `spool`,
    `supply`, `load`, `hysteresis`: those of the arguments [-]. `muscles`: of all units, in a row.
    Of each unit: `counts` of its muscles [-], their `lengths` at rest [m], the `distances` of its
    plates at rest [m], its bundle's place among `sides` [-].
    """

    bundles: tuple[Bundle, ...]
    load: AbstractLoad
    supply: AbstractSupply
    chamber: AbstractChamber
    valve: SonicValve | Orifice
    exhaust_valve: SonicValve | Orifice
    spool: AbstractSpool
    hysteresis: AbstractHysteresis | None
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
        law: str = "table",
        volume: str = "conjugate",
        shape: tuple[int, int] = (161, 201),
    ):
        """**Arguments:**

        - `bundle`: the bundle [-], or two on an `AntagonisticJoint`.
        - `load`: what it moves [-].
        - `supply`: where its fluid comes from [-].
        - `chamber`: what each unit's fluid is in [-]; its numbers may be one for each unit.
        - `valve`: from the supply to each unit [-].
        - `exhaust_valve`: from each unit to the room [-]; left out, like `valve`.
        - `spool`: from commands to openings [-]; left out, `Direct`.
        - `hysteresis`: friction of each muscle [-]; left out, none.
        - `law`: "table" of the muscles' co-energy, or "exact", which is slow [-].
        - `volume`: "conjugate", which goes with the force, or "geometric" [-].
        - `shape`: nodes of the tables in pressure and strain [-].

        **Raises:** `ValueError`, one line, for what doesn't go together.
        """
        self.bundles = tuple(bundle) if isinstance(bundle, Sequence) else (bundle,)
        for item in self.bundles:
            if not isinstance(item, Bundle):
                raise InvalidInputError(
                    "bundle", "must be a Bundle", item, shown=type(item).__name__
                )
        self.load, self.supply, self.chamber = load, supply, chamber
        self.valve = valve
        self.exhaust_valve = valve if exhaust_valve is None else exhaust_valve
        self.spool = Direct() if spool is None else spool
        self.hysteresis = hysteresis
        units = [
            (unit, side) for side, item in enumerate(self.bundles) for unit in item.motor_units
        ]
        self.sides = tuple(side for _, side in units)
        self.counts = np.array([float(unit.count) for unit, _ in units])
        self.lengths = np.array([float(unit.muscle.length) for unit, _ in units])
        self.distances = np.array([float(self.bundles[side].length) for side in self.sides])
        _check_fit(self)
        check_choice(law, LAWS, "law")
        check_choice(volume, VOLUMES, "volume")
        per_bundle = [unit.muscle for unit, _ in units]
        top = min(_ABOVE_SUPPLY * self.supply_pressure, HIGHEST_PRESSURE)
        muscles: AbstractMuscles = Tables.of(per_bundle, top, shape)
        if law == "exact":
            muscles = Exact.of(per_bundle, top, muscles.strains)
        if volume == "geometric":
            sizes = ("length", "outer_radius", "braid_angle")
            braid = Braid(
                *(np.array([float(getattr(m, name)) for m in per_bundle]) for name in sizes)
            )
            muscles = Geometric(
                muscles, braid, np.array([float(m.bladder.volume) for m in per_bundle])
            )
        self.muscles = muscles

    @property
    def units(self) -> int:
        """How many motor units there are [-], of all bundles."""
        return len(self.sides)

    @property
    def commands(self) -> int:
        """How many commands it takes [-]."""
        return self.spool.commands(self.units)

    @property
    def liquid(self) -> bool:
        """True if it is filled with a liquid."""
        return isinstance(self.chamber, LiquidChamber)

    @property
    def supply_pressure(self) -> float:
        """Gauge pressure [Pa] that its supply begins with."""
        return float(self.supply.pressure_at(self.supply.start()))

    def places(self, side: int) -> Whole:
        """Indices of the units of the bundle `side`, counted from 0."""
        return np.flatnonzero(np.array(self.sides) == side)

    @property
    def gains(self) -> Numbers:
        """$g_i$, how much each unit's muscles contract by the load's coordinate [SI]."""
        return self._of_sides(1) / self.lengths

    @property
    def offsets(self) -> Numbers:
        """$\\varepsilon_{0,i}$ of each unit's muscles [-]."""
        return 1 - (self.distances - self._of_sides(0)) / self.lengths

    def _of_sides(self, side_index: int) -> Numbers:
        arms = [self.load.arms[side][side_index] for side in self.sides]
        return array_namespace(*arms).stack([arm + 0.0 for arm in arms])

    def checked(self, commands: Numbers) -> Numbers:
        """`commands` [-] as they are [-], refused unless they have a column for each it takes."""
        if commands.shape[-1] != self.commands:
            rule = f"must have {self.commands} columns, one for each command"
            raise InvalidInputError("commands", rule, commands.shape[-1])
        return commands

    def charged(self, pressures: Numbers, position: Batch) -> Numbers:
        """States of its chambers [SI] at `pressures` [Pa], as warm as the room, with the load at
        `position` [SI].
        """
        with np.errstate(all="ignore"):  # of branches that aren't taken
            eps = self.strains(np.asarray(position)[..., None])
            P = pressures + 0.0 * eps
            V, _, _ = self.muscles.volumes(self.muscles.at(P, eps), eps, self.lengths)
            state = self.chamber.start(P, self.counts * np.asarray(V))
        return np.array(np.broadcast_to(state, (*np.shape(P), self.chamber.count)))

    def strains(self, position: Batch) -> Numbers:
        """Strain of each unit's muscles [-] at the load's `position` [SI], (T3)."""
        return self.offsets + self.gains * position

    @property
    def stroke(self) -> tuple[float, float]:
        """Ends of the load's coordinate [SI] between which all muscles' strains are known."""
        low, high = self.muscles.strains
        ends = np.stack([(end - self.offsets) / self.gains for end in (low, high)])
        return float(np.max(np.min(ends, axis=0))), float(np.min(np.max(ends, axis=0)))


def _check_fit(plant: Plant) -> None:
    """Refuse parts that don't go together."""
    kinds = {
        "load": AbstractLoad, "supply": AbstractSupply, "chamber": AbstractChamber,
        "valve": SonicValve | Orifice, "exhaust_valve": SonicValve | Orifice,
        "spool": AbstractSpool, "hysteresis": AbstractHysteresis | None,
    }  # fmt: skip
    for name, kind in kinds.items():
        value: Any = getattr(plant, name)
        if not isinstance(value, kind):
            per_bundle = getattr(kind, "__args__", (kind,))
            named = " or ".join(item.__name__.removeprefix("Abstract") for item in per_bundle)
            rule = f"must be a {named}".replace("NoneType", "None")
            raise InvalidInputError(name, rule, value, shown=type(value).__name__)
    sides = len(plant.load.arms)
    if len(plant.bundles) != sides:
        kind = type(plant.load).__name__
        raise InvalidInputError("bundle", f"must be {sides} for {kind}", len(plant.bundles))
    flows = {"a gas": SonicValve, "a liquid": Orifice}
    fluid = "a liquid" if plant.liquid else "a gas"
    for name in ("valve", "exhaust_valve"):
        valve = getattr(plant, name)
        if not isinstance(valve, flows[fluid]):
            rule = f"must be of {flows[fluid].__name__} for {fluid}"
            raise InvalidInputError(name, rule, valve, shown=type(valve).__name__)
    plant.spool.commands(plant.units)
