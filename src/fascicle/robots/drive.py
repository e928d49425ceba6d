r"""Bundles that drive a robot: their chambers beside MuJoCo's state, and one step of both.

A step takes the tendons' lengths *of this step*, sets each bundle's pull for them, and lets MuJoCo
complete it. With the lengths of the step before, which are in MuJoCo's data before `mj_step`, a
muscle is a delayed spring, and generates energy. So does a pull that is constant through the stages
of a Runge-Kutta step: there it is evaluated at each stage, by MuJoCo's gain callback.

Fluid flows between steps: at the pressures $P$ of this step a chamber's mass becomes

$$m \leftarrow m + \Delta t\, \dot m(P),$$

and the next step's pressures are the roots of (F12) at its lengths, so that a closed chamber is a
spring, which keeps its energy.

**Sign:** pull is positive. **Source:** derived here; on the order of a step: MuJoCo's
documentation, "Simulation", on `mj_step1` and `mj_step2`.
"""

import difflib
import warnings
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np

from ..core.array_namespace import array_namespace
from ..core.errors import InvalidInputError
from ..core.module import Module, static
from ..core.types import Batch, Numbers, Values
from ..core.validation import HIGHEST_PRESSURE, check_interval, is_concrete
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
from .attach import Attached, Tendons
from .optional_imports import mjx, mujoco


_NEWTON = 3  # steps, from the last pressures: a tendon moves farther in a step than by its rate


class Fluid(NamedTuple):
    """Fluid of bundles: `chambers`, one row for each unit [SI], `pressures` [Pa] at the last step,
    `spool` of the valves [-], the `supply`'s state [SI], and `inside`, true if all strains and
    pressures were in the muscles' tables.
    """

    chambers: Numbers
    pressures: Numbers
    spool: Numbers
    supply: Numbers
    inside: Any

    @property
    def known(self) -> Any:
        """Former name of `inside`."""
        warnings.warn("`Fluid.known` is now `Fluid.inside`.", DeprecationWarning, stacklevel=2)
        return self.inside


