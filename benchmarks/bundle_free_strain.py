"""A bundle's free strain, each root counted in forces.

8 unlike units at 20 000 pressure vectors, by NumPy. One root's time is given
twice: in scattered forces of the whole bundle, (B1), each of which is 8 muscles' forces, and in
scattered forces of one muscle by `muscle.compile()`. The reach is held against the bundle's.

    python benchmarks/bundle_free_strain.py
"""

import equinox as eqx
import numpy as np
from cases import LARGEST_STRAIN, done, muscle, scattered, unit_pressures, unlike_bundle
from timing import Row, interleaved, run


UNITS = 8


def rows(small: bool = False) -> list[Row]:
    count, points = (8, 500) if small else (20_000, 1_000_000)
    bundle, pressures = unlike_bundle(UNITS), unit_pressures(count, UNITS)
    at_once = np.asarray(pressures)
    one_muscle, cloud = muscle().compile(), scattered(points)
    # as many muscles' forces as there are points
    vectors = pressures[: max(1, points // UNITS)]
    strains = cloud[1][: len(vectors)]
    bundle_force = eqx.filter_jit(lambda bundle, P, eps: bundle.force(P, eps))
    assert float(strains.max()) <= LARGEST_STRAIN
    times = interleaved(
        {
            "muscle": lambda: done(one_muscle(*cloud)),
            "bundle": lambda: done(bundle_force(bundle, vectors, strains)),
            "root": lambda: bundle.free_strain(at_once),
        },
        repeats=7,
        budget=40.0,
    )
    question = f"free strain of a bundle of {UNITS} unlike units at {count:,} pressure vectors"
    spent = f"{times.median('root') / count * 1e6:.3g} µs a root"
    force, whole = times.median("muscle") / points, times.median("bundle") / len(vectors)
    return [
        Row(
            question,
            times.ratio("root", "bundle", len(vectors) / count),
            "forces",
            f"one scattered force of the bundle, {whole * 1e9:.3g} ns",
            20.0,
            "≤",
            spent,
        ),
        Row(
            question,
            times.ratio("root", "muscle", points / count),
            "forces",
            f"one scattered force of one muscle, {force * 1e9:.3g} ns",
        ),
    ]


if __name__ == "__main__":
    run(rows, __doc__)
