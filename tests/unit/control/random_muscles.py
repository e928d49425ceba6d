"""Hand-over of muscles that differ from the controller's model: dips of isometric demands.

Random truths: standard deviations of 10 % of Young's modulus, collapse moment and rubber, 5 % of
the wall, 2 % of the radius, 1° of the braid angle, 0.4 of the logarithm of the transition rate. The
controller knows the nominal muscles. Air, isothermal, valves of 1e-9 m³/(s Pa) a muscle, 1 kHz;
dips over the model's dip D, counted up to the demand that the truth can hold. Simulated: nothing
here was measured on a bench. `study(4, 0.2, 24, seed=2026)` has the numbers of the docs.
"""

from functools import cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.control.metrics import drawdown
from fascicle.core.module import with_fields


SUPPLY, DT, LENGTH = 413.7e3, 1e-3, 0.127
SHAPE = (81, 121)  # of the muscles' tables: a quarter of the memory, and as good for a dip
NOMINAL = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)


class Result(NamedTuple):
    """Of each truth: dip over D [-], the `least` that any controller could have from there, at
    rest, and air [kg].
    """

    dip: np.ndarray
    least: np.ndarray
    air: np.ndarray


def draw_muscle(generator: np.random.Generator) -> fs.Muscle:
    """Muscle with random differences from the model."""
    modulus, moment, rubber, wall, radius, braid, rate = generator.standard_normal(7)
    material = NOMINAL.material
    return NOMINAL.replace(
        material=type(material)(
            c10=float(material.c10) * (1 + 0.1 * rubber),
            c01=float(material.c01) * (1 + 0.1 * rubber),
            youngs_modulus=float(material.youngs_modulus) * (1 + 0.1 * modulus),
        ),
        wall_thickness=float(NOMINAL.wall_thickness) * (1 + 0.05 * wall),
        outer_radius=float(NOMINAL.outer_radius) * (1 + 0.02 * radius),
        braid_angle=float(NOMINAL.braid_angle) + np.radians(braid),
        transition_rate=float(NOMINAL.transition_rate) * np.exp(0.4 * rate),
        tuning=fs.Tuning(collapse_moment_factor=1 + 0.1 * moment),
    )


@cache
def draw_muscles(truths: int, seed: int) -> list[fs.Muscle]:
    """Muscles of random truths."""
    generator = np.random.default_rng(seed)
    return [draw_muscle(generator) for _ in range(truths)]


@cache
def _tabulate_plant(muscle: fs.Muscle) -> dynamics.Plant:
    """Plant of 1 + 1, whose tables all others of this muscle share."""
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle)], SUPPLY)
    return dynamics.Plant(
        bundle, dynamics.PrescribedMotion(0.0), fluid.ConstantSupply(SUPPLY), fluid.Isothermal(),
        fluid.SonicValve(1e-9 * np.ones(2), 0.3), shape=SHAPE,
    )  # fmt: skip


@cache
def _tabulate_branches(muscle: fs.Muscle) -> control.Branches:
    """Branches of two units of a `muscle`."""
    tables: Any = _tabulate_plant(muscle).muscles
    return control.Branches.tabulated(tables, SUPPLY)


def make_plant(
    muscle: fs.Muscle, count: int, strain: float, lag: float | None = None
) -> dynamics.Plant:
    """1 + `count` muscles, held at a `strain` [-], with valves of a `lag` [s]."""
    counts = np.array([1.0, count])
    valve = fluid.SonicValve(1e-9 * counts, 0.3)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, count)], SUPPLY)
    return with_fields(
        _tabulate_plant(muscle), bundles=(bundle,), load=dynamics.PrescribedMotion(strain * LENGTH),
        valve=valve, exhaust_valve=valve, counts=counts,
        spool=fluid.Direct() if lag is None else fluid.Servovalve(lag),
    )  # fmt: skip


def start_at(plant: dynamics.Plant, force: float, strain: float) -> dynamics.State:
    """The plant at rest, its first unit at the pressure that gives a `force` [N]."""
    branches = _tabulate_branches(plant.bundles[0].motor_units[0].muscle)
    count = float(plant.counts[1])
    empty = count * float(branches.force(np.zeros(2), np.full(2, strain))[1])
    pressure = branches.pressure(np.array([force - empty, 0.0]), np.full(2, strain))
    return dynamics.equilibrium_state(plant, [float(pressure[0]), 0.0])


