r"""Bundles that drive a robot: their chambers beside MuJoCo's state, and one step of both.

A step takes the tendons' lengths *of this step*, sets each bundle's pull for them, and lets MuJoCo
complete it. With the lengths of the step before, which are in MuJoCo's data before `mj_step`, a
muscle is a delayed spring, and generates energy. So does a pull that is constant through the stages
of a Runge-Kutta step, which is therefore refused.

Fluid flows between steps: at the pressures $P$ of this step a chamber's mass becomes

$$m \leftarrow m + \Delta t\, \dot m(P),$$

and the next step's pressures are the roots of (F12) at its lengths, so that a closed chamber is a
spring, which keeps its energy. Cords and brackets that stretch, and cords that go slack, are solved
with them, (J2).

**Sign:** pull is positive. **Source:** derived here; on the order of a step: MuJoCo's
documentation, "Simulation", on `mj_step1` and `mj_step2`.
"""

import warnings
from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..core.array_namespace import array_namespace, maximum, where
from ..core.errors import InvalidInputError
from ..core.module import Module, static, with_fields
from ..core.types import Batch, Marks, Numbers, PyTree, Values, Whole
from ..core.validation import (
    HIGHEST_PRESSURE,
    check_finite,
    check_interval,
    is_concrete,
    match_array_type,
)
from ..dynamics import Plant, State
from ..dynamics.chamber_pressure import solve_pressures
from ..dynamics.motion import evaluate_flows
from ..fluid import (
    AbstractChamber,
    AbstractSpool,
    AbstractSupply,
    ConstantSupply,
    Isothermal,
    Orifice,
    SonicValve,
)
from ..fluid.chamber import AbstractMassChamber
from ..fluid.spools import validate_commands
from .attach import Attached, Tendons, check_model
from .compliance import NEWTON_STEPS, Series, bundle_strains
from .optional_imports import Data, Model, mjx, mujoco
from .tables import SoftEnds, TableWarning, status_message, table_status


_RUNGE_KUTTA = int(mujoco.mjtIntegrator.mjINT_RK4)  # a number compares faster


class Fluid(NamedTuple):
    """Fluid of bundles: `chambers`, a row for each unit [SI], `spool` of the valves [-], the
    `supply`'s state [SI], `consumption` from it so far [kg], and `inside`, true if all muscles were
    in their tables up to now. At the last step: units' `pressures` [Pa] and `status`, a
    `TableStatus`, and `contractions` of the bundles [m].
    """

    chambers: Numbers
    pressures: Numbers
    spool: Numbers
    supply: Numbers
    inside: Marks
    contractions: Numbers
    status: Whole
    consumption: Batch


