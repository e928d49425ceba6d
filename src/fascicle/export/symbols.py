"""Laws on symbols: the functions that a law asks an array library for, by CasADi.

What is searched for has no derivative of its own, the steps after it carry them: so a search's
result, and whatever a law holds still, is a new symbol, kept here with its meaning, and put in
only when slopes have been taken.
"""

from typing import Any

import casadi as ca
import numpy as np

from ..core.array_namespace import register_namespace


_FUNCTIONS = {
    "sqrt": ca.sqrt, "exp": ca.exp, "expm1": ca.expm1, "log": ca.log, "log1p": ca.log1p,
    "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "arcsin": ca.asin, "arccos": ca.acos,
    "arctan": ca.atan,
    "absolute": ca.fabs, "minimum": ca.fmin, "maximum": ca.fmax, "where": ca.if_else,
    "logical_and": ca.logic_and, "logical_or": ca.logic_or, "logical_not": ca.logic_not,
}  # fmt: skip


class Symbols:
    """NumPy's functions by their names, of CasADi's scalar symbols."""

    def __init__(self):
        self.__dict__ |= _FUNCTIONS
        self.held: list[Any] = []
        self.meant: list[Any] = []

    def stop_gradient(self, x: Any) -> Any:
        """A new symbol that stands for `x` [any unit]."""
        if x.is_constant():
            return x
        self.held.append(ca.SX.sym(f"held_{len(self.held)}", x.shape))
        self.meant.append(x)
        return self.held[-1]

    def resolved(self, *expressions: Any) -> list[Any]:
        """The `expressions` [any unit] with everything put in that was held still."""
        inputs: Any = list(expressions)
        return list(ca.substitute_inplace(self.held, self.meant, inputs, False)[1])

    @staticmethod
    def asarray(values: Any) -> Any:
        """`values` [any unit] as a column."""
        return ca.SX(np.asarray(values, float))

    @staticmethod
    def isfinite(x: Any) -> Any:
        """True where it is neither infinite nor NaN."""
        return ca.logic_and(x < np.inf, x > -np.inf)

    @staticmethod
    def sum(x: Any, axis: int = 0) -> Any:  # noqa: ARG004 a column has one
        """Over a column [any unit]."""
        return ca.sum1(x)

    @staticmethod
    def min(x: Any, axis: int = 0) -> Any:  # noqa: ARG004
        """The smallest of a column [any unit]."""
        return ca.mmin(x)

    @staticmethod
    def max(x: Any, axis: int = 0) -> Any:  # noqa: ARG004
        """The largest of a column [any unit]."""
        return ca.mmax(x)


def symbols() -> Symbols:
    """The functions that laws are given from now on for CasADi's symbols [-]."""
    functions = Symbols()
    register_namespace(ca.SX, functions)
    return functions
