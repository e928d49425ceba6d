r"""Circles side by side: how wide a bundle is.

$N$ equal circles of radius $r$ fit into one of radius $\rho_N r$. The $\rho_N$ up to 30 are
those of the best packings known (proved for $N \le 13$ and $19$; Graham, Lubachevsky, Nurmela
and Östergård 1998); beyond, the density is taken to stay that of 30.

Two lie side by side. More, unlike ones are taken to fill the circle around them as densely
as equal ones do,

$$R = \max\Bigl(\rho_N \sqrt{\textstyle\sum_i r_i^2 / N},\; r_1 + r_2\Bigr), \tag{G1}$$

with $r_1$ and $r_2$ the two largest, which must lie side by side. **Exact** for equal circles
and for two; else an estimate: a large circle among small ones wastes more, small ones that
fit into the gaps less.
"""

import numpy as np

from ...core.array_namespace import array_namespace, maximum, sqrt, where
from ...core.types import Numbers, Values


_RATIOS = (
    1.0, 2.0, 2.1547, 2.4142, 2.7013, 3.0, 3.0, 3.3048, 3.6131, 3.8130,
    3.9238, 4.0296, 4.2361, 4.3284, 4.5214, 4.6154, 4.7920, 4.8637, 4.8637, 5.1223,
    5.2523, 5.4397, 5.5452, 5.6517, 5.7528, 5.8282, 5.9063, 6.0149, 6.1386, 6.1977,
)  # fmt: skip
_EXACT = {2: 2.0, 3: 1 + 2 / np.sqrt(3), 4: 1 + np.sqrt(2)}


def ratio(count: Values) -> Numbers:
    r"""How much wider the circle around equal ones is.

    **Arguments:** `count`: $N$ of them [-], at least 1.

    **Returns:** $\rho_N$ [-].
    """
    table = np.array([_EXACT.get(n, rho) for n, rho in enumerate(_RATIOS, start=1)])
    at_work, most = array_namespace(count), len(table)
    n = at_work.asarray(count)
    known = at_work.asarray(table)[at_work.clip(n, 1, most) - 1]
    return where(n > most, table[-1] * sqrt(n / most), known)


def bowed_diameter(radii: Values, counts: Values, bulge: Values) -> Numbers:
    """Diameter of the circle around all muscles, where units that aren't fed bow out.

    **Arguments:**

    - `radii`: of a muscle of each unit [m].
    - `counts`: muscles in each unit [-]; 0 for none.
    - `bulge`: how far a muscle bows out [m]; a lone unit is fed, and doesn't.

    **Returns:** the diameter [m].
    """
    several = (array_namespace(counts).asarray(counts) > 0).sum(axis=-1) > 1
    return 2 * (packed_radius(radii, counts) + where(several, bulge, 0.0))


def packed_radius(radii: Values, counts: Values) -> Numbers:
    """Radius of the circle around all muscles, equation (G1).

    **Arguments:**

    - `radii`: of a muscle of each unit [m].
    - `counts`: muscles in each unit [-]; 0 for none.

    **Returns:** the radius [m].
    """
    at_work = array_namespace(radii, counts)
    radii, counts = at_work.asarray(radii), at_work.asarray(counts)
    N = counts.sum(axis=-1)
    dense = ratio(N) * sqrt((counts * radii**2).sum(axis=-1) / maximum(N, 1))
    # the two largest: a unit of two or more brings both
    there, twice = where(counts > 0, radii, 0.0), where(counts > 1, radii, 0.0)
    both = at_work.sort(at_work.concatenate([there, twice], axis=-1), axis=-1)
    side_by_side = both[..., -1] + both[..., -2]
    return where(N == 2, side_by_side, maximum(dense, side_by_side))
