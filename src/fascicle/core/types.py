"""Shape vocabulary. `*#batch`: any batch shape, broadcasting like NumPy.

An `AnyArray` is NumPy's or JAX's, as are single numbers; a `Symbol` is of a library that writes
code. `Numbers`, `Whole` and `Marks` are of any shape. `Values` is what a caller hands in: a
number, an array or nested lists; `checks` looks at it.
"""

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from jaxtyping import ArrayLike, Bool, Float, Int, Real


if TYPE_CHECKING:  # no type checker knows yet what arrays of several libraries have in common
    AnyArray = Symbol = Any
else:
    AnyArray = ArrayLike

    @runtime_checkable
    class Symbol(Protocol):
        """A symbolic array."""

        def is_symbolic(self) -> bool:
            """Whether it is a bare name [-]."""
            ...


BatchLike = Real[AnyArray, "*#batch"] | Symbol
Batch = Float[AnyArray, "*#batch"] | Symbol
IntBatch = Int[AnyArray, "*#batch"] | Symbol
BoolBatch = Bool[AnyArray, "*#batch"] | Symbol
Numbers = Float[AnyArray, "..."] | Symbol
Whole = Int[AnyArray, "..."] | Symbol
Marks = Bool[AnyArray, "..."] | Symbol
PerUnit = Float[AnyArray, "*#points unit"] | Symbol
Values = Any
