"""The library against the oracle: one muscle's every number, on random muscles."""

import dataclasses
import itertools
import math
from functools import cache

import numpy as np
import oracle_force as oracle
import pytest
from from_oracle import ask, ask_bent, library_muscle
from oracle_buckling import elastica
from oracle_muscle import (
    Muscle,
    blocked_force,
    collapse_moment,
    free_strain,
    lowest_strain,
    modulus,
    second_moment,
    volume,
)
from oracle_random import PAIRS, Case, random_cases


HIGHEST = 0.6

# (seed, n, what is fixed): the 400 under each buckling law, tuned ones, and the ideal law;
# few pairs of laws, since every one is compiled anew
DRAWS = {
    "kim2021": (2021, 400, {"buckling": "kim2021"}),
    "elastica": (2021, 400, {"buckling": "elastica", "pairs": PAIRS[:2]}),
    "kim2021-tuned": (42, 100, {"buckling": "kim2021", "tuned": True, "pairs": PAIRS[:1]}),
    "elastica-tuned": (43, 100, {"buckling": "elastica", "tuned": True, "pairs": PAIRS[1:2]}),
    "kim2021-ideal": (44, 60, {"tension": "ideal", "pairs": PAIRS[2:3]}),
    "elastica-ideal": (45, 60, {"tension": "ideal", "buckling": "elastica", "pairs": PAIRS[:1]}),
}


def with_corners(case):
    """The case with strains beside every corner of its force added to the random ones."""
    muscle, P = case.muscle, case.pressure
    corners = [free_strain(muscle, P), oracle.collapse_strain(muscle, P)]
    corners.append(elastica(muscle, P).onset if muscle.buckling == "elastica" else math.inf)
    extra = []
    for corner in corners:
        inside = lowest_strain(muscle) / 2 < corner < HIGHEST - 1e-3
        # where there is no such corner, an ordinary strain keeps the shape
        at = corner if inside else 0.3
        extra += [at - 1e-6, at + 1e-6, at + 1e-3]
    return dataclasses.replace(case, strains=(*case.strains, *extra))


@cache
def _compare(draw):
    seed, n, fixed = DRAWS[draw]
    cases = [with_corners(case) for case in random_cases(seed, n, **fixed)]
    expected = [[oracle.response(c.muscle, c.pressure, e) for e in c.strains] for c in cases]
    return list(zip(cases, expected, ask(cases), strict=True))


@pytest.fixture(scope="module", params=DRAWS)
def compared(request):
    """(case, what the oracle says, what the library says) for a draw."""
    return _compare(request.param)


@pytest.mark.parametrize("component", ["force", "mesh", "bladder", "bending"])
def test_forces(compared, component):
    # the accuracy asked for; the oracle's own roots are good to 1e-10 or better
    worst = []
    for case, expected, got in compared:
        for i, e in enumerate(case.strains):
            scale = abs(expected[i].force) + 1
            error = abs(got[component][i] - getattr(expected[i], component)) / scale
            worst.append((float(error), e, case, expected[i]))
    error, e, case, response = max(worst, key=lambda w: w[0] if math.isfinite(w[0]) else math.inf)
    assert error <= 1e-8, f"{component} off by {error:.2e} at {e}: {case} {response}"


def test_regions(compared):
    for case, expected, got in compared:
        assert list(got["region"]) == [r.region for r in expected], case


def test_free_strain_and_blocked_force(compared):
    for case, _, got in compared:
        # the accuracy asked of every root
        assert abs(got["free_strain"] - free_strain(case.muscle, case.pressure)) <= 1e-12, case
        expected = blocked_force(case.muscle, case.pressure)
        assert abs(got["blocked_force"] - expected) <= 1e-10 * (abs(expected) + 1), case


def test_collapse_moment(compared):
    for case, _, got in compared:
        expected = collapse_moment(case.muscle, case.pressure)
        # a product of a few numbers: rounding alone
        assert abs(got["collapse_moment"] - expected) <= 1e-13 * expected, case


