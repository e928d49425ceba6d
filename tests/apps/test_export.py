"""`fascicle export`."""


def test_a_table_is_written_and_says_how_far_it_is_off(fascicle, tmp_path):
    code, out, err = fascicle("export", "kim2021_bundle_1_4", "--table", "code", "--name", "knee")
    assert (code, err) == (0, "")
    assert out.startswith("wrote code/knee.h and code/knee.c\nError of the table")
    header = (tmp_path / "code" / "knee.h").read_text()
    assert "#define KNEE_UNITS 2" in header
    # what the command says is what stands in the file
    said = " ".join(out.split("\n", 1)[1].split())
    assert said in " ".join(header.replace(" * ", " ").split())


def test_a_joints_table_has_its_inverse(fascicle, refused, tmp_path):
    arm = "export kim2021_figure_6 --moment-arm 30mm"
    code, _, err = fascicle(*arm.split(), "--strain", "0.1", "--table", "code", "--name", "knee")
    assert (code, err) == (0, "")
    header = (tmp_path / "code" / "knee.h").read_text()
    assert "int knee_pressures(double angle, double torque, double stiffness" in header
    other = "kim2021_bundle_1_4"
    code, *_ = fascicle(*arm.split(), "--antagonist", other, "--table", "unlike", "--name", "knee")
    assert code == 0
    assert header != (tmp_path / "unlike" / "knee.h").read_text()
    refused(f"{arm} --fmu knee.fmu")
    refused(f"export kim2021_figure_6 --table more --antagonist {other}")
    refused("export ramp_hand_over --table more --moment-arm 30mm")
    refused("export kim2021_figure_6 --table more --moment-arm 30kg")


def test_a_scenarios_controller_is_written_as_a_step(fascicle, tmp_path):
    from fascicle.files import example_text

    (tmp_path / "ramp.toml").write_text(example_text("ramp_hand_over"))
    code, _, err = fascicle("export", "ramp.toml", "--table", "code", "--name", "ramp")
    assert (code, err) == (0, "")
    header = (tmp_path / "code" / "ramp.h").read_text()
    assert "int ramp_step(ramp_memory *memory" in header and "sample time is 0.001 s" in header


def test_a_unit_is_written_and_without_a_compiler_its_sources_are(fascicle, tmp_path, monkeypatch):
    import shutil
    import zipfile

    if shutil.which("gcc"):
        code, out, err = fascicle("export", "kim2021_figure_6", "--fmu", "arm.fmu", "--name", "arm")
        assert (code, out, err) == (0, "wrote arm.fmu\n", "")
    monkeypatch.setattr(shutil, "which", lambda _: None)
    code, _, err = fascicle("export", "kim2021_figure_6", "--fmu", "bare.fmu", "--name", "arm")
    assert code == 2 and err
    assert "sources/arm.c" in zipfile.ZipFile(tmp_path / "bare.fmu").namelist()


def test_a_scenarios_plant_is_written_as_a_unit(fascicle, refused):
    import shutil

    if shutil.which("gcc"):
        line = ("export", "ramp_pulses", "--fmu", "plant.fmu", "--plant", "--name", "bench")
        assert fascicle(*line) == (0, "wrote plant.fmu\n", "")
    refused("export ramp_pulses --table code --plant")
    refused("export kim2021_figure_6 --fmu a.fmu --plant")
    refused("export supply_runs_dry --fmu a.fmu --plant")


def test_values_of_a_table_are_the_laws(fascicle, refused, tmp_path):
    import numpy as np
    import pandas as pd

    import fascicle as fs

    line = ("export", "kim2021_figure_6", "--values", "arm.csv", "-p", "0kPa:400kPa:40kPa")
    assert fascicle(*line) == (0, "wrote arm.csv\n", "")
    P, strain, force, volume, _ = pd.read_csv(tmp_path / "arm.csv").to_numpy().T
    muscle = fs.example("kim2021_figure_6")
    error = muscle.table(400e3).errors[2]
    assert len(P) == 11 * 101 and np.all(np.abs(force - muscle.force(P, strain)) <= error)
    before = strain < muscle.free_strain(P)
    np.testing.assert_allclose(volume[before], muscle.volume(strain[before]), rtol=1e-4)
    refused("export kim2021_figure_6 --values arm.nc")
    refused("export kim2021_bundle_1_4 --values arm.nc -p 1bar")


def test_opensims_element_has_the_force_of_the_ideal_braid(fascicle, refused, tmp_path):
    import math
    import re

    import fascicle as fs

    line = ("export", "kim2021_figure_6", "--opensim", "arm.xml", "-p", "400kPa", "--name", "arm")
    assert fascicle(*line) == (0, "wrote arm.xml\n", "")
    text = (tmp_path / "arm.xml").read_text()
    assert '<McKibbenActuator name="arm">' in text
    n, b = (
        float(re.search(rf"<{name}>(.*)</{name}>", text)[1])
        for name in ("number_of_turns", "thread_length")
    )
    ideal = fs.example("kim2021_figure_6").replace(tension="ideal")
    # OpenSim's formula at its length; the bladder is what the element leaves out
    for strain in (0.0, 0.1):
        force = 2e5 / (4 * math.pi * n**2) * (3 * (0.127 * (1 - strain)) ** 2 - b**2)
        assert abs(force - float(ideal.response(2e5, strain).mesh)) < 1e-9
    refused("export kim2021_figure_6 --opensim other.xml")


def test_a_function_block_is_written_for_a_plc(fascicle, refused, tmp_path):
    line = ("export", "kim2021_figure_6", "--structured-text", "arm.st", "-p", "4bar")
    assert fascicle(*line, "--precision", "float", "--name", "arm") == (0, "wrote arm.st\n", "")
    text = (tmp_path / "arm.st").read_text()
    assert "FUNCTION_BLOCK FB_arm\n" in text and "TOP : REAL := 4.0e+05;" in text
    refused("export kim2021_figure_6 --structured-text arm.txt")
    refused("export kim2021_bundle_1_4 --structured-text knee.st")


def test_a_page_is_written_once(fascicle, refused, tmp_path):
    code, out, err = fascicle("export", "kim2021_figure_6", "--page", "arm.html", "-p", "1bar,2bar")
    assert (code, out, err) == (0, "wrote arm.html\n", "")
    text = (tmp_path / "arm.html").read_text()
    assert "<h1>kim2021_figure_6</h1>" in text and 'value="100, 200"' in text
    assert "arm.html" in refused("export kim2021_figure_6 --page arm.html")
    assert fascicle("export", "kim2021_figure_6", "--page", "arm.html", "--overwrite")[0] == 0


def test_a_table_that_cannot_be_written_leaves_no_folder(refused, tmp_path, monkeypatch):
    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fascicle.io.atomic._flush", fail)
    refused("export kim2021_figure_6 --table code")
    (tmp_path / "code").mkdir()
    (tmp_path / "code" / "mine.txt").write_text("mine")
    refused("export kim2021_figure_6 --table code")
