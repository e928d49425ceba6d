"""One muscle: sizes at rest, a material, a choice of laws, and its forces and shapes.

The physics is in the parts and in the piecewise law that joins them; values are
checked here, once, and the law is evaluated in the array library of its arguments.
`muscle.at(pressure)` solves for free strain and collapse strain, which depend on pressure alone;
forces and shapes at any strain are closed forms from there.

**Sign:** pulling force and contraction positive, gauge pressure. **Valid for**
0 ≤ P ≤ 1 MPa and strains from straight fibers, 1 − 1/cos α₀, to 0.6.
**Source:** Kim, Mazzoleni and Bryant (2021).
"""

from collections.abc import Callable
from functools import cached_property, partial

import numpy as np

from ..core.errors import InvalidInputError
from ..core.module import (
    Module,
    record,
    replace_checked,
    static,
    tree_leaves,
    tree_map,
    with_fields,
)
from ..core.types import Batch, Values
from ..core.validation import (
    HIGHEST_PRESSURE,
    check_interval,
    check_positive,
    check_size,
    check_whole_number,
    is_concrete,
    warn_user,
)
from ..repr_table import with_table_repr
from .bladder import Bladder
from .braid import Braid
from .buckling import BUCKLING_LAWS, AbstractBuckling, Centerline
from .coenergy import conjugate_volume
from .collapse import COLLAPSE_LAWS, AbstractCollapse
from .ends import ENDS_LAWS, AbstractEnds
from .materials import LATEX, AbstractMaterial
from .piecewise import Piecewise, PressurizedMuscle, Response
from .post_collapse import POST_COLLAPSE_LAWS, AbstractPostCollapse
from .printing import muscle_line, muscle_table
from .products import sleeve_angle, thread_sizes
from .table import MuscleTable, tabulate
from .tension import TENSION_LAWS, AbstractTension
from .tuning import TunedTension, Tuning
from .validation import (
    FittedLength,
    check_broadcast,
    check_muscle,
    choose_material,
    choose_tuning,
    fitted_length_mismatch,
    validate_braid_angle,
    validate_point,
    validate_pressure,
    validate_strain,
)


class AtPressure(Module):
    """A muscle at a `pressure` [Pa], from `muscle.at`; `state`: its laws there, unchecked."""

    pressure: Batch
    state: PressurizedMuscle

    @property
    def free_strain(self) -> Batch:
        """Strain $\\varepsilon_f$ [-] at which the force vanishes."""
        return self.state.column.free_strain

    @property
    def onset(self) -> Batch:
        """Strain [-] at which the muscle buckles; inf where it never does."""
        return self.state.onset

    @property
    def collapse_strain(self) -> Batch:
        """Strain $\\varepsilon_c$ [-] at which the bladder collapses; inf where it never does."""
        return self.state.collapse_strain

    def force(self, strain: Values) -> Batch:
        """Pulling force $F$ [N] at `strain` [-], (27); `ValueError` off the domain, as of all."""
        return self.state.pulling_force(self._validate(strain))

    def stiffness(self, strain: Values) -> Batch:
        """Stiffness $\\partial F/\\partial L$ [N/m] at `strain` [-]; at a kink, of smaller ones."""
        return self.state.stiffness(self._validate(strain))

    def response(self, strain: Values) -> Response:
        """Force and its components [N], and the region, at `strain` [-]."""
        return self.state.response(self._validate(strain))

    def deflection(self, strain: Values) -> Batch:
        """Deflection of the axis $y_{max}$ [m] at `strain` [-]; after collapse the hinge's."""
        return self.state.deflection(self._validate(strain))

    def moment(self, strain: Values) -> Batch:
        """Largest bending moment $M_b$ [N·m] at `strain` [-]; after collapse the hinge's."""
        return self.state.moment(self._validate(strain))

    def shape(self, strain: Values, points: int = 101) -> Centerline:
        """Centerline [m] of at least 3 `points` between the clamped ends, at `strain` [-]."""
        count = check_whole_number(points, "points", 3)
        return self.state.shape(self._validate(strain), count)

    def _validate(self, strain: Values) -> Batch:
        eps = validate_strain(strain, self.state.law)
        check_broadcast(self.pressure, eps)
        return eps


