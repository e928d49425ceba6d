r"""Bundles in series with cords and brackets.

A tendon that is shorter by $c$ than its rest length contracts the bundle by $x$ and stretches cord
and brackets, of the compliance $\kappa$, by $x - c$. Their forces are equal,

$$\kappa F(P, x) = x - c, \qquad
  F(P, x) = \sum_i n_i F_i(P_i, \varepsilon_i(x)),  \tag{J2}$$

a scalar equation for each bundle, which is solved at each step: a force that follows from the
tendon's length alone keeps energy, and is softer than the muscle's, so that it takes no shorter
step. A cord that can go slack doesn't push; then the muscle has its free length, $F(P, x) = 0$.
Both are the root of the lesser of $\kappa F - (x - c)$ and $F$. The pressures of closed chambers,
which depend on $x$, are solved inside (J2).

**Assumes** that muscles, cords and brackets have no mass.
"""

import numpy as np

from ..core.array_namespace import array_namespace, maximum, minimum, where
from ..core.module import Module, static
from ..core.roots import root
from ..core.types import Numbers
from ..dynamics import Plant
from ..dynamics.chamber_pressure import evaluate_chambers, solve_pressures


NEWTON_STEPS = 3  # from the last pressures: a tendon moves farther in a step than by its rate
_SLACK_SCALE = 1e-3  # m/N, of a slack cord's residual: any positive number has the same root


class Series(Module):
    """Cords and brackets of bundles: their `compliance` [m/N], and whether they go `slack`.

    `members`: a row for each bundle, with ones at its units. `rigid`: none stretches or goes slack.
    """

    compliance: Numbers
    members: Numbers
    slack: tuple[bool, ...] = static()
    rigid: bool = static()

    def sum_units(self, values: Numbers) -> Numbers:
        """Sums of units' `values` [SI] over the units of each bundle."""
        return values @ self.members.T

    def contractions(
        self,
        plant: Plant,
        contraction: Numbers,
        pressures: Numbers,
        chambers: Numbers = None,
        start: Numbers = None,
    ) -> Numbers:
        """Contraction of each bundle of a `plant` [m], the root of (J2), searched from `start` [m]
        for a `contraction` of the tendons [m]; `pressures` [Pa]: of all units, constant without
        states of closed `chambers` [SI], else those of the last step.
        """
        if self.rigid:
            return contraction
        members = self.members.astype(bool)
        ends = [plant.distances - plant.lengths * (1 - end) for end in plant.muscles.strains]
        xp = array_namespace(members, *ends)
        low = xp.min(xp.where(members, ends[0], np.inf), axis=-1)
        high = xp.max(xp.where(members, ends[1], -np.inf), axis=-1)
        if start is None:
            start = minimum(maximum(contraction, low), high)
        # the pull is positive where the tables begin, and pushes where they end
        low, high = minimum(contraction, low), maximum(contraction, high)
        theta = (self, plant, contraction, pressures, chambers)
        return root(_residual, theta, low, high, start)


def bundle_strains(plant: Plant, contractions: Numbers) -> Numbers:
    """Strain of each unit's muscles [-] of a `plant` at `contractions` of its bundles [m]."""
    return 1 - (plant.distances - contractions[..., np.array(plant.sides)]) / plant.lengths


def _residual(theta: tuple, contractions: Numbers) -> tuple[Numbers, Numbers]:
    """Residual of (J2) [m] and its slope [-], at `contractions` of the bundles [m]."""
    series, plant, contraction, P, chambers = theta
    eps = bundle_strains(plant, contractions)
    if chambers is None:
        surface = plant.muscles.at(P, eps)
        slope = surface.force_by_strain
    else:
        P = solve_pressures(plant, chambers, eps, P, NEWTON_STEPS)
        fluid = evaluate_chambers(plant, chambers, eps, P)
        surface = fluid.muscles
        # a closed chamber's pressure falls as its muscle contracts
        stiffness = where(fluid.is_folded, fluid.residual.by_pressure, fluid.slope)
        by_strain = -fluid.residual.by_volume * fluid.by_strain / stiffness
        slope = surface.force_by_strain + surface.force_by_pressure * by_strain
    pull = series.sum_units(plant.counts * surface.force)
    slope = series.sum_units(plant.counts * slope / plant.lengths)
    kappa = series.compliance
    taut, free = kappa * pull - (contractions - contraction), _SLACK_SCALE * pull
    is_slack = np.array(series.slack) & (free < taut)
    return where(is_slack, free, taut), where(is_slack, _SLACK_SCALE * slope, kappa * slope - 1.0)
