"""Shape vocabulary. `*#batch`: any batch shape, broadcasting like NumPy.

An `AnyArray` is NumPy's or JAX's, as are single numbers, or a symbol of a library that writes code.
`Numbers`, `Whole` and `Marks` are of any shape. `Values` is what a caller hands in: a
number, an array or nested lists; `checks` looks at it.
"""

# a shape in words, for people: no type checker knows what arrays of several libraries share
from typing import Annotated as Bool
from typing import Annotated as Float
from typing import Annotated as Int
from typing import Annotated as Real
from typing import Any


AnyArray = Any

BatchLike = Real[AnyArray, "*#batch"]
Batch = Float[AnyArray, "*#batch"]
IntBatch = Int[AnyArray, "*#batch"]
BoolBatch = Bool[AnyArray, "bool *#batch"]
Numbers = Float[AnyArray, "..."]
Whole = Int[AnyArray, "..."]
Marks = Bool[AnyArray, "bool ..."]
PerUnit = Float[AnyArray, "*#points unit"]
Values = Real[AnyArray, "..., or nested lists, or text with units"]
