"""The library with NumPy, compared with `scipy_script.py`, which a good student would write.

A force field of 200 pressures × 10,000 strains by both, and under JAX. Free strain of a bundle of 8
unlike units: time of one root, by the script at ten pressure vectors, by the library at 10,000 that
begin with the same. Both must agree within 1e-9 N: in the field, and where the script says that
the bundle's force is zero.

    python benchmarks/against_scipy.py
"""

import jax
import jax.numpy as jnp
import numpy as np
from cases import field, make_muscle, unit_pressures, unlike_bundle, wait
from scipy_script import Tube, bundle_free_strain, force_field
from timing import Row, run, take_turns


TOLERANCE = 1e-9  # N: roots of both end at the last digits of a strain, and slopes are some 1e4 N


def field_rows(small: bool) -> list[Row]:
    """Force fields."""
    shape = (4, 50) if small else (200, 10_000)
    muscle, (pressure, strain) = make_muscle(), field(*shape)
    tube, compiled = Tube.of(muscle), jax.jit(muscle.force)
    P, eps = jnp.asarray(pressure), jnp.asarray(strain)
    script = force_field(tube, pressure[:, 0], strain)
    difference = np.max(np.abs(script - muscle.force(pressure, strain)))
    assert difference < TOLERANCE, f"the script's forces differ by {difference:.1e} N"
    times = take_turns(
        {
            "script": lambda: force_field(tube, pressure[:, 0], strain),
            "numpy": lambda: muscle.force(pressure, strain),
            "jax": lambda: wait(compiled(P, eps)),
        }
    )
    name = f"field, {shape[0]:,} pressures × {shape[1]:,} strains"
    floor = f"the SciPy script, {times.median('script'):.2g} s"
    rate = f"{shape[0] * shape[1] / times.median('numpy') / 1e6:.3g} million points/s"
    by_numpy, by_jax = (times.ratio("script", way) for way in ("numpy", "jax"))
    return [
        Row(f"NumPy: {name}", by_numpy, "×", floor, at_least=1, note=rate),
        Row(f"JAX: {name}", by_jax, "×", floor, at_least=10,
            note=f"forces {difference:.0e} N apart"),
    ]  # fmt: skip


def bundle_row(small: bool) -> Row:
    """Free strain of a bundle."""
    units, few, many = (3, 2, 4) if small else (8, 10, 10_000)
    bundle, pressures = unlike_bundle(units), unit_pressures(many, units)
    tubes = [Tube.of(unit.muscle) for unit in bundle.motor_units]
    roots = np.array([bundle_free_strain(tubes, P) for P in pressures[:few]])
    force = np.max(np.abs(bundle.force(pressures[:few], roots)))
    assert force < TOLERANCE, f"at the script's free strain the bundle pulls with {force:.1e} N"
    times = take_turns(
        {
            "script": lambda: [bundle_free_strain(tubes, P) for P in pressures[:few]],
            "fascicle": lambda: bundle.free_strain(pressures),
        },
        rounds=3 if small else 7,
    )
    ratio = times.ratio("script", "fascicle", many / few)
    floor = f"the SciPy script, {times.median('script') / few * 1e3:.2g} ms a root"
    name = f"NumPy: free strain of a bundle of {units} unlike units"
    return Row(name, ratio, "×", floor, at_least=100)


def rows(small: bool = False) -> list[Row]:
    """Fields and free strains."""
    return [*field_rows(small), bundle_row(small)]


if __name__ == "__main__":
    run(rows, __doc__)
