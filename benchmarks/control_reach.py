"""What each policy makes of the transition: dip against energy, on isometric ramps.

A ramp of force from 0.1 to 3 times what the first unit holds, in 4 s, air, isothermal, valves of a
conductance of 1e-9 m³/(s Pa) a muscle and a third of it, a controller at 1 kHz; and beforehand what
`crossing` says. Rows tell drawdown over the dip, and how much more air is taken than by
`threshold`, until no policy can follow any more. Nothing here was measured on a bench.

    python benchmarks/control_reach.py
"""

from typing import NamedTuple

import numpy as np
from timing import Measured, Row, run

import fascicle as fs
from fascicle import control, dynamics, fluid


SUPPLY, DT, STEPS = 413.7e3, 1e-3, 4000
POLICIES = ("threshold", "orderly", "fast_cross", "hand_over", "pre_charge")
CASES = ((1, 0.15, 1.0), (1, 0.2, 1.0), (4, 0.15, 1.0), (4, 0.2, 1.0), (4, 0.2, 1 / 3),
         (4, 0.24, 1.0))  # fmt: skip
REACH = 0.1  # of the dip, and no more air than this share, of 1 + 1 and of 1 + 4
AIR = {1: 5.0, 4: 12.0}  # %


class Ran(NamedTuple):
    """A policy's run: drawdown over the dip, root mean square [N], air [kg], and that it takes
    more of than `threshold` [%].
    """

    drawdown: float
    rms: float
    air: float
    more: float


def bench(count: int, strain: float, share: float) -> tuple[dynamics.Plant, np.ndarray, float]:
    """The plant, its demand [N], and the pressure of its first unit to begin with [Pa]."""
    muscle = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, count)], SUPPLY)
    first = float(control.transition(bundle, strain).largest_force)
    plant = dynamics.Plant(
        bundle, dynamics.PrescribedMotion(mean=strain * 0.127), fluid.ConstantSupply(SUPPLY),
        fluid.Isothermal(), fluid.SonicValve(1e-9 * share * np.array([1.0, count]), 0.3),
    )  # fmt: skip
    demand = np.linspace(0.1, 3.0, STEPS) * first
    empty = count * float(muscle.force(0.0, strain))
    begin = control.Branches.of(bundle).pressure(
        np.array([demand[0] - empty, 0.0]), np.full(2, strain)
    )
    return plant, demand, float(begin.pressure[0])


def ran(
    case: tuple[int, float, float], policies: tuple[str, ...]
) -> tuple[control.Crossing, dict[str, Ran]]:
    """What is said beforehand, and each policy's run, `threshold` first."""
    count, strain, _ = case
    plant, demand, pressure = bench(*case)
    bundle = plant.bundles[0]
    path = control.Path.of(DT * np.array([0, STEPS]), demand[[0, -1]], strain)
    said = control.crossing(bundle, path, plant)
    start = dynamics.equilibrium_state(plant, [pressure, 0.0])
    # as far as any policy can follow
    last = int(np.argmax(demand > 0.995 * float(bundle.force([SUPPLY, SUPPLY], strain)))) or STEPS
    found: dict[str, Ran] = {}
    least = 0.0
    for policy in policies:
        controller = control.cascade(plant, policy)
        done = dynamics.simulate(plant, controller, demand, start=start, substeps=2)
        worth = control.control_metrics(controller, done, demand)
        air = float(np.maximum(done.outputs.drawn[:last], 0.0).sum() * DT)
        least = least or air
        found[policy] = Ran(worth.drawdown / worth.dip, worth.rms, air, 100 * (air / least - 1))
        one = found[policy]
        print(
            f"1 + {count} at {strain:.2f}, {case[2]:.2f} C, {policy:10} {one.drawdown:6.3f} D"
            f"  rms {one.rms:6.3f} N  air {1e6 * air:7.1f} mg, {one.more:+5.1f} %",
            flush=True,
        )
    return said, found


def rows(small: bool = False) -> list[Row]:
    """Drawdown and air of `threshold` and `hand_over`; a single case where it is to be small."""
    made = []
    for case in CASES[:1] if small else CASES:
        said, found = ran(case, (POLICIES[0], "hand_over") if small else POLICIES)
        print(f"beforehand: {said}")
        count, strain, share = case
        name = f"ramp across 1 + {count} at a strain of {strain:g}, valves {share:.2g} C"
        for policy in ("threshold", "hand_over"):
            one = found[policy]
            held = policy == "hand_over" and said.exists
            about = f"beforehand: {said}" if policy == "hand_over" else ""
            dip = Row(
                f"{name}: `{policy}`, drawdown", Measured.of([one.drawdown]), "D",
                "the dip D of unit 2", REACH if held else None, "≤", about,
            )  # fmt: skip
            made.append(dip)
        air = Row(
            f"{name}: `hand_over`, air", Measured.of([found["hand_over"].more]), "%",
            "more than `threshold`", AIR[count] if said.exists else None, "≤",
        )  # fmt: skip
        made.append(air)
    return made


if __name__ == "__main__":
    run(rows, __doc__)
