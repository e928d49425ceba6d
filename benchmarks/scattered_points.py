"""Points that each have a pressure of their own, against a field's.

In a field free and collapse strain are solved for once for each pressure. Here every one of
1e6 points needs its own: `muscle.compile()` either way, rates in points a second.

    python benchmarks/scattered_points.py
"""

from cases import done, field, muscle, scattered
from timing import Row, interleaved, run


def rows(small: bool = False) -> list[Row]:
    count, shape = (500, (20, 30)) if small else (1_000_000, (1000, 10_000))
    force, points, grid = muscle().compile(), scattered(count), field(*shape)
    times = interleaved(
        {
            "field": lambda: done(force(*grid)),
            "scattered": lambda: done(force(*points)),
        }
    )
    more = count / (shape[0] * shape[1])
    rate = count / times.median("scattered") / 1e6
    return [
        Row(
            f"{count:,} scattered (pressure, strain) points",
            times.ratio("field", "scattered", more),
            "×",
            "the field's rate",
            1 / 3,
            limit=f"{rate:.1f} million points/s; each solves for its free and collapse strain",
        )
    ]


if __name__ == "__main__":
    run(rows, __doc__)
