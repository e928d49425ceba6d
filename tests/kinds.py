"""Annotations as checks that cost little: a call whose kind has passed isn't checked again, and of
a function's many calls in one test the first are looked at, then one in sixteen.

What jaxtyping and beartype look at is a value's class, its shape and element type, and a string's
text; of a list they look at an item or so. A call with all of these as before, in its arguments
and its result, has the same answer, and asking again takes longer than most laws do.
"""

import functools
import inspect

import jaxtyping


_ITEMS = 16  # of a list, of which beartype looks at one
_LETTERS = 64  # more than in any text that an annotation names
_FIRST, _THEN = 64, 16  # to look at each call took a third of the time of NumPy's laws
_checked = jaxtyping.jaxtyped
_calls = {}  # by code, which functions made within others share
_passed = {}


def begin():
    """A test begins: of each function the first calls are looked at again."""
    _calls.clear()


def look_at_each():
    """However often a function is called."""
    global _THEN  # noqa: PLW0603 of a process
    _THEN = 1


def kind(value):
    """All of `value` that an annotation tells apart."""
    return type(value), _teller(type(value))(value)


def _one_by_one(values):
    return len(values), *map(kind, values[:_ITEMS])


_TOLD = {
    str: lambda text: text[:_LETTERS],
    type: lambda of: of,
    tuple: _one_by_one,
    list: _one_by_one,
    dict: lambda values: tuple((kind(key), kind(one)) for key, one in values.items()),
    set: lambda values: frozenset(map(kind, values)),
    frozenset: lambda values: frozenset(map(kind, values)),
}


@functools.cache
def _teller(of):
    if hasattr(of, "shape") and hasattr(of, "dtype"):
        # a quantity with a unit has them only where its magnitude has
        return lambda array: (getattr(array, "shape", None), getattr(array, "dtype", None))
    return next((told for base, told in _TOLD.items() if issubclass(of, base)), lambda _: None)


def checked_once(function=None, *, typechecker):
    """`jaxtyping.jaxtyped` that checks each kind of call once, as far as calls are looked at."""
    if function is None:
        return functools.partial(checked_once, typechecker=typechecker)
    if not inspect.isfunction(function):
        return _checked(function, typechecker=typechecker)

    results = []

    @functools.wraps(function)
    def given(*_arguments, **_named):
        return results.pop()

    @functools.cache  # at the first call: most functions are never called in a process
    def checked(of):
        return _checked(of, typechecker=typechecker)

    code = function.__code__
    passed = _passed.setdefault(code, {})

    @functools.wraps(function)
    def wrapped(*arguments, **named):
        __tracebackhide__ = True
        count = _calls[code] = _calls.get(code, 0) + 1
        if count > _FIRST and count % _THEN:
            return function(*arguments, **named)
        asked = (*map(kind, arguments), kind(named))
        if asked not in passed:
            result = checked(function)(*arguments, **named)
            passed[asked] = {kind(result)}
            return result
        result = function(*arguments, **named)
        answered = kind(result)
        if answered not in passed[asked]:
            results.append(result)
            checked(given)(*arguments, **named)
            passed[asked].add(answered)
        return result

    return wrapped
