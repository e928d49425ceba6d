"""The oracle's muscles as the library's, one by one or many in one call."""

import dataclasses
from collections import defaultdict

import jax
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
    return fs.Muscle(
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


def _forces(muscle, pressure, strains):
    law, braid = muscle.law, muscle.braid
    at = law.at(pressure)
    of_pressure = {
        "free_strain": at.column.free_strain,
        "blocked_force": law.tension.force(pressure, 0 * pressure),
        "collapse_strain": at.collapse_strain,
        "collapse_moment": law.collapse_moment(pressure),
    }
    return (
        at.response(strains)._asdict()
        | {name: values[:, 0] for name, values in of_pressure.items()}
        | {"volume": braid.volume(strains) - muscle.bladder.volume}
    )


def _bent(muscle, pressure, strains):
    at = muscle.law.at(pressure)
    return {"moment": at.moment(strains), "deflection": at.deflection(strains)}


def ask(cases, question=_forces):
    """What the library says of each case: a dictionary for each, in order.

    Cases of the same laws go through one call, as rows of one muscle.
    """
    groups = defaultdict(list)
    for i, case in enumerate(cases):
        laws = tuple(getattr(case.muscle, name) for name in LAWS)
        groups[laws, len(case.strains), case.muscle.tuning != Tuning()].append(i)
    answers = [{} for _ in cases]
    for members in groups.values():
        muscles = [library_muscle(cases[i].muscle) for i in members]
        with np.errstate(all="ignore"):  # of branches that aren't taken
            out = question(
                jax.tree.map(lambda *x: np.stack(x)[:, None], *muscles),
                np.array([[cases[i].pressure] for i in members]),
                np.array([cases[i].strains for i in members]),
            )
        for row, i in enumerate(members):
            answers[i] = {name: values[row] for name, values in out.items()}
    return answers


def ask_bent(cases):
    """Moment and deflection of each case."""
    return ask(cases, _bent)
