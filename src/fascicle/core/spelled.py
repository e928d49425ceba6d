r"""A law spelled out: its operations at one point, one after the other, on Python's numbers.

NumPy is made for arrays. Of single numbers it takes ten times as long as their operations do, and
a law works out again at each point what doesn't change. So a law is followed once, on symbols, and
what it does to them is written down as a function of Python's: what is known is a number by then,
nothing is computed twice or in vain, and of two branches mostly the one that is taken. A search is
a loop over a function of its own.

Nothing of the law is written again: the same operations in the same order give the same numbers,
to rounding where NumPy's exponentials have another. Python's numbers refuse what NumPy's answer
with infinity (a division by zero), by an `ArithmeticError` or `ValueError`: such a point is
NumPy's.
"""

import math
from collections import Counter
from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any

import jax
import numpy as np

from .operations import (
    FUNCTIONS,
    Body,
    Column,
    Program,
    SpellingError,
    Symbol,
    followed,
    symbols_of,
    written,
)
from .roots import STEPS, Search, begun, stepped


REFUSED = (ArithmeticError, ValueError)  # of numbers that NumPy has an answer for
_DEEP = 30  # brackets within one another: Python reads no more than some hundred


def spelled(law: Callable[..., Any], part: Any, count: int) -> Callable[..., Any]:
    """`law(part, *numbers)` as a function of `count` numbers of Python's.

    **Arguments:**

    - `law`: elementwise, gives a number or a tuple of them [-].
    - `part`: a tree of modules, numbers and rows of them [SI].
    - `count`: how many numbers it takes beside [-].

    **Returns:** a function that gives what the law does, of Python's numbers [SI]; what depends on
    the part alone is worked out here.

    **Raises:** `SpellingError` where the law asks for more than NumPy's elementwise functions, and
    `REFUSED` where of the part alone something has no number.
    """
    leaves, structure = jax.tree.flatten(part)
    shapes = tuple(map(np.shape, leaves))
    made = _made(law, structure, shapes, count)
    if isinstance(made, SpellingError):
        raise made
    return made(*(number for leaf in leaves for number in np.ravel(leaf).tolist()))


@lru_cache(maxsize=256)
def _made(law: Callable, structure: Any, shapes: tuple, count: int) -> Callable | SpellingError:
    """A function of all numbers in parts of one `structure`, that gives the function of points."""
    try:
        text, kind = _text(law, structure, shapes, count)
    except Exception as why:  # noqa: BLE001 a user's own law may ask anything of its numbers
        return SpellingError(f"{type(why).__name__}: {why}")  # which it stays
    at_hand = {
        **FUNCTIONS, "inf": math.inf, "nan": math.nan, "searched": _searched, "kind": kind,
        "__builtins__": {},
    }  # fmt: skip
    exec(text, at_hand)  # noqa: S102 operators, names and numbers of laws, nobody's words
    return at_hand["spelled"]


def _text(law: Callable, structure: Any, shapes: tuple, count: int) -> tuple[str, Callable]:
    """What is written for it, and what makes a result of its numbers."""
    if any(len(shape) > 1 for shape in shapes):
        raise SpellingError("rows of muscles")
    program = Program()
    outside, program.body = program.body, Body(1)
    of_part, parts = [], []
    for shape in shapes:
        rows = [Symbol(outside, f"c{len(of_part) + i}") for i in range(math.prod(shape))]
        of_part += rows
        parts.append(Column(rows) if shape else rows[0])
    point = [Symbol(program.body, f"x{i}") for i in range(count)]
    with followed(program):
        found = law(jax.tree.unflatten(structure, parts), *point)
    several = isinstance(found, tuple)
    given = tuple(found) if several else (found,)
    if any(map(np.ndim, given)):
        raise SpellingError("more than a number")
    text = _Text(program, given, program.body)
    inner = text.function("point", point, program.body, given, "kind")
    ahead = text.function("spelled", of_part, outside)
    lines = [*ahead, *(f"    {line}" for line in inner), "    return point"]
    return "\n".join(lines), getattr(found, "_make", tuple) if several else _alone


class _Text:
    """What is written for some results of a program."""

    def __init__(self, program: Program, results: tuple, body: Body):
        self.uses: Counter[Symbol] = Counter(symbols_of(results))
        # with a function inside of their own
        self.shared = {one for one in self.uses if one.body is not body}
        self.written: dict[Symbol, tuple[str, int]] = {}
        for one in reversed(program.order):
            if not self.uses[one]:
                continue
            for place, operand in enumerate(one.operands):
                if isinstance(operand, Symbol):
                    self.uses[operand] += max(1, one.form.count(f"{{{place}}}"))
                    if operand.body is not one.body:
                        self.shared.add(operand)
            if one.residual is not None:
                self.uses.update(symbols_of(one.residual.given))
                self.shared.update(one.residual.taken)

    def function(
        self, name: str, arguments: Any, body: Body, given: tuple = (), kind: str = ""
    ) -> list[str]:
        """Its lines; the last returns what is `given`, if anything, as one of a `kind`."""
        lines = [f"def {name}({', '.join(one.name for one in arguments)}):"]
        for one in body.operations:
            if not self.uses[one]:
                continue
            if one.residual is not None:
                x, inside, found, _ = one.residual
                inner = self.function(f"residual_{one.name}", [x], inside, found)
                lines += [f"    {line}" for line in inner]
            text, deep = self._operation(one)
            # what is asked for once is written where it is
            if self.uses[one] == 1 and one not in self.shared and deep < _DEEP:
                self.written[one] = f"({text})", deep + 1
            else:
                lines.append(f"    {one.name} = {text}")
        last = f"    return {kind}(({', '.join(self._operand(one)[0] for one in given)},))"
        return [*lines, last] if given else lines

    def _operation(self, one: Symbol) -> tuple[str, int]:
        texts, depths = zip(*map(self._operand, one.operands), strict=True)
        name = () if one.residual is None else (f"residual_{one.name}",)
        return one.form.format(*name, *texts), max(depths)

    def _operand(self, one: Any) -> tuple[str, int]:
        plain = written(one), 0
        return self.written.get(one, plain) if isinstance(one, Symbol) else plain


def _alone(given: tuple) -> Any:
    return given[0]


def _searched(residual: Callable, low: float, high: float, start: float) -> float:
    """The root of a `residual` that gives value and slope, as NumPy searches for it."""
    step, search = _step(), begun(low, high, start)
    for _ in range(STEPS):
        search = step(*search, *residual(search[0]))
        if search[-1]:
            break
    return search[0]


@cache
def _step() -> Callable[..., tuple]:
    """A step of a search, of numbers."""

    def step(_: Any, *state: Any) -> tuple:
        *search, value, slope = state
        return stepped(Search(*search), value, slope)

    return spelled(step, (), len(Search._fields) + 2)
