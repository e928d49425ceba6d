import contextlib

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from fascicle.records import load
from fascicle.records.sidecar import Sidecar, read_sidecar
from refusing import refuses_at


TABLE = "A,position [mm],pressure [kPa]\n-50,12.5,100\n0,-17.5,100\n"
WHOLE = """rest_length = "300 mm"
displacement_at_rest = "12.5 mm"
clipped_at_zero = true
synthetic = true
source = "a bench, 2020"
notes = ["of one muscle", "slowly"]
[columns]
force = "A"
[units]
force = "N"
[signs]
force = "pushing positive"
displacement = "extension positive"
"""


@pytest.fixture
def files(tmp_path):
    (tmp_path / "m.csv").write_text(TABLE)

    def with_toml(text, name="m.toml"):
        (tmp_path / name).write_text(text)
        return tmp_path / "m.csv"

    return with_toml


def test_all_of_it(files):
    record = load(files(WHOLE))
    assert_array_equal(record.force, [50, 0])
    # 30 mm of 300 mm; the difference of the positions rounds
    assert_allclose(record.strain, [0, 0.1], rtol=0, atol=1e-16)
    assert_array_equal(record.censored, [False, True])
    assert not np.signbit(record.strain).any() and record.synthetic
    assert {"m.csv: source: a bench, 2020", "m.csv: of one muscle"} <= set(record.notes)


def test_what_is_given_wins(files):
    record = load(files(WHOLE), rest_length=0.6, units={"force": "lbf"}, clipped_at_zero=False)
    assert_allclose(record.force, [50 * 4.4482216152605, 0], rtol=1e-15)
    assert record.rest_length == 0.6
    assert not record.censored.any()


def test_another_file_of_any_name(files, tmp_path):
    path = files(WHOLE, "setup.toml")
    assert load(path, sidecar=tmp_path / "setup.toml").rest_length == 0.3
    for sidecar in (None, tmp_path / "none.toml"):
        with pytest.raises((ValueError, OSError)):
            load(path, sidecar=sidecar)


def test_a_muscles_file_of_the_same_name_is_not_meant(files):
    path = files('format = 1\n[muscle]\nlength = "127 mm"\n')
    record = load(path, columns={"force": "A"}, units={"force": "N"}, rest_length=0.3)
    assert record.rest_length == 0.3


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('rest_lenght = "1 m"', "rest_lenght"), ("rest_length = 300", "rest_length = 300"),
        ('rest_length = "300 N"', "rest_length"), ('rest_length = "-3 mm"', "rest_length"),
        ("clipped_at_zero = 1", "clipped_at_zero"), ("columns = 3", "columns"),
        ("[columns]\nforce = 3", "columns.force"), ('[columns]\nforc = "A"', "columns"),
        ('[signs]\nforce = "pushing"', "signs.force"), ("notes = [1]", "notes[0]"),
        ("a = ", ""), ("a." * 60_000 + "a = 1", ""), ("\0", ""),
    ],
)  # fmt: skip
def test_invalid_sidecars(tmp_path, text, place):
    path = tmp_path / "m.toml"
    path.write_text(text)
    with refuses_at(f"{path}: {place}"):
        read_sidecar(path)


VALUES = ["[1]", '[["a"]]', "{}", "3", "2024-01-01", "{ angle = 1, arm = 2 }", "true", "[]", '""']


@pytest.mark.parametrize("key", Sidecar.model_fields)
def test_values_of_other_kinds_are_refused_in_one_line(files, key):
    for value in VALUES:
        with contextlib.suppress(ValueError):
            load(files(f"{key} = {value}"))
