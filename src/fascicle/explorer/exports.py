"""What a tab gives away: its picture, its data, and the Python that makes both.

The picture is one of `fascicle.plot`, the data are a table of `fascicle.tables`, with the command
line's columns, where there is one of that kind, else labelled variables. The Python is plain text,
written for a reader; it is never run here.
"""

import io
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn

from .. import plot
from ..bundle.space import overlap, space
from ..calibrate.plot_data import measured_with_curves
from ..core.validation import HIGHEST_PRESSURE
from ..energetics import efficiency_map
from ..files import dumps
from ..muscle import Muscle
from ..plot.calibration import fit as plot_fit
from ..plot.style import to_bytes
from ..plot.workspace import efficiency as draw_efficiency
from ..plot.workspace import workspace as draw_space
from ..records.record import Record
from ..results import tables
from ..results.labelled import Variable, to_csv, write
from .measured import FOUND, STARTS, TUNING, Reading
from .muscle_curves import widest
from .state import View
from .theme import Look, widget_css


@dataclass(frozen=True)
class Export:
    """A tab's data as `variables` by name, its `figure`, and `python` that makes both."""

    stem: str
    variables: Mapping[str, Variable]
    figure: Callable[[], Any]
    python: str

    def content(self, suffix: str) -> bytes:
        """The bytes of one of its files: `suffix` svg, png, csv, nc or py [-]."""
        if suffix in ("svg", "png"):
            return to_bytes(self.figure(), suffix)
        if suffix == "csv":
            return to_csv(self.variables).encode()
        if suffix == "py":
            return self.python.encode()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"{self.stem}.nc")
            write(self.variables, path, title=self.stem)
            return path.read_bytes()


_WITHOUT = "efficiency_without_resistance"
_ABOUT = "the same where units past their own free strain don't push back"
_HEAD = '''"""Made by `fascicle explore`: writes {stem}.svg and {stem}.csv."""

{imports}

{what} = loads("""
{toml}""")
'''


def muscle(view: View) -> Export:
    """The muscle's curve at the chosen pressure, of a `view` [-]."""
    top, P = widest(view.muscle, view.supply), view.pressure
    strain = np.linspace(0.0, top, 201)
    imports = (
        "import numpy as np\n\n"
        "from fascicle import plot, tables\n"
        "from fascicle.files import loads\n"
    )
    python = (
        _head("muscle", "muscle", dumps(view.muscle), imports)
        + f"""
pressure = {P!r}  # Pa
strain = np.linspace(0.0, {top!r}, 201)
tables.muscle_force(muscle, [pressure], strain).write("muscle.csv")
plot.force_strain(muscle, [pressure], strain).savefig("muscle.svg")
"""
    )
    found = tables.muscle_force(view.muscle, [P], strain)
    return Export("muscle", found, lambda: plot.force_strain(view.muscle, [P], strain), python)


def bundle(view: View) -> Export:
    """The force-strain space of the bundle of a `view` [-]."""
    made = view.bundle
    found = space(made, levels=5, resistance=view.resistance)
    imports = (
        "from fascicle import recruitment, tables\n"
        "from fascicle.files import loads\n"
        "from fascicle.plot.workspace import workspace as draw\n"
    )
    python = (
        _head("bundle", "bundle", dumps(made), imports)
        + f"""
found = recruitment.space(bundle, levels=5, resistance={view.resistance})
tables.space(found).write("bundle.csv")
draw(found, recruitment.overlap(found)).savefig("bundle.svg")
"""
    )
    return Export("bundle", tables.space(found), lambda: draw_space(found, overlap(found)), python)


def reversal(view: View) -> Export:
    """Free strain against the second unit's pressure, of a `view` [-]."""
    from .reversal_tab import POINTS, split_curves

    found = split_curves(view.muscle, view.splits, view.supply)
    P = found[0].pressure
    strains = {one.name: one.resisted for one in found}
    strains |= {f"{one.name}, without resistance": one.free for one in found}
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
    python = (
        _head("reversal", "muscle", dumps(view.muscle), imports)
        + f"""
supply = {view.supply!r}  # Pa
pressure = np.linspace(0.0, supply, {POINTS})
bundles = {{
    " + ".join(map(str, counts)): Bundle([MotorUnit(muscle, n) for n in counts], supply)
    for counts in {view.splits!r}
}}
strains = {{name: free_strain_curve(one, 2, pressure) for name, one in bundles.items()}}
for name, one in bundles.items():
    without = free_strain_curve(one, 2, pressure, resistance=False)
    strains[f"{{name}}, without resistance"] = without
variables = {{"pressure": Variable(("pressure",), pressure, "Pa")}}
for name, values in strains.items():
    variables[name] = Variable(("pressure",), values, "-")
write(variables, "reversal.csv")
turns = {{name: reversal(one) for name, one in bundles.items()}}
plot.free_strain(pressure, strains, "P₂", turns).savefig("reversal.svg")
"""
    )
    turns = {one.name: one.turn for one in found}
    return Export("reversal", variables, lambda: plot.free_strain(P, strains, "P₂", turns), python)


