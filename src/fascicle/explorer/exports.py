"""Downloads of a tab: its picture, its data, and a Python script that makes both.

The picture is one of `fascicle.plot`; the data are a table of `fascicle.tables`, with the columns
of the command line, where there is one of that kind, else labeled variables. The script is text for
a reader; it is never run here.
"""

import io
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn

from .. import plot
from ..calibrate.plot_data import measured_with_curves
from ..core.validation import HIGHEST_PRESSURE
from ..files import dumps
from ..muscle import Muscle
from ..plot.calibration import fit as draw_fit
from ..plot.theme import to_bytes
from ..plot.workspace import efficiency as draw_efficiency
from ..records.record import Record
from ..results import Table, Variable, tables
from .efficiency_tab import efficiency_maps
from .measured import AUTOMATIC, STARTS, TUNING
from .muscle_curves import strain_limit
from .reversal_tab import POINTS, split_curves
from .state import View
from .widgets import widget


_STRAINS = 201  # along a muscle's curve


@dataclass(frozen=True)
class Export:
    """A tab's data as `variables` by name, its `figure`, and a `script` that makes both.

    A file of text alone has it as its `script`.
    """

    stem: str
    variables: Table
    figure: Callable[[], Any]
    script: str

    def content(self, suffix: str) -> bytes:
        """Bytes of a file with the `suffix` svg, png, csv or nc, or of the script for any other."""
        if suffix in ("svg", "png"):
            return to_bytes(self.figure(), suffix)
        if suffix == "csv":
            return self.variables.to_csv().encode()
        if suffix != "nc":
            return self.script.encode()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"{self.stem}.nc")
            self.variables.write(path, title=self.stem)
            return path.read_bytes()


def muscle(view: View, input_names: Iterable[str] = ()) -> Export:
    """Curve of the muscle at the view's pressure."""
    stem = output_stem(view.name, "force", input_names)
    top, P = strain_limit(view.muscle, view.supply), view.pressure
    strain = np.linspace(0.0, top, _STRAINS)
    body = f"""\
pressure = {P!r}  # Pa
strain = np.linspace(0.0, {top!r}, {_STRAINS})
tables.muscle_force(muscle, [pressure], strain).write("{stem}.csv")
muscle.plot([pressure], strain).savefig("{stem}.svg")
"""
    imports = ["import numpy as np\n", "from fascicle import tables"]
    return Export(
        stem,
        tables.muscle_force(view.muscle, [P], strain),
        lambda: view.muscle.plot([P], strain),
        _script(stem, imports, "muscle", dumps(view.muscle), body),
    )


def bundle(view: View, input_names: Iterable[str] = ()) -> Export:
    """Force-strain space of the bundle."""
    stem, target = output_stem(view.name, "space", input_names), view.bundle
    body = f"""\
space = bundle.workspace(resistance={view.resistance})
tables.space(space).write("{stem}.csv")
bundle.plot(resistance={view.resistance}).savefig("{stem}.svg")
"""
    return Export(
        stem,
        tables.space(target.workspace(resistance=view.resistance)),
        lambda: target.plot(resistance=view.resistance),
        _script(stem, ["from fascicle import tables"], "bundle", dumps(target), body),
    )


def reversal(view: View, input_names: Iterable[str] = ()) -> Export:
    """Free strain against the second unit's pressure."""
    stem = output_stem(view.name, "reversal", input_names)
    curves = split_curves(view.muscle, view.splits, view.supply)
    P = curves[0].pressure
    strains = {curve.name: curve.resisted for curve in curves}
    strains |= {f"{curve.name}, without resistance": curve.free for curve in curves}
    turns = {curve.name: curve.turn for curve in curves}
    body = f"""\
supply = {view.supply!r}  # Pa
pressure = np.linspace(0.0, supply, {POINTS})
bundles = {{
    " + ".join(map(str, counts)): Bundle([MotorUnit(muscle, n) for n in counts], supply)
    for counts in {view.splits!r}
}}
strains = {{name: free_strain_curve(b, 2, pressure) for name, b in bundles.items()}}
for name, b in bundles.items():
    without = free_strain_curve(b, 2, pressure, resistance=False)
    strains[f"{{name}}, without resistance"] = without
variables = Table(pressure=Variable(("pressure",), pressure, "Pa"))
for name, values in strains.items():
    variables[name] = Variable(("pressure",), values, "-")
variables.write("{stem}.csv")
turns = {{name: b.reversal() for name, b in bundles.items()}}
plot.free_strain(pressure, strains, "P₂", turns).savefig("{stem}.svg")
"""
    imports = [
        "import numpy as np\n",
        "from fascicle import Bundle, MotorUnit, plot",
        "from fascicle.reversal import free_strain_curve",
        "from fascicle.results import Table, Variable",
    ]
    variables = Table(pressure=Variable(("pressure",), P, "Pa"))
    variables |= {name: Variable(("pressure",), values, "-") for name, values in strains.items()}
    return Export(
        stem,
        variables,
        lambda: plot.free_strain(P, strains, "P₂", turns),
        _script(stem, imports, "muscle", dumps(view.muscle), body),
    )


