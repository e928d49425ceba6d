"""What each policy makes of the transition: dip against energy, on isometric ramps.

A ramp of force from 0.1 to 3 times what the first unit holds, in 4 s, air, isothermal, valves of a
conductance of 1e-9 m³/(s Pa) a muscle and a third of it, a controller at 1 kHz; and beforehand what
`crossing` says. Nothing here was measured on a bench.
"""

import numpy as np

import fascicle as fs
from fascicle import control, dynamics, fluid


SUPPLY, DT = 413.7e3, 1e-3
POLICIES = ("threshold", "orderly", "fast_cross", "hand_over", "pre_charge")
CASES = ((1, 0.15, 1.0), (1, 0.2, 1.0), (4, 0.15, 1.0), (4, 0.2, 1.0), (4, 0.2, 1 / 3),
         (4, 0.24, 1.0))  # fmt: skip


def bench(count: int, strain: float, share: float) -> tuple[dynamics.Plant, np.ndarray, float]:
    """The plant, its demand [N], and the pressure of its first unit to begin with [Pa]."""
    muscle = fs.example("kim2021_figure_6").replace(material=fs.materials.SILICONE_KIM2021)
    bundle = fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, count)], SUPPLY)
    first = float(control.transition(bundle, strain).largest_force)
    plant = dynamics.Plant(
        bundle, dynamics.PrescribedMotion(mean=strain * 0.127), fluid.ConstantSupply(SUPPLY),
        fluid.Isothermal(), fluid.SonicValve(1e-9 * share * np.array([1.0, count]), 0.3),
    )  # fmt: skip
    demand = np.linspace(0.1, 3.0, 4000) * first
    empty = count * float(muscle.force(0.0, strain))
    begin = control.Branches.of(bundle).pressure(
        np.array([demand[0] - empty, 0.0]), np.full(2, strain)
    )
    return plant, demand, float(begin.pressure[0])


def main() -> None:
    """Print a table."""
    print("1 + n  strain  C/C0  policy       dip/D   rms N  fluid mg  more  unreachable")
    for count, strain, share in CASES:
        plant, demand, pressure = bench(count, strain, share)
        bundle = plant.bundles[0]
        path = control.Path.of(DT * np.array([0, 4000]), demand[[0, -1]], strain)
        print(f"beforehand: {control.crossing(bundle, path, plant)}")
        start, least = dynamics.rest(plant, [pressure, 0.0]), None
        # as far as any policy can follow
        most = float(bundle.force([SUPPLY, SUPPLY], strain))
        for policy in POLICIES:
            controller = control.cascade(plant, policy)
            run = dynamics.simulate(plant, controller, demand, start=start, substeps=2)
            worth = control.worth(controller, run, demand)
            last = int(np.argmax(demand > 0.995 * most)) or len(demand)
            taken = np.maximum(run.seen.drawn[:last], 0.0).sum() * DT
            least = taken if least is None else least
            case = f"1 + {count}  {strain:5.2f}  {share:5.2f}  {policy:10}"
            more = 100 * (taken / least - 1)
            print(
                f"{case}  {worth.drawdown / worth.dip:6.3f}  {worth.rms:6.3f}  {1e6 * taken:8.1f}"
                f"  {more:4.1f}%  {worth.unreachable}",
                flush=True,
            )


if __name__ == "__main__":
    main()
