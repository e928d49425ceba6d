"""Many different muscles at once, against as many points of one.

10 000 muscles that differ in all four sizes, 100 scattered points each, in one compiled call
that takes them as an argument; beside it 1e6 points of one muscle, by `muscle.compile()`,
which knows its muscle beforehand, and by the same call as the many.

    python benchmarks/many_muscles.py
"""

import equinox as eqx
from cases import done, muscle, scattered, unlike_muscles
from timing import Row, interleaved, run


def rows(small: bool = False) -> list[Row]:
    count, each = (10, 20) if small else (10_000, 100)
    points, many, one = scattered(count, each), unlike_muscles(count), muscle()
    force, known = eqx.filter_jit(lambda muscle, P, eps: muscle.force(P, eps)), one.compile()
    times = interleaved(
        {
            "many": lambda: done(force(many, *points)),
            "one": lambda: done(force(one, *points)),
            "compiled": lambda: done(known(*points)),
        }
    )
    question = f"{count:,} different muscles × {each} points each"
    beside = f"rate of one muscle × {count * each:,}"
    return [
        Row(question, times.ratio("compiled", "many"), "×", f"{beside}, `muscle.compile()`", 0.5),
        Row(question, times.ratio("one", "many"), "×", f"{beside}, the same function"),
    ]


if __name__ == "__main__":
    run(rows, __doc__)
