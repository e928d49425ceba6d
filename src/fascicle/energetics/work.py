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

from ..bundle.at import pressurized
from ..bundle.bundle import Bundle
from ..bundle.volumes import unit_volume_change
from ..core.array_namespace import array_namespace
from ..core.module import evaluate
from ..core.types import Batch, Numbers, PerUnit, Values
from ..core.validation import to_si
from ..muscle.coenergy import contraction_work
from ..muscle.piecewise import Pressurized


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
    works = unit_work(bundle, pressures, strain, resistance)
    return array_namespace(works).sum(works, axis=-1)


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
    return evaluate(_unit_work, bundle, P, eps, static=(bool(resistance),))


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
    supply_pressure = to_si(supply_pressure, "supply_pressure", "Pa")
    at_work = array_namespace(taken, supply_pressure)
    return supply_pressure * at_work.sum(at_work.asarray(active) * taken, axis=-1)


def _unit_work(bundle: Bundle, pressures: Numbers, strain: Numbers, resistance: bool) -> Numbers:
    def one(muscle: Pressurized, strain: Numbers, rest: Numbers) -> Numbers:
        return contraction_work(muscle, strain, rest, resistance)

    # of a muscle that isn't as long as the plates are apart, the strain at rest isn't zero;
    # its own length times its own strain is the plates' way all the same
    at = pressurized(bundle, pressures)
    return bundle.counts * at.along(one, strain, 0.0 * strain)
