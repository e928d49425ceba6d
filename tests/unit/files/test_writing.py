import jax
import jax.numpy as jnp
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fascicle.bundle import Bundle, MotorUnit
from fascicle.files import dumps, example, loads, save
from fascicle.muscle import Muscle, Tuning
from fascicle.muscle.buckling import BUCKLING_LAWS, Kim2021
from fascicle.muscle.collapse import COLLAPSE_LAWS
from fascicle.muscle.materials import MATERIALS, MooneyRivlin
from fascicle.muscle.post_collapse import POST_COLLAPSE_LAWS
from fascicle.muscle.tension import TENSION_LAWS, Kothera2009
from refusing import refuses


def bits(obj):
    """Kinds of laws and the exact values of all parameters."""
    leaves, structure = jax.tree.flatten(obj)
    return structure, [
        (jnp.asarray(x).dtype, x.shape, x.tobytes()) for x in map(jnp.asarray, leaves)
    ]


def floats(low, high):
    return st.floats(low, high, allow_nan=False)


# plain data: muscles are built in the tests, outside of Hypothesis's own bookkeeping
materials = st.sampled_from(sorted(MATERIALS)) | st.fixed_dictionaries(
    {"c10": floats(1e3, 1e6), "c01": floats(1e3, 1e6), "youngs_modulus": floats(1e4, 1e7),
     "poisson_ratio": floats(0, 0.5)}
)  # fmt: skip
rows = st.tuples(floats(1.0, 1e6), floats(-50, 50), floats(0.1, 3))
tables = st.lists(rows, max_size=4, unique_by=lambda row: row[0]).map(sorted)
tunings = st.fixed_dictionaries(
    {"table": tables, "youngs_modulus_factor": floats(0.1, 5),
     "collapse_moment_factor": floats(0.1, 5), "hinge_stiffness_factor": floats(0.1, 5),
     "hinge_stiffness_slope": st.just(0.0) | floats(0, 1e-4),
     "transition_rate": st.none() | floats(1, 500), "dead_band": st.just(0.0) | floats(0, 9e5)}
)  # fmt: skip
tensions = st.sampled_from(sorted(TENSION_LAWS)) | st.one_of(
    st.tuples(st.just("tondu_lopez"), floats(0.5, 2), floats(-0.4, 1), floats(1e3, 1e6)),
    st.tuples(st.just("meller2014"), floats(0.5, 2), floats(0.1, 2)),
    st.tuples(st.just("kothera2009"), st.sampled_from(Kothera2009.switches()[0].options)),
)
muscles = st.fixed_dictionaries(
    {"length": floats(0.05, 0.5), "outer_radius": floats(1e-3, 0.05), "wall": floats(0.05, 0.9),
     "braid_angle": floats(0.1, 0.95), "material": materials,
     "tension": tensions,
     "buckling": st.sampled_from(sorted(BUCKLING_LAWS)),
     "collapse": st.sampled_from(sorted(COLLAPSE_LAWS)), "factor": st.just(1.0) | floats(0.1, 3),
     "post_collapse": st.sampled_from(sorted(POST_COLLAPSE_LAWS)),
     "transition_rate": floats(1, 500), "tuning": st.none() | tunings}
)  # fmt: skip


def build(wall, factor, collapse, material, tuning, tension, **rest):
    if not isinstance(tension, str):
        tension = TENSION_LAWS[tension[0]](*tension[1:])
    if tuning is not None:
        table, factors = tuning["table"], {k: x for k, x in tuning.items() if k != "table"}
        tuning = Tuning(*([row[i] for row in table] for i in range(3)), **factors)
    return Muscle(
        wall_thickness=rest["outer_radius"] * wall,
        material=material if isinstance(material, str) else MooneyRivlin(**material),
        collapse=COLLAPSE_LAWS[collapse](factor),
        tuning=tuning,
        tension=tension,
        **rest,
    )


@pytest.mark.filterwarnings("ignore:.* is unusual")
@settings(max_examples=60, deadline=None)
@given(muscles)
def test_a_muscle_reads_back_bitwise(parameters):
    muscle = build(**parameters)
    assert bits(loads(dumps(muscle))) == bits(muscle)


@pytest.mark.filterwarnings("ignore:.* is unusual")
@settings(max_examples=20, deadline=None)
@given(
    st.lists(muscles, min_size=1, max_size=3),
    st.lists(st.tuples(st.integers(0, 2), st.integers(1, 9)), min_size=1, max_size=4),
    st.none() | floats(1, 1e6),
    st.sampled_from(["orderly", "batch"]),
)
def test_a_bundle_reads_back_bitwise(parameters, units, supply_pressure, scheme):
    # rigid plates want one length
    kinds = [build(**(one | {"length": 0.127})) for one in parameters]
    units = [MotorUnit(kinds[which % len(kinds)], count) for which, count in units]
    bundle = Bundle(units, supply_pressure, scheme)
    assert bits(loads(dumps(bundle))) == bits(bundle)


def test_text_is_as_people_write_it():
    text = dumps(example("kim2021_slenderness_8"))
    for line in (
        'length = "102 mm"',
        'outer_radius = "6.35 mm"',
        'braid_angle = "33 deg"',
        'material = "silicone_kim2021"',
        "transition_rate = 25",
        'slope = "0.87 1/bar"',
    ):
        assert line in text.splitlines()
    assert "tuning" not in dumps(example("kim2021_figure_6"))


def test_refuses_what_a_file_cannot_describe(tmp_path):
    path = tmp_path / "m.toml"
    muscle = Muscle(0.1, 0.01, 0.002, 0.5)

    class Stiffer(Kim2021):
        pass

    for obj, argument in (
        (3, "obj"),
        (MotorUnit(muscle), "obj"),
        (muscle.replace(length=jnp.array([0.1, 0.2])), "length"),
        (muscle.replace(buckling=Stiffer()), "buckling"),
    ):
        with refuses(argument):
            save(obj, path)
    assert list(tmp_path.iterdir()) == []
