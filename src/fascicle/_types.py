"""Shape vocabulary. `*#batch`: any batch shape, broadcasting like NumPy."""

from jaxtyping import Array, ArrayLike, Bool, Float, Int, Real


BatchLike = Real[ArrayLike, "*#batch"]
Batch = Float[Array, "*#batch"]
IntBatch = Int[Array, "*#batch"]
BoolBatch = Bool[Array, "*#batch"]