def test_collapse_strain(compared):
    for case, _, got in compared:
        muscle, P = case.muscle, case.pressure
        expected = oracle.collapse_strain(muscle, P)
        if expected > HIGHEST:  # past the domain: only that nothing collapses inside it
            assert got["collapse_strain"] > HIGHEST - 1e-12, case
            continue
        tolerance = 1e-12
        if muscle.buckling == "kim2021" and expected > free_strain(muscle, P):
            # near tangency the root is no better than the moment's rounding over its slope
            h = 1e-5
            low = oracle.kim2021(muscle, P, max(expected - h, free_strain(muscle, P))).moment
            slope = (oracle.kim2021(muscle, P, expected + h).moment - low) / (2 * h)
            tolerance += 1e-14 * collapse_moment(muscle, P) / abs(slope)
        assert abs(got["collapse_strain"] - expected) <= tolerance, (case, expected)


# the tuned draws have every number that these two use
@pytest.mark.parametrize("compared", ["kim2021-tuned", "elastica-tuned"], indirect=True)
def test_moment_and_deflection(compared):
    bent = ask_bent([case for case, _, _ in compared])
    for (case, expected, _), got in zip(compared, bent, strict=True):
        muscle, P = case.muscle, case.pressure
        e_f = free_strain(muscle, P)
        EI_over_length = modulus(muscle) * second_moment(muscle) / (muscle.length * (1 - e_f))
        for i, e in enumerate(case.strains):
            if expected[i].region == oracle.POST_COLLAPSE or e <= e_f:
                continue
            state = oracle.bent(muscle, P, e)
            # both rise with an infinite slope at the onset: m good to 1e-15 gives k to 3e-8
            # there, so the scale is the moment of a tube that is plainly bent
            assert abs(got["moment"][i] - state.moment) <= 1e-7 * EI_over_length, case
            assert abs(got["deflection"][i] - state.deflection) <= 1e-7 * muscle.length, case


def test_volume(compared):
    for case, _, got in compared:
        expected = np.array([volume(case.muscle, e) for e in case.strains])
        # rounding of a difference between the cylinder and its wall
        assert np.abs(got["volume"] - expected).max() <= 1e-13 * np.abs(expected).max(), case


def test_the_draw_visits_every_region(compared):
    seen = {r.region for _, expected, _ in compared for r in expected}
    wanted = {oracle.TENSION, oracle.POST_BUCKLING, oracle.POST_COLLAPSE}
    if compared[0][0].muscle.buckling == "elastica":
        wanted.add(oracle.STRAIGHT)
    assert seen == wanted


@pytest.mark.slow
def test_stubby_muscles_where_elastica_has_several_states():
    """Compared wherever the choice is no question: up to the onset, or with one state."""
    cases, several = [], 0
    for wall, ratio, degrees, P, factor in itertools.product(
        (0.12, 0.25), (4.0, 4.5541, 5.0, 6.0), (18, 22, 24, 27), (0.0, 20e3), (0.6, 1e6)
    ):
        muscle = Muscle(
            length=ratio * 10e-3,
            outer_radius=10e-3,
            wall_thickness=wall * 10e-3,
            braid_angle=math.radians(degrees),
            buckling="elastica",
            collapse_factor=factor,
        )
        strains = np.linspace(free_strain(muscle, P) + 0.003, HIGHEST, 60)
        cases.append(Case(muscle, P, tuple(strains.tolist())))
    for case, got in zip(cases, ask(cases), strict=True):
        curve = elastica(case.muscle, case.pressure)
        for i, e in enumerate(case.strains):
            if e > curve.onset and curve.count(e) > 1:
                several += 1
                continue
            expected = oracle.force(case.muscle, case.pressure, e)
            assert abs(got["force"][i] - expected) <= 1e-8 * (abs(expected) + 1), (case, e)
    assert several > 0


def test_elastica_follows_its_branch_up_to_the_fold():
    """A stubby, steep-fibered muscle whose bent branch folds at .4525, past its onset at .405."""
    muscle = Muscle(
        length=50e-3,
        outer_radius=10e-3,
        wall_thickness=2.5e-3,
        braid_angle=math.radians(24),
        buckling="elastica",
        collapse_factor=1e6,
    )
    curve, strains = elastica(muscle, 20e3), np.array([0.41, 0.43, 0.45, 0.46])
    assert [curve.count(e) > 1 for e in strains] == [True, True, True, False]
    expected = np.array([oracle.force(muscle, 20e3, e) for e in strains])
    found = library_muscle(muscle).force(20e3, strains)
    assert np.abs(found - expected).max() <= 1e-8 * (np.abs(expected).max() + 1)
