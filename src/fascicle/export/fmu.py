"""A functional mock-up unit, FMI 2.0 for co-simulation, from a table's C: sources and binary.

Inputs are the units' pressures, the plates' strain, a demanded force and the supply's pressure;
outputs are the force, the volumes, and the pressures that give the demand. With a controller it
also has what a bench measures and the valves' commands, once a sample time. The unit only calls the
header's functions, so that numbers are equal bit for bit.

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
from ..core.validation import check_choice, check_positive
from ..io.atomic import write
from ..muscle import Muscle
from .c_files import check_c_name, render_template
from .c_table import BundleTables, tabulate


_STEP = 1e-3  # s, suggested to a host: a millisecond resolves a valve
# suffix of a shared library on each of FMI's platforms
_SUFFIXES = {"linux64": "so", "darwin64": "dylib", "win64": "dll"}
_COMPILERS = ("gcc", "cc", "clang")  # the first that is installed builds the binary
# compilers for another platform, and the package that brings them
_CROSS_COMPILERS = {"win64": (("x86_64-w64-mingw32-gcc",), "mingw-w64")}
_DATE = (2020, 1, 1, 0, 0, 0)  # of all files in the archive: equal numbers give equal files
_UNITS: dict[str, dict[str, str]] = {
    "Pa": {"kg": "1", "m": "-1", "s": "-2"},
    "N": {"kg": "1", "m": "1", "s": "-2"},
    "m3": {"m": "3"},
    "1/s": {"s": "-1"},
    "m": {"m": "1"},
    "m/s": {"m": "1", "s": "-1"},
    "K": {"K": "1"},
    "kg/s": {"kg": "1", "s": "-1"},
    "1": {},
}


class UnbuiltUnitError(Exception):
    """An FMU that has its sources alone, without a binary, and the reason."""


class FmuVariable(NamedTuple):
    """A number of the FMU: its `name`, SI `unit` (none of an integer), whether it is an input, its
    `description`, and its initial value, `start` [SI].
    """

    name: str
    unit: str | None
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
    """Write a muscle, a bundle or a controller with its bundle as an FMU for co-simulation, to a
    file whose path it returns.

    **Arguments:**

    - `target`: the muscle or bundle, or a `Cascade` as for `table_code`.
    - `path`: the file, which ends in .fmu.
    - `name`: of the model, a name in C.
    - `sample_time`: step suggested to the host [s]; default: 1 ms, or the controller's.
    - `platform`: of the binary, as FMI names it; default: this one. MinGW builds that of Windows
      elsewhere.

    **Raises:** `ValueError` as `table_code`, and for an invalid sample time or platform;
    `UnbuiltUnitError` without a compiler for it: the file is written with its sources.
    """
    path = Path(path)
    folder = unit_platform(platform)
    check_c_name(name)
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
    guid = unit_guid(header + source)
    files = f"fmu.c {name}.c"
    values = {"name": name, "guard": name.upper(), "guid": guid, "files": files}
    values |= {"controls": int(tables.controller is not None), "sample_time": repr(step)}
    values |= {"supply_pressure": repr(tables.supply_pressure)} | tables.limits_as_text
    values["model"] = render_template("fmu_table.c", values)
    sources = {f"{name}.h": header, f"{name}.c": source, "fmu.c": render_template("fmu.c", values)}
    about = "Fluidic artificial muscles, force and volume from one table of co-energy"
    description = describe_unit(variables(tables), about, name, guid, step, files.split())
    return write_unit(path, name, folder, sources, description)


def unit_guid(code: str) -> str:
    """Identifier of an FMU: of equal `code` it is equal."""
    return hashlib.sha256(code.encode()).hexdigest()[:32]


def write_unit(
    path: Path, name: str, platform: str | None, sources: dict[str, str], description: bytes
) -> Path:
    """Write an FMU with its `sources` and `description`, and a binary for the `platform`.

    Raises `UnbuiltUnitError` without a compiler for it, or without a platform: the file is written
    with its sources.
    """
    files = {"modelDescription.xml": description}
    files |= {f"sources/{file}": text.encode() for file, text in sources.items()}
    path.parent.mkdir(parents=True, exist_ok=True)
    unbuilt = None
    try:
        if platform is None:
            raise UnbuiltUnitError("this machine has no name in FMI 2.0")
        library = f"binaries/{platform}/{name}.{_SUFFIXES[platform]}"
        files[library] = _build_library(sources, name, platform)
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


def variables(tables: BundleTables) -> list[FmuVariable]:
    """The numbers of an FMU, in the order of their references."""
    units, status = range(1, len(tables.kinds) + 1), "0: reached, 1: above what is reachable"
    inputs = [(f"pressure_{i}", "Pa", f"gauge pressure of unit {i}") for i in units]
    inputs += [("strain", "1", "contraction over the plates' distance at rest")]
    inputs += [("demand", "N", "demanded force")]
    inputs += [("supply_pressure", "Pa", "gauge pressure of supply, measured")]
    outputs = [("force", "N", "force that pulls the plates together")]
    outputs += [(f"volume_{i}", "m3", f"volume of all muscles of unit {i}") for i in units]
    outputs += [
        (f"setpoint_{i}", "Pa", f"gauge pressure of unit {i} for the demand") for i in units
    ]
    outputs += [("reached_force", "N", "force at the setpoints")]
    if tables.controller is not None:
        inputs += [("strain_rate", "1/s", "rate of strain, measured")]
        inputs += [("measured_force", "N", "force, measured")]
        outputs += [(f"command_{i}", "1", f"command of unit {i}'s valve, -1 to 1") for i in units]
    integers = [("recruitment_state", None, "recruitment state of the setpoints, from 1")]
    integers += [("demand_status", None, f"{status}, 2: below it, 3: no supply pressure")]
    start = {"supply_pressure": tables.supply_pressure}
    return [
        FmuVariable(name, unit, is_input, text, start.get(name, 0.0))
        for numbers, is_input in ((inputs, True), (outputs, False), (integers, False))
        for name, unit, text in numbers
    ]


def describe_unit(
    numbers: list[FmuVariable], about: str, name: str, guid: str, step: float, files: list[str]
) -> bytes:
    """An FMU's `modelDescription.xml`, with its `numbers` and the names of its C `files`."""
    head = {"fmiVersion": "2.0", "modelName": name, "guid": guid, "description": about}
    head |= {"version": __version__, "generationTool": f"fascicle {__version__}"}
    head |= {"variableNamingConvention": "flat", "numberOfEventIndicators": "0"}
    root = ET.Element("fmiModelDescription", head)
    options = {"modelIdentifier": name, "canHandleVariableCommunicationStepSize": "true"}
    simulation = ET.SubElement(root, "CoSimulation", options)
    source_files = ET.SubElement(simulation, "SourceFiles")
    for file in files:
        ET.SubElement(source_files, "File", name=file)
    units = ET.SubElement(root, "UnitDefinitions")
    for unit, base in _UNITS.items():
        ET.SubElement(ET.SubElement(units, "Unit", name=unit), "BaseUnit", dict(base))
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(step))
    model_variables = ET.SubElement(root, "ModelVariables")
    outputs, references = [], {"Real": 0, "Integer": 0}
    for index, variable in enumerate(numbers, start=1):
        kind = "Real" if variable.unit else "Integer"
        facts = {"name": variable.name, "valueReference": str(references[kind])}
        facts |= {"description": variable.description}
        facts |= {"variability": "continuous" if variable.unit else "discrete"}
        facts |= {"causality": "input" if variable.is_input else "output"}
        scalar = ET.SubElement(model_variables, "ScalarVariable", facts)
        references[kind] += 1
        number = ET.SubElement(scalar, kind, {"unit": variable.unit} if variable.unit else {})
        if variable.is_input:
            number.set("start", repr(variable.start))
        else:
            outputs.append(str(index))
    structure = ET.SubElement(root, "ModelStructure")
    for kind in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, kind)
        for index in outputs:
            ET.SubElement(unknowns, "Unknown", index=index)
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True)