def efficiency(view: View) -> Export:
    """The efficiency maps of the bundle of a `view` [-], with resistance and without."""
    made = view.bundle
    found = efficiency_map(made, path=view.path)
    free = efficiency_map(
        made, path=view.path, resistance=False, force=found.force, strain=found.strain
    )
    variables = tables.efficiency([found])
    variables[_WITHOUT] = variables["efficiency"]._replace(
        values=free.efficiency[None], about=_ABOUT
    )
    imports = (
        "from fascicle import tables\n"
        "from fascicle.energetics import efficiency_map\n"
        "from fascicle.files import loads\n"
        "from fascicle.plot.workspace import efficiency as draw\n"
    )
    python = (
        _head("efficiency", "bundle", dumps(made), imports)
        + f"""
found = efficiency_map(bundle, path={view.path!r})
points = {{"force": found.force, "strain": found.strain}}
free = efficiency_map(bundle, path={view.path!r}, resistance=False, **points)
variables = tables.efficiency([found])
variables[{_WITHOUT!r}] = variables["efficiency"]._replace(
    values=free.efficiency[None], about={_ABOUT!r}
)
variables.write("efficiency.csv")
draw(found).savefig("efficiency.svg")
"""
    )
    return Export("efficiency", variables, lambda: draw_efficiency(found), python)


def data(
    muscle: Muscle,
    record: Record,
    tuned: Muscle | None,
    name: str,
    reading: Reading,
    names: Sequence[str] = (FOUND,),
) -> Export:
    """A record beside the muscle, or the one that is tuned to it.

    **Arguments:**

    - `muscle`: the muscle, as it was before it was tuned [-].
    - `record`: the readings [-].
    - `tuned`: what they made of the muscle [-], or None.
    - `name`: of the file they came from [-].
    - `reading`: how it was read [-].
    - `names`: what was fitted, as `measured.fitted` takes it [-].

    **Returns:** the export [-].
    """
    shown, stem = muscle if tuned is None else tuned, output_stem(name, "comparison")
    label = "the muscle" if tuned is None else "tuned"
    found = tuple(names) == (FOUND,)
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
        f"from fascicle.calibrate import {'select_model' if found else 'fit'}\n"
        "from fascicle.calibrate.plot_data import measured_with_curves\n"
        "from fascicle.files import loads\n"
        "from fascicle.plot import calibration\n"
        "from fascicle.results.labelled import Variable, write\n"
    )
    said = reading.given | {"rest_length": record.rest_length}
    given = ", ".join(f"{key}={value!r}" for key, value in said.items())
    free = "" if tuple(names) == (TUNING,) else f"{list(names)!r}, "
    tune = f"muscle = fit(record, muscle, {free}starts={STARTS}, whole=False).muscle\n"
    if found:
        tune = f"muscle = select_model(record, muscle, starts={STARTS}).calibration.muscle\n"
    if tuned is None:
        tune = ""
    python = (
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
    return Export(
        stem, variables, lambda: plot_fit(measured_with_curves(record, shown, label)), python
    )


EXPORTS: Mapping[str, Callable[[View], Export]] = {
    "muscle": muscle, "bundle": bundle, "reversal": reversal, "efficiency": efficiency,
}  # fmt: skip
_FILES = {"svg": "Picture, SVG", "png": "Picture, PNG", "csv": "Data, CSV",
          "nc": "Data, netCDF", "py": "Python"}  # fmt: skip


def downloads(look: Look, name: str, made: Callable[[], Export]) -> list[Any]:
    """Buttons [-] that give away what the tab `name` [-] shows, once `made` [-]."""

    def file(suffix: str) -> Any:
        return io.BytesIO(made().content(suffix))

    return [
        pn.widgets.FileDownload(
            label=label, filename=f"{name}.{suffix}", callback=lambda s=suffix: file(s),
            stylesheets=[widget_css(look)], width=118, margin=(2, 4),
        )
        for suffix, label in _FILES.items()
    ]  # fmt: skip


def _head(stem: str, what: str, toml: str, imports: str) -> str:
    # a file's text is data in the script: nothing in it may end the string it stands in
    return _HEAD.format(stem=stem, what=what, imports=imports, toml=escaped(toml))


def output_stem(name: str, what: str) -> str:
    """Name of an output without its suffix: never the name of the file that it comes from.

    **Arguments:**

    - `name`: of the file that was read [-].
    - `what`: the output is of it, one word [-].

    **Returns:** letters, digits, dots, dashes and underscores [-].
    """
    # the name is a visitor's: nothing in it may leave a string of the script, or a folder
    stem = re.sub(r"[^\w.-]+", "_", Path(name.replace("\\", "/")).stem).strip(".-")
    return f"{stem or 'file'}_{what}"


def escaped(text: str) -> str:
    """A `text` [-] as it stands between three double quotes in Python."""
    return text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')
