"""Operations that a law does to numbers which aren't known yet, in order, each once.

A law takes its arguments' library, so symbols with one of their own follow it: what it does to them
is noted. `spelled` writes it down. A search has a function of its own, its residual, within that of
the point.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import partial, reduce
from typing import Any, NamedTuple

import numpy as np

from .arrays import register


_MOST = 4000  # operations: beyond, Python takes longer to read them than is gained

FUNCTIONS = {
    "sqrt": math.sqrt, "exp": math.exp, "expm1": math.expm1, "log": math.log, "log1p": math.log1p,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "arcsin": math.asin, "arccos": math.acos,
    "arctan": math.atan, "absolute": abs, "power": math.pow,
}  # fmt: skip
_FORMS = {
    "where": "{1} if {0} else {2}", "isfinite": "-inf < {} < inf",
    "minimum": "{0} if {0} < {1} or {0} != {0} else {1}",  # NaN if one of them is
    "maximum": "{0} if {0} > {1} or {0} != {0} else {1}",
    "logical_and": "{} and {}", "logical_or": "{} or {}", "logical_not": "not {}",
}  # fmt: skip
_OPERATORS = {
    "add": "+", "sub": "-", "mul": "*", "truediv": "/", "pow": "**", "and": "and", "or": "or",
}  # fmt: skip
_COMPARISONS = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "==", "ne": "!="}
_POWER, _SQUARE = "{} ** {}", "{0} * {0}"
# what changes nothing, not even the sign of a zero
_IDLE = {"{} * {}": 1.0, "{} / {}": 1.0, _POWER: 1.0, "{} - {}": 0.0}


class SpellingError(TypeError):
    """A law asks for what can't be spelled out."""


class Program:
    """A law's operations in order, each once, and the function whose body is at work."""

    def __init__(self):
        self.body = Body(0)  # of what its constants alone say, no point
        self.order: list[Symbol] = []
        self.known: dict[tuple, Symbol] = {}

    def symbol(self, body: "Body", form: str, *operands: Any) -> "Symbol":
        """What an operation of this `form` gives in a `body`."""
        if len(self.order) > _MOST:
            raise SpellingError(f"more than {_MOST} operations")
        made = Symbol(body, f"v{len(self.order)}", form, operands)
        self.order.append(made)
        body.operations.append(made)
        return made

    def once(self, form: str, *operands: Any) -> "Symbol":
        """The same, the same symbol for the same operation."""
        key = (form, *map(written, operands))
        if key not in self.known:
            self.known[key] = self.symbol(_innermost(operands), form, *operands)
        return self.known[key]


class Body:
    """What a function does, which is so many [-] others `deep`."""

    def __init__(self, deep: int):
        self.deep = deep
        self.operations: list[Symbol] = []


_AT_WORK: ContextVar[Program] = ContextVar("program")


class _Number:
    """What isn't known yet; operators are added below."""

    __array_ufunc__ = None  # NumPy's numbers leave operations to it
    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        raise SpellingError("a branch of Python's")

    def is_symbolic(self) -> bool:
        """Whether it stands for a number [-]."""
        return True


class Symbol(_Number):
    """A number: what an operation gives of its operands, or an argument."""

    ndim, shape = 0, ()

    def __init__(self, body: Body, name: str, form: str = "", operands: tuple = ()):
        self.body, self.name, self.form, self.operands = body, name, form, operands
        self.residual: Residual | None = None  # of a search


class Column(_Number):
    """Some numbers, known or not: a table's rows, a quadrature's nodes."""

    ndim = 1

    def __init__(self, rows: Iterable[Any]):
        self.rows = list(rows)
        self.shape = (len(self.rows),)

    def __getitem__(self, places: Any) -> Any:
        """Its rows at `places` [-], the last of which may be one or a range of them."""
        rows = self.rows[places[-1] if isinstance(places, tuple) else places]
        return Column(rows) if isinstance(rows, list) else rows


class Residual(NamedTuple):
    """A function of `x`: its `body`, what it gives, and what it takes from elsewhere."""

    x: Symbol
    body: Body
    given: tuple
    taken: list[Symbol]


