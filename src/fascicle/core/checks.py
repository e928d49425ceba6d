"""Checks made once, where a value enters the library; laws downstream trust them.

A traced value (inside `jax.jit`, `jax.grad`, `jax.vmap`) can't be looked at: it was
checked where it entered, or is the caller's own affair.
"""

import difflib
import math
from collections.abc import Iterable

import numpy as np

from .arrays import FLOATS, as_jax, imported_jax, is_jax_array
from .refused import Refused
from .types import Batch, Values
from .written import in_si


def within(
    value: Values,
    low: Batch,
    high: Batch,
    name: str,
    unit: str,
    why: str = "",
    closed: tuple[bool, bool] = (False, False),
    remedy: str = "",
) -> Batch:
    """Return `value` as floats, NumPy's, refusing anything outside the interval.

    The interval is open unless `closed` says otherwise for its low or high end. Ends may be
    arrays, which broadcast against the value. `why` completes the rule in words: "to
    contract"; `remedy` says what to do.
    """
    single = type(value) in FLOATS and type(low) is not np.ndarray
    if single and type(high) is not np.ndarray and low < value < high:
        return np.float64(value + 0.0)  # a single good one, soon
    value = in_si(value, name, unit)
    if not is_concrete(value):
        return traced_floats(value)
    x = _numeric(value, name, unit)
    # written so that NaN is refused too
    above = (x >= low) if closed[0] else (x > low)
    below = (x <= high) if closed[1] else (x < high)
    good = above & below
    if not np.all(good):
        bad, low, high = (float(np.broadcast_to(x, good.shape)[~good][0]) for x in (x, low, high))
        ends = f"{_number(low)}, {_number(high)}"
        interval = f"{'[' if closed[0] else '('}{ends}{']' if closed[1] else ')'}"
        rule = " ".join(part for part in (interval, _shown(unit), why) if part)
        raise Refused(name, f"must lie in {rule}", bad, remedy, shown=_amount(bad, unit))
    return x[()]


def positive(value: Values, name: str, unit: str, remedy: str = "") -> Batch:
    """Return `value` as floats, NumPy's, refusing anything that is not > 0 and finite; `remedy`
    says what to do.
    """
    value = in_si(value, name, unit)
    if not is_concrete(value):
        return traced_floats(value)
    x = _numeric(value, name, unit)
    good = (x > 0) & np.isfinite(x)
    if not np.all(good):
        bad = float(x[~good].flat[0])
        raise Refused(name, "must be positive and finite", bad, remedy, shown=_amount(bad, unit))
    return x[()]


def finite(value: Values, name: str, unit: str) -> Batch:
    """Return `value` as floats, NumPy's, refusing NaN and infinities."""
    return within(value, -math.inf, math.inf, name, unit)


def as_given(value: Values, checked: Batch) -> Batch:
    """What was `checked` of a `value`, in the library that the value came from."""
    return as_jax(checked) if is_jax_array(value) else checked


def one_of(name: str, choices: Iterable[str], what: str) -> str:
    """Return `name` if it is a choice; else refuse it and suggest the nearest."""
    if name in (choices := list(choices)):
        return name
    known = sorted(choices)
    near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.4)
    hint = f"did you mean {near[0]!r}? " if near else ""
    remedy = f"{hint}choose one of {', '.join(known)}"
    raise Refused(what, f"{name!r} is unknown", name, remedy, shown="")


def is_concrete(*values: Values) -> bool:
    """Whether none of `values` is traced, nor holds what is, so that they can be looked at."""
    jax = imported_jax()
    if jax is None:
        return True
    return not any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(values))


concrete = is_concrete  # a name that modules not yet renamed use


def traced_floats(value: Values) -> Batch:
    """A traced `value` [any unit] as JAX's floats."""
    return imported_jax().numpy.asarray(value, dtype=float)


def _shown(unit: str) -> str:
    return "" if unit == "-" else unit


def _number(value: float) -> str:
    return f"{value:g}".replace("e+0", "e")


def _amount(value: float, unit: str) -> str:
    return " ".join(part for part in (_number(value), _shown(unit)) if part)


def _numeric(value: Values, name: str, unit: str) -> np.ndarray:
    try:
        x = np.asarray(value)
        if x.dtype.kind not in "fiu":  # a bool or a string is no measurement
            raise TypeError
        return np.asarray(x.astype(float) + 0.0)  # no negative zero
    except (TypeError, ValueError):
        what = f"numbers in {unit}" if _shown(unit) else "dimensionless numbers"
        raise Refused(name, f"takes {what}", value, shown=repr(value)) from None