def _stack(trees: list[Any]) -> tuple[list[Any], list[Any], Any]:
    """Leaves of `trees` with an axis of trees where they differ, the axes, and the structure."""
    columns = list(zip(*map(jax.tree.leaves, trees), strict=True))
    is_equal = [all(np.array_equal(x, column[0]) for x in column) for column in columns]
    leaves = [c[0] if s else np.stack(c) for c, s in zip(columns, is_equal, strict=True)]
    return leaves, [None if s else 0 for s in is_equal], jax.tree.structure(trees[0])


class Fleet:
    """Plants that are simulated in one batch, each with its own controller."""

    def __init__(self, plants: list[dynamics.Plant], force: float, strain: float):
        """All at rest at a `strain` [-] and the first unit's share of a `force` [N]."""
        self.plants = _stack(plants)
        self.starts = _stack([start_at(plant, force, strain) for plant in plants])
        self.size = len(plants)

    def run(self, controllers: list[Any], demand: np.ndarray) -> tuple[np.ndarray, ...]:
        """Forces [N] and pressures [Pa] at each moment, and air drawn in each step [kg/s]."""
        leaves, axes, kinds = zip(self.plants, self.starts, _stack(controllers), strict=True)
        results = _program(kinds, tuple(map(tuple, axes)), self.size)(*leaves, demand)
        return tuple(map(np.asarray, results))


@cache
def _program(kinds: tuple[Any, ...], axes: tuple[Any, ...], size: int) -> Any:
    """Simulation of a fleet of a `size`, compiled once for all fleets alike: structures and axes of
    its plants, starts and controllers.
    """

    def simulate(*parts: Any) -> tuple[jax.Array, jax.Array, jax.Array]:
        *trees, demand = parts
        plant, start, controller = map(jax.tree.unflatten, kinds, trees)
        run = dynamics.simulate(plant, controller, demand, DT, start=start, substeps=2)
        force = jnp.sum(plant.lengths * plant.gains * run.outputs.forces, axis=-1)
        air = jnp.maximum(run.outputs.drawn, 0.0).sum(-1)[:-1]
        return force, run.outputs.pressures, air

    in_axes = (*map(list, axes), None)
    return jax.jit(jax.vmap(simulate, in_axes, axis_size=size))


def make_demand(shape: str, duration: float, first: float) -> np.ndarray:
    """Demand [N] at each step; `first`: what the first unit holds [N]. "ramp", "down": and back in
    the same time, or "sine", two periods of a `duration` [s] each.
    """
    steps = round(duration / DT)
    up = np.linspace(0.1, 3.0, steps) * first
    if shape == "sine":
        phase = np.arange(2 * steps) * DT / duration
        return (0.9 - 0.8 * np.cos(2 * np.pi * phase)) * first
    return np.r_[up, up[::-1]] if shape == "down" else up


def study(
    count: int, strain: float, truths: int, lag: float | None = None,
    duration: float = 4.0, shape: str = "ramp", seed: int = 1,
    declared: tuple[float | None, float] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Results of `threshold` and `hand_over`, for random `truths`.

    `declared`: lag and delay [s] that the controller is told; left out, the true `lag`.
    """
    plants = [make_plant(m, count, strain, lag) for m in draw_muscles(truths, seed)]
    declared_lag, declared_delay = (lag, 0.0) if declared is None else declared
    model = make_plant(NOMINAL, count, strain, declared_lag)
    state = control.transition(model.bundles[0], strain)
    first, depth = float(state.largest_force), float(state.dip)
    demand = make_demand(shape, duration, first)
    fleet = Fleet(plants, demand[0], strain)
    truth = [control.transition(plant.bundles[0], strain) for plant in plants]
    least = [max(float(t.dip - t.largest_force) + demand[0], 0.0) / depth for t in truth]

    def result(force: np.ndarray, air: np.ndarray) -> Result:
        rows = []
        for plant, y, flow in zip(plants, force[:, 1:], air, strict=True):
            can = demand <= 0.995 * float(plant.bundles[0].force([SUPPLY, SUPPLY], strain))
            fall = drawdown(y, demand, can)
            rise = drawdown(-y, -demand, can)  # while the demand falls
            rows.append((max(fall, rise) / depth, float(flow[can].sum()) * DT))
        dip, drawn = np.array(rows).T
        return Result(dip, np.array(least), drawn)

    results = {}
    for policy in ("threshold", "hand_over"):
        controllers = [control.cascade(model, policy, delay=declared_delay)] * truths
        force, _, air = fleet.run(controllers, demand)
        results[policy] = result(force, air)
    return results
