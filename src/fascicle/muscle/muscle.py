"""One muscle: sizes at rest, a material, a choice of laws, and what follows from them.

The physics is in the parts and in the piecewise law that joins them; here values enter,
are checked once, and the law is evaluated, at once or compiled.

**Sign:** pulling force and contraction positive, gauge pressure. **Valid for**
0 ≤ P ≤ 1 MPa and strains from straight fibers, 1 − 1/cos α₀, to 0.6.
**Source:** Kim, Mazzoleni and Bryant (2021).
"""

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..core.array_namespace import is_numpy, map_in_chunks
from ..core.errors import InvalidInputError, require
from ..core.lazy import import_late
from ..core.module import Module, evaluate
from ..core.types import Batch, Values
from ..core.validation import check_choice, check_size, is_concrete, warn_slenderness
from ..repr_table import with_table_repr
from .at import AtPressure, at_pressure
from .bladder import Bladder
from .braid import Braid
from .buckling import AbstractBuckling
from .coenergy import conjugate_volume
from .collapse import AbstractCollapse
from .column import Centerline
from .ends import AbstractEnds
from .entry import (
    active,
    centerline_points,
    checked,
    chosen,
    contracting,
    gauge,
    lowest_of,
    point,
    points_of,
    strained,
    thinner,
    told,
)
from .fitted import replaced
from .laws import law as law_of
from .materials import LATEX, MATERIALS, AbstractMaterial
from .piecewise import Piecewise, Response
from .post_collapse import AbstractPostCollapse
from .printing import line, sheet
from .quantities import (
    batch_of,
    blocked_force_of,
    collapse_moment_of,
    collapse_strain_of,
    deflection_of,
    force_of,
    free_strain_of,
    moment_of,
    radius_of,
    response_of,
    rows_of,
    shape_of,
    stiffness_of,
    volume_of,
)
from .tension import AbstractTension
from .tuning import TunedTension, Tuning


BACKENDS = ("jax", "casadi")  # of a compiled force


