"""A whole efficiency map: the eager call, from bundle to arrays.

`fs.energetics.efficiency_map` on 81 forces × 121 strains, isobaric, 6 motor units and so 6
recruitment states. The reach is for equal units, as in the paper's Fig. 10; beside it a bundle
of which no two units are alike.

    python benchmarks/efficiency_maps.py
"""

import numpy as np
from cases import LARGEST_PRESSURE, muscle, unlike_bundle
from timing import Row, interleaved, run

import fascicle as fs


def rows(small: bool = False) -> list[Row]:
    units, shape = (2, (5, 7)) if small else (6, (81, 121))
    equal = fs.Bundle([fs.MotorUnit(muscle())] * units, supply_pressure=LARGEST_PRESSURE)
    bundles = {"equal": equal}
    if not small:
        bundles["unlike"] = unlike_bundle(units)
    calls = {}
    for name, bundle in bundles.items():
        full = np.full(units, LARGEST_PRESSURE)
        force = np.linspace(0.0, float(bundle.force(full, 0.0)), shape[0])
        strain = np.linspace(0.0, 0.3, shape[1] + 1)[1:]
        calls[name] = lambda bundle=bundle, force=force, strain=strain: (
            fs.energetics.efficiency_map(bundle, force=force, strain=strain)
        )
    times = interleaved(calls)
    made = []
    for name in calls:
        question = f"efficiency map, {shape[0]} × {shape[1]} points, {units} {name} units, whole"
        reach = 50.0 if name == "equal" else None
        made.append(Row(question, times.each(name, 1e3), "ms", "", reach, "≤"))
    return made


if __name__ == "__main__":
    run(rows, __doc__)
