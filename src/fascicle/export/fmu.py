"""A functional mock-up unit, FMI 2.0 for co-simulation, from a table's C: sources and binary.

Inputs are the units' pressures and the plates' strain, outputs the force and volumes; with a
controller also what a bench measures and the valves' commands, once a sample time. Nothing is
computed but what the header's functions do, so that numbers are equal bit for bit.

**Source:** Functional Mock-up Interface 2.0.4 (Modelica Association, 2022).
"""

import hashlib
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
from .c_files import checked_name
from .c_table import Tabulated, filled, tabulated, written


_STEP = 1e-3  # s, that a host is told to take where no controller has its own
_ENDINGS = {"linux64": "so", "darwin64": "dylib", "win64": "dll"}
_COMPILERS = ("gcc", "cc", "clang")
_UNITS: dict[str, dict[str, str]] = {
    "Pa": {"kg": "1", "m": "-1", "s": "-2"}, "N": {"kg": "1", "m": "1", "s": "-2"},
    "m3": {"m": "3"}, "1/s": {"s": "-1"}, "1": {},
}  # fmt: skip


class Unbuilt(Exception):  # noqa: N818 what became of it, not an error of whoever asked
    """A unit that was written, but without a binary: the words say why."""


class Variable(NamedTuple):
    """A number of the unit: its `name`, SI `unit`, whether it is an input (`into`), what it means,
    and with what it begins, `start` [SI].
    """

    name: str
    unit: str
    into: bool
    about: str
    start: float = 0.0


def write_fmu(
    target: Muscle | Bundle | Cascade,
    path: Values,
    name: str = "muscle",
    sample_time: Values = None,
    platform: str | None = None,
) -> Path:
    """Write a muscle, a bundle or a controller with its bundle as a unit for co-simulation.

    **Arguments:**

    - `target`: the muscle or bundle, or a `Cascade` as `table_code` takes it [-].
    - `path`: of the file [-], which ends in .fmu.
    - `name`: of the model, as C can have it [-].
    - `sample_time`: step that a host is told to take [s]; left out, 1 ms, or the controller's
      own.
    - `platform`: for which it is built, in FMI's words [-]; left out, this one.

    **Returns:** the path [-].

    **Raises:** `ValueError` as `table_code`, and for a sample time that isn't positive, or a
    platform that can't be built here; `Unbuilt` where there is no compiler: the file is there, with
    its sources.
    """
    path = Path(path)
    folder = _platform(platform)
    table, texts, step = _texts(target, name, sample_time)
    content = _packed(table, name, texts, step, None)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        if folder is None:
            raise Unbuilt("this machine has no name in FMI 2.0")
        built = _built(texts, name, _ENDINGS[folder])
    except Unbuilt:
        write(path, lambda draft: draft.write_bytes(content))
        raise
    content = _packed(table, name, texts, step, (folder, built))
    write(path, lambda draft: draft.write_bytes(content))
    return path


def _texts(
    target: Muscle | Bundle | Cascade, name: str, sample_time: Values
) -> tuple[Tabulated, dict[str, str], float]:
    """The tables, the C files, and the step [s]."""
    checked_name(name)
    step = _STEP
    if sample_time is not None:
        step = float(check_positive(sample_time, "sample_time", "s"))
    table = tabulated(target)
    controller = table.controller
    if controller is not None:
        identifier = float(controller.dt)
        if sample_time is not None and step != identifier:
            remedy = "leave it out, or change the scenario's"
            raise InvalidInputError(
                "sample_time", f"must be the controller's {identifier:g} s", step, remedy
            )
        step = identifier
    header, source = written(table, name, "double")
    digest = hashlib.sha256((header + source).encode()).hexdigest()
    low, high = table.strains
    names = {
        "name": name,
        "guard": name.upper(),
        "controls": int(controller is not None),
        "guid": digest[:32],
        "sample_time": repr(step),
        "supply_pressure": repr(_supply(table)),
        "low": f"{low:.6f}",
        "high": f"{high:.6f}",
        "lowest_pressure": "-101325",
        "highest": f"{min(float(one.highest_pressure) for one in table.surfaces):.0f}",
    }
    return (
        table,
        {f"{name}.h": header, f"{name}.c": source, "fmu.c": filled("fmu.c", names)},
        step,
    )


