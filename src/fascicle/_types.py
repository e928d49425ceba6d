"""Shape vocabulary. `*#batch`: any batch shape, broadcasting like NumPy.

An array is NumPy's or JAX's, as are single numbers, or the symbol of a library that writes
code. `Numbers`, `Whole` and `Marks` are of any shape. `Values` is what a caller hands in: a
number, an array or nested lists; `_checks` looks at it.
"""

from typing import Any, Protocol, runtime_checkable

from jaxtyping import ArrayLike, Bool, Float, Int, Real


@runtime_checkable
class Symbol(Protocol):
    """A symbolic array."""

    def is_symbolic(self) -> bool:
        """Whether it is a bare name [-]."""
        ...


BatchLike = Real[ArrayLike, "*#batch"] | Symbol
Batch = Float[ArrayLike, "*#batch"] | Symbol
IntBatch = Int[ArrayLike, "*#batch"] | Symbol
BoolBatch = Bool[ArrayLike, "*#batch"] | Symbol
Numbers = Float[ArrayLike, "..."] | Symbol
Whole = Int[ArrayLike, "..."] | Symbol
Marks = Bool[ArrayLike, "..."] | Symbol
PerUnit = Float[ArrayLike, "*#points unit"] | Symbol
Values = Any
