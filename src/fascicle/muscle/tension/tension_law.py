r"""What a tension law is: a pull in two components, and the strain at which it vanishes.

A law $T(P, \varepsilon)$ gives a muscle's pull in two components, of the pressurized mesh
and of the bladder,

$$T(P, \varepsilon) = F_{mesh}(P, \varepsilon) + F_{bladder}(\varepsilon), \tag{4}$$

and finds the strain at which it vanishes, also where an offset force $C_1(P)$ is taken off, as
the tuning of section 5 does: $T(P, \varepsilon_f) = C_1(P)$. Past the free strain $T$ goes on as
compression: buckling laws say what of it is real.

**Valid for** $0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$.
**Source:** Kim, Mazzoleni and Bryant (2021), section 2.
"""

import abc
from collections.abc import Callable
from typing import ClassVar, NamedTuple

from ...core.array_namespace import cos, maximum, minimum, sqrt
from ...core.roots import root
from ...core.types import Batch, BatchLike
from ...core.validation import HIGHEST_PRESSURE
from ..bladder import Bladder
from ..law import AbstractLaw


Offset = Callable[[Batch], Batch]
SIZES = ("braid_angle", "outer_radius")  # known least well, and what the mesh depends on most


class Pull(NamedTuple):
    """A tensile force in its two components, with their slopes in strain, all [N]."""

    mesh: Batch
    bladder: Batch
    mesh_slope: Batch
    bladder_slope: Batch

    @property
    def force(self) -> Batch:
        """Both together [N]."""
        return self.mesh + self.bladder

    @property
    def slope(self) -> Batch:
        """Its slope in strain [N]."""
        return self.mesh_slope + self.bladder_slope


class AbstractTension(AbstractLaw):
    """A tensile force in two components, and the strain at which it vanishes.

    `conservative`: whether the mesh works as much as the pressure does, $P \\mathrm{d}V$.
    `linear_in_pressure`: whether all of it is, so that it pulls most at an end of any range.
    `stretches`: whether its braid does, so that it says what a braid at `rest` takes up.
    `free`: what a fit of it moves where nobody says what: its constants, the rubber's, or sizes.
    `made_for`: the one muscle that its constants are published for; empty for a law of any muscle.
    `made_diameter` and `made_length`: that muscle's nominal ones [m], where the source says them.
    """

    conservative: ClassVar[bool]
    linear_in_pressure: ClassVar[bool] = False
    stretches: ClassVar[bool] = False
    free: ClassVar[tuple[str, ...]] = ()
    made_for: ClassVar[str] = ""
    made_diameter: ClassVar[float | None] = None
    made_length: ClassVar[float | None] = None

    @classmethod
    def usually_free(cls) -> tuple[str, ...]:
        """Names of what a fit of it moves where nobody says what [-]."""
        own = (one.name for one in cls.constants() if one.transform is not None)
        return cls.free or (*own, *SIZES)

    @abc.abstractmethod
    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-], with slopes."""

    @abc.abstractmethod
    def free_strain(self, bladder: Bladder, pressure: BatchLike, offset: Offset) -> Batch:
        """Strain [-] at which the force equals `offset` of the pressure, $C_1(P)$ [N]."""

    def rest(self, bladder: Bladder, pressure: BatchLike) -> tuple[Batch, Batch]:
        """Co-energy [J] that a braid at rest length takes up at `pressure` [Pa] beyond $P V(0)$,
        and the volume [m³] by which it swells: none, but where it `stretches`.
        """
        none = 0.0 * pressure * bladder.braid.length
        return none, none

    def highest_pressure(self, bladder: Bladder) -> Batch:
        """Pressure [Pa] up to which it says something of a muscle with that `bladder` [-]: the
        domain's end, but where it `stretches`.
        """
        return HIGHEST_PRESSURE + 0.0 * bladder.braid.length

    def components(
        self, bladder: Bladder, pressure: BatchLike, strain: BatchLike
    ) -> tuple[Batch, Batch]:
        """Mesh and bladder force [N] at `pressure` [Pa] and `strain` [-]. Elementwise."""
        pull = self.pull(bladder, pressure, strain)
        return pull.mesh, pull.bladder


def solved_free_strain(
    law: AbstractTension, bladder: Bladder, pressure: BatchLike, offset: Offset
) -> Batch:
    """The first root of $F_{mesh} + F_{bladder} = C_1$ [-], for a `law` with a bladder.

    **Arguments:**

    - `law`: positive below the root [-].
    - `bladder`: inside its braid [-].
    - `pressure`: gauge pressure $P$ [Pa].
    - `offset`: $C_1$ [N] of the pressure.

    **Returns:** $\\varepsilon_f$ [-]; 0 at $P = 0$.
    """
    theta = (law, bladder, pressure, offset(pressure))
    # the fibers would be straight at twice `low`; at `high` the mesh pushes hard
    low, high = 0.5 * (1 - 1 / cos(bladder.braid.angle)), 0.8
    # the parabola that leaves rest as the force does, and meets it where the mesh lets go:
    # its zero comes too early, and Newton's steps from there don't overshoot
    far = bladder.braid.ideal_free_strain
    value, slope = _remaining(theta, 0.0 * pressure)
    bend = (_remaining(theta, far)[0] - value - slope * far) / far**2
    inside = sqrt(maximum(slope**2 - 4 * bend * value, 0.0))
    start = minimum(maximum(-2 * value / (slope - inside), low), high)
    return root(_remaining, theta, low, high, start, soon=4)


def _remaining(theta: tuple, strain: Batch) -> tuple[Batch, Batch]:
    """What is left of the force [N] after $C_1$, and its slope [N]."""
    law, bladder, pressure, c1 = theta
    pull = law.pull(bladder, pressure, strain)
    return pull.force - c1, pull.slope