@with_table_repr(sheet, line)
class Muscle(Module):
    """A fluidic artificial muscle: its sizes at rest, its material, and its laws."""

    length: Batch
    outer_radius: Batch
    wall_thickness: Batch
    braid_angle: Batch
    material: AbstractMaterial
    tension: AbstractTension
    buckling: AbstractBuckling
    collapse: AbstractCollapse
    post_collapse: AbstractPostCollapse
    transition_rate: Batch
    tuning: Tuning
    ends: AbstractEnds

    def __init__(
        self,
        length: Values,
        outer_radius: Values,
        wall_thickness: Values,
        braid_angle: Values,
        material: str | AbstractMaterial = LATEX,
        tension: str | AbstractTension = "klute_hannaford",
        buckling: str | AbstractBuckling = "kim2021",
        collapse: str | AbstractCollapse = "kim2021",
        post_collapse: str | AbstractPostCollapse = "derived",
        transition_rate: Values = 25.0,
        tuning: Tuning | None = None,
        ends: str | AbstractEnds = "rigid",
    ):
        """**Arguments:** those of `from_dimensions`."""
        self.length = check_size(length, "length")
        self.outer_radius = check_size(outer_radius, "outer_radius")
        self.wall_thickness = check_size(wall_thickness, "wall_thickness")
        self.braid_angle = contracting(braid_angle)
        if is_concrete(self.outer_radius, self.wall_thickness):
            thinner(self.wall_thickness, self.outer_radius)
        warn_slenderness(self.length, self.outer_radius)
        self.material = chosen(material, AbstractMaterial, MATERIALS, "material")
        self.tension = law_of(tension, AbstractTension, "tension")
        self.buckling = law_of(buckling, AbstractBuckling, "buckling")
        self.collapse = law_of(collapse, AbstractCollapse, "collapse")
        self.post_collapse = law_of(post_collapse, AbstractPostCollapse, "post_collapse")
        self.transition_rate = check_size(transition_rate, "transition_rate")
        if not isinstance(tuning, Tuning | None):
            raise InvalidInputError("tuning", "must be a Tuning or None", tuning)
        self.tuning = Tuning() if tuning is None else tuning
        self.ends = law_of(ends, AbstractEnds, "ends")
        active(self.ends, self.length)
        told(self)

    @classmethod
    def from_dimensions(
        cls,
        length: Values,
        outer_radius: Values,
        wall_thickness: Values,
        braid_angle: Values,
        material: str | AbstractMaterial = LATEX,
        tension: str | AbstractTension = "klute_hannaford",
        buckling: str | AbstractBuckling = "kim2021",
        collapse: str | AbstractCollapse = "kim2021",
        post_collapse: str | AbstractPostCollapse = "derived",
        transition_rate: Values = 25.0,
        tuning: Tuning | None = None,
        ends: str | AbstractEnds = "rigid",
    ) -> "Muscle":
        """A muscle from what can be measured on it at rest.

        **Arguments:**

        - `length`: $L_0$ [m] between the end fittings.
        - `outer_radius`: $r_0$ [m] of the bladder, which is the braid's radius.
        - `wall_thickness`: $t_0$ [m], less than the radius.
        - `braid_angle`: $\\alpha_0$ [rad] from the axis, below 0.9553 (54.7°) to contract.
        - `material`: the bladder's, a name or an object [-].
        - `tension`: a law of `fascicle.tension`, by name or as an object [-].
        - `buckling`: a law of `fascicle.buckling` [-].
        - `collapse`: a law of `fascicle.collapse` [-].
        - `post_collapse`: a law of `fascicle.post_collapse` [-].
        - `transition_rate`: $\\beta$ [-] of (26).
        - `tuning`: measured corrections [-]; left out, none.
        - `ends`: a law of `fascicle.ends` [-].

        **Returns:** the muscle [-].

        **Raises:** `ValueError`, one line, for sizes that can't exist and unknown names.
        """
        given = (length, outer_radius, wall_thickness, braid_angle, material, tension, buckling)
        return cls(*given, collapse, post_collapse, transition_rate, tuning, ends)

    def replace(self, **changes: Any) -> "Muscle":
        """The same muscle, but for some of its arguments.

        **Arguments:** `changes`: arguments of the class, such as `wall_thickness=1e-3` [-].

        **Returns:** a new muscle [-]; this one stays as it is.

        **Raises:** `ValueError`, one line, for unknown names and for what a muscle can't be.
        """
        return replaced(self, changes)

    @cached_property
    def braid(self) -> Braid:
        """The braid at rest [-]."""
        return Braid(self.length, self.outer_radius, self.braid_angle)

    @cached_property
    def bladder(self) -> Bladder:
        """The bladder inside it [-]."""
        return Bladder(self.braid, self.wall_thickness, self.material)

    @cached_property
    def law(self) -> Piecewise:
        """Equation (27) for its parts [-]: elementwise, and nothing checked."""
        pull = TunedTension(self.tension, self.bladder, self.tuning, self.ends)
        laws = (self.buckling, self.collapse, self.post_collapse)
        return Piecewise(pull, *laws, self.transition_rate)

    @property
    def slenderness(self) -> Batch:
        """Length over diameter at rest, $L_0/(2 r_0)$ [-] [R15]."""
        return self.length / (2 * self.outer_radius)

    def force(self, pressure: Values, strain: Values) -> Batch:
        """Pulling force, equation (27).

        **Arguments:**

        - `pressure`: gauge pressure $P$ [Pa], 0 to 1 MPa.
        - `strain`: contraction $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** force $F$ [N], negative where the muscle pushes its ends apart.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(force_of, *point(self, pressure, strain))

    def response(self, pressure: Values, strain: Values) -> Response:
        """Force, its components and the region, at a point.

        **Arguments:**

        - `pressure`: gauge pressure $P$ [Pa], 0 to 1 MPa.
        - `strain`: contraction $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** a `Response`: forces [N], region and whether it is the only one [-].

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(response_of, *point(self, pressure, strain))

    def stiffness(self, pressure: Values, strain: Values) -> Batch:
        """Stiffness along the axis, by how much more it pulls a meter longer.

        **Arguments:**

        - `pressure`: gauge pressure $P$ [Pa], 0 to 1 MPa.
        - `strain`: contraction $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** $\\partial F/\\partial L = -(\\partial F/\\partial\\varepsilon)/L_0$ [N/m]:
        positive where the pull falls as the muscle contracts, so that it holds a load by
        itself. At free strain, onset and collapse, where it jumps, that of smaller strains.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return self._evaluated(stiffness_of, *point(self, pressure, strain))

    def at(self, pressure: Values) -> AtPressure:
        """The muscle at a pressure: its roots solved for once, for forces at many strains.

        **Arguments:** `pressure`: $P$ [Pa], 0 to 1 MPa.

        **Returns:** an `AtPressure`: free strain, onset and collapse strain [-], and methods that
        take strains.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        return at_pressure(self, gauge(pressure, self.tuning))

    def free_strain(self, pressure: Values) -> Batch:
        """Strain at which the force vanishes.

        **Arguments:** `pressure`: $P$ [Pa], 0 to 1 MPa.

        **Returns:** $\\varepsilon_f$ [-].
        """
        return self._evaluated(free_strain_of, gauge(pressure, self.tuning))

    def blocked_force(self, pressure: Values) -> Batch:
        """Force at rest length.

        **Arguments:** `pressure`: $P$ [Pa], 0 to 1 MPa.

        **Returns:** $F(P, 0)$ [N].
        """
        return self._evaluated(blocked_force_of, gauge(pressure, self.tuning))

    def collapse_strain(self, pressure: Values) -> Batch:
        """Strain at which the buckled bladder collapses.

        **Arguments:** `pressure`: $P$ [Pa], 0 to 1 MPa.

        **Returns:** $\\varepsilon_c$ [-]; inf where it never collapses.
        """
        return self._evaluated(collapse_strain_of, gauge(pressure, self.tuning))

    def collapse_moment(self, pressure: Values) -> Batch:
        """Moment at which the bladder collapses, with the tuning's factors.

        **Arguments:** `pressure`: $P$ [Pa], 0 to 1 MPa.

        **Returns:** $M_{collapse}$ [N·m].
        """
        return self._evaluated(collapse_moment_of, gauge(pressure, self.tuning))

    def volume(self, strain: Values) -> Batch:
        """Volume of the fluid inside, without the bladder's own [R17]; where ends give, unloaded.

        **Arguments:** `strain`: $\\varepsilon$ [-].

        **Returns:** $\\pi r^2 L - V_b$ [m³].
        """
        return self._evaluated(volume_of, strained(strain, *lowest_of(self)))

    def conjugate_volume(self, pressure: Values, strain: Values) -> Batch:
        """Volume on which the pressure does the work that the ends and the store take, (V2).

        Up to the free strain it is `volume`; past it, less, since the muscle bows. With any other
        a cycle makes energy. Where `elastica`'s force jumps it holds the jump's share.

        **Arguments:**

        - `pressure`: gauge pressure $P$ [Pa], 0 to 1 MPa.
        - `strain`: contraction $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** $V^*$ [m³]. Where the force is continuous, so is it.

        **Raises:** `ValueError` for concrete values off the domain.
        """
        arrays = checked(self, pressure, strain)
        points_of(*arrays, muscles=batch_of(self))
        volume = conjugate_volume(self, *arrays)
        return np.asarray(volume)[()] if self.is_numpy and is_numpy(*arrays) else volume

    def radius(self, strain: Values) -> Batch:
        """Outer radius while straight.

        **Arguments:** `strain`: $\\varepsilon$ [-].

        **Returns:** $r$ [m].
        """
        return self._evaluated(radius_of, strained(strain, *lowest_of(self)))

    def deflection(self, pressure: Values, strain: Values) -> Batch:
        """How far the axis bows out at the middle.

        **Arguments:**

        - `pressure`: $P$ [Pa], 0 to 1 MPa.
        - `strain`: $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** $y_{max}$ [m]; after collapse the hinged shape's, with a jump there.
        """
        return self._evaluated(deflection_of, *checked(self, pressure, strain))

    def moment(self, pressure: Values, strain: Values) -> Batch:
        """Largest bending moment in the bladder.

        **Arguments:**

        - `pressure`: $P$ [Pa], 0 to 1 MPa.
        - `strain`: $\\varepsilon$ [-]; broadcasts against `pressure`.

        **Returns:** $M_b$ [N·m]; after collapse the hinge's.
        """
        return self._evaluated(moment_of, *checked(self, pressure, strain))

    def shape(self, pressure: Values, strain: Values, points: int = 101) -> Centerline:
        """Centerline between the clamped ends.

        **Arguments:**

        - `pressure`: $P$ [Pa], 0 to 1 MPa.
        - `strain`: $\\varepsilon$ [-]; broadcasts against `pressure`.
        - `points`: how many [-], at least 3.

        **Returns:** a `Centerline`: `.z` and `.y` [m], points on the last axis.
        """
        static = (centerline_points(points),)
        return self._evaluated(shape_of, *checked(self, pressure, strain), static=static)

    def plot(
        self, pressures: Values = None, strains: Values = None, components: bool = False
    ) -> Any:
        """Its force over contraction, a curve for each pressure.

        **Arguments:**

        - `pressures`: gauge pressures [Pa]; left out, five up to 400 kPa, or to what was measured.
        - `strains`: contractions [-], rising; left out, to past the largest free strain.
        - `components`: a panel for each of at most four pressures, with the force's parts [-].

        **Returns:** a figure of matplotlib's [-].
        """
        return import_late("plot.objects.of_muscle")(self, pressures, strains, components)

    def compile(self, backend: str = "jax") -> Callable[[Values, Values], Any]:
        """The force alone as a bare function, with this muscle held constant and nothing checked.

        **Arguments:** `backend`: "jax" for arrays, batches and gradients, or "casadi" for single
        points, some 30 µs each, and their slopes (`with_slopes`) [-].

        **Returns:** a function of pressure [Pa] and strain [-] that gives the force [N].

        **Raises:** `ValueError` for an unknown backend, `ImportError` where it is not installed.
        """
        if check_choice(backend, BACKENDS, "backend") == "casadi":
            return import_late("export.point_function.muscle_function")(self)
        require("jax")
        from ..core.jax_backend import jit

        return jit(partial(force_of, self))

    def _evaluated(self, law: Callable, *arrays: Batch, static: tuple = ()) -> Any:
        points_of(*arrays, muscles=() if self._is_single else batch_of(self))
        evaluated = partial(evaluate, law, self, static=static)
        # rows of muscles, and whatever has one argument, are too few to be cut
        if len(arrays) == 2 and self._is_single and not static and is_numpy(*arrays):
            return map_in_chunks(evaluated, *arrays)
        return evaluated(*arrays)

    @cached_property
    def _is_single(self) -> bool:
        """Whether it is one muscle, rather than rows of it [-]."""
        return self.tuning.pressures.ndim == 1 and not rows_of(self)