class Drive(Module):
    """Bundles on tendons of one compiled model, made by `Drive.of`.

    `plant`: their muscles, chambers, valves and supply. `rest_lengths`: of their tendons [m].
    `members`: a row for each bundle, with ones at its units. `actuators`: their indices in the
    model. `tendons`: their names. `valved`: true with valves and chambers.
    """

    plant: Plant
    rest_lengths: Numbers
    members: Numbers
    actuators: tuple[int, ...] = static()
    tendons: tuple[str, ...] = static()
    valved: bool = static()

    @classmethod
    def of(
        cls,
        model: Any,
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
        - `supply`, `chamber`, `valve`: as of a `Plant`; without all three, the command of a step is
          pressures.
        - `exhaust_valve`, `spool`: as of a `Plant`.
        - `highest_pressure`: of a command [Pa]; left out, the bundles' largest supply pressure.
        - `shape`: nodes of the muscles' tables in pressure and strain.

        **Raises:** `InvalidInputError` for components that don't fit, a chamber whose gas warms,
        and a tendon that begins outside of its muscles' tables.
        """
        arguments = [value is not None for value in (supply, chamber, valve)]
        if any(arguments) and not all(arguments):
            name = ("supply", "chamber", "valve")[arguments.index(False)]
            remedy = "give supply, chamber and valve, or none of them"
            raise InvalidInputError(name, "is missing", None, remedy)
        if chamber is not None and not isinstance(chamber, AbstractMassChamber):
            rule = "must be one whose state is its mass"
            remedy = "take Isothermal, Polytropic or LiquidChamber"
            raise InvalidInputError("chamber", rule, chamber, remedy, shown=type(chamber).__name__)
        if not attached:
            raise InvalidInputError("attached", "must name at least one bundle", None, shown="none")
        if not all(arguments):
            if highest_pressure is None:
                supplies = [entry.bundle.supply_pressure for entry in attached]
                # the tables reach a fifth beyond the supply's pressure
                top = max(
                    (float(x) for x in supplies if x is not None), default=HIGHEST_PRESSURE / 1.2
                )
            else:
                name, limit = "highest_pressure", HIGHEST_PRESSURE
                top = float(check_interval(highest_pressure, 0.0, limit, name, "Pa"))
            supply, chamber, valve = ConstantSupply(top), Isothermal(), SonicValve(1e-9, 0.3)
        assert supply is not None
        assert chamber is not None
        assert valve is not None
        bundles = [entry.bundle for entry in attached]
        load = Tendons(bundles=len(bundles))
        plant = Plant(bundles, load, supply, chamber, valve, exhaust_valve, spool, shape=shape)
        drive = cls(
            plant,
            np.array([entry.rest_length for entry in attached]),
            np.array([np.array(plant.sides) == side for side in range(len(bundles))], float),
            tuple(_actuator_index(model, entry) for entry in attached),
            tuple(entry.tendon for entry in attached),
            all(arguments),
        )
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        drive._check(data.actuator_length[list(drive.actuators)])
        return drive

    @property
    def units(self) -> int:
        """Number of motor units of all bundles."""
        return self.plant.units

    def strains(self, lengths: Numbers) -> Numbers:
        """Strain of each unit's muscles [-] at `lengths` of the bundles' tendons [m]."""
        contraction = self.rest_lengths - lengths
        plant, sides = self.plant, np.array(self.plant.sides)
        return 1 - (plant.distances - contraction[..., sides]) / plant.lengths

    def pull(self, pressures: Numbers, lengths: Numbers) -> Numbers:
        """Pull of each bundle [N].

        **Arguments:**

        - `pressures`: of all units [Pa].
        - `lengths`: of the bundles' tendons [m].

        **Raises:** `InvalidInputError` for concrete numbers outside of the muscles' tables.
        """
        self._check_domain(pressures, lengths)
        return self._pull(pressures, lengths)

    def _pull(self, pressures: Numbers, lengths: Numbers) -> Numbers:
        """As `pull`, without checks."""
        force = self.plant.muscles.at(pressures, self.strains(lengths)).force
        return array_namespace(force).sum(self.members * (self.plant.counts * force), axis=-1)

    def energy(self, pressures: Numbers, lengths: Numbers) -> Batch:
        """Stored energy [J] of all bundles at constant pressures: the negative of their co-energy.

        **Arguments:** those of `pull`.

        **Raises:** as `pull`.
        """
        self._check_domain(pressures, lengths)
        coenergy = self.plant.muscles.at(pressures, self.strains(lengths)).coenergy
        return -array_namespace(coenergy).sum(self.plant.counts * coenergy, axis=-1)

    def start(self, model: Any, data: Any, pressures: Values = 0.0) -> Fluid:
        """Initial fluid [SI].

        **Arguments:**

        - `model`, `data`: MuJoCo's.
        - `pressures`: of all units, or of each [Pa].

        **Raises:** `InvalidInputError` for pressures above the muscles' tables.
        """
        mujoco.mj_forward(model, data)
        top = float(np.min(self.plant.muscles.highest_pressure))
        closed = (True, True)
        P = check_interval(pressures, 0.0, top, "pressures", "Pa", "of the table", closed) + 0.0
        P = np.broadcast_to(P, (self.units,)) + 0.0
        eps = self.strains(data.actuator_length[list(self.actuators)])
        V = self.plant.counts * self.plant.muscles.at(P, eps).volume
        spool = np.zeros(self.plant.spool.state_count(self.units))
        chambers = np.asarray(self.plant.chamber.start(P, V))
        supply = np.asarray(self.plant.supply.start(), float)
        return Fluid(chambers, P, spool, supply, np.array(True))

    def step(self, model: Any, data: Any, fluid: Fluid, command: Values, act: Any = None) -> Fluid:
        """Step MuJoCo's `data`; returns the fluid after the step [SI].

        **Arguments:**

        - `model`, `data`: MuJoCo's.
        - `fluid`: before the step [SI].
        - `command`: of the valves, from -1 to 1 [-]; without valves, all units' pressures [Pa].
        - `act`: `jax.jit(drive.act)`, for many steps; left out, NumPy's, without compilation.

        **Raises:** `InvalidInputError` if a tendon leaves its muscles' tables; data are then at the
        beginning of the step, with MuJoCo's RK4 at its end.
        """
        count, indices = self.plant.commands if self.valved else self.units, list(self.actuators)
        if self.valved:
            values = np.asarray(validate_commands(command), float)
        else:
            top, closed = float(np.min(self.plant.muscles.highest_pressure)), (True, True)
            checked = check_interval(command, 0.0, top, "command", "Pa", "of the table", closed)
            values = np.asarray(checked)
        if values.shape not in {(), (count,)}:
            raise InvalidInputError("command", f"must be one for each of the {count}", values.size)
        command = np.broadcast_to(values, (count,))
        if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
            return self._runge_kutta_step(model, data, fluid, command)
        mujoco.mj_step1(model, data)
        lengths = data.actuator_length[indices]
        after, pull = (act or self.act)(fluid, lengths, command, model.opt.timestep)
        self._check(lengths, after)
        data.ctrl[indices] = pull
        mujoco.mj_step2(model, data)
        return after

    def act(
        self, fluid: Fluid, lengths: Numbers, command: Numbers, dt: Batch
    ) -> tuple[Fluid, Numbers]:
        """One step of the bundles.

        **Arguments:**

        - `fluid`: before the step [SI].
        - `lengths`: of the bundles' tendons, of this step [m].
        - `command`: of the valves [-]; without valves, pressures [Pa].
        - `dt`: the step [s].

        **Returns:** the fluid after the step [SI], and each bundle's pull in the step [N].
        """
        plant, eps = self.plant, self.strains(lengths)
        xp = array_namespace(eps, fluid.chambers)
        low, high = plant.muscles.strains
        if not self.valved:
            P = command + 0.0 * eps
            inside = xp.all((eps >= low) & (eps <= high)) & fluid.inside
            return fluid._replace(pressures=P, inside=inside), self._pull(P, lengths)
        P = solve_pressures(plant, fluid.chambers, eps, fluid.pressures, _NEWTON)
        state = State(0.0, 0.0, fluid.spool, fluid.chambers, P, fluid.supply)
        flows = evaluate_flows(plant, state, P, command)
        rate = plant.chamber.rates(fluid.chambers, P, flows.mass, flows.enthalpy, 0.0)
        drawn, enthalpy = (xp.sum(x, axis=-1) for x in (flows.drawn, flows.drawn_enthalpy))
        inside = (eps >= low) & (eps <= high) & (plant.muscles.highest_pressure >= P)
        after = Fluid(
            fluid.chambers + dt * rate,
            P,
            fluid.spool + dt * plant.spool.rate(command, fluid.spool),
            fluid.supply + dt * plant.supply.rates(fluid.supply, -drawn, -enthalpy),
            xp.all(inside) & fluid.inside,
        )
        return after, self._pull(P, lengths)

    def step_mjx(self, model: Any, data: Any, fluid: Fluid, command: Numbers) -> tuple[Any, Fluid]:
        """One step of MJX, under `jit`, `vmap` and forward derivatives; nothing is checked, and
        `fluid.inside` is false after a step outside of the muscles' tables.

        **Arguments:**

        - `model`, `data`: MJX's.
        - `fluid`: before the step [SI].
        - `command`: of the valves, from -1 to 1 [-]; without valves, all units' pressures [Pa].

        **Returns:** data and fluid after the step [SI].
        """
        import jax

        engine, indices = mjx(), np.array(self.actuators)
        lengths = engine.fwd_position(model, data).actuator_length[indices]
        fluid, pull = self.act(fluid, lengths, command, model.opt.timestep)
        after = engine.step(model, data.replace(ctrl=data.ctrl.at[indices].set(pull)))
        # with 64 bits some whole numbers come back wider than before, which no loop accepts
        return jax.tree.map(lambda x, before: jnp.asarray(x, before.dtype), after, data), fluid

    def _check_domain(self, pressures: Numbers, lengths: Numbers) -> None:
        """Raise for numbers outside of the muscles' tables, which end there."""
        if not is_concrete(pressures, lengths):
            return
        self._check(lengths)
        top = float(np.min(self.plant.muscles.highest_pressure))
        low = float(np.min(self.plant.chamber.lowest_pressure))
        check_interval(pressures, low, top, "pressures", "Pa", "of the table", (True, True))

    def _check(self, lengths: Numbers, fluid: Fluid | None = None) -> None:
        """Refuse tendons' `lengths` [m] and a `fluid` outside of the muscles' tables."""
        low, high = (np.asarray(end) for end in self.plant.muscles.strains)
        strains = np.asarray(self.strains(np.asarray(lengths)))
        outside = np.argwhere(~((strains >= low) & (strains <= high)))
        if outside.size:
            i, eps = int(outside[0][-1]), float(strains[tuple(outside[0])])
            tendon = self.tendons[self.plant.sides[i]]
            raise InvalidInputError(
                "tendon",
                f"{tendon!r} leaves the table's strains, {low[i]:.3f} to {high[i]:.3f}",
                eps,
                "limit its range in the model, or take another `rest_length`",
                shown=f"a strain of {eps:.3f}",
            )
        if fluid is not None and not bool(fluid.inside):
            top = float(np.min(self.plant.muscles.highest_pressure))
            raise InvalidInputError(
                "pressure",
                f"must stay below the table's {top:g} Pa",
                float(np.max(fluid.pressures)),
                "a closed chamber is stretched too far",
                shown=f"{float(np.max(fluid.pressures)):g} Pa",
            )  # fmt: skip

    def _runge_kutta_step(self, model: Any, data: Any, fluid: Fluid, command: Numbers) -> Fluid:
        """A Runge-Kutta step, with pulls evaluated at each of its stages."""
        indices = {actuator: side for side, actuator in enumerate(self.actuators)}
        first = min(indices)  # MuJoCo calls in this order
        kind = model.actuator_gaintype.copy()
        before = mujoco.get_mjcb_act_gain()
        initial: list[Any] = []
        pulls: list[Any] = []

        def gain(mj_model: Any, mj_data: Any, actuator: int) -> float:
            """Negative pull of an actuator's bundle [N]; the first call evaluates all of them."""
            side = indices.get(actuator)
            if side is None:
                return 0.0 if before is None else before(mj_model, mj_data, actuator)
            if actuator == first:
                lengths = mj_data.actuator_length[list(self.actuators)].copy()
                after, pulls[:] = self.act(fluid, lengths, command, model.opt.timestep)
                initial.append((lengths, after))
            return -float(pulls[side])

        model.actuator_gaintype[list(self.actuators)] = mujoco.mjtGain.mjGAIN_USER
        data.ctrl[list(self.actuators)] = 1.0
        mujoco.set_mjcb_act_gain(gain)
        try:
            mujoco.mj_step(model, data)
        finally:
            mujoco.set_mjcb_act_gain(before)
            model.actuator_gaintype[:] = kind
        self._check(*initial[0])  # the first stage is the step's beginning
        return initial[0][1]


def _actuator_index(model: Any, attached: Attached) -> int:
    """Index of a bundle's actuator in the compiled model."""
    names = [model.actuator(i).name for i in range(model.nu)]
    if attached.actuator in names:
        return names.index(attached.actuator)
    # a sub-model may have been put under a prefix, or a suffix
    likely = [name for name in names if attached.actuator in name]
    suggestions = likely or difflib.get_close_matches(attached.actuator, names, n=1, cutoff=0.4)
    remedy = f"it has {', '.join(names) or 'none'}"
    if suggestions:
        remedy = f"write `attached._replace(actuator={suggestions[0]!r})`"
    rule = f"names the actuator {attached.actuator!r}, which isn't in the model"
    raise InvalidInputError("attached", rule, attached.actuator, remedy, shown="")
