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
from fascicle.export.fmu import UnbuiltUnitError
from refusing import refuses_at


fmpy = pytest.importorskip("fmpy", reason="FMPy checks the units")
gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc to build it with")
SUPPLY = 413.7e3
NUMBER, ARRAY = ctypes.c_double, ctypes.c_double * 2


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
    slow = control.Gains(pressure_time=0.3)  # so that valves are seldom at their limits
    return control.cascade(plant, "threshold", gains=slow, dt=1e-3, sample_time=2e-3)


def names_in(path):
    with zipfile.ZipFile(path) as archive:
        return set(archive.namelist())


def check_sources_alone(target, path, **options):
    """The unit is written with its sources, and without a binary."""
    with pytest.raises(UnbuiltUnitError):
        write_fmu(target, path, "knee", **options)
    assert "sources/knee.c" in names_in(path)
    assert not any(name.startswith("binaries") for name in names_in(path))


@gcc
def test_a_unit_validates_and_simulates(bundle, tmp_path):
    from fmpy.validation import validate_fmu

    path = write_fmu(bundle, tmp_path / "knee.fmu", "knee")
    assert validate_fmu(str(path)) == []
    assert path.stat().st_size < 500e3
    assert {"sources/knee.c", "sources/knee.h", "sources/fmu.c"} < names_in(path)
    copy = write_fmu(bundle, tmp_path / "copy.fmu", "knee")
    with zipfile.ZipFile(path) as first, zipfile.ZipFile(copy) as second:
        assert first.read("modelDescription.xml") == second.read("modelDescription.xml")
    start = {"pressure_1": 2e5, "pressure_2": 1e5, "strain": 0.1}
    result = fmpy.simulate_fmu(str(path), stop_time=0.01, start_values=start)
    # against the law: the table's error there
    np.testing.assert_allclose(result["force"], float(bundle.force([2e5, 1e5], 0.1)), rtol=1e-3)


@gcc
def test_a_unit_equals_the_header_bit_for_bit(bundle, load_unit, compile_c, tmp_path):
    unit, references = load_unit(write_fmu(bundle, tmp_path / "knee.fmu", "knee"))
    library = compile_c(write_table(bundle, tmp_path, "knee")[1])
    rng = np.random.default_rng(1)
    names = "pressure_1", "pressure_2", "strain", "demand", "supply_pressure"
    inputs = [references[name] for name in names]
    outputs = [references[name] for name in ("force", "volume_1", "volume_2")]
    inverse = [references[name] for name in ("setpoint_1", "setpoint_2", "reached_force")]
    integers = [references[name] for name in ("demand_status", "recruitment_state")]
    # its own supply's pressure, before any is set
    assert unit.getReal([references["supply_pressure"]]) == [SUPPLY]
    choices = set()
    for k in range(500):
        P, eps = rng.uniform(-1e3, SUPPLY, 2), rng.uniform(-0.1, 0.35)
        demand, supply = rng.uniform(-50, 500), rng.uniform(0.5, 1.1) * SUPPLY
        unit.setReal(inputs, [*P, eps, demand, supply])
        unit.doStep(k * 1e-3, 1e-3)
        setpoints, state, reached = ARRAY(), ctypes.c_int(), NUMBER()
        status = library.knee_pressures(
            NUMBER(demand), NUMBER(eps), NUMBER(supply), setpoints, ctypes.byref(state),
            ctypes.byref(reached),
        )  # fmt: skip
        assert unit.getReal(inverse) == [*setpoints, reached.value]
        assert unit.getInteger(integers) == [status, state.value]
        choices.add((status, state.value))
        force, volume = NUMBER(), ARRAY()
        library.knee_force(ARRAY(*P), NUMBER(eps), ctypes.byref(force), None, None)
        library.knee_volume(ARRAY(*P), NUMBER(eps), volume)
        assert unit.getReal(outputs) == [force.value, *volume]
    assert choices >= {(0, 1), (0, 2), (1, 2)}


Memory = NUMBER * 8  # doubles of the controller's struct


