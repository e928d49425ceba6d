"""Downloads of a tab: its picture, its data, and a Python script that makes both.

The picture is one of `fascicle.plot`; the data are a table of `fascicle.tables`, with the columns
of the command line, where there is one of that kind, else labeled variables. The script is text for
a reader; it is never run here.
"""

import asyncio
import io
import re
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import panel as pn
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..bundle import Bundle
from ..calibrate.plot_data import measured_with_curves
from ..core.validation import HIGHEST_PRESSURE
from ..files import dumps
from ..muscle import Muscle
from ..plot.calibration import fit as draw_fit
from ..plot.curves import force_comparison
from ..plot.theme import to_bytes
from ..records.record import Record
from ..results import Table, Variable, tables
from .measured import AUTOMATIC, STARTS, TUNING
from .muscle_curves import strain_limit
from .pins import top_strain
from .state import View
from .widgets import Message, widget
from .worker import result_and_error


_STRAINS = 201  # along a muscle's curve
_TEMPLATES = Environment(  # noqa: S701 Python, not HTML
    loader=FileSystemLoader(Path(__file__).with_name("scripts")),
    keep_trailing_newline=True,
    trim_blocks=True,
    undefined=StrictUndefined,
)


def _toml(target: Muscle | Bundle) -> str:
    """Text of a file, escaped to stand between triple quotes in a script."""
    return dumps(target).replace("\\", "\\\\").replace('"""', '\\"\\"\\"')


_TEMPLATES.filters |= {"repr": repr, "toml": _toml}


@dataclass(frozen=True)
class Export:
    """A tab's data as `variables` by name, its `figure`, and a `script` that makes both."""

    stem: str
    variables: Table
    figure: Callable[[], Any]
    script: str

    def content(self, suffix: str) -> bytes:
        """Bytes of a picture (svg, png, pdf), of data (csv, nc) or of the script, by `suffix`."""
        if suffix in ("svg", "png", "pdf"):
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
    """Downloads of the muscle's curve at the view's pressure."""
    stem = output_stem(view.name, "force", input_names)
    top, P = strain_limit(view.muscle, view.supply), view.pressure
    strain = np.linspace(0.0, top, _STRAINS)
    script = _script("muscle", stem, view.muscle, pressure=P, top=top, points=_STRAINS)
    variables = tables.muscle_force(view.muscle, [P], strain)
    return Export(stem, variables, lambda: view.muscle.plot([P], strain), script)


def bundle(view: View, input_names: Iterable[str] = ()) -> Export:
    """Downloads of the bundle's force-strain workspace."""
    stem, target = output_stem(view.name, "space", input_names), view.bundle
    script = _script("bundle", stem, target, resistance=view.resistance)
    variables = tables.space(target.workspace(resistance=view.resistance))
    return Export(stem, variables, lambda: target.plot(resistance=view.resistance), script)


def comparison_downloads(view: View, input_names: Iterable[str] = ()) -> Export:
    """Downloads of the view's pins; there must be one."""
    stem = output_stem(view.name, "compare", input_names)
    top = top_strain(view.pins)
    strain, chosen = np.linspace(0.0, top, _STRAINS), min(view.strain, top)
    muscles = {pin.name: pin.muscle for pin in view.pins}
    pressures = [pin.pressure for pin in view.pins]
    script = _TEMPLATES.get_template("compare.py.jinja").render(
        stem=stem, pins=view.pins, top=top, points=_STRAINS, chosen_strain=chosen
    )
    variables = tables.force_comparison(muscles, pressures, strain, chosen)
    picture = lambda: force_comparison(muscles, pressures, strain, chosen)  # noqa: E731 drawn late
    return Export(stem, variables, picture, script)


