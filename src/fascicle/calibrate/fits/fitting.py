"""From a record and a muscle to a fitted muscle: the one call behind `fascicle calibrate`.

Without a choice of parameters this is the paper's tuning: $C_1(P)$ and $C_2(P)$ from
blocked force and free strain, and the factors on what resists (`tuned`). With physical
constants among the parameters all of the readings are fitted directly by the law, clipped
ones as what they are (`problem`).
"""

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import replace

import equinox as eqx
import numpy as np

from ...core.errors import InvalidInputError
from ...core.validation import RANGES
from ...muscle import Muscle
from ...muscle.fitted_length import END_PARAMETERS, with_fitted_length
from ...muscle.tuning import Tuning
from ...records.record import Record
from ..after.buckling import other_buckling_law
from ..after.calibration import Calibration
from ..after.causes import causes, untold
from ..after.discrepancy import from_trends, table, widening
from ..after.remainder import remainder
from ..after.trends import looked
from ..after.warned import warned
from ..data.grid import Grid, trimmed, weighed
from ..data.pulling import strain_of, untuned
from ..data.readings import Readings, smooth_free_strain, tables_of
from ..data.taking import Taken, pulling_of, taken
from ..problem.beginning import STARTS, Prior, Search, begun
from ..problem.joint import joined
from ..problem.parameters import put
from ..problem.residuals import Problem
from ..problem.searching import searched
from ..problem.solving import Solutions
from ..problem.uncertainty import Conclusion
from .candidates import with_laws


_ROWS = 33  # of the tuned muscle's table


def fit(
    record: Record,
    muscle: Muscle,
    parameters: Sequence[str] | None = None,
    priors: Mapping[str, Prior] | None = None,
    *,
    loss: str = "linear",
    weights: str = "uniform",
    starts: int = STARTS,
    seed: int = 0,
    whole: bool = True,
) -> Calibration:
    """Fit a muscle to a record.

    **Arguments:**

    - `record`: what was measured [-].
    - `muscle`: sizes, laws and constants to begin with [-].
    - `parameters`: names of those that are free [-]; left out, the paper's factors. If all
      of them are factors, the tension is corrected by $C_1$, $C_2$ first; else it is
      fitted through its constants.
    - `priors`: what is known of some of them beforehand, by name [-].
    - `loss`: "linear", or against outliers "soft_l1" or "cauchy" [-].
    - `weights`: "uniform", or "level" to let every pressure count the same [-].
    - `starts`: how many places the search begins from [-].
    - `seed`: of the random ones among them [-].
    - `whole`: whether the law past the free strain has a say in what readings say that are
      clipped at zero [-]. If not, and nothing pushed, the tension law alone is fitted, which
      is several times as fast.

    **Returns:** the calibration [-].

    **Raises:** `ValueError` for unknown names, and for fewer readings than parameters.
    """
    search = Search(loss, weights, starts, seed, whole)
    return fitted(taken(record), muscle, parameters, priors, search)


def fitted(
    of: Taken,
    muscle: Muscle,
    parameters: Sequence[str] | None,
    priors: Mapping[str, Prior] | None,
    search: Search,
) -> Calibration:
    """As `fit`, `of` what was taken of a record [-], by a `search` [-]; of no `parameters` [-] the
    muscle as it is, compared with the record.
    """
    if of.pulls and not search.whole:
        of = pulling_of(of)
    muscle = with_laws(muscle, parameters or ())
    if parameters is not None and not parameters:
        # the same compiled function as the others, with nothing free
        problem, readings = begun(of, muscle, search.among[:1] or ("braid_angle",), priors, search)
        problem = replace(problem, free=np.zeros(len(problem.parameters), dtype=bool))
    else:
        problem, readings = begun(of, muscle, parameters, priors, search)
    if readings is not None and not np.any(readings.valid) and _pressed(of.data):
        raise ValueError(_UNREAD)
    problem, solutions, best, end = searched(problem, readings, search)
    if readings is not None:
        weight = weighed(problem.data, search.weights)
        together = joined(problem, readings, best, weight, apart=end.covariance)
        if together is not None:
            problem, readings = together.problem, together.readings
            best, end = together.coordinates, together.end
    return concluded(of, readings, search, problem, solutions, best, end)


