r"""A muscle or a bundle as a table in C: force and volume from one co-energy, C99, no dependencies.

What is written are the nodes of each unlike muscle's `UnitSurface`, (V3), as Hermite has them: the
co-energy and its slopes by strain, pressure and both, four numbers instead of a cell's sixteen. In
C they are the same polynomial, so that force and volume come from one table and no cycle makes
energy. How far the table is off the law stands in the header.
"""

import re
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .. import __version__
from ..bundle import Bundle
from ..bundle.pressurized import unique_indices
from ..control import Cascade
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import HIGHEST_PRESSURE, check_choice
from ..muscle import Muscle
from ..muscle.surface import UnitSurface, table_error
from .c_files import checked_bundle, checked_name, write_c_files
from .controlling import on_table
from .controlling import words as controls


# nodes in pressure and strain: of a computer and of a microcontroller
SHAPES = {"double": (65, 81), "float": (33, 41)}
_LOWEST = -101325.0  # Pa, no fluid at all in a usual room
# of a sum of six products in Hermite's form, for each of both coordinates
_ROUNDINGS = 12


class Tabulated(NamedTuple):
    """A bundle's tables: `surfaces` of its unlike muscles, and of each unit which of these it has
    (`kinds`), its `counts` and `ratios` [-]; `errors` in words; a `controller` on them, or none.
    """

    surfaces: tuple[UnitSurface, ...]
    kinds: tuple[int, ...]
    counts: tuple[int, ...]
    ratios: tuple[float, ...]
    errors: str
    controller: Cascade | None = None

    @property
    def strains(self) -> tuple[float, float]:
        """Ends [-] of the plates' strain between which all units' tables are."""
        ends = np.array([[float(x) for x in self.surfaces[k].strains] for k in self.kinds]).T
        low, high = 1 - (1 - ends) / np.array(self.ratios)
        return float(np.max(low)), float(np.min(high))

    @property
    def size(self) -> int:
        """How many numbers its tables have [-]."""
        return sum(nodes(surface).size for surface in self.surfaces)


def table_code(
    target: Muscle | Bundle | Cascade,
    name: str = "muscle",
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> tuple[str, str]:
    """Header and source of a muscle's or bundle's table in C.

    **Arguments:**

    - `target`: the muscle or bundle [-], with numbers, not arrays; or a `Cascade` that controls a
      bundle's force on gas by "orderly" or "threshold", whose step is written as well.
    - `name`: with which all names in C begin [-].
    - `precision`: of numbers in C, "double" or "float" [-].
    - `highest_pressure`: the table's end [Pa]; left out, the bundle's supply pressure, or 1 MPa.
    - `shape`: nodes in pressure and in strain [-]; left out, 65 and 81, of floats 33 and 41.

    **Returns:** the header's text and the source's [-].

    **Raises:** `ValueError` for a name that C can't have, what isn't one muscle or bundle, and ends
    and shapes that can't be.
    """
    table = tabulated(target, precision, highest_pressure, shape)
    return written(table, checked_name(name), precision)


def write_table(
    target: Muscle | Bundle | Cascade,
    folder: Values,
    name: str = "muscle",
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> tuple[Path, Path]:
    """Write `NAME.h` and `NAME.c` of a table into a folder.

    **Arguments:** those of `table_code`, and

    - `target`, `name`, `precision`, `shape`: as there [-].
    - `folder`: where to [-]; made where it isn't.
    - `highest_pressure`: the table's end [Pa].

    **Returns:** the paths of header and source [-].

    **Raises:** as `table_code`.
    """
    texts = table_code(target, name, precision, highest_pressure, shape)
    return write_c_files(texts, folder, name)


def tabulated(
    target: Muscle | Bundle | Cascade,
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> Tabulated:
    """The tables [-] of a muscle or bundle, `target` [-], for a `precision` [-], up to
    `highest_pressure` [Pa], of a `shape` [-]; left out as in `table_code`.
    """
    check_choice(precision, SHAPES, "precision")
    if isinstance(target, Cascade):
        if precision == "float":
            raise InvalidInputError("precision", "must be double of a controller", precision)
        tables = on_table(target, shape or SHAPES[precision])
        plant = tables.plant
        top = np.max(plant.muscles.highest_pressure)
        return tabulated(plant.bundles[0], precision, top, shape)._replace(controller=tables)
    bundle = checked_bundle(target, "a Muscle or a Bundle, or a Cascade")
    units = bundle.motor_units
    if highest_pressure is None:
        supply = bundle.supply_pressure
        highest_pressure = HIGHEST_PRESSURE if supply is None else supply
    nodes_kept, kinds = unique_indices([unit.muscle for unit in units])
    muscles = [units[i].muscle for i in nodes_kept]
    surfaces = tuple(
        UnitSurface.tabulate(muscle, highest_pressure, shape=shape or SHAPES[precision])
        for muscle in muscles
    )
    ratios = (1.0,) * len(units) if bundle.ratios is None else map(float, bundle.ratios)
    counts = tuple(int(unit.count) for unit in units)
    return Tabulated(surfaces, kinds, counts, tuple(ratios), _errors(muscles, surfaces, precision))


def nodes(surface: UnitSurface) -> np.ndarray:
    """Hermite's numbers of a table at its nodes: [line, column, 4], the co-energy [J] and its
    slopes by strain, for a cell [J], by pressure [m³] and by both, for a cell [m³].
    """
    c = np.asarray(surface.coefficients)
    lines, columns = c.shape[:2]
    h = float(surface.root_step)
    # value and slope of a cubic at its beginning and at its end
    ends = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 1, 1, 1], [0, 1, 2, 3]], float)
    corner = ends @ c @ ends.T
    i = np.arange(lines)[:, None]
    by_P = np.where(i > 0, 2 * i * h**2, h**2), np.where(i > 0, 2 * (i + 1) * h**2, h**2)
    tables = np.empty((lines + 1, columns + 1, 4))
    # each node from its own cell, those of the last line and column from the ones before
    for a, rows in ((1, slice(1, None)), (0, slice(None, -1))):
        for b, cols in ((1, slice(1, None)), (0, slice(None, -1))):
            u, w = 2 * a, 2 * b
            tables[rows, cols] = np.stack([
                corner[..., u, w], corner[..., u, w + 1],
                corner[..., u + 1, w] / by_P[a], corner[..., u + 1, w + 1] / by_P[a],
            ], axis=-1)  # fmt: skip
    return tables


