"""What `hand_over` makes of muscles that differ from its model: dips on isometric ramps.

Random truths: standard deviations of 10 % of Young's modulus, collapse moment and rubber, 5 % of
the wall, 2 % of the radius, 1° of the braid angle, 0.4 of the logarithm of the transition rate. The
controller knows the nominal muscles. A ramp from 0.1 to 3 times what the first unit holds, air,
isothermal, valves of 1e-9 m³/(s Pa) a muscle, 1 kHz; dips over the model's dip D, counted up to
the demand that the truth can hold. Simulated: nothing here was measured on a bench.

    python benchmarks/hand_over_reach.py [truths]
"""

import sys
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

import fascicle as fs
from fascicle import control, dynamics, fluid


SUPPLY, DT, LENGTH = 413.7e3, 1e-3, 0.127
SHAPE = (81, 121)  # of the muscles' tables: a quarter of the memory, and as good for a dip
CASES = ((1, 0.15), (1, 0.2), (4, 0.15), (4, 0.2))
DELAYS = (
    ("nothing", None, 0.0),
    ("valves by 20 ms", 20e-3, 0.0),
    ("measurement by 20 ms", None, 20e-3),
)
NOMINAL = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)


class Result(NamedTuple):
    """Of each truth: dip over D [-], and air [kg]."""

    dip: np.ndarray
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


def make_plant(
    muscle: fs.Muscle, count: int, strain: float, lag: float | None = None
) -> dynamics.Plant:
    """1 + `count` muscles, held at a `strain` [-], with valves of a `lag` [s]."""
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, count)], SUPPLY)
    return dynamics.Plant(
        bundle, dynamics.PrescribedMotion(strain * LENGTH), fluid.ConstantSupply(SUPPLY),
        fluid.Isothermal(), fluid.SonicValve(1e-9 * np.array([1.0, count]), 0.3),
        spool=None if lag is None else fluid.Servovalve(lag), shape=SHAPE,
    )  # fmt: skip


def start_at(plant: dynamics.Plant, force: float, strain: float) -> dynamics.State:
    """The plant at rest, its first unit at the pressure that gives a `force` [N]."""
    tables: Any = plant.muscles
    branches = control.Branches.tabulated(tables, SUPPLY)
    count = float(plant.counts[1])
    empty = count * float(branches.force(np.zeros(2), np.full(2, strain))[1])
    pressure = branches.pressure(np.array([force - empty, 0.0]), np.full(2, strain)).pressure
    return dynamics.equilibrium_state(plant, [float(pressure[0]), 0.0])


def _stack(trees: list[Any]) -> tuple[list[Any], list[Any], Any]:
    """Leaves of `trees` with an axis of trees where they differ, the axes, and the structure."""
    columns = list(zip(*map(jax.tree.leaves, trees), strict=True))
    is_equal = [all(np.array_equal(x, column[0]) for x in column) for column in columns]
    leaves = [c[0] if s else np.stack(c) for c, s in zip(columns, is_equal, strict=True)]
    return leaves, [None if s else 0 for s in is_equal], jax.tree.structure(trees[0])


def run_ramp(
    plants: list[dynamics.Plant], controller: Any, demand: np.ndarray, strain: float
) -> tuple[np.ndarray, np.ndarray]:
    """Forces [N] and air drawn [kg/s] of all `plants`, in one batch."""
    leaves, axes, structure = _stack(plants)
    starts, start_axes, start_structure = _stack(
        [start_at(plant, demand[0], strain) for plant in plants]
    )

    def simulate(leaves: list[Any], start: list[Any]) -> tuple[jax.Array, jax.Array]:
        plant = jax.tree.unflatten(structure, leaves)
        start_state = jax.tree.unflatten(start_structure, start)
        run = dynamics.simulate(
            plant, controller, demand, dt=DT, start=start_state, substeps=2
        ).outputs
        force = jnp.sum(plant.lengths * plant.gains * run.forces, axis=-1)
        return force[1:], jnp.maximum(run.drawn, 0.0).sum(-1)[:-1]

    batch = jax.jit(jax.vmap(simulate, (axes, start_axes), axis_size=len(plants)))
    forces, drawn = batch(leaves, starts)
    return np.asarray(forces), np.asarray(drawn)


def study(
    count: int, strain: float, truths: int, lag: float | None = None, delay: float = 0.0,
    duration: float = 4.0, policies: tuple[str, ...] = ("threshold", "hand_over"), seed: int = 1,
) -> dict[str, Result]:  # fmt: skip
    """Dips and air of each policy for random `truths`."""
    generator = np.random.default_rng(seed)
    model = make_plant(NOMINAL, count, strain, lag)
    state = control.transition(model.bundles[0], strain)
    demand = np.linspace(0.1, 3.0, round(duration / DT)) * float(state.largest_force)
    plants = [make_plant(draw_muscle(generator), count, strain, lag) for _ in range(truths)]
    results = {}
    for policy in policies:
        controller = control.cascade(model, policy, delay=delay)
        forces, drawn = run_ramp(plants, controller, demand, strain)
        rows = []
        for plant, force, flow in zip(plants, forces, drawn, strict=True):
            most = 0.995 * float(plant.bundles[0].force([SUPPLY, SUPPLY], strain))
            is_reachable = demand <= most
            dip = control.metrics.drawdown(force, demand, is_reachable) / float(state.dip)
            rows.append((dip, float(flow[is_reachable].sum()) * DT))
        results[policy] = Result(*np.array(rows).T)
    return results


def main(truths: int) -> None:
    """Print the table of the docs."""
    print("| | strain | late | dip: median | 90 % | worst | `threshold`: median | more air |")
    print("|---|---|---|---|---|---|---|---|")
    for label, lag, delay in DELAYS:
        for count, strain in CASES:
            result = study(count, strain, truths, lag, delay)
            reference, hand_over = result["threshold"], result["hand_over"]
            dips = " | ".join(f"{x:.2f}" for x in np.quantile(hand_over.dip, (0.5, 0.9, 1.0)))
            more_air = 100 * np.median(hand_over.air / reference.air - 1)
            print(
                f"| 1 + {count} | {strain:.2f} | {label} | {dips} |"
                f" {np.median(reference.dip):.2f} | {more_air:+.1f} % |", flush=True,
            )  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
