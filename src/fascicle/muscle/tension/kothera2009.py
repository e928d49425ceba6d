r"""A balance of forces with a thinning wall: Kothera et al. (2009).

The braid, pressed outward by $p_b$, pulls with $2 \pi r_0^2 \lambda^2 \cot^2\alpha_0\, p_b$;
the pressure pushes on the bore, $-P \pi r_i^2$; the wall, of Young's modulus $E$, holds
$E(\lambda - 1)$ along the axis and $E(r/r_0 - 1)$ around it. Around it, equilibrium takes
$p_b r = P r_i - \sigma_\theta t$, so that

$$T = P \left(2 \pi r_0^2 \lambda^2 \cot^2\alpha_0 \frac{r_i}{r} - \pi r_i^2\right)
    + E A \frac{\lambda - 1}{\lambda}
    - 2 \pi r_0^2 \lambda^2 \cot^2\alpha_0 \frac{t}{r} E \left(\frac{r}{r_0} - 1\right), \tag{K}$$

where the wall keeps its volume: $r_i^2 = r^2 - A/(\pi\lambda)$, $t = r - r_i$. The first
term is `pressure_term="inner_radius"`, as published. It leaves out that a wall between
fluid and braid is itself under pressure: with it, the term is exactly that of the ideal
law, which virtual work gives too, `pressure_term="ideal"`.

**Sign:** pull and contraction positive; the bladder resists contraction and extension, and
is at ease at rest. **Assumes** a bladder that keeps to the braid. **Valid for**
$0 \le P \le 1$ MPa, $1 - 1/\cos\alpha_0 < \varepsilon \le 0.6$; drawn out so far that the
wall fills the braid ($r^2 \lambda \le A/\pi$) there is no bore, and $r_i = 0$: there the
force has a vertical tangent. **Source:** Kothera, Jangid, Sirohi and Wereley (2009), derived
anew; where it differs is on the theory page.
"""

from typing import ClassVar

import numpy as np

from ...core.array_namespace import sqrt, where
from ...core.parameters import Switch
from ...core.roots import guarded
from ...core.types import Batch, BatchLike
from ..bladder import Bladder
from . import SIZES, AbstractTension, Pull


class Kothera2009(AbstractTension):
    """Braid, bore and thinning wall in equilibrium, equation (K)."""

    name: ClassVar[str] = "kothera2009"
    title: ClassVar[str] = "Kothera"
    source: ClassVar[str] = "Kothera, Jangid, Sirohi and Wereley (2009)"
    linear_in_pressure: ClassVar[bool] = True
    free: ClassVar[tuple[str, ...]] = ("youngs_modulus", *SIZES)

    pressure_term: str = Switch(
        "pressure_term", ("inner_radius", "ideal"), "as published, or as virtual work has it"
    ).field()

    @property
    def conservative(self) -> bool:
        """True with the ideal term, where the mesh works as much as the pressure does."""
        return self.pressure_term == "ideal"

    def pull(self, bladder: Bladder, pressure: BatchLike, strain: BatchLike) -> Pull:
        """Pressure and wall force [N], the first and the other terms of equation (K)."""
        braid, E, A = bladder.braid, bladder.material.youngs_modulus, bladder.area
        lam, r0, cot2, square = 1 - strain, braid.radius, braid.cot2, braid.squared_stretch(strain)
        square_slope = 2 * lam * cot2  # in strain
        bore, bore_slope = _bore(A / (np.pi * r0**2), lam * square, lam * square_slope - square)
        area, area_slope = 2 * np.pi * r0**2 * cot2 * lam**2, -4 * np.pi * r0**2 * cot2 * lam
        stretch = sqrt(square)
        hoop, hoop_slope = stretch - 1, square_slope / (2 * stretch)
        shell, shell_slope = area * (1 - bore), area_slope * (1 - bore) - area * bore_slope  # t/r
        wall = E * A * (lam - 1) / lam - shell * E * hoop
        wall_slope = -E * A / lam**2 - E * (shell_slope * hoop + shell * hoop_slope)
        if self.conservative:
            mesh, mesh_slope = braid.mesh(pressure, strain)
            return Pull(mesh, wall, mesh_slope, wall_slope)
        section = np.pi * r0**2
        mesh = pressure * (area * bore - section * square * bore**2)
        ring_slope = area_slope * bore + area * bore_slope
        bore_area_slope = section * (square_slope * bore**2 + 2 * square * bore * bore_slope)
        return Pull(mesh, wall, pressure * (ring_slope - bore_area_slope), wall_slope)


def _bore(wall: Batch, inside: Batch, slope: Batch) -> tuple[Batch, Batch]:
    """Ratio $r_i/r$ [-] and its slope; `wall`, `inside`: volumes over that in the braid at rest."""
    fraction = 1 - wall / inside
    is_open = fraction > 0
    bore = where(is_open, sqrt(guarded(is_open, fraction)), 0.0)
    return bore, where(is_open, wall * slope / (2 * inside**2 * guarded(is_open, bore)), 0.0)
