"""The search of a fit: from wide, then about its best; and the noise that is left."""

from dataclasses import replace

import numpy as np

from ..data.readings import Readings
from .beginning import Search
from .residuals import Problem
from .solving import ROUGH, Solutions, around, joined, scattered, solve
from .uncertainty import Conclusion, conclude


_ROUNDS = 6


def searched(
    problem: Problem, readings: Readings | None, search: Search
) -> tuple[Problem, Solutions, np.ndarray, Conclusion]:
    """A search, then a second one about its best: the last problem, all ends, the best, and what
    holds there.

    Each collapse is a kink in strain, which passes from one reading to the next as its place
    moves: that leaves shallow minima side by side, within the fit's own uncertainty. A record that
    only pulls has none.
    """
    curves = None if readings is None else readings.covariance
    places = places_of(problem, search)
    problem, first, best, end = settled(problem, problem.whole(places), curves)
    if problem.pulls:
        return problem, first, best, end
    near = around(best[problem.chosen], end.covariance, len(places), search.seed)
    # the second takes the noise that the first one left: priors weigh against it
    again = replace(problem, noise=np.asarray(end.noise))
    close = solve(again, again.whole(near), little=ROUGH)
    best = solve(again, close.coordinates[close.best][None]).coordinates[0]
    scale = (float(problem.noise) / end.noise) ** 2
    ends = joined(replace(first, cost=first.cost * scale), close)
    return again, ends, best, conclude(again, best, curves)


def places_of(problem: Problem, search: Search) -> np.ndarray:
    """Where a `search` [-] begins: coordinates of the free parameters of a `problem` [-]."""
    center = np.asarray(problem.center)[problem.chosen]
    places = scattered(center, max(int(search.starts), 1), search.seed)
    if search.near:
        named = zip(problem.fitted, center, strict=True)
        near = np.array([search.near.get(one.name, z) for one, z in named])
        places = np.concatenate([near[None], places])
    return places


def settled(
    problem: Problem, places: np.ndarray, curves: np.ndarray | None
) -> tuple[Problem, Solutions, np.ndarray, Conclusion]:
    """The problem with the noise that its own solution leaves, solved from `places` [-].

    What a clipped reading says depends on the noise, and the noise on the fit; where none is
    clipped, only priors weigh against it, and once is enough.
    """
    # which start leads lowest shows long before each has settled: only that one goes on
    solutions = solve(problem, places, little=ROUGH)
    best = solve(problem, solutions.coordinates[solutions.best][None]).coordinates[0]
    end = conclude(problem, best, curves)
    if curves is not None:
        return problem, solutions, best, end
    for _ in range(_ROUNDS):
        if abs(end.noise / float(problem.noise) - 1) < 1e-3:
            break
        problem = replace(problem, noise=np.asarray(end.noise))
        best = solve(problem, best[None]).coordinates[0]
        end = conclude(problem, best, curves)
    # the others follow with the noise as it is now, to be told as they end
    ends = solve(problem, np.concatenate([solutions.coordinates, best[None]]), little=ROUGH)
    steps = np.append(solutions.steps, 0) + ends.steps
    ends = replace(ends, steps=steps)
    if ends.best < len(places):
        best = solve(problem, ends.coordinates[ends.best][None]).coordinates[0]
        end = conclude(problem, best, curves)
    return problem, ends, best, end
