"""Policies on isometric ramps across the change of state: dip and air.

The demand rises from 0.1 to 3 times what the first unit holds, in 4 s. Air, isothermal, valves of a
conductance of 1e-9 m³/(s Pa) a muscle and of a third of it, a controller at 1 kHz. Rows have the
drawdown over the dip D, and the air beyond that of `threshold`, until no policy can follow any
more. Simulated, not measured on a bench.

    python benchmarks/control_policies.py
"""

from typing import NamedTuple

import numpy as np
from timing import Quartiles, Row, run

import fascicle as fs
from fascicle import control, dynamics, fluid


SUPPLY, DT, STEPS = 413.7e3, 1e-3, 4000
POLICIES = ("threshold", "orderly", "hand_over")
# muscles of the second unit, strain [-], conductance over 1e-9 m³/(s Pa) a muscle
CASES = ((1, 0.15, 1.0), (1, 0.2, 1.0), (4, 0.15, 1.0), (4, 0.2, 1.0), (4, 0.2, 1 / 3),
         (4, 0.24, 1.0))  # fmt: skip
MAX_DIP, MAX_AIR = 0.1, {1: 5.0, 4: 12.0}  # goals: of D, and % by muscles of the second unit


class Result(NamedTuple):
    """Drawdown over the dip [-], and air beyond that of `threshold` [%]."""

    drawdown: float
    air: float


def make_plant(count: int, strain: float, conductance: float) -> dynamics.Plant:
    """1 + `count` muscles, held at a strain."""
    muscle = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, count)], SUPPLY)
    return dynamics.Plant(
        bundle, dynamics.PrescribedMotion(mean=strain * 0.127), fluid.ConstantSupply(SUPPLY),
        fluid.Isothermal(), fluid.SonicValve(1e-9 * conductance * np.array([1.0, count]), 0.3),
    )  # fmt: skip


def simulate_ramp(
    case: tuple[int, float, float], policies: tuple[str, ...]
) -> tuple[control.Crossing, dict[str, Result]]:
    """The predicted crossing, and the result of each policy, of which the first is `threshold`."""
    count, strain, _ = case
    plant = make_plant(*case)
    bundle, muscle = plant.bundles[0], plant.bundles[0].motor_units[0].muscle
    demand = np.linspace(0.1, 3.0, STEPS) * float(control.transition(bundle, strain).largest_force)
    path = control.Path.of(DT * np.array([0, STEPS]), demand[[0, -1]], strain)
    vented = count * float(muscle.force(0.0, strain))
    begin = control.Branches.of(bundle).pressure(
        np.array([demand[0] - vented, 0.0]), np.full(2, strain)
    )
    start = dynamics.equilibrium_state(plant, [float(begin.pressure[0]), 0.0])
    # as far as any policy can follow
    last = int(np.argmax(demand > 0.995 * float(bundle.force([SUPPLY, SUPPLY], strain)))) or STEPS
    results: dict[str, Result] = {}
    threshold_air = 0.0
    for policy in policies:
        controller = control.cascade(plant, policy)
        outcome = dynamics.simulate(plant, controller, demand, start=start, substeps=2)
        metrics = control.control_metrics(controller, outcome, demand)
        air = float(np.maximum(outcome.outputs.drawn[:last], 0.0).sum() * DT)
        threshold_air = threshold_air or air
        result = Result(metrics.drawdown / metrics.dip, 100 * (air / threshold_air - 1))
        results[policy] = result
        print(f"1 + {count} at {strain:.2f}, {case[2]:.2f} C, {policy:10} {result.drawdown:6.3f} D"
              f"  rms {metrics.rms:6.3f} N  air {1e6 * air:7.1f} mg, {result.air:+5.1f} %",
              flush=True)  # fmt: skip
    return control.crossing(bundle, path, plant), results


def rows(small: bool = False) -> list[Row]:
    """Drawdown and air of `threshold` and `hand_over`; goals where a crossing is predicted."""
    measured = []
    for case in CASES[:1] if small else CASES:
        crossing, results = simulate_ramp(case, ("threshold", "hand_over") if small else POLICIES)
        count, strain, conductance = case
        name = f"ramp across 1 + {count} at a strain of {strain:g}, valves of {conductance:.2g} C"
        plain, hand_over = (results[policy] for policy in ("threshold", "hand_over"))
        goals = (MAX_DIP, MAX_AIR[count]) if crossing.exists else (None, None)
        floor, predicted = "the dip D of unit 2", f"predicted: {crossing}"
        measured += [
            Row(f"{name}: `threshold`, drawdown", Quartiles.of([plain.drawdown]), "D", floor),
            Row(f"{name}: `hand_over`, drawdown", Quartiles.of([hand_over.drawdown]), "D", floor,
                at_most=goals[0], note=predicted),
            Row(f"{name}: `hand_over`, air", Quartiles.of([hand_over.air]), "%",
                "beyond `threshold`", at_most=goals[1]),
        ]  # fmt: skip
    return measured


if __name__ == "__main__":
    run(rows, __doc__)
