"""The reading options of commands become arguments of `records.load`, and errors name options."""

import pytest

from fascicle.cli.errors import UserError
from fascicle.cli.record import Reading, read_record


def reading(**given):
    """Options of reading, with those left out as the command line has them."""
    left_out = dict.fromkeys(Reading._fields)
    return Reading(**left_out | given)


ROWS = "118.4,200.1,0.0\n95.2,200.3,0.1\n70.8,199.9,0.2\n"


def test_options_are_arguments(tmp_path):
    (tmp_path / "171mm.csv").write_text(ROWS)
    options = reading(
        columns="force[N],pressure[kPa],time", zero=["force=8N"], pressure="2bar", rows="2:",
        name_pattern="{length}mm", push_positive=True,
    )  # fmt: skip
    record = read_record([str(tmp_path / "*.csv")], options, 0.18)
    assert record.pressure.tolist() == [2e5, 2e5]
    assert record.force == pytest.approx([8 - 95.2, 8 - 70.8])
    assert record.strain == pytest.approx(0.05)
    assert record.rest_length == 0.18
    assert "record.default_length" in {finding.code for finding in record.findings}


def test_what_is_missing_is_offered_as_an_option(tmp_path):
    (tmp_path / "m.csv").write_text(ROWS)
    for columns, option in (
        (None, "--columns 'force[N]"), ("force,pressure[kPa],length[mm]", "--unit force='N'"),
        ("force[N],pressure[kPa],-", "--constant length='167 mm'"),
    ):  # fmt: skip
        with pytest.raises(UserError) as error:
            read_record([str(tmp_path / "m.csv")], reading(columns=columns), 0.18)
        assert option in str(error.value)


def test_options_that_contradict_each_other(tmp_path):
    for wrong in ({"columns": "force,pressure", "column": ["force=F"]}, {"zero": ["force"]}):
        with pytest.raises(UserError):
            read_record([str(tmp_path / "m.csv")], reading(**wrong))


def test_a_joint_is_read_by_options(tmp_path):
    knee = tmp_path / "knee.csv"
    knee.write_text("P [kPa],angle [deg],torque [Nm]\n200,10,2\n200,40,1\n")
    with pytest.raises(UserError) as error:
        read_record([str(knee)], reading(), 0.18)
    assert "--moment-arm '25 mm'" in str(error.value)
    options = reading(moment_arm="25mm", zero=["angle=10deg"])
    record = read_record([str(knee)], options, 0.18)
    assert record.force == pytest.approx([80, 40])
