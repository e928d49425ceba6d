import ast
import copy
import math
import pickle
from pathlib import Path

import pytest

import fascicle as fs
from fascicle import InvalidInputError, units
from fascicle.core.errors import InvalidInputError as Base
from fascicle.files.errors import FileLocation


def refused(run):
    with pytest.raises(InvalidInputError) as caught:
        run()
    return caught.value


def test_a_constructor_says_which_argument_breaks_which_rule():
    made = refused(lambda: fs.Muscle.from_dimensions(0.127, 6e-3, 1e-3, math.radians(60)))
    assert (made.argument, made.rule) == ("braid_angle", "must lie in (0, 54.7356) deg to contract")
    assert made.value == pytest.approx(60) and made.remedy == ""
    assert str(made) == "`braid_angle` must lie in (0, 54.7356) deg to contract, got 60 deg."
    assert isinstance(made, ValueError)


def test_what_to_do_is_a_field_of_its_own():
    made = refused(lambda: fs.Muscle.from_dimensions(127.0, 6e-3, 1e-3, 0.5))
    assert (made.argument, made.value, made.remedy) == ("length", 127.0, "check its unit")
    assert str(made) == "`length` must lie in [0.0001, 100] m, got 127 m: check its unit."


def test_an_unknown_name_is_the_value():
    muscle = fs.example("kim2021_figure_6")
    made = refused(lambda: fs.Bundle([fs.MotorUnit(muscle)], scheme="batsh"))
    assert (made.argument, made.value) == ("scheme", "batsh")
    assert made.remedy.startswith("did you mean 'batch'? choose one of ")
    assert str(made) == f"`scheme` 'batsh' is unknown: {made.remedy}."


def test_a_quantity_is_refused_as_it_was_written():
    made = refused(lambda: units.parse("34.5", "pressure", "supply_pressure"))
    assert (made.argument, made.value) == ("supply_pressure", "34.5")
    assert made.rule == 'must be a pressure, such as "34.5 kPa"'
    assert made.remedy == "write it with its unit"
    # a question ends its line
    assert str(refused(lambda: units.parse("3 mbarr", "pressure"))).endswith("did you mean 'mbar'?")


def test_lines_are_one_sentence():
    assert str(Base("a", "must be b", None)) == "`a` must be b."
    assert str(Base("a", ", `b` must be c", 3)) == "`a`, `b` must be c, got 3."
    assert str(Base("a", "must be b", "c", "do d")) == "`a` must be b, got 'c': do d."
    assert str(Base("a", "b", 3, "c", shown="")) == "`a` b: c."


@pytest.mark.parametrize("again", [copy.copy, lambda x: pickle.loads(pickle.dumps(x))])  # noqa: S301
def test_a_workers_refusal_comes_back_whole(again):
    made = InvalidInputError("length", "must be short", 3.0, "cut it", shown="3 m")
    other = again(made)
    assert str(other) == str(made) == "`length` must be short, got 3 m: cut it."
    assert vars(other) == vars(made)


def test_a_file_names_the_key_by_the_field_not_by_the_words():
    place = FileLocation("m.toml", {"muscle": {"length": "1 m"}}, ("muscle",), "muscle")
    named = r"^m.toml: muscle.length = \"1 m\": `length` is odd\.$"
    with pytest.raises(ValueError, match=named), place.error_context():
        raise InvalidInputError("length", "is odd", None)
    with (
        pytest.raises(ValueError, match=r"^m.toml: muscle: `length` is what"),
        place.error_context(),
    ):
        raise ValueError("`length` is what somebody else's words begin with.")


def test_whoever_names_an_argument_says_it_in_a_field():
    found = []
    for path in Path(fs.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "ValueError":
                text = node.args[0] if node.args else None
                text = text.values[0] if isinstance(text, ast.JoinedStr) else text
                if str(getattr(text, "value", "")).startswith("`"):
                    found.append(f"{path.name}:{node.lineno}")
    assert not found


def test_the_former_name_warns():
    with pytest.warns(DeprecationWarning, match="InvalidInputError"):
        former = fs.Refused
    assert former is InvalidInputError
