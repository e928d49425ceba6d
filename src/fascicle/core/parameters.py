"""Constants of laws, each declared once, beside its law's equation.

Constructors check it, files read and write it, fits move it, the explorer has a field for it and
the docs a row in a table, all from one declaration:

    force_factor: Batch = Constant(
        "force_factor", "f_F", "number", (1e-4, 0.1, 10.0, 1e4), POSITIVE, 1.0,
        "factor on the force: measured over ideal blocked force", "Meller et al. (2014)",
    ).field()

A `Switch` declares an option that is chosen by name.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import attrs

from ..units import DIMENSIONS
from .array_namespace import exp, expm1, log, log1p, where
from .module import record, static
from .types import Batch, Values
from .validation import Range, check_choice, check_size


class Transform(NamedTuple):
    """Scale of a constant in a fit: the `coordinate` of a value, and the `value` of a coordinate;
    `even`: true where its interval is even about the value, not in the coordinate.
    """

    coordinate: Callable[[Batch], Batch]
    value: Callable[[Batch], Batch]
    even: bool = False


POSITIVE = Transform(log, exp)  # of a positive constant: a fit moves it by factors


def symmetric_scale(scale: float) -> Transform:
    """Linear scale in fits of a constant of either sign; `scale` [SI]: a large step."""
    return Transform(lambda value: value / scale, lambda z: z * scale, even=True)


def log1p_scale(scale: float) -> Transform:
    """Scale in fits of a constant from zero on: even below `scale` [SI], logarithmic above."""
    return Transform(
        lambda value: log1p(value / scale), lambda z: where(z >= 0, scale * expm1(z), 0.0)
    )


_MARGIN = 0.1  # the logistic curve passes 0 and 1 by this much, so that a fit can begin at either


def _fraction(z: Batch) -> Batch:
    """Value [-] at a coordinate `z`, from 0 to 1 and constant beyond both."""
    value = _MARGIN * (1 + _MARGIN) * expm1(z) / (1 + _MARGIN * (1 + exp(z)))
    return where(z >= 0, where(value < 1, value, 1.0), 0.0)


# of a constant from 0 to 1, both of which it can be
SHARE = Transform(
    lambda x: log((1 + _MARGIN) * (_MARGIN + x) / (_MARGIN * (1 + _MARGIN - x))), _fraction
)


@dataclass(frozen=True)
class Constant:
    """Declaration of a law's constant: `name` of the argument and of the key in files, `symbol` in
    TeX, `dimension` of `units.DIMENSIONS`, what it is `about` and its `source`.

    - `bounds`: the least possible, the low and high ends of the usual, the largest possible [SI];
      a constant whose least one is positive must be positive.
    - `transform`: scale in fits; `None` for a constant that no fit moves.
    - `default`: value of a constant that is left out [SI]; `None` for a required one.
    """

    name: str
    symbol: str
    dimension: str
    bounds: tuple[float, float, float, float]
    transform: Transform | None = None
    default: float | None = None
    about: str = ""
    source: str = ""

    @property
    def range(self) -> Range:
        """Bounds with their SI unit."""
        return Range(DIMENSIONS[self.dimension].si or "-", *self.bounds)

    def validate(self, value: Values) -> Batch:
        """Return a `value` as floats [SI]; refuse an impossible one, warn of an unusual one."""
        return check_size(value, self.name, self.range)

    def field(self) -> Any:
        """Field of a law that is validated when set, with the constant in its metadata."""
        default = attrs.NOTHING if self.default is None else self.default
        return record(default=default, converter=self.validate, constant=self)


@dataclass(frozen=True)
class Switch:
    """An option of a law, chosen by name: `name` of the argument, its `options`, of which the first
    is the default, what it is `about` and its `source`.
    """

    name: str
    options: tuple[str, ...]
    about: str = ""
    source: str = ""

    def validate(self, value: str) -> str:
        """Return `value` if it is an option; else `ValueError`, one line."""
        return check_choice(value, self.options, self.name)

    def field(self) -> Any:
        """Static field of a law that holds one of the options, by default the first."""
        return static(default=self.options[0], converter=self.validate, switch=self)
