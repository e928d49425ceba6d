"""A functional mock-up unit, FMI 2.0 for co-simulation, from a table's C: sources and binary.

Inputs are the units' pressures and the plates' strain, outputs the force and volumes; with a
controller also what a bench measures and the valves' commands, once a sample time. The unit only
calls the header's functions, so that numbers are equal bit for bit.

**Source:** Functional Mock-up Interface 2.0.4 (Modelica Association, 2022).
"""

import hashlib
import os
import platform as machine
import shutil
import subprocess
import sys
import tempfile
import zipfile
from io import BytesIO
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

from .. import __version__
from ..bundle import Bundle
from ..control import Cascade
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import check_positive
from ..io.atomic import write
from ..muscle import Muscle
from .c_files import check_name, render_template
from .c_table import MuscleTables, tabulate


_STEP = 1e-3  # s, suggested to a host: a millisecond resolves a valve
# suffix of a shared library on each of FMI's platforms
_SUFFIXES = {"linux64": "so", "darwin64": "dylib", "win64": "dll"}
_COMPILERS = ("gcc", "cc", "clang")  # the first that is installed builds the binary
_DATE = (2020, 1, 1, 0, 0, 0)  # of all files in the archive: equal numbers give equal files
_UNITS: dict[str, dict[str, str]] = {
    "Pa": {"kg": "1", "m": "-1", "s": "-2"}, "N": {"kg": "1", "m": "1", "s": "-2"},
    "m3": {"m": "3"}, "1/s": {"s": "-1"}, "1": {},
}  # fmt: skip


class UnbuiltUnitError(Exception):
    """A unit that was written without a binary, and the reason."""


class Variable(NamedTuple):
    """A number of the unit: its `name`, SI `unit`, whether it is an input, its `description`, and
    its initial value, `start` [SI].
    """

    name: str
    unit: str
    is_input: bool
    description: str
    start: float = 0.0


def write_fmu(
    target: Muscle | Bundle | Cascade,
    path: str | os.PathLike[str],
    name: str = "muscle",
    sample_time: Values = None,
    platform: str | None = None,
) -> Path:
    """Write a muscle, a bundle or a controller with its bundle as a unit for co-simulation.

    **Arguments:**

    - `target`: the muscle or bundle, or a `Cascade` as for `table_code`.
    - `path`: the file, which ends in .fmu.
    - `name`: name of the model, a name in C.
    - `sample_time`: step that the unit suggests to its host [s]; default: 1 ms, or the
      controller's.
    - `platform`: platform of the binary, as FMI names it; default: this one.

    **Returns:** the path.

    **Raises:** `ValueError` as `table_code`, and for a sample time that isn't positive, or a
    platform that can't be built here; `UnbuiltUnitError` if there is no compiler: the file is
    written with its sources.
    """
    path = Path(path)
    folder = _platform(platform)
    check_name(name)
    step = _STEP if sample_time is None else float(check_positive(sample_time, "sample_time", "s"))
    tables = tabulate(target)
    if tables.controller is not None:
        period = float(tables.controller.dt)
        if sample_time is not None and step != period:
            rule = f"must be the controller's {period:g} s"
            remedy = "drop it, or change the scenario's"
            raise InvalidInputError("sample_time", rule, step, remedy)
        step = period
    header, source = tables.code(name)
    guid = hashlib.sha256((header + source).encode()).hexdigest()[:32]
    values = {
        "name": name,
        "guard": name.upper(),
        "controls": int(tables.controller is not None),
        "guid": guid,
        "sample_time": repr(step),
        "supply_pressure": repr(_supply_pressure(tables)),
        **tables.limits_as_text,
    }
    sources = {f"{name}.h": header, f"{name}.c": source, "fmu.c": render_template("fmu.c", values)}
    files = {"modelDescription.xml": _description(tables, name, guid, step)}
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    path.parent.mkdir(parents=True, exist_ok=True)
    unbuilt = None
    try:
        if folder is None:
            raise UnbuiltUnitError("this machine has no name in FMI 2.0")
        suffix = _SUFFIXES[folder]
        files[f"binaries/{folder}/{name}.{suffix}"] = _build(sources, name, suffix)
    except UnbuiltUnitError as error:
        unbuilt = error
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, data in files.items():
            archive.writestr(zipfile.ZipInfo(file, _DATE), data, zipfile.ZIP_DEFLATED)
    write(path, lambda draft: draft.write_bytes(content.getvalue()))
    if unbuilt is not None:
        raise unbuilt
    return path