def efficiency(view: View, input_names: Iterable[str] = ()) -> Export:
    """Efficiency maps of the bundle, with resistance and without."""
    stem = output_stem(view.name, "efficiency", input_names)
    maps = efficiency_maps(view.bundle, view.path)
    key, about = "efficiency_without_resistance", "muscles past their free strain don't push back"
    body = f"""\
result = bundle.efficiency_map(path={view.path!r})
points = {{"force": result.force, "strain": result.strain}}
free = bundle.efficiency_map(path={view.path!r}, resistance=False, **points)
variables = tables.efficiency([result])
variables[{key!r}] = variables["efficiency"]._replace(
    values=free.efficiency[None], about={about!r}
)
variables.write("{stem}.csv")
draw(result).savefig("{stem}.svg")
"""
    imports = [
        "from fascicle import tables",
        "from fascicle.plot.workspace import efficiency as draw",
    ]
    variables = tables.efficiency([maps.resisted])
    variables[key] = variables["efficiency"]._replace(
        values=maps.free.efficiency[None], about=about
    )
    return Export(
        stem,
        variables,
        lambda: draw_efficiency(maps.resisted),
        _script(stem, imports, "bundle", dumps(view.bundle), body),
    )


def data(
    muscle: Muscle,
    record: Record,
    tuned: Muscle | None,
    name: str,
    options: Mapping[str, Any],
    names: Sequence[str] = (AUTOMATIC,),
    input_names: Iterable[str] = (),
) -> Export:
    """A record and the muscle, or the one that was `tuned` to it, with constants of `names`."""
    stem = output_stem(name, "comparison", [name, *input_names])
    drawn, label = (muscle, "the muscle") if tuned is None else (tuned, "tuned")
    P = np.clip(record.pressure, 0.0, HIGHEST_PRESSURE)
    arguments = {**options, "rest_length": record.rest_length}
    keywords = "".join(f", {key}={value!r}" for key, value in arguments.items())
    imports = [
        "import numpy as np\n",
        "from fascicle import records",
        "from fascicle.calibrate.plot_data import measured_with_curves",
        "from fascicle.plot.calibration import fit as draw",
        "from fascicle.results import Table, Variable",
    ]
    fit = ""
    if tuned is not None and tuple(names) == (AUTOMATIC,):
        imports.insert(2, "from fascicle.calibrate import select_model")
        fit = f"muscle = select_model(record, muscle, starts={STARTS}).calibration.muscle\n"
    elif tuned is not None:
        imports.insert(2, "from fascicle.calibrate import fit")
        free = "" if tuple(names) == (TUNING,) else f"{list(names)!r}, "
        fit = f"muscle = fit(record, muscle, {free}starts={STARTS}, whole=False).muscle\n"
    body = f"""\
record = records.load({name!r}{keywords})  # beside this script
{fit}pressure = np.clip(record.pressure, 0.0, {HIGHEST_PRESSURE!r})
force = muscle.force(pressure, record.strain)
variables = Table(
    pressure=Variable(("reading",), record.pressure, "Pa"),
    strain=Variable(("reading",), record.strain, "-"),
    force=Variable(("reading",), record.force, "N"),
    muscle=Variable(("reading",), np.asarray(force), "N"),
)
variables.write("{stem}.csv")
draw(measured_with_curves(record, muscle, {label!r})).savefig("{stem}.svg")
"""
    force = np.asarray(drawn.force(P, record.strain))
    return Export(
        stem,
        Table(
            pressure=Variable(("reading",), record.pressure, "Pa"),
            strain=Variable(("reading",), record.strain, "-"),
            force=Variable(("reading",), record.force, "N"),
            muscle=Variable(("reading",), force, "N"),
        ),
        lambda: draw_fit(measured_with_curves(record, drawn, label)),
        _script(stem, imports, "muscle", dumps(muscle), body),
    )


EXPORTS: Mapping[str, Callable[[View, Iterable[str]], Export]] = {
    "muscle": muscle, "bundle": bundle, "reversal": reversal, "efficiency": efficiency,
}  # fmt: skip
_FILES = {"svg": "SVG", "png": "PNG", "csv": "CSV", "nc": "netCDF", "py": "Python"}


def download_buttons(export: Callable[[], Export], **options: Any) -> list[Any]:
    """Buttons that download the files of an `export`, made when one is pressed."""
    return [
        download_button(f"Download {label}", suffix, export, **options)
        for suffix, label in _FILES.items()
    ]


def download_button(label: str, suffix: str, export: Callable[[], Export], **options: Any) -> Any:
    """Button that downloads the file of an `export` with a `suffix`."""

    def content() -> io.BytesIO:
        result = export()
        download.filename = f"{result.stem}.{suffix}"
        return io.BytesIO(result.content(suffix))

    download = widget(
        pn.widgets.FileDownload, label, filename=f"fascicle.{suffix}", callback=content,
        **{"width": 146, "margin": (2, 4)} | options,
    )  # fmt: skip
    return download


def output_stem(name: str, kind: str, input_names: Iterable[str] = ()) -> str:
    """Name of an output without its suffix, never that of a file that was read."""
    # the name is a visitor's: nothing in it may leave a string of the script, or a folder
    base = Path(name.replace("\\", "/")).name
    base = re.sub(r"\.(toml|csv|txt|tsv)$", "", base, flags=re.IGNORECASE)
    safe = re.sub(r"[^\w.-]+", "_", base).strip(".-") or "file"
    stem = f"{safe}_{kind}"
    stems = {Path(other).stem.lower() for other in input_names}
    while stem.lower() in stems:
        stem = f"{stem}_{kind}"
    return stem


def _script(stem: str, imports: Sequence[str], variable: str, toml: str, body: str) -> str:
    """Script that loads a muscle or bundle from its `toml` into a `variable`, and then a `body`."""
    lines = "\n".join([*imports, "from fascicle.files import loads"])
    # a file's text is data in the script: nothing in it may end the string that holds it
    text = toml.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
    return f'''"""Written by `fascicle explore`: makes {stem}.svg and {stem}.csv."""

{lines}


{variable} = loads("""
{text}""")

{body}'''
