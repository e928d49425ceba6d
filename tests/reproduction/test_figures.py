import csv

import numpy as np
import pytest
import xarray

from fascicle.plot import free_strain
from fascicle.results.labelled import Variable
from reproduction.figures import PaperFigure, tables, write_figure


FIGURE = PaperFigure(
    key="figure_99",
    title="Fig. 99. Nothing much",
    conditions=(),
    data={
        "x": Variable(("x",), np.arange(3.0), "m"),
        "y": Variable(("x",), np.arange(3.0) ** 2, "N", "a square", "(1)"),
        "k": Variable((), 2.5, "N/m"),
        "z": Variable(("x", "n"), np.ones((3, 2)), "-"),
        "n": Variable(("n",), [1, 2], "-"),
    },
    draw=lambda: free_strain([0.0, 1e5], {"a": [0.0, 0.1]}),
)


def test_variables_of_like_dimensions_share_a_table():
    found = tables(FIGURE)
    assert {name: list(table) for name, table in found.items()} == {
        "figure_99.csv": ["x", "y"],
        "figure_99_numbers.csv": ["k"],
        "figure_99_by_x_n.csv": ["x", "n", "z"],
    }


def test_every_file_is_written_and_read_back(tmp_path):
    written = write_figure(FIGURE, tmp_path)
    others = [f"figure_99.{kind}" for kind in ("nc", "png", "svg")]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*written.tables, *others])
    assert (tmp_path / "figure_99.svg").read_bytes() == written.svg
    assert written.tables["figure_99.csv"] == (tmp_path / "figure_99.csv").read_bytes()
    assert written.width == pytest.approx(88 / 25.4)
    data = xarray.load_dataset(tmp_path / "figure_99.nc")
    np.testing.assert_array_equal(data["y"], [0, 1, 4])
    assert data["y"].attrs["units"] == "N"
    assert data["y"].attrs["source"] == "(1)"
    text = (tmp_path / "figure_99.csv").read_text(encoding="utf-8")
    rows = list(csv.reader(text.splitlines()))
    assert rows == [["x [m]", "y [N]"], ["0.0", "0.0"], ["1.0", "1.0"], ["2.0", "4.0"]]


def test_the_name_of_a_figure_is_its_number():
    assert FIGURE.name == "Fig. 99"
