r"""Linear model of a plant about a state.

$$\dot x = \dot x_0 + A\,(x - x_0) + B\,(u - u_0), \qquad y = y_0 + C\,(x - x_0) + D\,(u - u_0)$$

States are the load's position and velocity, the spools, the units' pressures, the mass in a chamber
whose temperature is free, and the supply's own. A pressure stands for the last number of its
chamber's state, mass or internal energy, which follows from it by (F12). A prescribed motion is
held, so that its load has no state.

**Valid near** the state: kinks of muscles, stops and Coulomb's friction have no slope. At a shut
valve the slope by its command is the mean of filling and venting. A dead time is left out.
"""

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.flatten_util import ravel_pytree

from ..core.errors import InvalidInputError
from ..core.types import Numbers, Values
from ..core.validation import check_choice, check_finite
from ..fluid import Solenoid, validate_commands
from .chamber_pressure import muscle_volumes
from .motion import State, evaluate_plant, relaxed_friction, time_derivative


if TYPE_CHECKING:
    from .plant import Plant


INPUTS = ("command", "force")
OUTPUTS = ("position", "velocity", "pressure", "strain", "force", "flow")


class LinearModel(NamedTuple):
    """Matrices of a linear model, with the names of their rows and columns.

    `A`, `B`, `C`, `D` [SI]; `states`, `inputs` and `outputs`: unit of each by name; `rate`:
    $\\dot x_0$ [SI], zero at rest; `delays`: dead time of each input [s], which no matrix has.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    states: dict[str, str]
    inputs: dict[str, str]
    outputs: dict[str, str]
    rate: np.ndarray
    delays: np.ndarray

    def frequency_response(self, frequency: Values) -> np.ndarray:
        """Response $(C (s I - A)^{-1} B + D) e^{-s \\tau}$ [SI], complex, with `delays` $\\tau$, at
        each `frequency` [Hz], which is the first axis; then outputs and inputs.
        """
        s = 2j * np.pi * np.atleast_1d(check_finite(frequency, "frequency", "Hz"))
        pencil = s[:, None, None] * np.eye(len(self.A)) - self.A
        response = self.C @ np.linalg.solve(pencil, self.B + 0j * s[:, None, None]) + self.D
        return response * np.exp(-s[:, None, None] * self.delays)

    def to_control(self) -> Any:
        """The model without `delays` as python-control's `StateSpace`; it must be installed."""
        control = import_module("control")  # no dependency: a type checker may not find it
        names = {key: list(getattr(self, key)) for key in ("states", "inputs", "outputs")}
        return control.ss(self.A, self.B, self.C, self.D, **names)


def linearize(
    plant: "Plant",
    state: State,
    inputs: Sequence[str] = ("command",),
    outputs: Sequence[str] = ("position", "pressure"),
    command: Values = 0.0,
) -> LinearModel:
    """Linear model of a `plant` about a `state` [SI], such as `equilibrium_state` gives.

    **Arguments:**

    - `plant`, `state`: the plant and its state.
    - `inputs`: of "command", of each motor unit [-], and "force", on the load in the sense of a
      rising position [N or N·m].
    - `outputs`: of "position" and "velocity" of the load, and of each motor unit "pressure",
      "strain", "force" of all its muscles and "flow", of mass into it.
    - `command`: at the state, one for each motor unit or one for all [-].

    **Returns:** a `LinearModel`. **Raises:** `ValueError` for other names, and invalid commands.
    """
    if isinstance(plant.spool, Solenoid):
        remedy = "linearize a plant with a Direct spool, which has the pulses' mean"
        raise InvalidInputError("spool", "must not pulse", plant.spool, remedy, shown="a Solenoid")
    for key, names, choices in (("inputs", inputs, INPUTS), ("outputs", outputs, OUTPUTS)):
        if isinstance(names, str) or not names:
            raise InvalidInputError(key, "must be a list of names", names)
        for name in names:
            check_choice(name, choices, key)
    if "force" in inputs and plant.load.prescribed:
        raise InvalidInputError("inputs", "can't be a force on a prescribed motion", "force")
    state = State(*(jnp.asarray(x, float) for x in state))
    motion = () if plant.load.prescribed else (state.position, state.velocity)
    start = motion, state.spool, state.pressures, state.chambers[:, :-1], state.supply
    commands = jnp.broadcast_to(validate_commands(command), (plant.units,))
    defaults = {"command": commands, "force": jnp.zeros(())}
    x_0, unpack = ravel_pytree(start)
    u_0, unpack_inputs = ravel_pytree([defaults[name] for name in inputs])

    def evaluate(x: Numbers, u: Numbers) -> tuple[tuple[Numbers, Numbers], Numbers]:
        chosen = dict(zip(inputs, unpack_inputs(u), strict=True))
        rates, values = _rates_and_outputs(plant, state, unpack(x), **{**defaults, **chosen})
        rate, y = (ravel_pytree(x)[0] for x in (rates, [values[name] for name in outputs]))
        return (rate, y), rate

    slopes, rate = jax.jit(jax.jacfwd(evaluate, argnums=(0, 1), has_aux=True))(x_0, u_0)
    (A, B), (C, D) = (map(np.asarray, pair) for pair in slopes)
    states = _state_units(plant)
    # a supply's sums of energy, and its switch, act on nothing
    acts = np.arange(len(states)) < len(states) - len(plant.supply.names)
    acts |= np.any(A != 0, axis=0) | np.any(C != 0, axis=0)
    names = {name: unit for (name, unit), i in zip(states.items(), acts, strict=True) if i}
    unit = plant.load.unit
    input_units = _units(plant, inputs, {"force": "N" if unit == "m" else "N·m"})
    output_units = _units(plant, outputs, {"position": unit, "velocity": f"{unit}/s"})
    matrices = A[np.ix_(acts, acts)], B[acts], C[:, acts], D
    dead_times = {"command": np.full(plant.units, plant.spool.dead_time), "force": np.zeros(1)}
    delays = np.concatenate([dead_times[name] for name in inputs])
    rates = np.asarray(rate)[acts]
    return LinearModel(*matrices, names, input_units, output_units, rates, delays)


