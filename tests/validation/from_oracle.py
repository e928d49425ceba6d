"""The oracle's muscles as the library's, one by one or many in one compiled call."""

import dataclasses
from collections import defaultdict

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from oracle_muscle import Tuning

import fascicle as fs
from fascicle.muscle.collapse import COLLAPSE_LAWS


SIZES = ("length", "outer_radius", "wall_thickness", "braid_angle", "transition_rate")
LAWS = ("tension", "buckling", "collapse", "post_collapse")


def library_muscle(muscle):
    """One muscle."""
    tuning = None
    if muscle.tuning != Tuning():
        tuning = fs.Tuning(**dataclasses.asdict(muscle.tuning))
    return fs.Muscle.from_dimensions(
        **{name: getattr(muscle, name) for name in SIZES},
        material=fs.MooneyRivlin(**dataclasses.asdict(muscle.material)),
        tension=muscle.tension,
        buckling=muscle.buckling,
        collapse=COLLAPSE_LAWS[muscle.collapse](factor=muscle.collapse_factor),
        post_collapse=muscle.post_collapse,
        tuning=tuning,
    )


def library_bundle(units, **options):
    """An oracle's bundle, ((muscle, count), ...), as the library's."""
    return fs.Bundle([fs.MotorUnit(library_muscle(m), count=n) for m, n in units], **options)


@eqx.filter_jit
@eqx.filter_vmap
def _forces(muscle, pressure, strains):
    response = muscle.response(pressure, strains)
    return {
        "force": response.force,
        "mesh": response.mesh,
        "bladder": response.bladder,
        "bending": response.bending,
        "region": response.region,
        "volume": muscle.volume(strains),
        "free_strain": muscle.free_strain(pressure),
        "blocked_force": muscle.blocked_force(pressure),
        "collapse_strain": muscle.collapse_strain(pressure),
        "collapse_moment": muscle.collapse_moment(pressure),
    }


@eqx.filter_jit
@eqx.filter_vmap
def _bent(muscle, pressure, strains):
    # apart from the forces: compiling is what takes the time, and few draws ask for these
    return {
        "moment": muscle.moment(pressure, strains),
        "deflection": muscle.deflection(pressure, strains),
    }


def ask(cases, question=_forces):
    """What the library says of each case: a dictionary for each, in order.

    Cases of the same laws go through one batched, compiled call, as one batched muscle.
    """
    groups = defaultdict(list)
    for i, case in enumerate(cases):
        laws = tuple(getattr(case.muscle, name) for name in LAWS)
        groups[laws, len(case.strains), case.muscle.tuning != Tuning()].append(i)
    answers = [{} for _ in cases]
    for members in groups.values():
        muscles = [library_muscle(cases[i].muscle) for i in members]
        out = question(
            jax.tree.map(lambda *x: jnp.stack(x), *muscles),
            jnp.asarray([cases[i].pressure for i in members]),
            jnp.asarray([cases[i].strains for i in members]),
        )
        out = {name: np.asarray(values) for name, values in out.items()}
        for row, i in enumerate(members):
            answers[i] = {name: values[row] for name, values in out.items()}
    return answers


def ask_bent(cases):
    """Moment and deflection of each case."""
    return ask(cases, _bent)