def concluded(
    of: Taken,
    readings: Readings | None,
    search: Search,
    problem: Problem,
    solutions: Solutions,
    best: np.ndarray,
    end: Conclusion,
) -> Calibration:
    """A calibration from where its search ended.

    **Arguments:**

    - `of`: what was taken of a record [-].
    - `readings`, `search`: of the fit [-].
    - `problem`: that was solved at last [-].
    - `solutions`: where each start ended [-].
    - `best`: coordinates of all parameters at the minimum [-].
    - `end`: what holds there, as far as noise goes [-].

    **Returns:** the calibration [-].
    """
    data, start, chosen = problem.data, problem.muscle, problem.chosen
    if not np.all(np.isfinite(end.linear.residuals)):
        rule = ": its laws have no number where the search begins"
        raise InvalidInputError("muscle", rule, None, "check sizes and constants")
    left = remainder(problem, end, best, of.gathered.branch, of.gathered.time)
    seen = looked(left)
    trends, inflation = from_trends(problem, end, left, seen), widening(left, seen)
    noise = inflation * (end.covariance - end.from_curves)
    muscle = put(problem.fitted, start, best[chosen])
    if readings is not None and _pressed(data):
        muscle = _with_tables(muscle, readings)
    shape = np.shape(trimmed(data).count)
    fits_ends = not END_PARAMETERS.isdisjoint(one.name for one in problem.fitted)
    made = Calibration(
        muscle=with_fitted_length(muscle, float(muscle.length), fits_ends),
        start=start,
        taken=of,
        method="constants" if readings is None else "tuning",
        problem=replace(problem, noise=np.asarray(end.noise)),
        coordinates=best[chosen],
        covariance=noise + end.from_curves + trends,
        from_curves=end.from_curves,
        from_trends=trends,
        readings=readings,
        conclusion=end,
        force=end.linear.force[: shape[0], : shape[1]],
        free_strain=_free_strain(muscle, readings, data)[: shape[0]],
        solutions=solutions,
        inflation=inflation,
        seen=seen,
        causes=causes(problem, best, left, seen),
        untold=untold(problem, best, left),
        discrepancy=table(problem, left, seen),
        weights=search.weights,
    )
    other = other_buckling_law(made)
    if other is not None:
        # what it explains is not the rubber's or the gauge's
        less = tuple(cause for cause in made.causes if cause.share > other.share)
        made = replace(made, causes=(other, *less))
    return replace(made, warned=warned(made))


_UNREAD = (
    "`record` shows no blocked force and free strain at any pressure: it needs at least two"
    " readings that pull at one pressure, or name constants to fit instead, such as c10, c01."
)


def _free_strain(muscle: Muscle, readings: Readings | None, data: Grid) -> np.ndarray:
    """Free strain [-] of the fitted `muscle` at each level."""
    if readings is not None:
        return smooth_free_strain(muscle, readings)[0]
    P, tuning = np.asarray(data.pressure)[:, 0], muscle.tuning
    seen = np.maximum(P - float(tuning.dead_band), 0.0)
    offset = np.interp(seen, np.asarray(tuning.pressures), np.asarray(tuning.c1))
    return strain_of(untuned(muscle), P, offset)


def _pressed(data: Grid) -> bool:
    """Whether any reading was taken under pressure."""
    return bool(np.max(np.asarray(data.pressure)) > 1.0)


def _with_tables(muscle: Muscle, readings: Readings) -> Muscle:
    """The muscle with $C_1$, $C_2$ at even steps over the measured pressures."""
    P = readings.pressure
    measured = P[readings.valid]
    rows = np.unique(np.concatenate([np.linspace(measured[0], measured[-1], _ROWS), measured]))
    rows = rows[np.concatenate([[True], np.diff(rows) > 1e-9 * rows[-1]])]
    c1, c2 = tables_of(muscle, readings, rows)
    seen = np.maximum(rows - float(muscle.tuning.dead_band), 0.0)
    # below the blocked force's threshold the muscle doesn't pull: the table begins above it
    # and near it C2 is a quotient of two small forces, beyond what any muscle has
    likely = (RANGES["c2"].least < c2) & (c2 < RANGES["c2"].largest)
    good = np.isfinite(c1) & likely & (seen > 0)
    old = muscle.tuning
    with warnings.catch_warnings():
        # a number that was given may be a slip; one that was fitted is told with its interval
        warnings.filterwarnings("ignore", ".* is unusual", UserWarning)
        tuning = Tuning(
            seen[good], c1[good], c2[good],
            youngs_modulus_factor=old.youngs_modulus_factor,
            collapse_moment_factor=old.collapse_moment_factor,
            hinge_stiffness_factor=old.hinge_stiffness_factor,
            hinge_stiffness_slope=old.hinge_stiffness_slope,
            transition_rate=old.transition_rate,
            dead_band=old.dead_band,
        )  # fmt: skip
    return eqx.tree_at(lambda m: m.tuning, muscle, tuning)
