"""The library against `scipy_script.py`, which a good student would write.

The force field: the same 200 pressures × 10 000 strains by both. A bundle's free strain, 8
unlike units: time of one root, the script's at a few pressure vectors, the library's at 10 000
that begin with the same few, by NumPy as both are. Both must agree: forces to 1e-9 N, and where the
script says that the bundle's force is zero, the library's is zero to 1e-9 N.

    python benchmarks/against_scipy.py
"""

import time
from typing import Any

import jax.numpy as jnp
import numpy as np
from cases import done, field, muscle, stream, unit_pressures, unlike_bundle
from scipy_script import Tube, bundle_free_strain, force_field
from timing import Call, Measured, Row, interleaved, run

import fascicle as fs


UNITS = 8
CLOSE = 1e-9  # N


def tube(muscle: fs.Muscle) -> Tube:
    rubber: Any = muscle.material
    sizes = (muscle.length, muscle.outer_radius, muscle.wall_thickness, muscle.braid_angle)
    constants = (rubber.c10, rubber.c01, rubber.youngs_modulus, rubber.poisson_ratio)
    return Tube(*(float(x) for x in (*sizes, *constants, muscle.transition_rate)))


def field_rows(small: bool) -> list[Row]:
    shape = (4, 50) if small else (200, 10_000)
    one, (pressure, strain) = muscle(), field(*shape)
    force, plain = one.compile(), tube(one)
    P, eps = np.asarray(pressure)[:, 0], np.asarray(strain)
    apart = np.max(np.abs(force_field(plain, P, eps) - np.asarray(force(pressure, strain))))
    assert apart < CLOSE, f"the script's forces differ by {apart:.1e} N"
    numbers = jnp.zeros(shape)
    times = interleaved(
        {
            "script": lambda: force_field(plain, P, eps),
            "fascicle": lambda: done(force(pressure, strain)),
            "streaming": lambda: done(stream(numbers)),
        }
    )
    name = f"force field, {shape[0]:,} pressures × {shape[1]:,} strains"
    floor = f"the SciPy script, {times.median('script'):.2g} s"
    once = [after(lambda: force_field(plain, P, eps), lambda: done(force(pressure, strain)))
            for _ in range(3 if small else 15)]  # fmt: skip
    return [
        Row(
            name,
            times.ratio("script", "fascicle"),
            "×",
            f"{floor}; forces {apart:.0e} N apart",
            50.0,
            limit=f"x + 1 alone: {times.median('script') / times.median('streaming'):.2g} ×",
        ),
        Row(
            f"{name}, a single one after a call that had one thread",
            Measured.of(times.median("script") / seconds for seconds in once),
            "×",
            floor,
        ),
    ]


def after(before: Call, call: Call) -> float:
    """Seconds that a `call` takes right after another."""
    before()
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def bundle_row(small: bool) -> Row:
    units, few, many = (3, 2, 4) if small else (UNITS, 10, 10_000)
    bundle, pressures = unlike_bundle(units), unit_pressures(many, units)
    plain = [tube(unit.muscle) for unit in bundle.motor_units]
    pressures = np.asarray(pressures)
    first = pressures[:few]
    found = np.array([bundle_free_strain(plain, P) for P in first])
    left = np.max(np.abs(np.asarray(bundle.force(jnp.asarray(first), jnp.asarray(found)))))
    assert left < CLOSE, f"at the script's free strain the bundle pulls with {left:.1e} N"
    apart = np.max(np.abs(found - bundle.free_strain(pressures)[:few]))
    assert apart < CLOSE, f"the script's free strains differ by {apart:.1e}"
    times = interleaved(
        {
            "script": lambda: [bundle_free_strain(plain, P) for P in first],
            "fascicle": lambda: bundle.free_strain(pressures),
        }
    )
    return Row(
        f"free strain of a bundle of {units} unlike units",
        times.ratio("script", "fascicle", many / few),
        "×",
        f"the SciPy script, {times.median('script') / few * 1e3:.2g} ms a root",
        100.0,
    )


def rows(small: bool = False) -> list[Row]:
    return [*field_rows(small), bundle_row(small)]


if __name__ == "__main__":
    run(rows, __doc__)
