import json

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import fascicle as fs
from fascicle.results import Table


MUSCLE = fs.example("kim2021_figure_6")
BUNDLE = fs.Bundle([fs.MotorUnit(MUSCLE, 1), fs.MotorUnit(MUSCLE, 4)], 400e3)
P, STRAIN = [1e5, 3e5], [0.0, 0.1, 0.2]


def every_table():
    found = fs.recruitment.recruit(BUNDLE, np.array([[10.0], [9000.0]]), np.array(STRAIN))
    paths = [fs.energetics.efficiency_map(BUNDLE, path=path) for path in ("isobaric", "isotonic")]
    return {
        "muscle_force": fs.tables.muscle_force(MUSCLE, P, STRAIN),
        "force_comparison": fs.tables.force_comparison(
            {"a": MUSCLE, "b": MUSCLE.replace(buckling="elastica")}, P, STRAIN, 0.15
        ),
        "muscle_table": fs.tables.muscle_table(MUSCLE, P),
        "muscle_free_strain": fs.tables.muscle_free_strain(MUSCLE, P),
        "bundle_force": fs.tables.bundle_force(BUNDLE, [P, [4e5, 4e5]], STRAIN),
        "bundle_equilibria": fs.tables.bundle_equilibria(BUNDLE, [P, [2e3, 4e5]]),
        "space": fs.tables.space(fs.recruitment.workspace(BUNDLE)),
        "recruited": fs.tables.recruited(found, [10.0, 9000.0], STRAIN),
        "efficiency": fs.tables.efficiency(paths),
    }


@pytest.mark.parametrize(("name", "table"), every_table().items())
def test_tables_have_units_in_every_format(name, table, tmp_path):
    data = table.dataset(title=name)
    assert set(data.variables) == set(table) and data.title == name
    for key, variable in table.items():
        assert variable.about, key
        assert np.shape(variable.values) == tuple(data.sizes[dim] for dim in variable.dims)
        assert data[key].attrs["units"] == (variable.unit if variable.unit != "-" else "1")
        assert f"[{variable.unit}]" in repr(table)
    assert set(json.loads(table.to_json())) == set(table)
    assert len(table.to_csv().splitlines()) > 1
    table.write(tmp_path / "table.json")
    assert (tmp_path / "table.json").read_text(encoding="utf-8").strip() == table.to_json()


def test_tables_equal_the_laws():
    tables = every_table()
    assert all(isinstance(table, Table) for table in tables.values())
    force = tables["muscle_force"]["force"].values
    assert_array_equal(force, MUSCLE.force(np.array(P)[:, None], np.array(STRAIN)))
    assert_array_equal(tables["bundle_force"]["force"].values[0], BUNDLE.force(P, np.array(STRAIN)))
    compared = tables["force_comparison"]
    assert_array_equal(compared["force"].values[0], MUSCLE.force(P[0], np.array(STRAIN)))
    assert compared["chosen_force"].values[1] == MUSCLE.replace(buckling="elastica").force(
        P[1], 0.15
    )
    zeros = tables["bundle_equilibria"]
    assert zeros["free_strain"].values[1] == BUNDLE.free_strain([2e3, 4e5])
    count = BUNDLE.equilibria([P, [2e3, 4e5]]).count
    assert_array_equal(np.isfinite(zeros["equilibria"].values).sum(axis=1), count)
    assert_array_equal(tables["recruited"]["status"].values, [[0, 0, 0], [1, 1, 1]])
    paths = tables["efficiency"]
    assert list(paths["path"].values) == ["isobaric", "isotonic"]
    assert 0 < paths["average"].values[1] < 1
    area = tables["space"]["overlap_area"].values
    assert area.shape == (1,) and area[0] > 0
