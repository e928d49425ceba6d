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
from ..bundle.efficiency import efficiency_map
from ..bundle.workspace import overlap, space
from ..calibrate.plot_data import measured_with_curves
from ..core.validation import HIGHEST_PRESSURE
from ..files import dumps
from ..muscle import Muscle
from ..plot.calibration import fit as plot_fit
from ..plot.theme import to_bytes
from ..plot.workspace import efficiency as draw_efficiency
from ..plot.workspace import workspace as draw_space
from ..records.record import Record
from ..results import tables
from ..results.labelled import Variable, to_csv, write
from .measured import AUTOMATIC, STARTS, TUNING, ReadOptions
from .muscle_curves import strain_limit
from .reversal_tab import POINTS, split_curves
from .state import View
from .widgets import widget


@dataclass(frozen=True)
class Export:
    """A tab's data as `variables` by name, its `figure`, and a `script` that makes both.

    A file of text alone has it as its `script`.
    """

    stem: str
    variables: Mapping[str, Variable]
    figure: Callable[[], Any]
    script: str

    def content(self, suffix: str) -> bytes:
        """Bytes of a file with the `suffix` svg, png, csv or nc, or of the script for any other."""
        if suffix in ("svg", "png"):
            return to_bytes(self.figure(), suffix)
        if suffix == "csv":
            return to_csv(self.variables).encode()
        if suffix != "nc":
            return self.script.encode()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"{self.stem}.nc")
            write(self.variables, path, title=self.stem)
            return path.read_bytes()


_WITHOUT = "efficiency_without_resistance"
_ABOUT = "without resistance of units past their own free strain"
_HEAD = '''"""Made by `fascicle explore`: writes {stem}.svg and {stem}.csv."""

{imports}

{name} = loads("""
{toml}""")
'''


def muscle(view: View, opened: Iterable[str] = ()) -> Export:
    """Curve of the muscle at the chosen pressure."""
    stem = output_stem(view.name, "force", opened)
    top, P = strain_limit(view.muscle, view.supply), view.pressure
    strain = np.linspace(0.0, top, 201)
    imports = (
        "import numpy as np\n\n"
        "from fascicle import plot, tables\n"
        "from fascicle.files import loads\n"
    )
    script = (
        _head(stem, "muscle", dumps(view.muscle), imports)
        + f"""
pressure = {P!r}  # Pa
strain = np.linspace(0.0, {top!r}, 201)
tables.muscle_force(muscle, [pressure], strain).write("{stem}.csv")
plot.force_strain(muscle, [pressure], strain).savefig("{stem}.svg")
"""
    )
    variables = tables.muscle_force(view.muscle, [P], strain)
    return Export(stem, variables, lambda: plot.force_strain(view.muscle, [P], strain), script)


def bundle(view: View, opened: Iterable[str] = ()) -> Export:
    """Force-strain space of the bundle."""
    stem = output_stem(view.name, "space", opened)
    result = space(view.bundle, levels=5, resistance=view.resistance)
    imports = (
        "from fascicle import recruitment, tables\n"
        "from fascicle.files import loads\n"
        "from fascicle.plot.workspace import workspace as draw\n"
    )
    script = (
        _head(stem, "bundle", dumps(view.bundle), imports)
        + f"""
space = recruitment.space(bundle, levels=5, resistance={view.resistance})
tables.space(space).write("{stem}.csv")
draw(space, recruitment.overlap(space)).savefig("{stem}.svg")
"""
    )
    figure = lambda: draw_space(result, overlap(result))  # noqa: E731 drawn if it is asked for
    return Export(stem, tables.space(result), figure, script)


def reversal(view: View, opened: Iterable[str] = ()) -> Export:
    """Free strain against the second unit's pressure."""
    stem = output_stem(view.name, "reversal", opened)
    curves = split_curves(view.muscle, view.splits, view.supply)
    P = curves[0].pressure
    strains = {curve.name: curve.resisted for curve in curves}
    strains |= {f"{curve.name}, without resistance": curve.free for curve in curves}
    variables = {"pressure": Variable(("pressure",), P, "Pa")} | {
        name: Variable(("pressure",), values, "-") for name, values in strains.items()
    }
    imports = (
        "import numpy as np\n\n"
        "from fascicle import Bundle, MotorUnit, plot\n"
        "from fascicle.bundle.reversal import free_strain_curve, reversal\n"
        "from fascicle.files import loads\n"
        "from fascicle.results.labelled import Variable, write\n"
    )
    script = (
        _head(stem, "muscle", dumps(view.muscle), imports)
        + f"""
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
variables = {{"pressure": Variable(("pressure",), pressure, "Pa")}}
for name, values in strains.items():
    variables[name] = Variable(("pressure",), values, "-")
write(variables, "{stem}.csv")
turns = {{name: reversal(b) for name, b in bundles.items()}}
plot.free_strain(pressure, strains, "P₂", turns).savefig("{stem}.svg")
"""
    )
    turns = {curve.name: curve.turn for curve in curves}
    return Export(stem, variables, lambda: plot.free_strain(P, strains, "P₂", turns), script)


