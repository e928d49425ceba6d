"""What is no muscle, material, law, tuning or table is refused with the argument's name."""

import math

import pytest

import fascicle as fs
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.tension import ElasticBraid, Kothera2009, Meller2014, TonduLopez


SIZES = {"length": 0.127, "outer_radius": 6.35e-3, "wall_thickness": 1.6e-3, "braid_angle": 0.576}
SIX = fs.example("kim2021_figure_6")


def muscle(**changed):
    return fs.Muscle(**SIZES | changed)


def rubber(**changed):
    return fs.MooneyRivlin(**{"c10": 1e5, "c01": 1e5} | changed)


def tondu_lopez(**changed):
    return TonduLopez(**{"strain_factor": 1.0, "strain_factor_rise": 0.2} | changed)


def measured(**changed):
    given = {"pressure": 1e5, "free_strain": 0.2, "blocked_force": 5.0}
    return Meller2014.from_measured(SIX.braid, **given | changed)


def tuned(**changed):
    return fs.Tuning(**{"pressures": [1e5], "c1": [1.0], "c2": [1.0]} | changed)


def tuned_in_rows(pressures):
    return fs.Tuning(pressures, [1.0, 2.0], [1.0, 1.0])


CASES = [
    (muscle, "length", [-0.1, math.nan, "127"]),
    (muscle, "outer_radius", [0]),
    (muscle, "wall_thickness", [7e-3, 6.35e-3]),
    (muscle, "braid_angle", [33, math.radians(54.7357), 0.0, "33 mm"]),
    (muscle, "transition_rate", [-25.0]),
    (muscle, "material", ["latx"]),
    (muscle, "buckling", ["euler"]),
    (muscle, "tension", ["hooke"]),
    (muscle, "collapse", ["wood"]),
    (muscle, "post_collapse", ["derive"]),
    (rubber, "c10", [0.0]),
    (rubber, "c01", [-1.0]),
    (rubber, "youngs_modulus", [math.nan]),
    (rubber, "poisson_ratio", [0.6, "half"]),
    (COLLAPSE_LAWS["kim2021"], "factor", [0.0, -1.0, math.nan, "1 bar"]),
    (tondu_lopez, "strain_factor", [0.0]),
    (tondu_lopez, "strain_factor_rise", [-1.0, math.nan]),
    (tondu_lopez, "decay_pressure", [0.0]),
    (Meller2014, "strain_factor", [-1.0]),
    (Meller2014, "force_factor", [math.inf]),
    (measured, "pressure", [0.0]),
    (measured, "free_strain", [0.0]),
    (ElasticBraid, "fiber_stiffness", [-1.0]),
    (lambda count: ElasticBraid.from_fibers(SIX.braid, 150.0, count), "count", [0]),
    (Kothera2009, "pressure_term", ["outer"]),
    (tuned_in_rows, "pressures", [[2e5, 1e5], [1e5]]),
    (tuned, "pressures", [[-1.0]]),
    (tuned, "c1", [[math.nan]]),
    (lambda c1: tuned(pressures=[0.0], c1=c1), "c1", [[1.0]]),
    (tuned, "c2", [[0.0]]),
    (fs.Tuning, "youngs_modulus_factor", [0.0]),
    (fs.Tuning, "collapse_moment_factor", [-1.0]),
    (fs.Tuning, "hinge_stiffness_factor", [math.inf]),
    (fs.Tuning, "hinge_stiffness_slope", [math.nan, -2e-6]),
    (fs.Tuning, "transition_rate", [0.0]),
    (fs.Tuning, "dead_band", [-1.0, 1e6]),
    (SIX.table, "supply_pressure", [-1.0]),
    (lambda strains: SIX.table(4e5, strains), "strains", [(0.1, 0.3)]),
    (lambda shape: SIX.table(4e5, shape=shape), "shape", [(2, 9)]),
]


@pytest.mark.parametrize(
    ("make", "argument", "value"), [(m, name, x) for m, name, values in CASES for x in values]
)
def test_what_cannot_be_is_refused(make, argument, value):
    with pytest.raises(fs.InvalidInputError) as error:
        make(**{argument: value})
    assert error.value.argument == argument
