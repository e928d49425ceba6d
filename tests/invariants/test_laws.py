"""Every registered law, held to the same physics on random muscles.

Values are NumPy's, slopes JAX's: one compiled function a combination of laws.
"""

from inspect import signature

import attrs
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import fascicle as fs
from fascicle.calibrate.parameters import PARAMETERS
from fascicle.muscle import LAWS
from fascicle.muscle.buckling import BUCKLING_LAWS, Elastica, Kim2021
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS
from fascicle.muscle.tension import ElasticBraid, Kothera2009, Meller2014, TonduLopez
from fascicle.units import DIMENSIONS


N, SLOW = 2000, pytest.mark.slow
# each law at least once with either buckling law
COMBINATIONS = [
    {"buckling": "kim2021", "collapse": "kim2021", "post_collapse": "derived"},
    {"buckling": "kim2021", "collapse": "wood1958", "post_collapse": "consistent", "tuned": True},
    {"buckling": "kim2021", "collapse": "brazier1927", "post_collapse": "printed"},
    {"buckling": "kim2021", "collapse": "stein_hedgepeth1961", "tension": "ideal"},
    {"buckling": "elastica", "collapse": "kim2021", "post_collapse": "derived"},
    {
        "buckling": "elastica",
        "collapse": "wood1958",
        "post_collapse": "printed",
        "tension": "ideal",
    },
    {
        "buckling": "elastica",
        "collapse": "brazier1927",
        "post_collapse": "consistent",
        "tuned": True,
    },
    {"buckling": "elastica", "collapse": "stein_hedgepeth1961"},
    {
        "buckling": "kim2021",
        "collapse": "kim2021",
        "post_collapse": "derived",
        "tension": TonduLopez(1.2, 0.15),
        "tuned": True,
    },
    {"buckling": "elastica", "collapse": "kim2021", "tension": Meller2014(1.15, 0.9)},
    {"buckling": "kim2021", "collapse": "wood1958", "tension": Kothera2009()},
    {
        "buckling": "elastica",
        "collapse": "kim2021",
        "tension": Kothera2009("ideal"),
        "tuned": True,
    },
    {"buckling": Kim2021(0.6), "collapse": "kim2021", "tuned": True},
    {"buckling": Elastica(0.6), "collapse": "wood1958"},
    {"buckling": Kim2021(shear="engesser"), "collapse": "kim2021"},
    {"buckling": Elastica(0.3, "engesser"), "collapse": "wood1958", "tuned": True},
    # fibers that stretch by up to a sixth at 1 MPa
    {"buckling": "kim2021", "collapse": "kim2021", "tension": ElasticBraid(1e8)},
    {"buckling": "elastica", "collapse": "wood1958", "tension": ElasticBraid(2e8), "tuned": True},
]


def changed(law):
    """A law with each of its constants off its default, by a fifth or so."""
    scales = {one.name: one.transform for one in law.constants() if one.transform is not None}
    made = {one.name: one.default for one in law.constants()}
    return law(**made | {k: s.value(s.coordinate(made[k]) + 0.2) for k, s in scales.items()})


# a law that nobody has put among them yet
COMBINATIONS += [
    {"buckling": "kim2021", "collapse": "kim2021", kind: changed(law)}
    for kind, registry in LAWS.items()
    for name, law in registry.items()
    if name not in {getattr(laws.get(kind), "name", laws.get(kind)) for laws in COMBINATIONS}
    and name != next(iter(registry))
    # of one muscle: tests/validation/test_oracle_festo.py
    and not getattr(law, "reference_muscle", "")
]


def named(laws):
    return "-".join(str(getattr(law, "name", law)) for law in laws.values())


