"""A page of a muscle or bundle: one HTML file that needs nothing else.

It holds the table of each different muscle, as the C code does, and states its error. Its scripts
draw force and deflection over contraction and, of a bundle, the free strain over the second unit's
pressure.
"""

import base64
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__
from ..bundle import Bundle
from ..bundle.reversal import free_strain_curve, reversal
from ..core.errors import InvalidInputError, require
from ..core.types import Numbers
from ..core.validation import HIGHEST_PRESSURE
from ..io.atomic import write_text
from ..muscle import Muscle, MuscleTable
from .c_files import concrete_bundle
from .c_table import nodes, tabulate


if TYPE_CHECKING:
    from ..plot.theme import Colors


CURVES = tuple(1e3 * pressure for pressure in (0.0, 100.0, 200.0, 300.0, 400.0))  # Pa
FOLDER = Path(__file__).with_name("page")
_SCRIPTS = ("table.js", "page.js")
_MOST_UNITS, _MOST_MUSCLES = 8, 60  # as in the explorer: more can't be told apart
_MOST_CURVES = 12  # as the page's own field allows
_START = 1 / 3, 0.1  # pressure at first, over the highest, and strain
_POINTS = 97  # of the free strain over the second unit's pressure


def page_text(
    target: Muscle | Bundle, title: str = "Muscle", pressures: Sequence[float] = CURVES
) -> str:
    """HTML of the page of a muscle or bundle, `target`, which holds numbers, not arrays.

    `title`: of the page; `pressures`: of the thin curves [Pa], at most twelve. `ValueError` for
    more units or muscles than can be told apart, and for pressures off the domain.
    """
    require("matplotlib")  # of its theme, which has the colors; jinja2 is of the same extra
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    from ..plot.curves import split_at_reversal
    from ..plot.theme import DARK, LIGHT, SANS, css

    bundle = concrete_bundle(target)
    values = _page_values(bundle, title, pressures)
    theme = {"light": _theme(LIGHT), "dark": _theme(DARK)}
    data = values.pop("data") | {"theme": theme, "font": SANS, "reversal": None}
    if len(bundle.motor_units) > 1:
        first, second = data["highest"], np.linspace(0.0, data["highest"], _POINTS)
        turn = reversal(bundle, 2, first)
        strains = free_strain_curve(bundle, 2, second, first)
        curve, jump = map(_line_data, split_at_reversal(second, strains, turn))
        turn_data = {"turn": [turn.pressure, turn.free_strain], "jump": jump}
        data["reversal"] = curve | turn_data
    options = {"undefined": StrictUndefined, "trim_blocks": True, "lstrip_blocks": True}
    environment = Environment(loader=FileSystemLoader(FOLDER), autoescape=True, **options)
    script = "\n".join((FOLDER / name).read_text(encoding="utf-8") for name in _SCRIPTS)
    # "<" ends no script in JSON; the scripts are fascicle's own
    text = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    return environment.get_template("page.html").render(
        values,
        version=__version__,
        light=Markup(css(LIGHT)),  # noqa: S704 fascicle's own
        dark=Markup(css(DARK)),  # noqa: S704 fascicle's own
        data=Markup(text),  # noqa: S704 escaped above
        script=Markup(script),  # noqa: S704 fascicle's own
    )


def write_page(
    target: Muscle | Bundle,
    path: str | os.PathLike[str],
    title: str = "Muscle",
    pressures: Sequence[float] = CURVES,
) -> Path:
    """Write the page of a muscle or bundle to the file `path`, which it returns; arguments and
    errors are those of `page_text`: `pressures` [Pa].
    """
    path = Path(path)
    write_text(path, page_text(target, title, pressures))
    return path


def _page_values(bundle: Bundle, title: str, pressures: Sequence[float]) -> dict[str, Any]:
    """Values of the template; `data` is what the scripts compute with [SI]."""
    curves = sorted({float(pressure) for pressure in pressures})
    if len(curves) > _MOST_CURVES or not all(0 <= x <= HIGHEST_PRESSURE for x in curves):
        rule = f"must be at most {_MOST_CURVES} in 0 to {HIGHEST_PRESSURE / 1e3:g} kPa"
        raise InvalidInputError("pressure", rule, curves, shown=f"{len(curves)} pressures")
    units, count = bundle.motor_units, int(np.sum(bundle.counts))
    if len(units) > _MOST_UNITS or count > _MOST_MUSCLES:
        rule = f"must have at most {_MOST_UNITS} motor units and {_MOST_MUSCLES} muscles"
        raise InvalidInputError("bundle", rule, count, shown=f"{len(units)} and {count}")
    supply = bundle.supply_pressure
    highest = max(curves, default=0.0) or CURVES[-1] if supply is None else float(supply)
    tables = tabulate(bundle, highest_pressure=max(highest, *curves))
    largest = tables.strains[1]
    is_bundle, first = count > 1, units[0].muscle
    laws = f"{first.tension.name}, {first.buckling.name}"
    pressure = float(f"{_START[0] * highest:.2g}")
    start = [highest, pressure] + [0.0] * len(units) if len(units) > 1 else [pressure]
    return {
        "title": title,
        "lead": f"{f'Bundle of {count} muscles' if is_bundle else 'Muscle'}; laws: {laws}.",
        "note": f"Made by fascicle {__version__}. The page loads nothing. Gauge pressures;"
        " contraction over the length at rest.",
        "kind": "bundle" if is_bundle else "muscle",
        "bundle": is_bundle,
        "units": [{"count": int(unit.count)} for unit in units],
        "errors": tables.errors,
        "curves": ", ".join(f"{pressure / 1e3:.6g}" for pressure in curves),
        "highest": f"{highest / 1e3:.9g}",
        "largest_strain": f"{largest:.9g}",
        "data": {
            "title": title,
            "units": [
                {"muscle": kind, "count": count}
                for kind, count in zip(tables.kinds, tables.counts, strict=True)
            ],
            "tables": [_table_data(table) for table in tables.surfaces],
            "ratios": tables.ratios,
            "highest": highest,
            "start": start[: len(units)],
            "strain": min(_START[1], largest),
            "curves": curves,
        },
    }


def _line_data(line: tuple[np.ndarray, np.ndarray]) -> dict[str, list[float | None]]:
    """Pressures [kPa] and strains [-] of a line for the page's scripts, null in its gaps."""
    pressure, strain = line
    y = [float(value) if np.isfinite(value) else None for value in strain]
    return {"x": (pressure / 1e3).tolist(), "y": y}


def _table_data(table: MuscleTable) -> dict[str, object]:
    """Numbers of a `table` for the page's scripts; arrays are doubles in base64."""
    lines, columns = table.coefficients.shape[:2]
    low, high = map(float, table.strains)

    def encode(values: Numbers) -> str:
        """Base64 of `values` as little-endian float64."""
        return base64.b64encode(np.asarray(values, "<f8").tobytes()).decode("ascii")

    return {
        "lines": lines,
        "columns": columns,
        "rootStep": float(table.root_step),
        "low": low,
        "high": high,
        "length": float(table.rest_length),
        "nodes": encode(nodes(table)),
        "kinks": encode(table.kinks),
        "bows": encode(table.bows),
    }


def _theme(colors: "Colors") -> dict[str, object]:
    """Colors by name for the page's scripts, which draw its figures, from these `colors`."""
    from ..plot.theme import mix

    names = ("ink", "soft", "edge", "line", "paper", "bad", "curves")
    family = [mix(colors.curves[3], colors.good, i / 7) for i in range(8)]
    return {**{name: getattr(colors, name) for name in names}, "family": family}
