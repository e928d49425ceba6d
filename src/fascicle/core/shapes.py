"""Shapes of arguments that go together, as NumPy broadcasts them."""

import itertools

import numpy as np

from .refused import Refused


def common(**shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The shape [-] to which arguments of these `shapes` broadcast, each by its name [-]."""
    if not any(shapes.values()):
        return ()  # single numbers, soon
    try:
        return np.broadcast_shapes(*shapes.values())
    except ValueError:
        one, other = next(
            pair for pair in itertools.combinations(shapes, 2) if _apart(shapes, pair)
        )
    raise Refused(
        other,
        f"must broadcast against `{one}`",
        None,
        "for each with each give one an axis more, x[:, None]",
        shown=f"the shapes {shapes[other]} and {shapes[one]}",
    )


def _apart(shapes: dict[str, tuple[int, ...]], names: tuple[str, str]) -> bool:
    sizes = zip(*(reversed(shapes[name]) for name in names), strict=False)
    return any(x != y and 1 not in (x, y) for x, y in sizes)
