"""The unit for co-simulation passes FMPy's validator, and is its header bit for bit."""

import ctypes
import resource
import shutil
import zipfile

import numpy as np
import pytest

import fascicle as fs
from fascicle import control, dynamics, fluid
from fascicle.export import write_fmu, write_table
from fascicle.export.fmu import Unbuilt


pytest.importorskip("fmpy", reason="units are checked by FMPy, which isn't here")
gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc here to build it with")
SUPPLY = 413.7e3


@pytest.fixture(scope="module")
def bundle():
    muscle = fs.example("kim2021_figure_6")
    return fs.Bundle([fs.MotorUnit(muscle), fs.MotorUnit(muscle, 4)], SUPPLY)


@pytest.fixture(scope="module")
def controller(bundle):
    plant = dynamics.Plant(
        bundle, dynamics.HangingMass(3.0), fluid.ConstantSupply(SUPPLY), fluid.Isothermal(),
        fluid.SonicValve(1e-9, 0.3),
    )  # fmt: skip
    slow = control.Gains(pressure_time=0.3)  # so that valves are seldom at their ends
    return control.cascade(plant, "threshold", gains=slow, dt=1e-3, sample_time=2e-3)


@pytest.fixture
def slave(tmp_path):
    """A unit, unpacked and begun, as a host does; its words are kept."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    made = []

    def of(path):
        folder = tmp_path / "unpacked"
        fmpy.extract(str(path), str(folder))
        told = fmpy.read_model_description(str(path))
        one = FMU2Slave(
            guid=told.guid, unzipDirectory=str(folder),
            modelIdentifier=told.coSimulation.modelIdentifier, instanceName="it",
        )  # fmt: skip
        one.instantiate()
        one.setupExperiment(startTime=0.0)
        one.enterInitializationMode()
        one.exitInitializationMode()
        made.append(one)
        return one, {x.name: x.valueReference for x in told.modelVariables}

    yield of
    for one in made:
        one.terminate()
        one.freeInstance()


@gcc
def test_it_validates_and_simulates_and_is_small(bundle, tmp_path):
    import fmpy
    from fmpy.validation import validate_fmu

    path = write_fmu(bundle, tmp_path / "knee.fmu", "knee")
    assert validate_fmu(str(path)) == []
    assert path.stat().st_size < 500e3
    with zipfile.ZipFile(path) as archive:
        names = set(archive.namelist())
    assert {"sources/knee.c", "sources/knee.h", "sources/fmu.c"} < names
    again = write_fmu(bundle, tmp_path / "again.fmu", "knee")
    with zipfile.ZipFile(path) as one, zipfile.ZipFile(again) as other:
        told = "modelDescription.xml"
        assert one.read(told) == other.read(told)
    start = {"pressure_1": 2e5, "pressure_2": 1e5, "strain": 0.1}
    found = fmpy.simulate_fmu(str(path), stop_time=0.01, start_values=start)
    expected = float(bundle.force([2e5, 1e5], 0.1))
    # against the law: the table's error there
    np.testing.assert_allclose(found["force"], expected, rtol=1e-3)


@gcc
def test_it_is_the_header_bit_for_bit(bundle, slave, compiled, tmp_path):
    unit, place = slave(write_fmu(bundle, tmp_path / "knee.fmu", "knee"))
    lib = compiled(write_table(bundle, tmp_path, "knee")[1])
    rng = np.random.default_rng(1)
    array, number = ctypes.c_double * 2, ctypes.c_double
    into = [place[name] for name in ("pressure_1", "pressure_2", "strain")]
    out = [place[name] for name in ("force", "volume_1", "volume_2")]
    for k in range(500):
        P, eps = rng.uniform(-1e3, SUPPLY, 2), rng.uniform(-0.1, 0.35)
        unit.setReal(into, [*P, eps])
        unit.doStep(k * 1e-3, 1e-3)
        got = unit.getReal(out)
        force, volume = number(), array()
        lib.knee_force(array(*P), number(eps), ctypes.byref(force), None, None)
        lib.knee_volume(array(*P), number(eps), volume)
        assert got == [force.value, *volume]


class Memory(ctypes.Structure):
    _fields_ = (("force_integral", ctypes.c_double), ("recruited", ctypes.c_double))


@gcc
def test_its_controller_acts_once_a_sample_time(controller, slave, compiled, tmp_path):
    from fmpy.validation import validate_fmu

    path = write_fmu(controller, tmp_path / "knee.fmu", "knee")
    assert validate_fmu(str(path)) == []
    unit, place = slave(path)
    step = compiled(write_table(controller, tmp_path, "knee")[1]).knee_step
    memory, got = Memory(0.0, 1.0), (ctypes.c_double * 2)()
    rng = np.random.default_rng(2)
    number = ctypes.c_double
    names = "pressure_1", "pressure_2", "strain", "strain_rate", "demand", "measured_force"
    into = [place[name] for name in names]
    commands = [place["command_1"], place["command_2"]]
    seen = set()
    for k in range(400):  # of a millisecond, where it acts each second one
        P, eps, rate = rng.uniform(0, SUPPLY, 2), 0.1 + 1e-4 * k, rng.normal(0, 0.1)
        demand = 200 + 150 * np.sin(k / 40)
        unit.setReal(into, [*P, eps, rate, demand, demand + 5])
        unit.doStep(k * 1e-3, 1e-3)
        if k % 2 == 0:
            step(
                ctypes.byref(memory), number(demand), number(demand + 5), (number * 2)(*P),
                number(SUPPLY), number(eps), number(rate), got,
            )  # fmt: skip
        assert unit.getReal(commands) == list(got)
        seen.add(tuple(got))
    assert len(seen) > 150


@gcc
def test_outside_of_the_table_a_step_fails_in_words(bundle, slave, tmp_path):
    unit, place = slave(write_fmu(bundle, tmp_path / "knee.fmu", "knee"))
    unit.setReal([place["strain"]], [0.7])
    with pytest.raises(Exception, match="fmi2DoStep failed with status 3"):
        unit.doStep(0.0, 1e-3)
    unit.setReal([place["strain"]], [0.1])
    with pytest.raises(Exception, match="fmi2DoStep failed with status 3"):
        unit.doStep(0.0, 0.0)
    with pytest.raises(Exception, match="fmi2SetReal failed with status 3"):
        unit.setReal([place["force"]], [1.0])
    unit.doStep(0.0, 1e-3)


def test_without_a_compiler_the_sources_are_there(bundle, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    path = tmp_path / "knee.fmu"
    with pytest.raises(Unbuilt, match="no C compiler here"):
        write_fmu(bundle, path, "knee")
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    assert "sources/knee.c" in names and not any(name.startswith("binaries") for name in names)


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"sample_time": 0.0}, "`sample_time` must be positive"),
        ({"sample_time": -1e-3}, "`sample_time` must be positive"),
        ({"platform": "win32"}, "`platform` can't be built here, only .*, got win32"),
        ({"name": "a b"}, "`name` must be a name in C"),
        ({"name": "math"}, "`name` must not be a keyword or a standard header of C, got math"),
        ({"name": "fmu"}, "`name` must not be a keyword"),
    ],
)
def test_what_can_not_be_is_refused(bundle, tmp_path, how, words):
    with pytest.raises(ValueError, match=words):
        write_fmu(bundle, tmp_path / "knee.fmu", **how)
    assert not (tmp_path / "knee.fmu").exists()


def _no_library(*_):
    raise Unbuilt("no C compiler here")


def _library(*_):
    return b"a shared library"


@pytest.mark.parametrize("built", [_library, _no_library])
def test_on_a_full_disk_the_former_unit_stays(bundle, tmp_path, monkeypatch, built):
    """Stood for by the largest file that the process may write."""
    path = tmp_path / "knee.fmu"
    path.write_bytes(b"former")
    monkeypatch.setattr("fascicle.export.fmu._built", built)
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match=r"knee\.fmu: can't be written: "):
            write_fmu(bundle, path, "knee")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert path.read_bytes() == b"former" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("other", ["win64", "darwin64", "linux64"])
def test_another_machines_unit_is_built_there_from_the_sources_in_the_file(
    bundle, tmp_path, monkeypatch, other
):
    here = "win32" if other == "linux64" else "linux"
    monkeypatch.setattr("fascicle.export.fmu.sys.platform", here)
    with pytest.raises(fs.InvalidInputError) as told:
        write_fmu(bundle, tmp_path / "knee.fmu", "knee", platform=other)
    assert "sources" in told.value.remedy and f"binaries/{other}/" in told.value.remedy
    assert "--table" not in str(told.value)


def test_a_machine_without_a_name_writes_the_sources(bundle, tmp_path, monkeypatch):
    monkeypatch.setattr("fascicle.export.fmu.machine.machine", lambda: "riscv64")
    with pytest.raises(Unbuilt, match="no name"):
        write_fmu(bundle, tmp_path / "knee.fmu", "knee")
    assert "sources/knee.c" in zipfile.ZipFile(tmp_path / "knee.fmu").namelist()


def test_a_controller_has_its_own_sample_time(controller, tmp_path):
    with pytest.raises(ValueError, match=r"must be the controller's 0\.002 s"):
        write_fmu(controller, tmp_path / "knee.fmu", sample_time=1e-3)
