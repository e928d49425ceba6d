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


def test_a_table_is_written_and_says_how_far_it_is_off(fascicle, tmp_path):
    code, out, err = fascicle("export", "kim2021_bundle_1_4", "--table", "code", "--name", "knee")
    assert (code, err) == (0, "")
    assert out.startswith("wrote code/knee.h and code/knee.c\nHow far it is off the law")
    header = (tmp_path / "code" / "knee.h").read_text()
    assert "#define KNEE_UNITS 2" in header
    # what the command says is what stands in the file
    said = " ".join(out.split("\n", 1)[1].split())
    assert said in " ".join(header.replace(" * ", " ").split())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "nothing to write: give --c or --table and a folder, or --fmu"),
        (("--table", "code", "--precision", "half"), "choose one of double, float"),
        (("--table", "code", "--name", "2"), "must be a name in C"),
        (("--table", "code", "--name", "math"), "must not be a keyword or a standard header of C"),
        (("--table", "code", "--name", "Int"), "must not be a keyword or a standard header of C"),
        (("--c", "code", "--name", "stdio"), "must not be a keyword or a standard header of C"),
        (("--fmu", "a.fmu", "--name", "fmu"), "must not be a keyword or a standard header of C"),
        (("--table", "code", "--c", "./code"), "--c and --table: both would write"),
        (("--fmu", "code"), "its name must end in .fmu"),
        (("--fmu", "a.fmu", "--sample-time", "0 s"), "must be positive"),
        (("--fmu", "a.fmu", "--sample-time", "-1 ms"), "must be positive"),
        (("--fmu", "a.fmu", "--platform", "plan9"), "can't be built here, only"),
    ],
)
def test_what_can_not_be_written_is_refused_in_a_line(fascicle, tmp_path, options, words):
    code, out, err = fascicle("export", "kim2021_figure_6", *options)
    assert code == 2 and words in err and err.count("\n") == 1 and out == ""
    assert not (tmp_path / "code").exists()


def test_a_scenarios_controller_is_written_as_a_step(fascicle, tmp_path):
    from fascicle.files.shipped_files import example_text

    text = example_text("ramp_hand_over")
    (tmp_path / "ramp.toml").write_text(text.replace('"hand_over"  ', '"threshold"'))
    code, _, err = fascicle("export", "ramp.toml", "--table", "code", "--name", "ramp")
    assert (code, err) == (0, "")
    header = (tmp_path / "code" / "ramp.h").read_text()
    assert "int ramp_step(ramp_memory *memory" in header and "sample time is 0.001 s" in header
    code, _, err = fascicle("export", "ramp_hand_over", "--table", "other")
    assert code == 2 and "take orderly or threshold" in err and err.count("\n") == 1
    code, _, err = fascicle("export", "lift_gas", "--c", "other")
    assert code == 2 and "the law is a bundle's: give --table" in err


def test_a_unit_is_written_and_without_a_compiler_its_sources_are(fascicle, tmp_path, monkeypatch):
    import shutil
    import zipfile

    if shutil.which("gcc"):
        code, out, err = fascicle("export", "kim2021_figure_6", "--fmu", "arm.fmu", "--name", "arm")
        assert (code, out, err) == (0, "wrote arm.fmu\n", "")
    monkeypatch.setattr(shutil, "which", lambda _: None)
    code, _, err = fascicle("export", "kim2021_figure_6", "--fmu", "bare.fmu", "--name", "arm")
    assert code == 2 and "no C compiler here" in err and "holds sources only" in err
    assert "sources/arm.c" in zipfile.ZipFile(tmp_path / "bare.fmu").namelist()