def variables(table: Tabulated) -> list[Variable]:
    """The numbers of a unit [-] from tables that are `table` [-], by their references."""
    units = range(1, len(table.kinds) + 1)
    into = [Variable(f"pressure_{i}", "Pa", True, f"gauge pressure of unit {i}") for i in units]
    into.append(Variable("strain", "1", True, "contraction of the plates' distance, over it"))
    out = [Variable("force", "N", False, "that pulls the plates together")]
    out += [Variable(f"volume_{i}", "m3", False, f"of all muscles of unit {i}") for i in units]
    if table.controller is not None:
        into += [
            Variable("strain_rate", "1/s", True, "rate of strain, measured"),
            Variable("supply_pressure", "Pa", True, "gauge, measured", _supply(table)),
            Variable("demand", "N", True, "force that is asked for"),
            Variable("measured_force", "N", True, "force, measured"),
        ]
        out += [
            Variable(f"command_{i}", "1", False, f"of unit {i}'s valve, -1 to 1") for i in units
        ]
    return into + out


def _supply(table: Tabulated) -> float:
    return table.controller.plant.supply_pressure if table.controller else 0.0


def _described(table: Tabulated, name: str, guid: str, step: float) -> bytes:
    """The model's description."""
    root = ET.Element(
        "fmiModelDescription", fmiVersion="2.0", modelName=name, guid=guid,
        description="Fluidic artificial muscles, force and volume from one table of co-energy",
        version=__version__, generationTool=f"fascicle {__version__}",
        variableNamingConvention="flat", numberOfEventIndicators="0",
    )  # fmt: skip
    simulated = ET.SubElement(
        root, "CoSimulation", modelIdentifier=name,
        canHandleVariableCommunicationStepSize="true",
    )  # fmt: skip
    files = ET.SubElement(simulated, "SourceFiles")
    for file in ("fmu.c", f"{name}.c"):
        ET.SubElement(files, "File", name=file)
    units = ET.SubElement(root, "UnitDefinitions")
    for unit, base in _UNITS.items():
        ET.SubElement(ET.SubElement(units, "Unit", name=unit), "BaseUnit", dict(base))
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(step))
    listed = ET.SubElement(root, "ModelVariables")
    outputs = []
    for reference, variable in enumerate(variables(table)):
        scalar = ET.SubElement(
            listed, "ScalarVariable", name=variable.name, valueReference=str(reference),
            description=variable.about, variability="continuous",
            causality="input" if variable.into else "output",
        )  # fmt: skip
        real = ET.SubElement(scalar, "Real", unit=variable.unit)
        if variable.into:
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


def _packed(
    table: Tabulated,
    name: str,
    texts: dict[str, str],
    step: float,
    binary: tuple[str, bytes] | None,
) -> bytes:
    """The archive; of one age always, so that the same numbers make the same file."""
    guid = hashlib.sha256((texts[f"{name}.h"] + texts[f"{name}.c"]).encode()).hexdigest()[:32]
    files = {"modelDescription.xml": _described(table, name, guid, step)}
    files |= {f"sources/{file}": text.encode() for file, text in texts.items()}
    if binary is not None:
        where, built = binary
        files[f"binaries/{where}/{name}.{_ENDINGS[where]}"] = built
    room = BytesIO()
    with zipfile.ZipFile(room, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, content in files.items():
            archive.writestr(zipfile.ZipInfo(file, (2020, 1, 1, 0, 0, 0)), content, 8)
    return room.getvalue()


def _built(texts: dict[str, str], name: str, ending: str) -> bytes:
    """The shared library of the C, by the compiler that there is."""
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if compiler is None:
        raise Unbuilt(f"no C compiler here ({', '.join(_COMPILERS)})")
    with tempfile.TemporaryDirectory() as folder:
        for file, text in texts.items():
            Path(folder, file).write_text(text, encoding="utf-8")
        library = Path(folder, f"{name}.{ending}")
        sources = [str(Path(folder, file)) for file in texts if file.endswith(".c")]
        how = ["-O2", "-std=c99", "-shared", "-fPIC", "-o", str(library), *sources, "-lm"]
        ran = subprocess.run([compiler, *how], capture_output=True, text=True, check=False)  # noqa: S603 C that was just written
        if ran.returncode != 0:
            first = (ran.stderr.splitlines() or ["no words"])[0]
            raise Unbuilt(f"{Path(compiler).name} could not build it: {first}")
        return library.read_bytes()


def _platform(platform: str | None) -> str | None:
    """Name of this machine in FMI 2.0, if it has one; refused where another one is asked for."""
    system = {"linux": "linux", "darwin": "darwin", "win32": "win"}.get(sys.platform)
    platforms = system is not None and machine.machine().lower() in ("x86_64", "amd64")
    folder = f"{system}64" if platforms else None
    if platform is not None and platform != folder:
        can = f"only {folder}" if folder else "this machine has no name in FMI 2.0"
        ending = _ENDINGS.get(platform)
        remedy = "leave it out"
        if ending is not None:
            library = f"binaries/{platform}/NAME.{ending}"
            remedy = f"leave it out, and compile the file's sources/*.c there into its {library}"
        raise InvalidInputError(
            "platform", f"can't be built here, {can}", platform, remedy, shown=platform
        )
    return folder