def _build_library(sources: dict[str, str], name: str, platform: str) -> bytes:
    """Shared library of the C sources for a `platform`, by the first compiler that is there."""
    file = f"{name}.{_SUFFIXES[platform]}"
    compilers, package, target = _COMPILERS, "", ""
    if platform != _this_platform():
        target = f"for {platform} "
        compilers, package = _CROSS_COMPILERS.get(platform, ((), ""))
    compiler = next(filter(None, map(shutil.which, compilers)), None)
    if compiler is None:
        install = f"install {package}, or " if package else ""
        there, known = "there " if target else "", ", ".join(compilers) or "none is known"
        raise UnbuiltUnitError(
            f"no C compiler {target}here ({known}): {install}"
            f"compile its sources/*.c {there}into its binaries/{platform}/{file}"
        )
    with tempfile.TemporaryDirectory() as folder:
        for source, text in sources.items():
            Path(folder, source).write_text(text, encoding="utf-8")
        library = Path(folder, file)
        files = [str(Path(folder, source)) for source in sources if source.endswith(".c")]
        options = ["-O2", "-std=c99", "-shared", "-o", str(library), *files, "-lm"]
        options += ["-static-libgcc"] if platform == "win64" else ["-fPIC"]
        result = subprocess.run([compiler, *options], capture_output=True, text=True, check=False)  # noqa: S603 C that was just written
        if result.returncode != 0:
            message = (result.stderr.splitlines() or ["no message"])[0]
            raise UnbuiltUnitError(f"{Path(compiler).name} could not build it: {message}")
        return library.read_bytes()


def unit_platform(platform: str | None) -> str | None:
    """A `platform` of FMI 2.0, checked; by default this machine's name in it, if it has one."""
    return _this_platform() if platform is None else check_choice(platform, _SUFFIXES, "platform")


def _this_platform() -> str | None:
    """Name of this machine in FMI 2.0, if it has one."""
    system = {"linux": "linux", "darwin": "darwin", "win32": "win"}.get(sys.platform)
    is_named = system is not None and machine.machine().lower() in ("x86_64", "amd64")
    return f"{system}64" if is_named else None