@gcc
def test_the_controller_acts_once_a_sample_time(controller, load_unit, compile_c, tmp_path):
    from fmpy.validation import validate_fmu

    path = write_fmu(controller, tmp_path / "knee.fmu", "knee")
    assert validate_fmu(str(path)) == []
    unit, references = load_unit(path)
    step = compile_c(write_table(controller, tmp_path, "knee")[1]).knee_step
    memory, expected = Memory(0.0, 1.0), ARRAY()
    rng = np.random.default_rng(2)
    names = "pressure_1", "pressure_2", "strain", "strain_rate", "demand", "measured_force"
    inputs = [references[name] for name in names]
    outputs = [references["command_1"], references["command_2"]]
    commands = set()
    for k in range(400):  # of a millisecond: it acts at each second one
        P, eps, rate = rng.uniform(0, SUPPLY, 2), 0.1 + 1e-4 * k, rng.normal(0, 0.1)
        demand = 200 + 150 * np.sin(k / 40)
        unit.setReal(inputs, [*P, eps, rate, demand, demand + 5])
        unit.doStep(k * 1e-3, 1e-3)
        if k % 2 == 0:
            step(
                ctypes.byref(memory), NUMBER(demand), NUMBER(demand + 5), ARRAY(*P),
                NUMBER(SUPPLY), NUMBER(eps), NUMBER(rate), expected,
            )  # fmt: skip
        assert unit.getReal(outputs) == list(expected)
        commands.add(tuple(expected))
    assert len(commands) > 150


@gcc
def test_outside_of_the_table_a_step_fails(bundle, load_unit, tmp_path):
    unit, references = load_unit(write_fmu(bundle, tmp_path / "knee.fmu", "knee"))
    for strain, step in ((0.7, 1e-3), (0.1, 0.0)):
        unit.setReal([references["strain"]], [strain])
        with pytest.raises(Exception, match="fmi2DoStep failed with status 3"):
            unit.doStep(0.0, step)
    with pytest.raises(Exception, match="fmi2SetReal failed with status 3"):
        unit.setReal([references["force"]], [1.0])
    unit.doStep(0.0, 1e-3)


@pytest.mark.parametrize(
    ("function", "result"), [("shutil.which", None), ("machine.machine", "riscv64")]
)
def test_without_a_compiler_the_sources_are_written(
    bundle, tmp_path, monkeypatch, function, result
):
    """Nor on a machine without a name in FMI."""
    monkeypatch.setattr(f"fascicle.export.fmu.{function}", lambda *_: result)
    check_sources_alone(bundle, tmp_path / "knee.fmu")


@pytest.mark.parametrize(
    "options",
    [{"sample_time": 0.0}, {"platform": "win32"}, *({"name": x} for x in ("a b", "math", "fmu"))],
)
def test_invalid_options_are_refused(bundle, tmp_path, options):
    with pytest.raises(fs.InvalidInputError) as error:
        write_fmu(bundle, tmp_path / "knee.fmu", **options)
    assert error.value.argument in options
    assert not (tmp_path / "knee.fmu").exists()


def test_a_controller_has_its_own_sample_time(controller, tmp_path):
    with pytest.raises(fs.InvalidInputError) as error:
        write_fmu(controller, tmp_path / "knee.fmu", sample_time=1e-3)
    assert error.value.argument == "sample_time" and "0.002 s" in error.value.rule


@pytest.mark.parametrize("is_built", [True, False])
def test_on_a_full_disk_the_former_unit_stays(bundle, tmp_path, monkeypatch, is_built):
    """The largest file that the process may write takes the place of a disk."""

    def build(*_):
        if is_built:
            return b"a shared library"
        raise UnbuiltUnitError("no C compiler here")

    path = tmp_path / "knee.fmu"
    path.write_bytes(b"former")
    monkeypatch.setattr("fascicle.export.fmu._build_library", build)
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limit[1]))
    try:
        with refuses_at(f"{path}: "):
            write_fmu(bundle, path, "knee")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
    assert path.read_bytes() == b"former" and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("platform", ["win64", "darwin64", "linux64"])
def test_without_a_compiler_for_it_another_platforms_unit_has_its_sources(
    bundle, tmp_path, monkeypatch, platform
):
    system = "win32" if platform == "linux64" else "linux"
    monkeypatch.setattr("fascicle.export.fmu.sys.platform", system)
    native = shutil.which
    monkeypatch.setattr(shutil, "which", lambda name: None if "mingw" in name else native(name))
    check_sources_alone(bundle, tmp_path / "knee.fmu", platform=platform)


@gcc
def test_mingw_builds_the_unit_for_windows(bundle, tmp_path, monkeypatch):
    """Where it is installed; else gcc takes its place, to see that it is asked and with what."""
    native, mingw = shutil.which, shutil.which("x86_64-w64-mingw32-gcc")
    compiler = mingw or native("gcc")
    monkeypatch.setattr("fascicle.export.fmu.sys.platform", "linux")
    monkeypatch.setattr(
        shutil, "which", lambda name: compiler if name == "x86_64-w64-mingw32-gcc" else native(name)
    )
    path = write_fmu(bundle, tmp_path / "knee.fmu", "knee", platform="win64")
    with zipfile.ZipFile(path) as archive:
        library = archive.read("binaries/win64/knee.dll")
    assert library.startswith(b"MZ" if mingw else b"\x7fELF")
    assert b"fmi2DoStep" in library