def _rates_and_outputs(
    plant: "Plant", state: State, x: tuple, command: Numbers, force: Numbers
) -> tuple[tuple, dict[str, Numbers]]:
    """Rates of the states `x` [SI] near a `state` [SI], and all outputs by name."""
    (motion, spool, P, inner, supply), load = x, plant.load
    q, v = load.motion_at(0.0, *(motion or (state.position, state.velocity)))
    _, volumes = muscle_volumes(plant, plant.strains(q[..., None]), P)
    # the residual is affine in the last number of a chamber's state: one step solves for it
    chambers = jnp.concatenate([inner, state.chambers[:, -1:]], axis=-1)
    g = plant.chamber.state_residual(chambers, P, volumes.volume)
    chambers = chambers.at[:, -1].add(-g.value / g.by_state[:, -1])
    point = State(q, v, spool, chambers, P, supply)
    evaluation = evaluate_plant(plant, 0.0, point, command, relaxed_friction(plant, state))
    rate = time_derivative(plant, point, evaluation, command)
    pull, flow = plant.counts * evaluation.fluid.muscles.force, evaluation.flows.mass
    values = q, v, P, evaluation.strains, pull, flow
    outputs: dict[str, Numbers] = dict(zip(OUTPUTS, values, strict=True))
    motion_rate = (rate.position, rate.velocity + force / load.inertia) if motion else ()
    return (motion_rate, rate.spool, rate.pressures, rate.chambers[:, :-1], rate.supply), outputs


def _state_units(plant: "Plant") -> dict[str, str]:
    """Unit of each state by name, in order."""
    load, chamber, supply = plant.load, plant.chamber, plant.supply
    units = range(1, plant.units + 1)
    names = {} if load.prescribed else {"position": load.unit, "velocity": f"{load.unit}/s"}
    names |= {f"spool {i}": "-" for i in range(1, plant.spool.state_count(plant.units) + 1)}
    names |= {f"pressure {i}": "Pa" for i in units}
    inner = list(zip(chamber.names, chamber.units, strict=True))[:-1]
    names |= {f"{name} {i}": unit for i in units for name, unit in inner}
    return names | {f"supply {x}": unit for x, unit in zip(supply.names, supply.units, strict=True)}


def _units(plant: "Plant", names: Sequence[str], of_load: dict[str, str]) -> dict[str, str]:
    """Unit of each input or output by name: one `of_load`, or one of each motor unit."""
    per_unit = {"command": "-", "pressure": "Pa", "strain": "-", "force": "N", "flow": "kg/s"}
    units: dict[str, str] = {}
    for name in names:
        of_units = {f"{name} {i}": per_unit.get(name, "") for i in range(1, plant.units + 1)}
        units |= {name: of_load[name]} if name in of_load else of_units
    return units