@with_table_repr(muscle_table, muscle_line)
class Muscle(Module):
    """A fluidic artificial muscle: its sizes at rest, its material, and its laws.

        Muscle("127 mm", "6.35 mm", "1.6 mm", "33 deg", material="latex", buckling="elastica")

    **Arguments:** numbers in SI units, or text with units.

    - `length`: $L_0$ [m] between the end fittings.
    - `outer_radius`: $r_0$ [m] of the bladder, which is the braid's radius.
    - `wall_thickness`: $t_0$ [m], less than the radius.
    - `braid_angle`: $\\alpha_0$ [rad] from the axis, below 0.9553 (54.7°) to contract.
    - `material`: the bladder's, a name or an object.
    - `tension`, `buckling`, `collapse`, `post_collapse`, `ends`: laws of `fascicle.tension` and so
      on, by name or as objects.
    - `transition_rate`: $\\beta$ [-] of (26).
    - `tuning`: measured corrections; none if left out.

    **Raises:** `ValueError`, one line, for sizes that can't exist and unknown names.
    """

    length: Batch = record(converter=partial(check_size, name="length"))
    outer_radius: Batch = record(converter=partial(check_size, name="outer_radius"))
    wall_thickness: Batch = record(converter=partial(check_size, name="wall_thickness"))
    braid_angle: Batch = record(converter=validate_braid_angle)
    material: AbstractMaterial = record(default=LATEX, converter=choose_material)
    tension: AbstractTension = record(default="klute_hannaford", converter=TENSION_LAWS.choose)
    buckling: AbstractBuckling = record(default="kim2021", converter=BUCKLING_LAWS.choose)
    collapse: AbstractCollapse = record(default="kim2021", converter=COLLAPSE_LAWS.choose)
    post_collapse: AbstractPostCollapse = record(
        default="derived", converter=POST_COLLAPSE_LAWS.choose
    )
    transition_rate: Batch = record(
        default=25.0, converter=partial(check_size, name="transition_rate")
    )
    tuning: Tuning = record(default=None, converter=choose_tuning)
    ends: AbstractEnds = record(default="rigid", converter=ENDS_LAWS.choose)
    fitted_length: FittedLength | None = static(default=None)  # of a calibrated muscle

    def __check_init__(self):
        check_muscle(self)

    @classmethod
    def from_thread(
        cls,
        length: Values,
        thread_length: Values,
        turns: Values,
        wall_thickness: Values,
        **laws: Values,
    ) -> "Muscle":
        """A muscle from the thread of its braid, as Chou and Hannaford describe it.

        **Arguments:**

        - `length`: $L_0$ [m] between the end fittings.
        - `thread_length`: of one thread of the braid [m].
        - `turns`: of a thread around the muscle [-].
        - `wall_thickness`: $t_0$ of the bladder [m].
        - `laws`: material and laws, as of the class.

        **Returns:** the muscle [SI].

        **Raises:** `InvalidInputError` for a thread that is shorter than the muscle.

        ```python
        Muscle.from_thread("264.1 mm", "277.1 mm", 1.5, "1 mm", material="latex")
        ```
        """
        radius, angle = thread_sizes(length, thread_length, turns)
        return cls(length, radius, wall_thickness, angle, **laws)

    @classmethod
    def from_sleeve(
        cls,
        length: Values,
        nominal_diameter: Values,
        nominal_angle: Values,
        tube_diameter: Values,
        wall_thickness: Values,
        **laws: Values,
    ) -> "Muscle":
        """A muscle from a braided sleeve on a tube, as they are sold.

        **Arguments:**

        - `length`: $L_0$ [m] between the end fittings.
        - `nominal_diameter`: of the sleeve [m].
        - `nominal_angle`: of its threads from the axis at that diameter [rad]; measure it.
        - `tube_diameter`: outer diameter of the tube [m].
        - `wall_thickness`: $t_0$ of the tube [m].
        - `laws`: material and laws, as of the class.

        **Returns:** the muscle [SI].

        **Raises:** `InvalidInputError` for a tube that is too thick for the sleeve.

        ```python
        Muscle.from_sleeve("200 mm", "12 mm", "40 deg", "9 mm", "1 mm", material="latex")
        ```
        """
        angle = sleeve_angle(nominal_diameter, nominal_angle, tube_diameter)
        radius = check_positive(tube_diameter, "tube_diameter", "m") / 2
        return cls(length, radius, wall_thickness, angle, **laws)

    def replace(self, **changes: Values) -> "Muscle":
        """A copy with `changes` of arguments, such as `wall_thickness=1e-3` [m]; `ValueError` for
        unknown names and sizes that can't exist.
        """
        changed = replace_checked(self, changes)
        if "length" in changes:
            warn_user(fitted_length_mismatch(changed))
        return changed

    @cached_property
    def braid(self) -> Braid:
        """Braid at rest."""
        return Braid(self.length, self.outer_radius, self.braid_angle)

    @cached_property
    def bladder(self) -> Bladder:
        """Bladder inside the braid."""
        return Bladder(self.braid, self.wall_thickness, self.material)

    @cached_property
    def law(self) -> Piecewise:
        """Force law of the muscle, equation (27): elementwise, without checks."""
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

        **Raises:** `ValueError` for concrete values off the domain, as all methods do.
        """
        P, eps = validate_point(self, pressure, strain)
        return self.law.at(P).pulling_force(eps)

    def response(self, pressure: Values, strain: Values) -> Response:
        """Force and its components [N], the region, and whether other equilibria exist, at
        `pressure` [Pa] and `strain` [-], which broadcast.
        """
        P, eps = validate_point(self, pressure, strain)
        return self.law.at(P).response(eps)

    def stiffness(self, pressure: Values, strain: Values) -> Batch:
        """Stiffness $\\partial F/\\partial L = -(\\partial F/\\partial\\varepsilon)/L_0$ [N/m]
        at `pressure` [Pa] and `strain` [-], which broadcast: positive where a muscle holds a load
        by itself. At free strain, onset and collapse, where it jumps, that of smaller strains.
        """
        P, eps = validate_point(self, pressure, strain)
        return self.law.at(P).stiffness(eps)

    def at(self, pressure: Values) -> AtPressure:
        """The muscle at a `pressure` [Pa], 0 to 1 MPa: free strain, onset and collapse strain [-],
        which are solved for once, and methods of strain.
        """
        P = validate_pressure(self, pressure)
        return AtPressure(P, self.law.at(P))

    def free_strain(self, pressure: Values) -> Batch:
        """Strain $\\varepsilon_f$ [-] of no force at `pressure` [Pa], 0 to 1 MPa."""
        return self.law.free_strain(validate_pressure(self, pressure))

    def blocked_force(self, pressure: Values) -> Batch:
        """Force $F(P, 0)$ [N] at rest length and `pressure` [Pa], 0 to 1 MPa."""
        return self.law.blocked_force(validate_pressure(self, pressure))

    def collapse_strain(self, pressure: Values) -> Batch:
        """Collapse strain $\\varepsilon_c$ [-] at `pressure` [Pa]; inf where it never collapses."""
        return self.law.collapse_strain(validate_pressure(self, pressure))

    def collapse_moment(self, pressure: Values) -> Batch:
        """Collapse moment $M_{collapse}$ [N·m], tuned, at `pressure` [Pa], 0 to 1 MPa."""
        return self.law.collapse_moment(validate_pressure(self, pressure))

    def volume(self, strain: Values) -> Batch:
        """Volume $\\pi r^2 L - V_b$ [m³] of the fluid [R17] at `strain` [-]; its ends unloaded."""
        eps = validate_strain(strain, self.law)
        volume, s = self.braid.volume, self.ends.strain_ratio(self.length)
        swept = (volume(s * eps) - volume(0.0)) / s
        return volume(0.0) + swept - self.bladder.volume

    def conjugate_volume(self, pressure: Values, strain: Values) -> Batch:
        """Volume $V^*$ [m³] that conserves energy with the force, (V2), at `pressure` [Pa] and
        `strain` [-], which broadcast.

        Up to the free strain it is `volume`; past it, less, since the muscle bows. With any other
        volume a cycle makes energy. It jumps where the force does, as `elastica`'s.
        """
        return conjugate_volume(self.law, *validate_point(self, pressure, strain))

    def table(
        self,
        supply_pressure: Values = HIGHEST_PRESSURE,
        strains: tuple[float, float] | None = None,
        shape: tuple[int, int] = (161, 201),
    ) -> MuscleTable:
        """Table of force, conjugate volume and deflection over pressure and strain, (V3), by NumPy.

        **Arguments:**

        - `supply_pressure`: the table's highest pressure [Pa], up to 1 MPa.
        - `strains`: its ends [-]; default: from 0.75 of the strain that straightens the fibers
          to 0.08 past the one at which no pressure pulls. The lower one is lowered by less than
          a step, so that zero strain is a node.
        - `shape`: numbers of nodes in pressure and in strain, at least 3 each.

        **Returns:** the table, which states its error; the muscle keeps it for the next call.

        **Raises:** `ValueError` for impossible ends and shapes, and for rows of muscles.
        """
        if not (self.is_single and is_concrete(self)):
            raise InvalidInputError("muscle", "must be one muscle of numbers", None, shown="arrays")
        top = check_interval(
            supply_pressure, 0.0, HIGHEST_PRESSURE, "supply_pressure", "Pa", closed=(False, True)
        )
        key = "table", float(top), strains, tuple(shape)
        if key not in self.cache:
            self.cache[key] = tabulate(self.law, float(top), strains, shape)
        return self.cache[key]

    def radius(self, strain: Values) -> Batch:
        """Outer radius $r$ [m] of the straight muscle at `strain` [-]."""
        eps = validate_strain(strain, self.law)
        return self.braid.radius_at(self.ends.strain_ratio(self.length) * eps)

    def deflection(self, pressure: Values, strain: Values) -> Batch:
        """Deflection of the axis in the middle $y_{max}$ [m] at `pressure` [Pa] and `strain` [-];
        after collapse the hinged shape's, with a jump there.
        """
        P, eps = validate_point(self, pressure, strain)
        return self.law.at(P).deflection(eps)

    def moment(self, pressure: Values, strain: Values) -> Batch:
        """Largest bending moment $M_b$ [N·m] in the bladder at `pressure` [Pa] and `strain` [-];
        after collapse the hinge's.
        """
        P, eps = validate_point(self, pressure, strain)
        return self.law.at(P).moment(eps)

    def shape(self, pressure: Values, strain: Values, points: int = 101) -> Centerline:
        """Centerline [m] of at least 3 `points` at `pressure` [Pa] and `strain` [-]."""
        count = check_whole_number(points, "points", 3)
        P, eps = validate_point(self, pressure, strain)
        return self.law.at(P).shape(eps, count)

    @cached_property
    def batch_shape(self) -> tuple[int, ...]:
        """Shape of rows of muscles; `()` of one muscle."""
        tables = [self.tuning.pressures, self.tuning.c1, self.tuning.c2]
        bare = with_fields(self.tuning, pressures=None, c1=None, c2=None)
        numbers = tree_leaves(with_fields(self, tuning=bare))
        # a table's last axis is one of rows even in a single muscle
        shapes = [*map(np.shape, numbers), *(np.shape(table)[:-1] for table in tables)]
        return np.broadcast_shapes(*shapes) if any(shapes) else ()

    @property
    def is_single(self) -> bool:
        """True for one muscle, false for rows of muscles."""
        return self.batch_shape == ()


def map_numbers(number: Callable, table: Callable, *muscles: Muscle) -> Muscle:
    """A muscle each of whose numbers is a function `number` of those of `muscles` of one structure;
    `table`: the function for the columns of a tuning's table, whose last axis isn't one of muscles.
    """
    none = dict.fromkeys(("pressures", "c1", "c2"))
    bare = [with_fields(m, tuning=with_fields(m.tuning, **none)) for m in muscles]
    mapped = tree_map(number, *bare)
    columns = {name: table(*(getattr(m.tuning, name) for m in muscles)) for name in none}
    return with_fields(mapped, tuning=with_fields(mapped.tuning, **columns))