def variables(tables: MuscleTables) -> list[Variable]:
    """The numbers of a unit, in the order of their references."""
    units = range(1, len(tables.kinds) + 1)
    inputs = [Variable(f"pressure_{i}", "Pa", True, f"gauge pressure of unit {i}") for i in units]
    inputs.append(Variable("strain", "1", True, "contraction over the plates' distance at rest"))
    outputs = [Variable("force", "N", False, "force that pulls the plates together")]
    outputs += [
        Variable(f"volume_{i}", "m3", False, f"volume of all muscles of unit {i}") for i in units
    ]
    if tables.controller is not None:
        supply = _supply_pressure(tables)
        inputs += [
            Variable("strain_rate", "1/s", True, "rate of strain, measured"),
            Variable("supply_pressure", "Pa", True, "gauge pressure of supply, measured", supply),
            Variable("demand", "N", True, "demanded force"),
            Variable("measured_force", "N", True, "force, measured"),
        ]
        outputs += [
            Variable(f"command_{i}", "1", False, f"command of unit {i}'s valve, -1 to 1")
            for i in units
        ]
    return inputs + outputs


def _supply_pressure(tables: MuscleTables) -> float:
    """Gauge pressure [Pa] of a controller's supply; zero without a controller."""
    return tables.controller.plant.supply_pressure if tables.controller else 0.0


def _description(tables: MuscleTables, name: str, guid: str, step: float) -> bytes:
    """The unit's `modelDescription.xml`."""
    root = ET.Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=name, guid=guid,
        description="Fluidic artificial muscles, force and volume from one table of co-energy",
        version=__version__, generationTool=f"fascicle {__version__}",
        variableNamingConvention="flat", numberOfEventIndicators="0",
    )  # fmt: skip
    simulation = ET.SubElement(
        root, "CoSimulation", modelIdentifier=name,
        canHandleVariableCommunicationStepSize="true",
    )  # fmt: skip
    files = ET.SubElement(simulation, "SourceFiles")
    for file in ("fmu.c", f"{name}.c"):
        ET.SubElement(files, "File", name=file)
    units = ET.SubElement(root, "UnitDefinitions")
    for unit, base in _UNITS.items():
        ET.SubElement(ET.SubElement(units, "Unit", name=unit), "BaseUnit", dict(base))
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(step))
    model_variables = ET.SubElement(root, "ModelVariables")
    outputs = []
    for reference, variable in enumerate(variables(tables)):
        scalar = ET.SubElement(
            model_variables, "ScalarVariable", name=variable.name, valueReference=str(reference),
            description=variable.description, variability="continuous",
            causality="input" if variable.is_input else "output",
        )  # fmt: skip
        real = ET.SubElement(scalar, "Real", unit=variable.unit)
        if variable.is_input:
            real.set("start", repr(variable.start))
        else:
            outputs.append(str(reference + 1))
    structure = ET.SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, kind)
        for index in outputs:
            ET.SubElement(unknowns, "Unknown", index=index)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True)


def _build(sources: dict[str, str], name: str, suffix: str) -> bytes:
    """The shared library of the C sources, by the first compiler that is installed."""
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        raise UnbuiltUnitError(f"no C compiler here ({', '.join(_COMPILERS)})")
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        library = Path(folder, f"{name}.{suffix}")
        files = [str(Path(folder, file)) for file in sources if file.endswith(".c")]
        options = ["-O2", "-std=c99", "-shared", "-fPIC", "-o", str(library), *files, "-lm"]
        result = subprocess.run([compiler, *options], capture_output=True, text=True, check=False)  # noqa: S603 C that was just written
        if result.returncode != 0:
            message = (result.stderr.splitlines() or ["no message"])[0]
            raise UnbuiltUnitError(f"{Path(compiler).name} could not build it: {message}")
        return library.read_bytes()


def _platform(platform: str | None) -> str | None:
    """Name of this machine in FMI 2.0, if it has one; any other `platform` is refused."""
    system = {"linux": "linux", "darwin": "darwin", "win32": "win"}.get(sys.platform)
    is_named = system is not None and machine.machine().lower() in ("x86_64", "amd64")
    folder = f"{system}64" if is_named else None
    if platform in (None, folder):
        return folder
    reason = f"only {folder}" if folder else "this machine has no name in FMI 2.0"
    remedy = "drop it"
    if platform in _SUFFIXES:
        library = f"binaries/{platform}/NAME.{_SUFFIXES[platform]}"
        remedy = f"drop it, and compile the file's sources/*.c there into its {library}"
    rule = f"can't be built here, {reason}"
    raise InvalidInputError("platform", rule, platform, remedy, shown=platform)
