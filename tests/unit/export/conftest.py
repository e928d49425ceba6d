"""A compiler of C, as strict as a controller's."""

import ctypes
import math
import shutil
import subprocess

import pytest

import fascicle as fs


STRICT = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic")


@pytest.fixture
def compile_c():
    """Compile C to a shared library, without a warning."""
    gcc = shutil.which("gcc")
    if gcc is None:
        pytest.skip("no gcc to compile C with")

    def compile_source(source, flags=("-O2",)):
        library = source.with_suffix(".so")
        command = [gcc, *STRICT, *flags, "-shared", "-fPIC", "-o", library, source, "-lm"]
        result = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert result.returncode == 0, result.stderr[:1000]
        return ctypes.CDLL(str(library))

    return compile_source


@pytest.fixture(scope="session")
def make_muscle():
    """A muscle with laws by keyword."""
    return lambda **laws: fs.Muscle(0.127, 6.35e-3, 1.6e-3, math.radians(33), **laws)


@pytest.fixture
def load_unit(tmp_path):
    """A unit, unpacked and initialized, as a host does, and its references by name."""
    fmpy = pytest.importorskip("fmpy", reason="FMPy runs the units")
    from fmpy.fmi2 import FMU2Slave

    units = []

    def load(path):
        folder = tmp_path / "unpacked"
        fmpy.extract(str(path), str(folder))
        description = fmpy.read_model_description(str(path))
        unit = FMU2Slave(
            guid=description.guid, unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier, instanceName="unit",
        )  # fmt: skip
        unit.instantiate()
        unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        unit.exitInitializationMode()
        units.append(unit)
        return unit, {x.name: x.valueReference for x in description.modelVariables}

    yield load
    for unit in units:
        unit.terminate()
        unit.freeInstance()
