"""A muscle at a pressure: what is solved for once, and then asked for at many strains.

Free strain and collapse strain are roots that depend on pressure alone. `muscle.at(pressure)`
finds them; forces and shapes at any strain are closed forms from there.

**Sign:** pulling force and contraction positive, gauge pressure.
**Source:** Kim, Mazzoleni and Bryant (2021), (27).
"""

from collections.abc import Callable
from typing import Any

from ..core.array_namespace import as_jax, is_jax_array
from ..core.module import Module, evaluate, static
from ..core.types import Batch, Values
from .column import Centerline
from .entry import centerline_points, points_of, strained
from .piecewise import Pressurized, Response


Muscle = Any  # the class, which imports this


class AtPressure(Module):
    """A muscle at a pressure: `muscle.at(pressure)` makes it.

    `pressure`: gauge [Pa]. `state`: its laws there, for library code: elementwise in strain,
    nothing checked, a force with its slope.
    """

    pressure: Batch
    state: Pressurized
    _of_jax: bool = static()

    @property
    def free_strain(self) -> Batch:
        """Strain $\\varepsilon_f$ [-] at which the force vanishes."""
        return self._given(self.state.column.free_strain)

    @property
    def onset(self) -> Batch:
        """Strain [-] at which the muscle buckles; inf where it never does."""
        return self._given(self.state.onset)

    @property
    def collapse_strain(self) -> Batch:
        """Strain $\\varepsilon_c$ [-] at which the bladder collapses; inf where it never does."""
        return self._given(self.state.collapse)

    def force(self, strain: Values) -> Batch:
        """Pulling force, equation (27).

        **Arguments:** `strain`: contraction $\\varepsilon$ [-]; broadcasts against the pressure.

        **Returns:** force $F$ [N], negative where the muscle pushes its ends apart.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(_force, strain)

    def stiffness(self, strain: Values) -> Batch:
        """Stiffness along the axis, from the force's slope.

        **Arguments:** `strain`: contraction $\\varepsilon$ [-]; broadcasts against the pressure.

        **Returns:** $-(\\partial F/\\partial\\varepsilon)/L_0$ [N/m]; at a kink, that of smaller
        strains.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(_stiffness, strain)

    def response(self, strain: Values) -> Response:
        """Force, its components and the region.

        **Arguments:** `strain`: contraction $\\varepsilon$ [-]; broadcasts against the pressure.

        **Returns:** a `Response`: forces [N], region and whether it is the only one [-].

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(_response, strain)

    def deflection(self, strain: Values) -> Batch:
        """How far the axis bows out at the middle.

        **Arguments:** `strain`: $\\varepsilon$ [-]; broadcasts against the pressure.

        **Returns:** $y_{max}$ [m]; after collapse the hinged shape's, with a jump there.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(_deflection, strain)

    def moment(self, strain: Values) -> Batch:
        """Largest bending moment in the bladder.

        **Arguments:** `strain`: $\\varepsilon$ [-]; broadcasts against the pressure.

        **Returns:** $M_b$ [N·m]; after collapse the hinge's.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(_moment, strain)

    def shape(self, strain: Values, points: int = 101) -> Centerline:
        """Centerline between the clamped ends.

        **Arguments:**

        - `strain`: $\\varepsilon$ [-]; broadcasts against the pressure.
        - `points`: how many [-], at least 3.

        **Returns:** a `Centerline`: `.z` and `.y` [m], points on the last axis.

        **Raises:** `ValueError` for concrete values off the domain and for fewer points.
        """
        return self._evaluated(_shape, strain, static=(centerline_points(points),))

    def _evaluated(self, law: Callable, strain: Values, static: tuple = ()) -> Any:
        tension = self.state.law.tension
        eps = strained(strain, tension.bladder.braid.angle, tension.stretch)
        if self._of_jax:
            eps = as_jax(eps)
        points_of(self.pressure, eps)
        return evaluate(law, self, eps, static=static)

    def _given(self, found: Batch) -> Batch:
        """What was `found`, in the library that the pressure came from."""
        return as_jax(found) if self._of_jax else found


def at_pressure(muscle: Muscle, pressure: Batch) -> AtPressure:
    """A `muscle` [-] at a checked `pressure` [Pa]."""
    of_jax = is_jax_array(pressure)
    return AtPressure(pressure, evaluate(_state, muscle, pressure), of_jax)


def _state(muscle: Muscle, pressure: Batch) -> Pressurized:
    return muscle.law.at(pressure)


def _force(at: AtPressure, strain: Batch) -> Batch:
    return at.state.force(strain)[0]


def _stiffness(at: AtPressure, strain: Batch) -> Batch:
    return -at.state.force(strain)[1] / at.state.column.rest_length


def _response(at: AtPressure, strain: Batch) -> Response:
    return at.state.response(strain)


def _deflection(at: AtPressure, strain: Batch) -> Batch:
    return at.state.deflection(strain)


def _moment(at: AtPressure, strain: Batch) -> Batch:
    return at.state.moment(strain)


def _shape(at: AtPressure, strain: Batch, points: int) -> Centerline:
    return at.state.shape(strain, points)