def every(test):
    """Of each combination every fourth point of the sample; the slow ones have the whole.

    What holds at each point of a sample holds at these; shares are held to the same bounds, too.
    """
    of_laws = pytest.mark.parametrize("laws", COMBINATIONS, ids=named)
    return of_laws(pytest.mark.parametrize("n", [N // 4, pytest.param(N, marks=SLOW)])(test))


# compiled for each combination: one here, each with its whole sample by the slow ones
SOON = "kim2021-wood1958-consistent-True"
compiled = pytest.mark.parametrize(
    ("laws", "n"),
    [
        *(pytest.param(laws, N // 4, id=named(laws)) for laws in COMBINATIONS
          if named(laws) == SOON),
        *(pytest.param(laws, N, id=f"{named(laws)}-{N}", marks=SLOW) for laws in COMBINATIONS),
    ],
)  # fmt: skip


@pytest.fixture
def drawn(random_muscles, random_points):
    """`drawn(seed, laws, n)`: of N random muscles, pressures and strains `n`, evenly taken."""

    def draw(seed, laws, n=N):
        muscles = random_muscles(seed, N, **laws)
        return jax.tree.map(lambda x: x[:: N // n], (muscles, *random_points(seed + 1, muscles)))

    return draw


def at(muscles, pressure, strain):
    """Response, kinks, moment and collapse moment, of NumPy's."""
    with np.errstate(all="ignore"):  # of branches that aren't taken
        law = muscles.law
        pressurized = law.at(np.asarray(pressure))
        response, moment = pressurized.response(strain), pressurized.moment(strain)
        return response, pressurized.kinks.T, moment, law.collapse_moment(pressure)


@jax.vmap
def _slopes(muscle, pressure, strain):
    force, by = jax.value_and_grad(lambda of: of[0].force(*of[1:]))((muscle, pressure, strain))
    return force, jnp.concatenate([jnp.ravel(leaf) for leaf in jax.tree.leaves(by)])


# compiled as a user's programs are, whatever the tests' other ones are spared
AS_USUAL = {"xla_backend_optimization_level": 3, "xla_cpu_use_fusion_emitters": True}
COMPILED = jax.jit(_slopes), jax.jit(_slopes, compiler_options=AS_USUAL)


def slopes(muscles, pressure, strain):
    """Force and its derivative by pressure, strain and each number in the muscle, in a row.

    Slopes of 1e21 N at the braid's end are finite or not as the compiler orders their terms: the
    elastica's are followed as a user's program has them.
    """
    return COMPILED[muscles.buckling.name == "elastica"](muscles, pressure, strain)


def exempt(laws, pressure):
    """Slopes at zero pressure are infinite for the wrinkled membrane's moment, zero there."""
    return (laws["collapse"] == "stein_hedgepeth1961") & (np.asarray(pressure) == 0)


@pytest.mark.parametrize(
    "law", [law for laws in LAWS.values() for law in laws.values()], ids=lambda law: law.name
)
def test_what_a_law_declares_can_be(law):
    """A default that is usual, a scale that leads back, a name that no other parameter has."""
    assert law.source
    told = {one.name for one in (*law.constants(), *law.switches())}
    assert told == {one.name for one in attrs.fields(law)}  # nothing of it is left untold
    for one in law.constants():
        least, low, high, largest = one.bounds
        assert least <= low <= one.default <= high <= largest
        assert one.dimension in DIMENSIONS and one.about
        if one.transform is None:
            continue
        assert one.name not in PARAMETERS
        for value in (*one.bounds, one.default):
            again = one.transform.value(one.transform.coordinate(value))
            assert_allclose(again, value, rtol=1e-12, atol=1e-12)  # some ulps of exp and log
        assert one.transform.even == (least < 0)


def test_the_first_of_each_kind_is_taken_where_none_is_chosen():
    given = signature(fs.Muscle).parameters
    for kind, laws in LAWS.items():
        assert given[kind].default == next(iter(laws))


def test_every_law_is_here():
    for key, registry in LAWS.items():
        found = [laws.get(key, next(iter(registry))) for laws in COMBINATIONS]
        of_any = {
            name for name, law in registry.items()
            if not getattr(law, "reference_muscle", "") and getattr(law, "collapses", True)
        }  # fmt: skip
        assert {getattr(law, "name", law) for law in found} == of_any


@every
def test_components_make_the_force_and_it_resists(laws, n, drawn):
    muscles, P, eps = drawn(1, laws, n)
    response, kinks, _, _ = at(muscles, P, eps)
    free, onset, collapse = np.asarray(kinks).T
    force = np.asarray(response.force)
    largest = np.maximum(np.abs(response.mesh), np.abs(response.bending)) + 1
    total = response.mesh + response.bladder + response.bending
    assert np.all(np.isfinite(force))
    assert np.all(np.abs(np.asarray(total) - force) <= 1e-14 * largest)
    # a pull up to the free strain, never one past it
    past = eps > free
    assert np.all(force[past] <= 0) and np.all(force[~past] >= 0)
    assert past.sum() > n / 10
    region = np.asarray(response.region)
    assert np.array_equal(region == 0, ~past)
    assert np.array_equal(region == 2, eps > collapse)
    assert np.array_equal((region == 3), past & (eps <= onset))
    assert set(region) >= {0, 1, 2}


@every
def test_force_is_continuous_in_strain(laws, n, drawn):
    muscles, P, eps = drawn(3, laws, n)
    _, kinks, _, _ = at(muscles, P, eps)
    step = 1e-12  # slopes reach 1e6 N per unit strain: 1e-6 N
    for place in (eps, *np.asarray(kinks).T):
        there = np.isfinite(place) & (place <= 0.6 - step)
        where = np.where(there, place, 0.0)
        below, _, _, _ = at(muscles, P, where - step)
        above, _, _, _ = at(muscles, P, where + step)
        force = np.asarray(below.force)
        jump = np.abs(np.asarray(above.force) - force)
        there &= ~exempt(laws, P)  # it collapses at the free strain: the force grows as √x
        # `elastica` snaps where its branch turns back: there are several equilibria
        snaps = np.asarray(below.several | above.several)
        assert np.all(jump[there & ~snaps] < 1e-5 * (np.abs(force[there & ~snaps]) + 1))
        assert snaps.mean() < 0.02


@every
def test_force_is_continuous_in_pressure(laws, n, drawn):
    muscles, P, eps = drawn(5, laws, n)
    step = 1e-6  # Pa; without pressure the membrane's moment rises from zero
    low, before, _, _ = at(muscles, P, eps)
    high, after, _, _ = at(muscles, np.minimum(P + step, 1e6), eps)
    force = np.asarray(low.force)
    jump = np.abs(np.asarray(high.force) - force)
    with np.errstate(invalid="ignore"):
        moved = np.abs(
            np.asarray(after)[:, 2] - np.asarray(before)[:, 2]
        )  # inf − inf: never, on either side
    # where the peak just reaches M_collapse the collapse strain's slope is unbounded
    steady = ~(moved > 1e-8) & ~np.asarray(low.several) & ~exempt(laws, P)
    # from 0 the mesh grows by πr0²·9/tan²α0, below 0.05 N/Pa; the free strain by 1e-6/Pa
    assert np.all(jump[steady] < 1e-6 * (np.abs(force[steady]) + 1))
    assert (
        steady.mean() > 0.85 if laws["collapse"] == "stein_hedgepeth1961" else steady.mean() > 0.98
    )


@every
def test_collapse_comes_where_the_moment_first_arrives(laws, n, drawn):
    muscles, P, eps = drawn(7, laws, n)
    _, kinks, _, limit = at(muscles, P, eps)
    (free, onset, collapse), limit = np.asarray(kinks).T, np.asarray(limit)
    last = np.minimum(collapse, 0.6)
    for share in (0.1, 0.5, 0.9, 0.99, 1 - 1e-9):
        response, _, moment, _ = at(muscles, P, free + share * (last - free))
        # a membrane without pressure has no moment to reach
        single = ~np.asarray(response.several) & (limit > 0)
        # moments are of 1e-4 N·m and more: 1e-15 is rounding
        assert np.all(np.asarray(moment)[single] <= limit[single] * (1 + 1e-8) + 1e-15)
    collapsed = (collapse < 0.6) & (collapse > free)
    assert collapsed.sum() > n / 10
    response, _, moment, _ = at(muscles, P, np.where(collapsed, collapse, 0.0))
    # a branch that folds back at the onset snaps over the moment there; seen from just below,
    # since at the onset itself rounding says whether the straight state counts
    jumped = collapsed & (collapse == onset) & (limit > 0)
    below, _, _, _ = at(muscles, P, np.where(jumped, collapse - 1e-9, 0.0))
    assert np.all(np.asarray(below.several)[jumped]) and jumped.mean() < 0.01
    single = collapsed & ~np.asarray(response.several) & (limit > 0) & ~jumped
    assert_allclose(np.asarray(moment)[single], limit[single], rtol=1e-8)


@every
def test_scaling(laws, n, drawn):
    """All lengths times s at equal pressure: forces times s², strains as they were."""
    if laws.get("tuned") or laws.get("post_collapse") == "printed" or "ends" in laws:
        pytest.skip("C1 is a force of its own; the printed reading has not the units of one; ends")
    muscles, P, eps = drawn(9, laws, n)
    s = 1.7
    lengths = lambda m: (m.length, m.outer_radius, m.wall_thickness)  # noqa: E731
    larger = eqx.tree_at(lengths, muscles, [s * x for x in lengths(muscles)])
    small, kinks, _, _ = at(muscles, P, eps)
    large, kinks_large, _, _ = at(larger, P, eps)
    single = ~np.asarray(small.several)
    # near tangency the collapse strain loses half its digits, and the force after it too
    far = single & np.all(
        np.isclose(kinks, kinks_large, rtol=0, atol=1e-10, equal_nan=True), axis=1
    )
    assert far.mean() > 0.97
    assert_allclose(
        np.asarray(large.force)[far], s**2 * np.asarray(small.force)[far], rtol=1e-6, atol=1e-7
    )


def special_points(laws, n, drawn):
    """Muscles at no, full and other pressures, and strains: kinks, ends and others."""
    muscles, P, eps = drawn(11, laws, n)
    low = np.asarray(1 - 1 / np.cos(muscles.braid_angle))
    rows = np.arange(n)
    P = np.where(rows % 3 == 0, 0.0, np.where(rows % 3 == 1, 1e6, P))
    _, kinks, _, _ = at(muscles, P, eps)
    free, onset, collapse = np.where(np.asarray(kinks) <= 0.6, kinks, 0.3).T
    for place in (eps, np.zeros(n), free, onset, collapse, low * (1 - 1e-6), np.full(n, 0.6)):
        yield muscles, P, place


@compiled
def test_finite_slopes_at_special_points(laws, n, drawn):
    for muscles, P, place in special_points(laws, n, drawn):
        force, row = slopes(muscles, P, place)
        assert np.all(np.isfinite(force))
        assert np.all(np.isfinite(np.asarray(row)[~exempt(laws, P)]))


@compiled
def test_finite_slopes_anywhere(laws, n, drawn):
    muscles, P, eps = drawn(13, laws, n)
    force, row = map(np.asarray, slopes(muscles, P, eps))
    assert np.all(np.isfinite(force)) and np.all(np.isfinite(row[~exempt(laws, P)]))
    # the derivative in strain is the force's: the row ends with it
    step = 1e-6
    inside = (eps < 0.6 - step) & (eps > 0.99 * np.asarray(1 - 1 / np.cos(muscles.braid_angle)))
    where = np.where(inside, eps, 0.0)
    ahead, kinks, _, _ = at(muscles, P, where + step)
    behind, _, _, _ = at(muscles, P, where - step)
    smooth = inside & np.all(np.abs(np.asarray(kinks) - where[:, None]) > 2 * step, axis=1)
    smooth &= ~np.asarray(ahead.several | behind.several)
    measured = (np.asarray(ahead.force) - np.asarray(behind.force)) / (2 * step)
    scale = np.abs(measured) + np.abs(np.asarray(force)) + 1
    assert smooth.mean() > 0.9
    assert np.all(np.abs(np.asarray(row)[:, -1] - measured)[smooth] < 1e-4 * scale[smooth])


@SLOW
@pytest.mark.parametrize("collapse", COLLAPSE_LAWS)
@pytest.mark.parametrize("post_collapse", POST_COLLAPSE_LAWS)
@pytest.mark.parametrize("buckling", BUCKLING_LAWS)
def test_finite_slopes_at_a_hundred_thousand_points(
    buckling, collapse, post_collapse, random_muscles, random_points
):
    """10⁵ for either buckling law, spread over the twelve choices that go with it."""
    laws = {"buckling": buckling, "collapse": collapse, "post_collapse": post_collapse}
    laws["tension"] = "ideal" if post_collapse == "printed" else "klute_hannaford"
    muscles = random_muscles(15, 8400, tuned=post_collapse == "consistent", **laws)
    P, eps = random_points(16, muscles)
    force, row = slopes(muscles, P, eps)
    assert np.all(np.isfinite(force)) and np.all(np.isfinite(np.asarray(row)[~exempt(laws, P)]))


def thrust_and_load(muscles, pressure, strain):
    """Whether a muscle is bent, its push, and the elastica's end load $2 M/y$ [N]."""
    with np.errstate(all="ignore"):  # of branches that aren't taken
        column = muscles.law.at(pressure).column
        state = muscles.buckling.push(column, strain)
        deflection, moment = muscles.buckling.bow(column, strain)
    thrust = -(state.mesh + state.bladder + state.bending)
    load = 2 * moment / np.where(state.straight, 1.0, deflection)
    return ~state.straight, thrust, load


@pytest.mark.parametrize("past", [3e-6, 3e-5, 3e-4])
def test_bent_states_balance_in_a_batch(past, random_muscles, random_points):
    """(E2), just past the onset, where some of a batch were once left unfinished."""
    muscles = random_muscles(3, N, buckling="elastica", tuned=True)
    P, _ = random_points(4, muscles)
    onset = at(muscles, P, 0.0 * P)[1][:, 1]
    strain = np.where(np.isfinite(onset), onset + past, 0.3)
    bent, thrust, load = thrust_and_load(muscles, P, strain)
    assert bent.sum() > N / 2
    # m is known to 1e-16/1e-6 there, a push of 1e3 N and its parts to 1e-12 N
    assert_allclose(thrust[bent], load[bent], rtol=1e-8)


@compiled
def test_numpy_and_jax_give_the_same(laws, n, drawn):
    """One source, at random points and on both sides of every kink."""
    muscles, P, eps = drawn(31, laws, n)
    response, kinks, _, _ = at(muscles, P, eps)
    places = [eps]
    for kink in kinks.T:
        there = np.isfinite(kink) & (kink < 0.6 - 1e-9)
        places += [np.where(there, kink + side, eps) for side in (-1e-9, 1e-9)]
    for strain in places:
        response, _, _, _ = at(muscles, P, strain)
        force, _ = slopes(muscles, P, strain)
        assert isinstance(response.force, np.ndarray) and isinstance(force, jax.Array)
        # rounding of parts that cancel, grown where a root is nearly double
        size = np.abs(response.mesh) + np.abs(response.bladder) + np.abs(response.bending) + 1
        off = np.abs(response.force - np.asarray(force)) / size
        # where a fold or a peak lies within rounding, the two may take either side
        assert np.quantile(off, 0.999) <= 1e-9
        assert np.quantile(off, 0.5) <= 1e-14
