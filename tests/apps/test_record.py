"""`fascicle record`: a file that says it is synthetic, and refusals."""

import json

import numpy as np
import pytest

from fascicle import records


TEN = "kim2021_slenderness_10"


def test_record_writes_a_labelled_file_that_reads_back(fascicle, tmp_path):
    code, out, err = fascicle(
        "record", TEN, "--out", "d.csv", "-p", "0kPa:200kPa:100kPa", "--samples", "5",
        "--noise", "1%", "--clip", "--seed", "7", "--json",
    )  # fmt: skip
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert found["synthetic"] is True and found["readings"] == 3 * 2 * 5
    assert "synthetic" in (tmp_path / "d.csv").read_text().splitlines()[0]
    record = records.load(tmp_path / "d.csv")
    assert record.synthetic and len(record) == found["readings"]
    assert found["censored"] == record.censored.sum() > 0
    assert found["largest_force"] == record.force.max()
    assert sorted(set(record.pressure)) == [0.0, 100e3, 200e3]
    # the same seed, without the gauge's limit, and over the file that is there
    again = fascicle("record", TEN, "-o", "d.csv", "-p", "0kPa:200kPa:100kPa", "--samples", "5",
                     "--noise", "1%", "--seed", "7", "--force")  # fmt: skip
    assert again[0] == 0 and "synthetic" in again[1]
    np.testing.assert_array_equal(
        np.maximum(records.load(tmp_path / "d.csv").force, 0), record.force
    )


def test_record_keeps_a_file_that_may_be_a_measurement(fascicle, tmp_path):
    (tmp_path / "d.csv").write_text("mine")
    code, out, err = fascicle("record", TEN, "--out", "d.csv")
    assert (code, out) == (2, "") and "--overwrite replaces it" in err
    assert (tmp_path / "d.csv").read_text() == "mine"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([TEN], "Missing option '--out'"),
        (["kim2021_bundle_1_1", "-o", "d.csv"], "a bundle, not a muscle"),
        ([TEN, "-o", "no/d.csv"], "--out no/d.csv: can't be written: no such folder"),
        ([TEN, "-o", "d.csv", "--noise", "-1%"], "--noise must lie in"),
        ([TEN, "-o", "d.csv", "--resolution", "1"], "write it with its unit"),
        ([TEN, "-o", "d.csv", "-p", "0kPa"], "at least one pressure above 0 Pa"),
        ([TEN, "-o", "d.csv", "--samples", "1"], "--samples must be at least 2, got 1."),
        ([TEN, "-o", "d.csv", "--samples", "1000000"], "points are more than"),
        (
            [TEN, "-o", "d.csv", "--angle-scatter", "90deg"],
            "--angle-scatter must lie in [0, 11.46] deg",
        ),
    ],
)
def test_record_refuses_in_one_line(fascicle, tmp_path, arguments, message):
    code, out, err = fascicle("record", *arguments)
    assert (code, out) == (2, "") and err.count("\n") == 1
    assert message in err
    assert not (tmp_path / "d.csv").exists()