class _Functions:
    """NumPy's functions by their names, of symbols and columns of them."""

    def __init__(self):
        self.__dict__ |= {name: partial(_put, f"{name}({{}})") for name in FUNCTIONS}
        self.__dict__ |= {name: partial(_put, form) for name, form in _FORMS.items()}

    def __getattr__(self, name: str) -> Any:
        raise SpellingError(name)

    @staticmethod
    def still(x: Any) -> Any:
        """The same [any unit]: nothing moves."""
        return x

    @staticmethod
    def asarray(values: Any) -> Any:
        """`values` [any unit] as a column."""
        return values if isinstance(values, _Number) else Column(np.ravel(values))

    @staticmethod
    def sum(x: Any, axis: int = 0) -> Any:  # noqa: ARG004 a column has one
        """Over a column [any unit]."""
        return reduce(partial(_put, "{} + {}"), _rows(x))

    @staticmethod
    def min(x: Any, axis: int = 0) -> Any:  # noqa: ARG004
        """The smallest of a column [any unit]."""
        return reduce(partial(_put, _FORMS["minimum"]), _rows(x))

    @staticmethod
    def max(x: Any, axis: int = 0) -> Any:  # noqa: ARG004
        """The largest of a column [any unit]."""
        return reduce(partial(_put, _FORMS["maximum"]), _rows(x))

    @staticmethod
    def searched(residual: Callable, low: Any, high: Any, start: Any) -> Any:
        """Where the `residual` is zero [any unit]: a loop over a function of its own."""
        program = _AT_WORK.get()
        outside, program.body = program.body, Body(program.body.deep + 1)
        body, x = program.body, Symbol(program.body, f"x{len(program.order)}")
        given = tuple(residual(x))
        program.body = outside
        asked = [one for each in body.operations for one in _asked_by(each)]
        taken = [one for one in (*asked, *symbols_of(given)) if one.body is not body]
        operands = (low, high, start)
        at = _innermost((*operands, *taken))
        found = program.symbol(at, "searched({}, {}, {}, {})", *operands)
        found.residual = Residual(x, body, given, taken)
        return found


@contextmanager
def followed(program: Program) -> Iterator[None]:
    """Operations inside are those of a `program` [-]."""
    before = _AT_WORK.set(program)
    try:
        yield
    finally:
        _AT_WORK.reset(before)


def _put(form: str, *operands: Any) -> Any:
    """What an operation gives, of symbols or along columns."""
    if any(map(np.ndim, operands)):
        columns = [_rows(one) if np.ndim(one) else [one] for one in operands]
        rows = max(map(len, columns))
        each = zip(*(x * rows if len(x) == 1 else x for x in columns), strict=True)
        return Column(_put(form, *row) for row in each)
    known = [not isinstance(x, Symbol) for x in operands]
    if form == _FORMS["where"] and known[0]:
        return operands[1] if operands[0] else operands[2]
    if known[-1] and _IDLE.get(form) == operands[-1]:
        return operands[0]
    if form == _POWER and not (known[1] and float(operands[1]).is_integer()):
        form = "power({}, {})"  # Python's own would give a complex number where NumPy has NaN
    elif form == _POWER and operands[1] == 2.0:
        form = _SQUARE
    return _AT_WORK.get().once(form, *operands)


def _rows(x: Any) -> list[Any]:
    return x.rows if isinstance(x, Column) else np.ravel(x).tolist()


def symbols_of(values: Iterable[Any]) -> list[Symbol]:
    """Those of the `values` [-] that are symbols."""
    return [one for one in values if isinstance(one, Symbol)]


def _asked_by(one: Symbol) -> list[Symbol]:
    """Symbols that an operation asks for."""
    return symbols_of(one.operands) + ([] if one.residual is None else one.residual.taken)


def _innermost(values: Iterable[Any]) -> Body:
    """The innermost body of those that some symbols are of; the one at work for none."""
    bodies = [one.body for one in symbols_of(values)]
    return max(bodies, key=lambda body: body.deep) if bodies else _AT_WORK.get().body


def written(value: Any) -> str:
    """A symbol's name, or a number, exactly."""
    return value.name if isinstance(value, Symbol) else f"({np.asarray(value).item()!r})"


def _operator(form: str, back: bool = False) -> Callable:
    def operation(self: Any, *other: Any) -> Any:
        return _put(form, *other, self) if back else _put(form, self, *other)

    return operation


for _name, _sign in _OPERATORS.items():
    setattr(_Number, f"__{_name}__", _operator(f"{{}} {_sign} {{}}"))
    setattr(_Number, f"__r{_name}__", _operator(f"{{}} {_sign} {{}}", back=True))
for _name, _sign in _COMPARISONS.items():
    setattr(_Number, f"__{_name}__", _operator(f"{{}} {_sign} {{}}"))
for _name, _sign in {"neg": "-", "invert": "not "}.items():
    setattr(_Number, f"__{_name}__", _operator(f"{_sign}{{}}"))
for _kind in (Symbol, Column):
    register(_kind, _Functions())