class Drive(Module):
    """Bundles on tendons of one compiled model, made by `Drive.of`.

    `plant`: their muscles, chambers, valves and supply. `rest_lengths`: of their tendons [m].
    `series`: their cords and brackets. `actuators`: their indices in the model. `tendons`: their
    names. `valved`: true with valves and chambers.
    """

    plant: Plant
    rest_lengths: Numbers
    series: Series
    actuators: tuple[int, ...] = static()
    tendons: tuple[str, ...] = static()
    valved: bool = static()

    @classmethod
    def of(
        cls,
        model: Model,
        attached: Sequence[Attached],
        supply: AbstractSupply | None = None,
        chamber: AbstractChamber | None = None,
        valve: SonicValve | Orifice | None = None,
        exhaust_valve: SonicValve | Orifice | None = None,
        spool: AbstractSpool | None = None,
        highest_pressure: Values = None,
        shape: tuple[int, int] = (161, 201),
    ) -> "Drive":
        """Drive of a model.

        **Arguments:**

        - `model`: MuJoCo's compiled `MjModel`.
        - `attached`: of each bundle, as returned by `attach`.
        - `supply`, `chamber`, `valve`, `exhaust_valve`, `spool`: as of a `Plant`; without the first
          three the command of a step is pressures.
        - `highest_pressure`: of a command [Pa]; left out, the bundles' largest supply pressure.
        - `shape`: nodes of the muscles' tables in pressure and strain.

        **Raises:** `InvalidInputError` for components that don't fit, a chamber whose gas warms, a
        model stepped by Runge-Kutta, and a tendon that begins outside of its muscles' tables, where
        `size` helps.
        """
        check_model(model, "model", ("MjModel",))
        _check_integrator(model)
        parts = {"supply": supply, "chamber": chamber, "valve": valve}
        missing = [name for name, part in parts.items() if part is None]
        if 0 < len(missing) < len(parts):
            remedy = "give supply, chamber and valve, or none of them"
            raise InvalidInputError(missing[0], "is missing", None, remedy)
        if chamber is not None and not isinstance(chamber, AbstractMassChamber):
            rule, remedy = "must be one whose state is its mass", "take Isothermal or LiquidChamber"
            kind = type(chamber).__name__
            raise InvalidInputError("chamber", rule, chamber, remedy, shown=kind)
        entries = attached if isinstance(attached, list | tuple) else [None]
        if not entries or not all(isinstance(entry, Attached) for entry in entries):
            rule, remedy = "must be a list of what `attach` returns", "write [attach(…)]"
            raise InvalidInputError("attached", rule, None, remedy)
        bundles = [entry.bundle for entry in attached]
        if supply is None or chamber is None or valve is None:
            limit = HIGHEST_PRESSURE
            supplies = [x.supply_pressure for x in bundles if x.supply_pressure is not None]
            # the tables reach a fifth beyond the supply's pressure
            top = max(map(float, supplies), default=limit / 1.2)
            if highest_pressure is not None:
                top = float(check_interval(highest_pressure, 0.0, limit, "highest_pressure", "Pa"))
            # a plant needs a valve; commands are pressures here, so none of its flow counts
            supply, chamber, valve = ConstantSupply(top), Isothermal(), SonicValve(1e-9, 0.3)
        load = Tendons(bundles=len(bundles))
        plant = Plant(bundles, load, supply, chamber, valve, exhaust_valve, spool, shape=shape)
        plant = with_fields(plant, muscles=SoftEnds.from_muscles(plant.muscles, plant.lengths))
        indices, names = zip(*(entry.actuator_in(model) for entry in attached), strict=True)
        if len(set(indices)) < len(indices):
            rule = f"must name each actuator once, got {', '.join(x.actuator for x in attached)}"
            raise InvalidInputError("attached", rule, None, "drop the second one", shown="")
        compliance = np.array([entry.compliance for entry in attached])
        members = np.eye(len(bundles))[:, list(plant.sides)]
        slack = tuple(entry.slack for entry in attached)
        series = Series(compliance, members, slack, not (any(slack) or compliance.any()))
        rest_lengths = np.array([entry.rest_length for entry in attached])
        drive = cls(plant, rest_lengths, series, tuple(indices), tuple(names), not missing)
        fluid = drive.start(model, data := mujoco.MjData(model))
        if not fluid.inside:
            side = plant.sides[int(np.flatnonzero(fluid.status)[0])]
            length, rest_length = data.actuator_length[indices[side]], rest_lengths[side]
            remedy = f"the tendon begins {length:.4g} m long, `rest_length` is {rest_length:.4g} m:"
            remedy += " `fascicle.robots.size` chooses one"
            rule = f"begin outside of a table: the {drive._describe(fluid.status)}"
            raise InvalidInputError("attached", rule, None, remedy)
        return drive

    def __repr__(self) -> str:
        return f"<Drive of {self.units} motor units on {', '.join(self.tendons)}>"

    @property
    def units(self) -> int:
        """Number of motor units of all bundles."""
        return self.plant.units

    def pull(self, pressures: Numbers, lengths: Numbers) -> Numbers:
        """Pull of each bundle [N] at `pressures` of all units [Pa] and `lengths` of the bundles'
        tendons [m]; a `TableWarning` says where a muscle has left its table, `InvalidInputError`
        refuses pressures outside of the tables, and NaN.
        """
        return self._pull(*self._enter(pressures, lengths))

    def energy(self, pressures: Numbers, lengths: Numbers) -> Batch:
        """Stored energy [J] of all bundles at constant pressures, the negative of their co-energy,
        and of stretched cords; `pressures` [Pa], `lengths` [m] and errors are those of `pull`.
        """
        P, eps = self._enter(pressures, lengths)
        coenergy = self.plant.muscles.at(P, eps).coenergy
        cords = self.series.compliance * self._pull(P, eps) ** 2 / 2
        add = array_namespace(coenergy).sum
        return add(cords, axis=-1) - add(self.plant.counts * coenergy, axis=-1)

    @property
    def highest_pressure(self) -> float:
        """Least of the ends of the muscles' tables [Pa]."""
        return float(np.min(self.plant.muscles.highest_pressure))

    def _check_pressures(self, pressures: Values, name: str, low: float = 0.0) -> Numbers:
        """The `pressures` [Pa], refused off the muscles' tables and below the `low` end [Pa]."""
        ends = low, self.highest_pressure
        return check_interval(pressures, *ends, name, "Pa", "of the table", (True, True))

    def _enter(self, pressures: Values, lengths: Values) -> tuple[Numbers, Numbers]:
        """Checked `pressures` [Pa], and strains of all units [-] at `lengths` of tendons [m]."""
        plant, low = self.plant, float(np.min(self.plant.chamber.lowest_pressure))
        P = match_array_type(pressures, self._check_pressures(pressures, "pressures", low))
        P = _expand(P, self.units, "pressures", rows=True)
        lengths = match_array_type(lengths, check_finite(lengths, "lengths", "m"))
        lengths = _expand(lengths, len(self.actuators), "lengths", rows=True)
        eps = bundle_strains(plant, self.series.contractions(plant, self.rest_lengths - lengths, P))
        if is_concrete(P, eps):
            self._warn(table_status(plant.muscles, P, eps), 4)
        return P, eps

    def _pull(self, pressures: Numbers, strains: Numbers) -> Numbers:
        """Pull of each bundle [N] at `pressures` [Pa] and `strains` of the units [-]."""
        force = self.plant.muscles.at(pressures, strains).force
        pull = self.series.sum_units(self.plant.counts * force)
        # a slack muscle pulls with the rounding of its free length
        return where(np.array(self.series.slack), maximum(pull, 0.0), pull)

    def _warn(self, status: Whole, level: int) -> None:
        """Warn of units outside of their tables, at the caller's line, `level` frames up."""
        if np.asarray(status).any():  # of a JAX array `np.any` compiles
            # the words are the same each time, so that Python shows them once for a line of code
            text = f"The {self._describe(status)}. This is shown once."
            warnings.warn(text, TableWarning, stacklevel=level)

    def _describe(self, status: Whole) -> str:
        """Words for the first unit outside of its table, by the `status` of each."""
        names = [self.tendons[side] for side in self.plant.sides]
        return status_message(self.plant.muscles, status, names)

    def start(self, model: Model, data: Data, pressures: Values = 0.0) -> Fluid:
        """Initial fluid [SI], of MuJoCo's `model` and `data`, at `pressures` [Pa] of all units, or
        of each; `InvalidInputError` for pressures above the muscles' tables.
        """
        check_model(model, "model", ("MjModel",))
        mujoco.mj_forward(model, data)
        P = _expand(self._check_pressures(pressures, "pressures"), self.units, "pressures")
        return self.fluid_at(data.actuator_length, P)

    def fluid_at(self, actuator_lengths: Numbers, pressures: Numbers) -> Fluid:
        """Fluid at `actuator_lengths`, of all actuators of the model [m], and units' `pressures`
        [Pa]; under JAX, too, where nothing is checked.
        """
        plant, P = self.plant, pressures
        contraction = self.rest_lengths - actuator_lengths[np.array(self.actuators)]
        xp = array_namespace(contraction, P)
        x = self.series.contractions(plant, contraction, P)
        eps = bundle_strains(plant, x)
        volume = plant.counts * plant.muscles.at(P, eps).volume
        chambers = xp.asarray(plant.chamber.state_at(P, volume))
        spool = xp.zeros(plant.spool.state_count(self.units))
        supply = xp.asarray(plant.supply.initial_state(), float)
        status = table_status(plant.muscles, P, eps)
        inside = xp.asarray(xp.all(status == 0))
        return Fluid(chambers, P, spool, supply, inside, x, status, xp.zeros(()))

    def step(
        self, model: Model, data: Data, fluid: Fluid, command: Values, act: Numbers | None = None
    ) -> Fluid:
        """Step MuJoCo's `data` of a `model`: the fluid [SI] after it, from the `fluid` before it.

        `command`: of the valves, from -1 to 1 [-]; without valves, all units' pressures [Pa].
        `act`: `jax.jit(drive.act)`, for many steps; left out, NumPy's, without compilation.
        A `TableWarning` says that a muscle has left its table; `status` of the fluid says which.
        `InvalidInputError` for a command that is none, and a simulation that diverges.
        """
        check = validate_commands if self.valved else self._check_pressures
        row = _expand(check(command, "command"), self.units, "command")
        if act is None:
            act, fluid = self.act, Fluid(*map(np.asarray, fluid))  # which compiled steps may give
        _check_integrator(model)
        mujoco.mj_step1(model, data)
        lengths = data.actuator_length[list(self.actuators)]
        if not np.all(np.isfinite(lengths)):
            remedy = "the simulation has diverged: take a shorter timestep, or more damping"
            raise InvalidInputError("data", "must have finite tendon lengths", None, remedy)
        after, pull = act(fluid, lengths, row, model.opt.timestep)
        data.ctrl[list(self.actuators)] = pull
        mujoco.mj_step2(model, data)
        self._warn(after.status, 3)
        return after

    def act(
        self, fluid: Fluid, lengths: Numbers, command: Numbers, dt: Batch
    ) -> tuple[Fluid, Numbers]:
        """One step `dt` [s] of the bundles: the fluid [SI] after it from that before, and each
        bundle's pull in it [N], at `lengths` of their tendons in this step [m], under a `command`
        of the valves [-], or without valves of pressures [Pa].
        """
        plant, solve, P = self.plant, self.series.contractions, fluid.pressures
        contraction, start, after = self.rest_lengths - lengths, fluid.contractions, fluid
        xp = array_namespace(contraction, P)
        if not self.valved:
            P = command + 0.0 * P
        closed = fluid.chambers if self.valved else None
        x = solve(plant, contraction, P, closed, start)
        if self.valved:
            P = solve_pressures(plant, closed, bundle_strains(plant, x), P, NEWTON_STEPS)
            state = State(0.0, 0.0, fluid.spool, closed, P, fluid.supply)
            flows = evaluate_flows(plant, state, P, command)
            rate = plant.chamber.rates(closed, P, flows.mass, flows.enthalpy, 0.0)
            drawn, enthalpy = (xp.sum(y, axis=-1) for y in (flows.drawn, flows.drawn_enthalpy))
            after = fluid._replace(
                chambers=closed + dt * rate,
                spool=fluid.spool + dt * plant.spool.rate(command, fluid.spool),
                supply=fluid.supply + dt * plant.supply.rates(fluid.supply, -drawn, -enthalpy),
                consumption=fluid.consumption + dt * drawn,
            )
        eps = bundle_strains(plant, x)
        status = table_status(plant.muscles, P, eps)
        inside = xp.all(status == 0, axis=-1) & fluid.inside
        after = after._replace(pressures=P, inside=inside, contractions=x, status=status)
        return after, self._pull(P, eps)

    def step_mjx(
        self, model: Model, data: Data, fluid: Fluid, command: Numbers
    ) -> tuple[Data, Fluid]:
        """MJX's data and fluid [SI] after one step, under `jit`, `vmap` and forward derivatives.

        MJX's `model` and `data`, and the `fluid` before the step [SI], best where the data are, by
        `jax.device_put(fluid, data.qpos.device)`: else the second step compiles again; `command` as
        of `step`. Nothing is checked: `fluid.inside` is false outside of the muscles' tables.
        """
        engine, indices = mjx(), np.array(self.actuators)
        lengths = engine.fwd_position(model, data).actuator_length[indices]
        fluid, pull = self.act(fluid, lengths, command, model.opt.timestep)
        after = engine.step(model, data.replace(ctrl=data.ctrl.at[indices].set(pull)))
        return with_types(after, data), fluid


def with_types(after: PyTree, before: PyTree) -> PyTree:
    """Data `after` a function of MJX with the types of those `before`: with 64 bits some whole
    numbers come back wider, which no loop accepts.
    """
    return jax.tree.map(lambda x, y: jnp.asarray(x, y.dtype), after, before)


def _expand(values: Numbers, count: int, name: str, rows: bool = False) -> Numbers:
    """A row of `count` numbers of `values` [any unit] called `name`, one or `count` of them, or
    `rows` of them; refused with another shape.
    """
    shape = np.shape(values)
    if shape[-1:] not in {(), (1,), (count,)} or (len(shape) > 1 and not rows):
        text = f"the shape {shape}"
        raise InvalidInputError(name, f"must be one, or {count}", None, shown=text)
    return values + np.zeros(count)


def _check_integrator(model: Model) -> None:
    """Refuse a `model` stepped by Runge-Kutta: a pull constant through its stages makes energy."""
    if model.opt.integrator == _RUNGE_KUTTA:
        remedy = "take Euler or implicitfast"
        raise InvalidInputError("model.opt.integrator", "must not be RK4", "RK4", remedy, shown="")