def data(
    muscle: Muscle,
    record: Record,
    tuned: Muscle | None,
    name: str,
    options: Mapping[str, Any],
    names: Sequence[str] = (AUTOMATIC,),
    input_names: Iterable[str] = (),
) -> Export:
    """Downloads of a record and the muscle, or the one `tuned` to it by constants of `names`."""
    stem = output_stem(name, "comparison", [name, *input_names])
    drawn, label = (muscle, "the muscle") if tuned is None else (tuned, "tuned")
    P = np.clip(record.pressure, 0.0, HIGHEST_PRESSURE)
    variables = Table(
        pressure=Variable(("reading",), record.pressure, "Pa"),
        strain=Variable(("reading",), record.strain, "-"),
        force=Variable(("reading",), record.force, "N"),
        muscle=Variable(("reading",), np.asarray(drawn.force(P, record.strain)), "N"),
    )
    script = _script(
        "data", stem, muscle, name=name, highest=HIGHEST_PRESSURE, label=label, starts=STARTS,
        keywords={**options, "rest_length": record.rest_length}, fit=tuned is not None,
        automatic=tuple(names) == (AUTOMATIC,),
        constants=[] if tuple(names) == (TUNING,) else list(names),
    )  # fmt: skip
    picture = lambda: draw_fit(measured_with_curves(record, drawn, label))  # noqa: E731 drawn late
    return Export(stem, variables, picture, script)


EXPORTS: Mapping[str, Callable[[View, Iterable[str]], Export]] = {
    "muscle": muscle,
    "bundle": bundle,
}
_FILES = {"svg": "SVG", "png": "PNG", "pdf": "PDF", "csv": "CSV", "nc": "netCDF", "py": "Python"}


def download_buttons(export: Callable[[], Export], message: Message, **options: Any) -> list[Any]:
    """Buttons that download the files of an `export`, made when one is pressed."""

    def make_button(suffix: str, label: str) -> Any:
        def stem_and_bytes() -> tuple[str, bytes]:
            result = export()
            return result.stem, result.content(suffix)

        return download_button(f"Download {label}", suffix, stem_and_bytes, message, **options)

    return [make_button(suffix, label) for suffix, label in _FILES.items()]


def download_button(
    label: str,
    suffix: str,
    content: Callable[[], tuple[str, bytes]],
    message: Message,
    **options: Any,
) -> Any:
    """Button that downloads a file with a `suffix`; `content` gives its stem and its bytes.

    If there is no file, `message` says why.
    """

    async def make_file() -> io.BytesIO:
        """Content of the file; also sets the button's filename."""
        result, error = result_and_error(content)
        if error is not None:
            message.show(f"{label}: the file can't be made. {error}")
            raise asyncio.CancelledError  # nothing to send
        stem, raw = result
        message.show("")
        button.filename = f"{stem}.{suffix}"
        return io.BytesIO(raw)

    button = widget(
        pn.widgets.FileDownload, label, filename=f"fascicle.{suffix}", callback=make_file,
        **{"width": 146, "margin": (2, 4)} | options,
    )  # fmt: skip
    return button


def output_stem(name: str, kind: str, input_names: Iterable[str] = ()) -> str:
    """Name of an output without its suffix, never that of a file that was read."""
    # the name is a visitor's: nothing in it may leave a string of the script, or a folder
    base = Path(name.replace("\\", "/")).name
    base = re.sub(r"\.(toml|csv|txt|tsv)$", "", base, flags=re.IGNORECASE)
    safe = re.sub(r"[^\w.-]+", "_", base).strip(".-") or "file"
    stem = f"{safe}_{kind}"
    stems = {Path(input_name).stem.lower() for input_name in input_names}
    while stem.lower() in stems:
        stem = f"{stem}_{kind}"
    return stem


def _script(kind: str, stem: str, target: Muscle | Bundle, **values: Any) -> str:
    """Script of a `kind` that loads a `target`; its template writes `values` as Python's."""
    variable = "muscle" if isinstance(target, Muscle) else "bundle"
    template = _TEMPLATES.get_template(f"{kind}.py.jinja")
    return template.render(stem=stem, variable=variable, target=target, **values)
