"""`fascicle export`."""

import pytest


def test_c_is_written_and_what_was_edited_is_kept(fascicle, tmp_path):
    pytest.importorskip("casadi", reason="C is written by CasADi, which isn't here")
    code, out, err = fascicle("export", "kim2021_figure_6", "--c", "code", "--name", "arm")
    assert (code, out, err) == (0, "wrote code/arm.h and code/arm.c\n", "")
    header = (tmp_path / "code" / "arm.h").read_text()
    assert "int arm_force(double pressure, double strain, double *force" in header
    (tmp_path / "code" / "arm.h").write_text(header + "/* mine */\n")
    code, _, err = fascicle("export", "kim2021_figure_6", "--c", "code", "--name", "arm")
    assert code == 2 and "code/arm.h" in err and "--force" in err
    assert "mine" in (tmp_path / "code" / "arm.h").read_text()


def test_a_name_that_c_can_not_have_is_refused(fascicle, tmp_path):
    pytest.importorskip("casadi", reason="C is written by CasADi, which isn't here")
    code, _, err = fascicle("export", "kim2021_figure_6", "--c", "code", "--name", "../arm")
    assert code == 2 and "must be a name in C" in err
    assert not (tmp_path / "code").exists()
