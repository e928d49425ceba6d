"""Laws on symbols: the functions of an array library, by CasADi.

A root has no derivative of its own, the steps after the search carry it. So the result of a search,
and every other constant of a law's derivative, is a new symbol, stored with its meaning; it is
substituted after the slopes have been taken.
"""

from typing import Any

import casadi as ca
import numpy as np

from ..core.array_namespace import register_namespace
from ..core.module import Kind, Module, with_fields


_FUNCTIONS = {  # of CasADi, by the names of the array library
    "sqrt": ca.sqrt, "exp": ca.exp, "expm1": ca.expm1, "log": ca.log, "log1p": ca.log1p,
    "sin": ca.sin, "cos": ca.cos, "tan": ca.tan, "arcsin": ca.asin, "arccos": ca.acos,
    "arctan": ca.atan,
    "absolute": ca.fabs, "minimum": ca.fmin, "maximum": ca.fmax, "where": ca.if_else,
    "logical_and": ca.logic_and, "logical_or": ca.logic_or, "logical_not": ca.logic_not,
}  # fmt: skip


class Symbols:
    """Array namespace for CasADi's symbols: NumPy's functions by their names, and the constants
    that `resolve` substitutes after derivatives have been taken.
    """

    def __init__(self):
        self.__dict__ |= _FUNCTIONS
        self.constants: list[Any] = []
        self.meanings: list[Any] = []

    def stop_gradient(self, x: Any) -> Any:
        """A new symbol that stands for `x`."""
        if x.is_constant():
            return x
        self.constants.append(ca.SX.sym(f"constant_{len(self.constants)}", x.shape))
        self.meanings.append(x)
        return self.constants[-1]

    def with_symbols(self, module: Kind, path: str = "") -> Kind:
        """Copy of a `module` with a new symbol for each of its numbers [any unit], named by its
        `path`, such as `material.c10`; `resolve` substitutes the numbers.
        """

        def symbol(name: str, number: Any) -> Any:
            self.constants.append(ca.SX.sym(name))
            self.meanings.append(ca.SX(float(number)))
            return self.constants[-1]

        values: dict[str, Any] = {}
        for name in module.leaf_names:
            value = getattr(module, name)
            if value is None or name == "pressures":  # at which a tuning was measured: no parameter
                continue
            if isinstance(value, Module):
                values[name] = self.with_symbols(value, f"{path}{name}.")
            elif np.ndim(value):
                values[name] = np.empty(len(value), object)
                values[name][:] = [symbol(f"{path}{name}[{i}]", x) for i, x in enumerate(value)]
            else:
                values[name] = symbol(path + name, value)
        return with_fields(module, **values)

    def resolve(self, *expressions: Any) -> list[Any]:
        """The `expressions` with the meanings of all constants substituted."""
        inputs: Any = list(expressions)
        return list(ca.substitute_inplace(self.constants, self.meanings, inputs, False)[1])

    @staticmethod
    def asarray(values: Any) -> Any:
        """`values` as a column."""
        return ca.SX(np.asarray(values, float))

    @staticmethod
    def isfinite(x: Any) -> Any:
        """True if it is neither infinite nor NaN."""
        return ca.logic_and(x < np.inf, x > -np.inf)

    @staticmethod
    def sum(x: Any, axis: int = 0) -> Any:  # noqa: ARG004 a column has one
        """Sum of a column."""
        return ca.sum1(x)

    @staticmethod
    def min(x: Any, axis: int = 0) -> Any:  # noqa: ARG004
        """Smallest entry of a column."""
        return ca.mmin(x)

    @staticmethod
    def max(x: Any, axis: int = 0) -> Any:  # noqa: ARG004
        """Largest entry of a column."""
        return ca.mmax(x)


def symbols() -> Symbols:
    """Register and return new functions for CasADi's symbols."""
    functions = Symbols()
    register_namespace(ca.SX, functions)
    return functions
