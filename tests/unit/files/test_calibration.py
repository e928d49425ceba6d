import math
import tomllib

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fascicle.files import dumps, example, load, loads, provenance, save
from fascicle.files.muscle_files import calibration_text
from refusing import refuses


MUSCLE = example("kim2021_figure_6")
PARAMETER = {"name": "c10", "value": 118.4e3}
REPORT = {"data": "a.csv", "rmse": 1.2345678901234567, "parameter": [PARAMETER]}


def read_back(table):
    return tomllib.loads(calibration_text(table))["calibration"]


def shown(value):
    """Its `repr`, in which 1 isn't 1.0 nor -0.0 0.0, whatever the order of keys."""
    if isinstance(value, dict):
        return str(sorted((key, shown(inner)) for key, inner in value.items()))
    return str([shown(inner) for inner in value]) if isinstance(value, list) else repr(value)


def test_provenance_reads_back_what_was_saved(tmp_path):
    path = tmp_path / "m.toml"
    save(MUSCLE, path, REPORT)
    assert provenance(path) == REPORT
    # the muscle is the one that was saved: the report is passed over
    assert load(path) == MUSCLE and "calibration" not in dumps(MUSCLE)
    save(MUSCLE, path)
    assert provenance(path) == {}


texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
numbers = st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False)
plain = texts | numbers | st.booleans()
values = plain | st.recursive(plain, lambda inner: st.lists(inner, max_size=3), max_leaves=6)
tables = st.dictionaries(texts, values, max_size=4)


@settings(max_examples=100, deadline=None)
@given(
    st.dictionaries(texts, values | tables | st.lists(tables, min_size=1, max_size=3), max_size=5)
)
def test_provenance_reads_back(table):
    assert shown(read_back(table)) == shown(table)


def test_arrays_are_lists():
    table = {"a": np.arange(3), "b": jnp.asarray([[0.5, 1.0]]), "c": np.float64(0.1), "d": (1, 2)}
    assert read_back(table) == {"a": [0, 1, 2], "b": [[0.5, 1.0]], "c": 0.1, "d": [1, 2]}
    assert math.isnan(read_back({"a": math.nan})["a"])


@pytest.mark.parametrize("value", [None, object()])
def test_unsupported_values_are_refused(value, tmp_path):
    with pytest.raises(ValueError):  # noqa: PT011 whatever its line
        save(MUSCLE, tmp_path / "m.toml", {"a": value})
    assert list(tmp_path.iterdir()) == []


def test_a_report_that_is_no_table(tmp_path):
    path, text = tmp_path / "m.toml", "calibration = 3\n" + dumps(MUSCLE)
    path.write_text(text)
    for read, file in ((load, path), (provenance, path), (loads, text)):
        with refuses("calibration"):
            read(file)
