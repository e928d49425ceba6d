import copy
import math
import pickle

import pytest

import fascicle as fs
from fascicle import InvalidInputError, units
from fascicle.files.schema import FileLocation
from refusing import refuses


def error_of(call):
    with pytest.raises(InvalidInputError) as caught:
        call()
    return caught.value


def test_an_error_has_argument_rule_value_and_remedy():
    error = error_of(lambda: fs.Muscle(0.127, 6e-3, 1e-3, math.radians(60)))
    assert error.argument == "braid_angle"
    assert error.value == pytest.approx(60) and "extensor" in error.remedy
    assert isinstance(error, ValueError)
    error = error_of(lambda: fs.Muscle(127.0, 6e-3, 1e-3, 0.5))
    assert (error.argument, error.value, error.remedy) == ("length", 127.0, "check its unit")
    muscle = fs.example("kim2021_figure_6")
    error = error_of(lambda: fs.Bundle([fs.MotorUnit(muscle)], scheme="batsh"))
    assert (error.argument, error.value) == ("scheme", "batsh")
    error = error_of(lambda: units.parse("34.5", "pressure", "supply_pressure"))
    assert (error.argument, error.value) == ("supply_pressure", "34.5")


@pytest.mark.parametrize("duplicate", [copy.copy, lambda x: pickle.loads(pickle.dumps(x))])  # noqa: S301
def test_the_error_of_a_worker_arrives_with_its_fields(duplicate):
    error = InvalidInputError("length", "must be short", 3.0, "cut it", shown="3 m")
    copied = duplicate(error)
    assert str(copied) == str(error) == "`length` must be short, got 3 m: cut it."
    assert vars(copied) == vars(error)


def test_a_file_names_the_key_by_the_field_not_by_the_text():
    location = FileLocation("m.toml", {"muscle": {"length": "1 m"}}, ("muscle",), "muscle")
    with refuses("muscle.length"), location.error_context():
        raise InvalidInputError("length", "is odd", None)
    with refuses("muscle"), location.error_context():
        raise ValueError("`length` is what another library's message begins with.")