def efficiency(view: View, opened: Iterable[str] = ()) -> Export:
    """Efficiency maps of the bundle, with resistance and without."""
    stem = output_stem(view.name, "efficiency", opened)
    result = efficiency_map(view.bundle, path=view.path)
    free = efficiency_map(
        view.bundle, path=view.path, resistance=False, force=result.force, strain=result.strain
    )
    variables = tables.efficiency([result])
    variables[_WITHOUT] = variables["efficiency"]._replace(
        values=free.efficiency[None], about=_ABOUT
    )
    imports = (
        "from fascicle import tables\n"
        "from fascicle.energetics import efficiency_map\n"
        "from fascicle.files import loads\n"
        "from fascicle.plot.workspace import efficiency as draw\n"
    )
    script = (
        _head(stem, "bundle", dumps(view.bundle), imports)
        + f"""
result = efficiency_map(bundle, path={view.path!r})
points = {{"force": result.force, "strain": result.strain}}
free = efficiency_map(bundle, path={view.path!r}, resistance=False, **points)
variables = tables.efficiency([result])
variables[{_WITHOUT!r}] = variables["efficiency"]._replace(
    values=free.efficiency[None], about={_ABOUT!r}
)
variables.write("{stem}.csv")
draw(result).savefig("{stem}.svg")
"""
    )
    return Export(stem, variables, lambda: draw_efficiency(result), script)


def data(
    muscle: Muscle,
    record: Record,
    tuned: Muscle | None,
    name: str,
    options: ReadOptions,
    names: Sequence[str] = (AUTOMATIC,),
    opened: Iterable[str] = (),
) -> Export:
    """A record and the muscle, or the one that was fitted to it.

    **Arguments:**

    - `muscle`: the muscle before the fit.
    - `record`: the readings.
    - `tuned`: the fitted muscle, or None.
    - `name`: of the record's file.
    - `options`: it was read with.
    - `names`: what was fitted, as `measured.fit_record` takes it.
    - `opened`: names of files that were read.
    """
    stem = output_stem(name, "comparison", [name, *opened])
    shown, label = (muscle, "the muscle") if tuned is None else (tuned, "tuned")
    automatic = tuple(names) == (AUTOMATIC,)
    P = np.clip(record.pressure, 0.0, HIGHEST_PRESSURE)
    variables = {
        "pressure": Variable(("reading",), record.pressure, "Pa"),
        "strain": Variable(("reading",), record.strain, "-"),
        "force": Variable(("reading",), record.force, "N"),
        "muscle": Variable(("reading",), np.asarray(shown.force(P, record.strain)), "N"),
    }
    imports = (
        "import numpy as np\n\n"
        "from fascicle import records\n"
        f"from fascicle.calibrate import {'select_model' if automatic else 'fit'}\n"
        "from fascicle.calibrate.plot_data import measured_with_curves\n"
        "from fascicle.files import loads\n"
        "from fascicle.plot import calibration\n"
        "from fascicle.results.labelled import Variable, write\n"
    )
    arguments = options.arguments | {"rest_length": record.rest_length}
    given = ", ".join(f"{key}={value!r}" for key, value in arguments.items())
    free = "" if tuple(names) == (TUNING,) else f"{list(names)!r}, "
    tune = f"muscle = fit(record, muscle, {free}starts={STARTS}, whole=False).muscle\n"
    if automatic:
        tune = f"muscle = select_model(record, muscle, starts={STARTS}).calibration.muscle\n"
    if tuned is None:
        tune = ""
    script = (
        _head(stem, "muscle", dumps(muscle), imports)
        + f"""
record = records.load({name!r}, {given})  # beside this script
{tune}pressure = np.clip(record.pressure, 0.0, {HIGHEST_PRESSURE!r})
variables = {{
    "pressure": Variable(("reading",), record.pressure, "Pa"),
    "strain": Variable(("reading",), record.strain, "-"),
    "force": Variable(("reading",), record.force, "N"),
    "muscle": Variable(("reading",), np.asarray(muscle.force(pressure, record.strain)), "N"),
}}
write(variables, "{stem}.csv")
calibration.fit(measured_with_curves(record, muscle, {label!r})).savefig("{stem}.svg")
"""
    )
    figure = lambda: plot_fit(measured_with_curves(record, shown, label))  # noqa: E731 as above
    return Export(stem, variables, figure, script)


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
        made = export()
        download.filename = f"{made.stem}.{suffix}"
        return io.BytesIO(made.content(suffix))

    download = widget(
        pn.widgets.FileDownload, label, filename=f"fascicle.{suffix}", callback=content,
        **{"width": 146, "margin": (2, 4)} | options,
    )  # fmt: skip
    return download


def _head(stem: str, name: str, toml: str, imports: str) -> str:
    # a file's text is data in the script: nothing in it may end the string it stands in
    return _HEAD.format(stem=stem, name=name, imports=imports, toml=escape_triple_quotes(toml))


def output_stem(name: str, what: str, opened: Iterable[str] = ()) -> str:
    """Name of an output without its suffix, never that of a file that was read.

    **Arguments:**

    - `name`: of the muscle or the file that the output comes from.
    - `what`: the output is, one word.
    - `opened`: names of files that were read, which it must not bear.

    **Returns:** letters, digits, dots, dashes and underscores.
    """
    # the name is a visitor's: nothing in it may leave a string of the script, or a folder
    base = Path(name.replace("\\", "/")).name
    base = re.sub(r"\.(toml|csv|txt|tsv)$", "", base, flags=re.IGNORECASE)
    safe = re.sub(r"[^\w.-]+", "_", base).strip(".-") or "file"
    stem = f"{safe}_{what}"
    taken = {Path(other).stem.lower() for other in opened}
    while stem.lower() in taken:
        stem = f"{stem}_{what}"
    return stem


def escape_triple_quotes(text: str) -> str:
    """A text as it stands between three double quotes in Python."""
    return text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
