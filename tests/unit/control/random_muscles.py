"""Hand-over of muscles that differ from the controller's model: dips of isometric demands.

Random truths: standard deviations of 10 % of Young's modulus, collapse moment and rubber, 5 % of
the wall, 2 % of the radius, 1° of the braid angle, 0.4 of the logarithm of the transition rate. The
controller knows the nominal muscles. Air, isothermal, valves of 1e-9 m³/(s Pa) a muscle, 1 kHz;
dips over the model's dip D, counted up to the demand that the truth can hold. Simulated: nothing
here was measured on a bench. `study(4, 0.2, 24, seed=2026)` has the numbers of the docs.
"""

from functools import cache
from typing import Any, NamedTuple

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
    rest, air [kg], and the air of one `filling` of its first unit [kg].
    """

    dip: np.ndarray
    least: np.ndarray
    air: np.ndarray
    filling: np.ndarray


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
    P = np.array([[0.0], [SUPPLY]])
    starts = [start_at(plant, demand[0], strain) for plant in plants]
    truth = [control.transition(plant.bundles[0], strain) for plant in plants]
    filling = [float(np.ptp(plant.chambers_at(P, strain * LENGTH)[:, 0, 0])) for plant in plants]
    least = [max(float(t.dip - t.largest_force) + demand[0], 0.0) / depth for t in truth]

    def dip_and_air(plant: dynamics.Plant, start: Any, controller: Any) -> tuple[float, float]:
        """Dip over D [-] and air [kg] of a run."""
        run = dynamics.simulate(plant, controller, demand, DT, start=start, substeps=2)
        y = np.sum(plant.lengths * plant.gains * np.asarray(run.outputs.forces)[1:], axis=-1)
        can = demand <= 0.995 * float(plant.bundles[0].force([SUPPLY, SUPPLY], strain))
        # while the demand rises, and while it falls
        dip = max(drawdown(y, demand, can), drawdown(-y, -demand, can))
        flow = np.maximum(run.outputs.drawn, 0.0).sum(-1)[:-1]
        return dip / depth, float(flow[can].sum()) * DT

    results = {}
    for policy in ("threshold", "hand_over"):
        controller = control.cascade(model, policy, delay=declared_delay)
        runs = [dip_and_air(*pair, controller) for pair in zip(plants, starts, strict=True)]
        dip, air = np.array(runs).T
        results[policy] = Result(dip, np.array(least), air, np.array(filling))
    return results
