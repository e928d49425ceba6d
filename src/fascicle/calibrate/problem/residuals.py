"""The least-squares problem: what the data and what is known beforehand say of a muscle.

Coordinates give a muscle and its forces; `misfit` says what readings and priors make of these.
"""

import equinox as eqx
import numpy as np

from ...core.array_namespace import where
from ...core.types import AnyArray, Bool, Float
from ...muscle import Muscle
from ..data.grid import Grid, Table
from ..data.pulling import tension_of
from ..data.readings import tables
from .misfit import Misfit
from .parameters import Parameter, put


Vector = Float[AnyArray, "parameter"]


class Problem(eqx.Module):
    """Data, a muscle to begin with, and which of its constants are free.

    - `weight`: of each reading's residual [-]; 0 leaves it out.
    - `noise`: $\\sigma$ [N] of one reading.
    - `center`, `deviation`: of the prior on each coordinate [-].
    - `rest_length`: that the data's strains refer to [m]; `None`: the muscle's own.
    - `curves`: coefficients of the readings' smooth curves [-], [N], that give $C_1$, $C_2$;
      `None` where the muscle's own tuning holds.
    - `parameters`: constants that may be free [-]: what is compiled knows all of them.
    - `free`: which of them are [-]; the muscle's own value holds for the others. `None`: all.
    - `pulls`: whether the tension law is all that is needed [-], since nothing pushed.
    - `corrects`: whether `curves` hold [-], so that fits with and without them are one
      function; `None`: where there are any.
    """

    muscle: Muscle
    data: Grid
    weight: Table
    noise: Float[AnyArray, ""]
    center: Vector
    deviation: Vector
    rest_length: Float[AnyArray, ""] | None
    curves: Float[AnyArray, "coefficient"] | None
    parameters: tuple[Parameter, ...] = eqx.field(static=True)
    loss: str = eqx.field(static=True, default="linear")
    free: Bool[AnyArray, "parameter"] | None = None
    pulls: bool = eqx.field(static=True, default=False)
    corrects: Bool[AnyArray, ""] | None = None

    @property
    def chosen(self) -> np.ndarray:
        """Places of the parameters that are free [-]."""
        every = np.arange(len(self.parameters))
        return every if self.free is None else every[np.asarray(self.free)]

    @property
    def fitted(self) -> tuple[Parameter, ...]:
        """The parameters that are free [-]."""
        return tuple(self.parameters[i] for i in self.chosen)

    def whole(self, coordinates: np.ndarray) -> np.ndarray:
        """Coordinates [-] of all parameters, from those of the free ones [-], on the last axis."""
        z = np.asarray(coordinates)
        every = np.broadcast_to(np.asarray(self.center), (*z.shape[:-1], self.center.size)).copy()
        every[..., self.chosen] = z
        return every

    def muscle_at(self, coordinates: Vector) -> Muscle:
        """The muscle [-] at these `coordinates` [-]."""
        muscle = put(self.parameters, self.muscle, coordinates, self.free)
        if self.curves is None:
            return muscle
        P = self.data.pressure[:, 0]
        c1, c2 = tables(muscle, self.curves, P)
        own, seen = muscle.tuning, muscle.tuning.effective_pressure(P)
        if self.corrects is not None:
            c1 = where(self.corrects, c1, own.c1_at(seen))
            c2 = where(self.corrects, c2, own.c2_at(seen))
        return eqx.tree_at(
            lambda m: (m.tuning.pressures, m.tuning.c1, m.tuning.c2), muscle, (seen, c1, c2)
        )

    def strain(self, muscle: Muscle) -> Table:
        """The data's strains [-] as contractions of `muscle` [-], which may be shorter than
        the length they were measured on.
        """
        if self.rest_length is None:
            return self.data.strain
        return self.data.strain * (self.rest_length / muscle.length)

    def force(self, coordinates: Vector) -> Table:
        """The model's forces [N] at the readings' places."""
        muscle = self.muscle_at(coordinates)
        law = tension_of(muscle) if self.pulls else muscle
        return law.force(self.data.pressure, self.strain(muscle))

    @property
    def misfit(self) -> Misfit:
        """What the readings and priors say of forces and coordinates [-]."""
        data = self.data
        arrays = (data.force, data.count, data.censored, self.weight, self.noise, self.center,
                  self.deviation)  # fmt: skip
        F, n, clipped, weight, noise, center, deviation = (np.asarray(one) for one in arrays)
        return Misfit(F, n, clipped, weight, noise, center, deviation, self.loss)
