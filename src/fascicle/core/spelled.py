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
from collections.abc import Callable, Iterable
from contextvars import ContextVar
from functools import cache, lru_cache, partial, reduce
from typing import Any, NamedTuple

import jax
import numpy as np

from .arrays import register
from .roots import STEPS, Search, begun, stepped


REFUSED = (ArithmeticError, ValueError)  # of numbers that NumPy has an answer for
_MOST = 4000  # operations: beyond, Python takes longer to read them than is gained
_DEEP = 30  # brackets within one another: Python reads no more than some hundred

_FUNCTIONS = {
    "sqrt": math.sqrt, "exp": math.exp, "expm1": math.expm1, "log": math.log, "log1p": math.log1p,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "arcsin": math.asin, "arccos": math.acos,
    "arctan": math.atan, "absolute": abs,
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


class _Program:
    """A law's operations in order, each once, and the function whose body is at work."""

    def __init__(self):
        self.body = _Body(0)  # of what its constants alone say, no point
        self.order: list[_Symbol] = []
        self.known: dict[tuple, _Symbol] = {}

    def symbol(self, body: "_Body", form: str, *operands: Any) -> "_Symbol":
        """What an operation of this `form` gives in a `body`."""
        if len(self.order) > _MOST:
            raise SpellingError(f"more than {_MOST} operations")
        made = _Symbol(body, f"v{len(self.order)}", form, operands)
        self.order.append(made)
        body.operations.append(made)
        return made

    def once(self, form: str, *operands: Any) -> "_Symbol":
        """The same, the same symbol for the same operation."""
        key = (form, *map(_text, operands))
        if key not in self.known:
            self.known[key] = self.symbol(_innermost(operands), form, *operands)
        return self.known[key]


class _Body:
    """What a function does, which is so many [-] others `deep`."""

    def __init__(self, deep: int):
        self.deep = deep
        self.operations: list[_Symbol] = []


_AT_WORK: ContextVar[_Program] = ContextVar("program")


class _Number:
    """What isn't known yet; operators are added below."""

    __array_ufunc__ = None  # NumPy's numbers leave operations to it
    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        raise SpellingError("a branch of Python's")

    def is_symbolic(self) -> bool:
        """Whether it stands for a number [-]."""
        return True


class _Symbol(_Number):
    """A number: what an operation gives of its operands, or an argument."""

    ndim, shape = 0, ()

    def __init__(self, body: _Body, name: str, form: str = "", operands: tuple = ()):
        self.body, self.name, self.form, self.operands = body, name, form, operands
        self.residual: _Residual | None = None  # of a search


class _Column(_Number):
    """Some numbers, known or not: a table's rows, a quadrature's nodes."""

    ndim = 1

    def __init__(self, rows: Iterable[Any]):
        self.rows = list(rows)
        self.shape = (len(self.rows),)

    def __getitem__(self, places: Any) -> Any:
        """Its rows at `places` [-], the last of which may be one or a range of them."""
        rows = self.rows[places[-1] if isinstance(places, tuple) else places]
        return _Column(rows) if isinstance(rows, list) else rows


class _Residual(NamedTuple):
    """A function of `x`: its `body`, what it gives, and what it takes from elsewhere."""

    x: _Symbol
    body: _Body
    given: tuple
    taken: list[_Symbol]


class _Functions:
    """NumPy's functions by their names, of symbols and columns of them."""

    def __init__(self):
        self.__dict__ |= {name: partial(_put, f"{name}({{}})") for name in _FUNCTIONS}
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
        return values if isinstance(values, _Number) else _Column(np.ravel(values))

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
        outside, program.body = program.body, _Body(program.body.deep + 1)
        body, x = program.body, _Symbol(program.body, f"x{len(program.order)}")
        given = tuple(residual(x))
        program.body = outside
        asked = [one for each in body.operations for one in _asked_by(each)]
        taken = [one for one in (*asked, *_symbols(given)) if one.body is not body]
        operands = (low, high, start)
        at = _innermost((*operands, *taken))
        found = program.symbol(at, "searched({}, {}, {}, {})", *operands)
        found.residual = _Residual(x, body, given, taken)
        return found


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
    numbers = (number for leaf in leaves for number in np.ravel(leaf).tolist())
    written = _written(law, structure, shapes, count)
    if isinstance(written, SpellingError):
        raise written
    return written(*numbers)


@lru_cache(maxsize=256)
def _written(law: Callable, structure: Any, shapes: tuple, count: int) -> Callable | SpellingError:
    """A function of all numbers in parts of one `structure`, that gives the function of points."""
    try:
        return _followed(law, structure, shapes, count)
    except Exception as why:  # noqa: BLE001 a user's own law may ask anything of its numbers
        return SpellingError(f"{type(why).__name__}: {why}")  # which it stays


def _followed(law: Callable, structure: Any, shapes: tuple, count: int) -> Callable:
    if any(len(shape) > 1 for shape in shapes):
        raise SpellingError("rows of muscles")
    program = _Program()
    outside, program.body = program.body, _Body(1)
    of_part, parts = [], []
    for shape in shapes:
        rows = [_Symbol(outside, f"c{len(of_part) + i}") for i in range(math.prod(shape))]
        of_part += rows
        parts.append(_Column(rows) if shape else rows[0])
    point = [_Symbol(program.body, f"x{i}") for i in range(count)]
    before = _AT_WORK.set(program)
    try:
        found = law(jax.tree.unflatten(structure, parts), *point)
    finally:
        _AT_WORK.reset(before)
    several = isinstance(found, tuple)
    given = tuple(found) if several else (found,)
    if any(map(np.ndim, given)):
        raise SpellingError("more than a number")
    text = _Text(program, given, program.body)
    inner = text.function("point", point, program.body, given, "kind")
    ahead = text.function("spelled", of_part, outside)
    lines = [*ahead, *(f"    {line}" for line in inner), "    return point"]
    kind = getattr(found, "_make", tuple) if several else _alone
    at_hand = {**_FUNCTIONS, "inf": math.inf, "nan": math.nan, "searched": _searched, "kind": kind}
    exec("\n".join(lines), at_hand)  # noqa: S102 operations of our own laws, nobody's text
    return at_hand["spelled"]


class _Text:
    """What is written for some results of a program."""

    def __init__(self, program: _Program, results: tuple, body: _Body):
        self.uses: Counter[_Symbol] = Counter(_symbols(results))
        # with a function inside of their own
        self.shared = {one for one in self.uses if one.body is not body}
        self.written: dict[_Symbol, tuple[str, int]] = {}
        for one in reversed(program.order):
            if not self.uses[one]:
                continue
            for place, operand in enumerate(one.operands):
                if isinstance(operand, _Symbol):
                    self.uses[operand] += max(1, one.form.count(f"{{{place}}}"))
                    if operand.body is not one.body:
                        self.shared.add(operand)
            if one.residual is not None:
                self.uses.update(_symbols(one.residual.given))
                self.shared.update(one.residual.taken)

    def function(
        self, name: str, arguments: Any, body: _Body, given: tuple = (), kind: str = ""
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

    def _operation(self, one: _Symbol) -> tuple[str, int]:
        texts, depths = zip(*map(self._operand, one.operands), strict=True)
        name = () if one.residual is None else (f"residual_{one.name}",)
        return one.form.format(*name, *texts), max(depths)

    def _operand(self, one: Any) -> tuple[str, int]:
        plain = _text(one), 0
        return self.written.get(one, plain) if isinstance(one, _Symbol) else plain


def _put(form: str, *operands: Any) -> Any:
    """What an operation gives, of symbols or along columns."""
    if any(map(np.ndim, operands)):
        columns = [_rows(one) if np.ndim(one) else [one] for one in operands]
        rows = max(map(len, columns))
        each = zip(*(x * rows if len(x) == 1 else x for x in columns), strict=True)
        return _Column(_put(form, *row) for row in each)
    known = [not isinstance(x, _Symbol) for x in operands]
    if form == _FORMS["where"] and known[0]:
        return operands[1] if operands[0] else operands[2]
    if known[-1] and _IDLE.get(form) == operands[-1]:
        return operands[0]
    if form == _POWER and known[1] and operands[1] == 2.0:
        form = _SQUARE
    return _AT_WORK.get().once(form, *operands)


def _rows(x: Any) -> list[Any]:
    return x.rows if isinstance(x, _Column) else np.ravel(x).tolist()


def _symbols(values: Iterable[Any]) -> list[_Symbol]:
    return [one for one in values if isinstance(one, _Symbol)]


def _asked_by(one: _Symbol) -> list[_Symbol]:
    """Symbols that an operation asks for."""
    return _symbols(one.operands) + ([] if one.residual is None else one.residual.taken)


def _innermost(values: Iterable[Any]) -> _Body:
    """The innermost body of those that some symbols are of; the one at work for none."""
    bodies = [one.body for one in _symbols(values)]
    return max(bodies, key=lambda body: body.deep) if bodies else _AT_WORK.get().body


def _text(value: Any) -> str:
    """A symbol's name, or a number, exactly."""
    return value.name if isinstance(value, _Symbol) else f"({np.asarray(value).item()!r})"


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
for _kind in (_Symbol, _Column):
    register(_kind, _Functions())
