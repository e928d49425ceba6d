r"""Work done by a contraction, and the fluid energy it takes.

$$W = L_0 \int_0^\varepsilon F \,\mathrm{d}\varepsilon', \qquad
  E = P_s \sum_{active} n_i (V_i(\varepsilon) - V_i(0)), \qquad
  \eta = W/E. \tag{28-30}$$

The supply's pressure $P_s$ counts, also for a unit that is throttled below it, and the
volume is the fluid's: the bladder is incompressible, so its own volume cancels [R17]. Where
muscles are of unlike length, $L_0$ is the distance between the plates at rest, and each
muscle's volume is taken at its own strain.

**Quadrature:** Gauss-Legendre on each stretch between a muscle's kinks, where its force is
smooth. **Source:** Kim, Mazzoleni and Bryant (2021), section 4.2.
"""

from functools import partial
from itertools import pairwise

import jax
import jax.numpy as jnp
import numpy as np

from .._types import Batch, PerUnit, Values
from ..bundle.bundle import Bundle, MusclesAtPressures, pressurized
from ..bundle.plates import muscle_strain


_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(12)


def work(bundle: Bundle, pressures: Values, strain: Values, resistance: bool = True) -> Batch:
    """Work of a contraction from rest length at constant pressures, (28).

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
    - `strain`: contraction at the end [-]; broadcasts against the rest of `pressures`.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** $W$ [J].

    **Raises:** `ValueError` for a wrong number of pressures and values off the domain.
    """
    return jnp.sum(unit_work(bundle, pressures, strain, resistance), axis=-1)


def unit_work(
    bundle: Bundle, pressures: Values, strain: Values, resistance: bool = True
) -> PerUnit:
    """Work of each motor unit, its muscles together; arguments as of `work`.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `pressures`: gauge pressures [Pa], one for each motor unit on the last axis.
    - `strain`: contraction at the end [-]; broadcasts against the rest of `pressures`.
    - `resistance`: whether units past their own free strain push back [-].

    **Returns:** works [J], motor units on the last axis.
    """
    P, eps = bundle._pressures(pressures), bundle._strain(strain)
    return _unit_work(bundle, P, eps, bool(resistance))


def unit_volume_change(bundle: Bundle, strain: Values) -> PerUnit:
    """Fluid taken in by each motor unit from rest length on.

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: contraction [-].

    **Returns:** $n_i (V_i(\\varepsilon) - V_i(0))$ [m³], motor units on the last axis.
    """
    rests, ends = [0.0] * len(bundle.motor_units), [strain] * len(bundle.motor_units)
    if bundle.ratios is not None:
        eps, ratios = bundle._strain(strain), jnp.moveaxis(bundle.ratios, -1, 0)
        rests = [muscle_strain(ratio, jnp.zeros(())) for ratio in ratios]
        ends = [muscle_strain(ratio, eps) for ratio in ratios]
    taken = [
        unit.count * (unit.muscle.volume(end) - unit.muscle.volume(rest))
        for unit, rest, end in zip(bundle.motor_units, rests, ends, strict=True)
    ]
    return jnp.stack(taken, axis=-1)


def fluid_energy(bundle: Bundle, strain: Values, supply_pressure: Values, active: Values) -> Batch:
    """Energy drawn from the supply by a contraction from rest length, (29).

    **Arguments:**

    - `bundle`: the bundle [-].
    - `strain`: contraction at the end [-].
    - `supply_pressure`: $P_s$ [Pa].
    - `active`: which motor units are fed [-], 0 or 1 each, on the last axis.

    **Returns:** $E$ [J].
    """
    taken = unit_volume_change(bundle, strain)
    return jnp.asarray(supply_pressure) * jnp.sum(jnp.asarray(active) * taken, axis=-1)


@partial(jax.jit, static_argnums=3)
def _unit_work(bundle: Bundle, pressures: PerUnit, strain: Batch, resistance: bool) -> PerUnit:
    def one(muscle: MusclesAtPressures, strain: Batch, rest: Batch | float = 0.0) -> Batch:
        eps_f, onset, eps_c = muscle.kinks
        # no stretch starts below rest or ends past the strain asked for, either way
        low, high = jnp.minimum(strain, rest), jnp.maximum(strain, rest)
        stops = [jnp.clip(kink, low, high) for kink in (eps_f, onset, eps_c)]
        ends = [low, *stops, high] if resistance else [low, stops[0]]
        total = jnp.zeros(jnp.broadcast_shapes(strain.shape, eps_f.shape))
        for a, b in pairwise(ends):
            middle, half = (a + b)[..., None] / 2, (b - a)[..., None] / 2
            force = jax.vmap(lambda eps: muscle.response(eps).force, in_axes=-1, out_axes=-1)
            total = total + jnp.sum(half * _WEIGHTS * force(middle + half * _NODES), axis=-1)
        return muscle.column.rest_length * jnp.where(strain < rest, -total, total)

    # of a muscle that isn't as long as the plates are apart, the strain at rest isn't zero;
    # its own length times its own strain is the plates' way all the same
    rest = () if bundle.ratios is None else (jnp.zeros(()),)
    return bundle.counts * pressurized(bundle, pressures).along(one, strain, *rest)
