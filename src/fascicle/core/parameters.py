"""A constant of a law, declared once, for all who read it.

Constructors check it, files read and write it, fits move it, the explorer has a field for it and
the docs a row in a table: all from one declaration beside the law's equation,

    force_factor: Batch = Constant(
        "force_factor", "f_F", "number", (1e-4, 0.1, 10.0, 1e4), POSITIVE, 1.0,
        "on the force: measured over ideal blocked force", "Meller et al. (2014)",
    ).field()

A `Switch` declares an option that is chosen by name.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ..units import DIMENSIONS
from .array_namespace import exp, expm1, log, log1p, where
from .module import record, static
from .types import Batch, Values
from .validation import Range, check_choice, check_finite, check_plausible, check_positive


class Transform(NamedTuple):
    """The scale on which a fit moves a constant: the `coordinate` of a value, and the `value`
    back; whether its interval is `even` about the value, not in the coordinate.
    """

    coordinate: Callable[[Batch], Batch]
    value: Callable[[Batch], Batch]
    even: bool = False


POSITIVE = Transform(log, exp)


def symmetric_scale(scale: float) -> Transform:
    """The scale of a constant of either sign, on which `scale` [SI] is a large step."""
    return Transform(lambda value: value / scale, lambda z: z * scale, even=True)


_BEYOND = 0.1  # past 0 and 1 goes a logistic curve, so that a fit can begin at either


def _coordinate_of_share(share: Batch) -> Batch:
    return log((1 + _BEYOND) * (_BEYOND + share) / (_BEYOND * (1 + _BEYOND - share)))


def _share(z: Batch) -> Batch:
    value = _BEYOND * (1 + _BEYOND) * expm1(z) / (1 + _BEYOND * (1 + exp(z)))
    return where(z >= 0, where(value < 1, value, 1.0), 0.0)


# of a constant from 0 to 1, both of which it can be
SHARE = Transform(_coordinate_of_share, _share)


def log1p_scale(scale: float) -> Transform:
    """The scale of a constant that is zero or more, even below `scale` [SI], logarithmic above."""

    def value(z: Batch) -> Batch:
        return where(z >= 0, scale * expm1(z), 0.0)

    return Transform(lambda value: log1p(value / scale), value)


@dataclass(frozen=True)
class Constant:
    """A number of a law.

    - `name`: of the argument and of the key in files.
    - `symbol`: in TeX.
    - `dimension`: a key of `units.DIMENSIONS`.
    - `bounds`: the least that can be, the low and high ends of what is usual, the largest that
      can be [SI]; it must be positive where the least one is.
    - `transform`: for fits; `None` where none moves it.
    - `default`: where it is left out [SI]; `None` where it can't be.
    - `about`: what it is, in a few words.
    - `source`: author and year.
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
        """Check a value.

        **Arguments:** `value`: number or array [SI].

        **Returns:** the value as floats [SI].

        **Raises:** `ValueError`, one line, for an impossible value; an unusual one warns.
        """
        known = self.range
        check = check_positive if known.least > 0 else check_finite
        return check_plausible(check(value, self.name, known.unit), self.name, known)

    def field(self) -> Any:
        """Field of a law that is checked when set, and holds the constant in its metadata."""
        left_out: dict[str, Any] = {} if self.default is None else {"default": self.default}
        return record(converter=self.validate, constant=self, **left_out)

    def plain_field(self) -> Any:
        """Field that its class checks itself, with the constant in its metadata."""
        return record(constant=self)


@dataclass(frozen=True)
class Switch:
    """An option of a law, chosen by name: `name` of the argument, its `options`, the first of them
    where it is left out, what it is `about` and its `source`.
    """

    name: str
    options: tuple[str, ...]
    about: str = ""
    source: str = ""

    def validate(self, value: str) -> str:
        """Return `value` if it is an option; else `ValueError`, one line."""
        return check_choice(value, self.options, self.name)

    def field(self) -> Any:
        """Field of a law that is checked when set, and holds the switch in its metadata."""
        return static(default=self.options[0], converter=self.validate, switch=self)