def written(table: Tabulated, name: str, precision: str) -> tuple[str, str]:
    """Header and source [-] of the tables `table` [-], by a `name` [-] and in a `precision` [-]."""
    number = _numbers(precision)
    low, high = table.strains
    surfaces = table.surfaces
    lines, columns = surfaces[0].coefficients.shape[:2]
    tops = [float(value.highest_pressure) for value in surfaces]
    ends = [[float(x) for x in value.strains] for value in surfaces]
    names = {
        "title": "A muscle" if len(table.kinds) == 1 else "A bundle of muscles",
        "version": __version__,
        "name": name,
        "guard": name.upper(),
        "real": precision,
        "sqrt": "sqrtf" if precision == "float" else "sqrt",
        "units": len(table.kinds),
        "kinds": len(surfaces),
        "lines": lines,
        "columns": columns,
        "lowest_pressure": f"{_LOWEST:.0f}",
        "lowest_pressure_real": number(_LOWEST),
        "highest": f"{min(tops):.0f}",
        "low": f"{low:.6f}",
        "high": f"{high:.6f}",
        "rounding": number(1 + (1e-12 if precision == "double" else 2.0**-22)),
        "errors": "\n".join(f" * {line}" for line in table.errors.splitlines()),
        "nodes": ",\n".join(_table(nodes(value), number) for value in surfaces),
        "root_steps": _row((float(value.root_step) for value in surfaces), number),
        "tops": _row(tops, number),
        "lows": _row((low for low, _ in ends), number),
        "highs": _row((high for _, high in ends), number),
        "cells": _row(((high - low) / columns for low, high in ends), number),
        "lengths": _row((float(value.rest_length) for value in surfaces), number),
        "kind_of": ", ".join(map(str, table.kinds)),
        "counts": _row(table.counts, number),
        "ratios": _row(table.ratios, number),
        "controller": "",
        "controller_source": "",
    }
    if table.controller is not None:
        names |= controls(table.controller, number)
        names["controller"] = filled("controller.h", names)
        names["controller_source"] = filled("controller.c", names)
    return filled("table.h", names), filled("table.c", names)


def filled(file: str, names: dict[str, Any]) -> str:
    """The text of a C `file` [-] beside this module with `names` [-] in their places."""
    text = (files("fascicle.export") / "c" / file).read_text(encoding="utf-8")
    tables = re.sub(r"@(\w+)@", lambda table: str(names[table[1]]), text)
    return tables.rstrip("\n") + "\n"


def _numbers(precision: str) -> Any:
    """How numbers are written in C: with as many digits as they have."""
    if precision == "float":
        return lambda x: f"{np.format_float_scientific(np.float32(x), trim='0')}f"
    return lambda x: repr(float(x))


def _row(values: Any, number: Any) -> str:
    return ", ".join(number(x) for x in values)


def _table(of: np.ndarray, number: Any) -> str:
    lines = (",\n".join("{" + _row(node, number) + "}" for node in line) for line in of)
    return "{" + ",\n".join("{" + line + "}" for line in lines) + "}"


def _errors(muscles: Sequence[Muscle], surfaces: Sequence[UnitSurface], precision: str) -> str:
    """How far one muscle's table is off its law, the worst of all kinds, in words."""
    off = [table_error(value, muscle) for value, muscle in zip(surfaces, muscles, strict=True)]
    force, volume = (
        np.max([np.quantile(value[of], (0.5, 0.99, 1.0)) for value in off], axis=0) for of in (0, 1)
    )
    rounded = max(_rounding(value) for value in surfaces)
    text = (
        "How far it is off the law, between all nodes: one muscle's\n"
        f"force is off by {force[0]:.1g} N (median), {force[1]:.1g} N (99 %), {force[2]:.2g} N at"
        " most,\n"
        f"volume by {1e6 * volume[0]:.1g} mL (median), {1e6 * volume[1]:.1g} mL (99 %),"
        f" {1e6 * volume[2]:.2g} mL at most."
    )
    if precision == "float":
        text += f"\nIts rounding adds up to {rounded:.1g} N."
    return text


def _rounding(surface: UnitSurface) -> float:
    """Error of single precision in a force [N]: the co-energy's last digit over a cell."""
    table = nodes(surface)
    low, high = (float(x) for x in surface.strains)
    step = (high - low) / (table.shape[1] - 1)
    largest = np.max(np.abs(table[..., 0])) + np.max(np.abs(table[..., 1]))
    return float(_ROUNDINGS * 2.0**-24 * largest / (step * float(surface.rest_length)))
