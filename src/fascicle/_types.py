"""Shape vocabulary. `*#batch`: any batch shape, broadcasting like NumPy.

`Values` is what a caller hands in: a number, an array or nested lists; `_checks` looks at it.
"""

from typing import Any

from jaxtyping import Array, ArrayLike, Bool, Float, Int, Real


BatchLike = Real[ArrayLike, "*#batch"]
Batch = Float[Array, "*#batch"]
IntBatch = Int[Array, "*#batch"]
BoolBatch = Bool[Array, "*#batch"]
PerUnit = Float[Array, "*#points unit"]
Values = Any
