import json
import resource

import numpy as np
import pytest
import xarray
from numpy.testing import assert_array_equal

from fascicle.results import labelled as results
from fascicle.results.labelled import Variable
from refusing import refuses_at


FORCE = np.array([[1.5, np.nan], [-2.0, 0.1], [3.0, 4.0]])
VARIABLES = {
    "pressure": Variable(("pressure",), np.array([0.0, 1e5, 2e5]), "Pa", "gauge pressure"),
    "strain": Variable(("strain",), np.array([0.0, 0.1]), "-", "contraction"),
    "force": Variable(("pressure", "strain"), FORCE, "N", "pulling force", "a paper, (27)"),
    "region": Variable(("pressure", "strain"), np.array([[0, 1], [0, 2], [0, 0]]), "-"),
    "collapse": Variable(("pressure",), np.array([0.1, np.inf, np.inf]), "-"),
    "parts": Variable(("unit", "pressure"), np.arange(6.0).reshape(2, 3), "N"),
    "other": Variable(("unit", "root"), np.zeros((2, 5)), "-"),
    "scheme": Variable((), np.asarray("orderly"), "-"),
}


def test_json_has_null_for_non_finite_numbers():
    data = json.loads(results.to_json(VARIABLES))
    assert data["force"] == [[1.5, None], [-2.0, 0.1], [3.0, 4.0]]
    assert data["collapse"] == [0.1, None, None]
    assert data["region"] == [[0, 1], [0, 2], [0, 0]]
    assert data["scheme"] == "orderly"
    assert list(data) == list(VARIABLES)


def test_csv_has_a_row_for_each_point():
    rows = [line.split(",") for line in results.to_csv(VARIABLES).splitlines()]
    assert rows[0] == [
        "pressure [Pa]", "strain [-]", "force [N]", "region [-]", "collapse [-]", "parts_1 [N]",
        "parts_2 [N]", "scheme [-]",
    ]  # fmt: skip
    assert rows[1] == ["0.0", "0.0", "1.5", "0", "0.1", "0.0", "3.0", "orderly"]
    assert rows[2] == ["0.0", "0.1", "nan", "1", "0.1", "0.0", "3.0", "orderly"]
    assert rows[6] == ["200000.0", "0.1", "4.0", "0", "inf", "2.0", "5.0", "orderly"]
    assert len(rows) == 7


def test_csv_of_a_transposed_variable():
    turned = VARIABLES | {"turned": Variable(("strain", "pressure"), FORCE.T, "N")}
    rows = [line.split(",") for line in results.to_csv(turned).splitlines()]
    assert [row[-1] for row in rows[1:]] == [row[2] for row in rows[1:]]


def test_datasets_have_unit_meaning_and_source():
    data = results.dataset(VARIABLES, title="a test", source="ourselves")
    assert data["force"].attrs == {
        "units": "N", "long_name": "pulling force", "source": "a paper, (27)",
    }  # fmt: skip
    assert data["strain"].attrs["units"] == "1"
    assert data["region"].attrs["source"] == "ourselves"
    assert set(data.coords) == {"pressure", "strain"}
    assert data.attrs == {"title": "a test", "source": "ourselves"}


def test_written_results_read_back(tmp_path):
    for _ in range(2):  # the second replaces the first
        results.write(VARIABLES, tmp_path / "x.nc", source="ourselves")
        again = xarray.load_dataset(tmp_path / "x.nc")
        for key, variable in VARIABLES.items():
            assert_array_equal(again[key].values, variable.values)
            assert again[key].attrs["units"] == (variable.unit if variable.unit != "-" else "1")
        assert [path.name for path in tmp_path.iterdir()] == ["x.nc"]


def test_refuses_other_endings(tmp_path):
    for name in ("x.xls", "x", "x.nc.txt"):
        with refuses_at(f"{str(tmp_path / name)!r}: "):
            results.write(VARIABLES, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".nc", ".csv", ".json"])
def test_on_a_full_disk_the_former_result_stays(tmp_path, suffix):
    """Stood for by the largest file that the process may write."""
    path = tmp_path / f"x{suffix}"
    table = {"force": Variable(("force",), np.random.default_rng(0).random(100_000), "N")}
    results.write({"force": Variable(("force",), np.arange(3.0), "N")}, path)
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        with refuses_at(f"{path}: "):
            results.write(table, path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == [path.name]
