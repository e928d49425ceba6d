"""Shapes of arrays in words: a `Batch` is of any shape and broadcasts as NumPy's arrays do.

An `AnyArray` is NumPy's or JAX's, as are single numbers, or a symbol of a library that writes code.
`Numbers`, `Whole` and `Marks` are of any shape. `Values` is input: a number, an array, nested lists
or text with units, which `validation` checks. A `PyTree` is an array, or modules, tuples and
dictionaries of arrays.
"""

# for people: no type checker knows what arrays of several libraries have in common
from typing import Annotated as Bool
from typing import Annotated as Float
from typing import Annotated as Int
from typing import Annotated as Real
from typing import Any


AnyArray = Any
PyTree = Any

BatchLike = Real[AnyArray, "*#batch"]
Batch = Float[AnyArray, "*#batch"]
IntBatch = Int[AnyArray, "*#batch"]
BoolBatch = Bool[AnyArray, "bool *#batch"]
Numbers = Float[AnyArray, "..."]
Whole = Int[AnyArray, "..."]
Marks = Bool[AnyArray, "bool ..."]
PerUnit = Float[AnyArray, "*#points unit"]
Values = Real[AnyArray, "..., or nested lists, or text with units"]
