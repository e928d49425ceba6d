"""Laws of all kinds together, with random constants: finite, continuous, one by one as many."""

import math
import warnings

import jax
import numpy as np
import pytest

import fascicle as fs
from fascicle.core.errors import InvalidInputError
from fascicle.muscle import LAWS


NEUTRAL = 54.7  # deg, just below where a braid no longer contracts


def drawn(rng, kind):
    """A law of a kind with random constants and choices."""
    names = list(LAWS[kind])
    law = LAWS[kind][names[rng.integers(len(names))]]
    given = {one.name: one.options[rng.integers(len(one.options))] for one in law.switches()}
    for one in law.constants():
        # what one muscle's law is fitted to means nothing elsewhere
        has_reference = bool(getattr(law, "reference_muscle", ""))
        if one.transform is not None and not has_reference and rng.random() < 0.5:
            low, high = one.bounds[1:3]
            # over decades where there are some
            wide = 0 < 10 * low < high
            given[one.name] = low * (high / low) ** rng.random() if wide else rng.uniform(low, high)
    try:
        return law(**given)
    except InvalidInputError:  # each can be, but not all of them together
        return law()


def muscle_of(seed):
    """A muscle of any sizes and laws, and random numbers that go on from there."""
    rng = np.random.default_rng(seed)
    laws = {kind: drawn(rng, kind) for kind in LAWS}
    radius = 10 ** rng.uniform(-3, -1.6)
    length = radius * 10 ** rng.uniform(math.log10(3), 2.2)
    if laws["ends"].name == "compliant":  # hardly more than a third may be held
        held = min(float(laws["ends"].inactive_length), 0.3 * length)
        laws["ends"] = fs.ends.Compliant(held, laws["ends"].end_compliance)
    rows = np.r_[np.sort(rng.uniform(1e4, 9e5, 2)), 1e6]
    tuning = fs.Tuning(
        rows, rng.uniform(0, 3, 3), rng.uniform(0.7, 1.3, 3), dead_band=rng.uniform(0, 5e4)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of stubby ones, and braids that are held
        muscle = fs.Muscle(
            length, radius, radius * rng.uniform(0.05, 0.5),
            math.radians(NEUTRAL if rng.random() < 0.1 else rng.uniform(5, NEUTRAL)),
            fs.MooneyRivlin(*rng.uniform(3e4, 3e5, 2), poisson_ratio=rng.uniform(0.3, 0.5)),
            transition_rate=rng.uniform(5, 120),
            tuning=tuning if rng.random() < 0.4 else None, **laws,
        )  # fmt: skip
    return muscle, rng


def held(seed):
    muscle, rng = muscle_of(seed)
    P = np.array([0.0, 1.0, rng.uniform(0, 1e6), 1e6])[:, None]
    low = 1 - 1 / math.cos(float(muscle.braid_angle))
    if muscle.ends.name == "compliant":  # its bladder is longer than its ends tell
        low = low * (1 - float(muscle.ends.inactive_length / muscle.length))
    strain = np.sort(np.r_[0.9 * low + (0.6 - 0.9 * low) * rng.random(12), 0.0, 0.6 - 1e-9])
    found = muscle.response(P, strain)
    for one in (found.force, muscle.stiffness(P, strain), muscle.moment(P, strain),
                muscle.deflection(P, strain), muscle.free_strain(P)):  # fmt: skip
        assert np.all(np.isfinite(one))
    assert not np.any(np.isnan(muscle.collapse_strain(P)))
    largest = np.max(np.abs(found.force))
    parts = found.mesh + found.bladder + found.bending
    # mesh and bladder may be far larger than what is left of them
    scale = np.max(np.abs(found.mesh)) + np.max(np.abs(found.bladder))
    assert np.max(np.abs(parts - found.force)) < 1e-10 * scale
    one = muscle.force(P[2, 0], strain[5])
    assert abs(one - found.force[2, 5]) < 1e-9 * (largest + scale)

    # slopes by all that the muscle is, without pressure as well
    slopes = jax.jit(jax.grad(lambda of, at: of[0].force(at + of[1], strain[5])))
    for pressure in (0.0, float(P[2, 0])):
        by = slopes((muscle, 0.0), pressure)
        assert all(np.all(np.isfinite(leaf)) for leaf in jax.tree.leaves(by))

    # no jumps but where other states exist; where a muscle collapses at its free strain the printed
    # hinge's force begins as a root of the strain, steeper than any slope allows for
    if muscle.post_collapse.name == "printed":
        return
    near = muscle.response(P, strain + 1e-9)
    steep = 1e-8 * np.abs(muscle.stiffness(P, strain)) * float(muscle.length)
    apart = np.abs(near.force - found.force)
    # a root of the strain begins, too, where a muscle without pressure has no moment of collapse
    root = np.abs(strain - muscle.collapse_strain(P)) < 1e-8
    assert np.all((apart < steep + 1e-7 * largest) | near.several | found.several | root)
    later = muscle.response(P[:3] * (1 + 1e-10) + 1e-9, strain)
    apart = np.abs(later.force - found.force[:3])
    assert np.all((apart < 1e-6 * largest) | later.several | found.several[:3])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_any_laws_go_together(seed):
    held(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 200))
def test_any_laws_go_together_often(seed):
    held(seed)
