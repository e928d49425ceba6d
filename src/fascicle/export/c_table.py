r"""A muscle or a bundle as a table in C: force and volume from one co-energy, C99, no dependencies.

The table holds the nodes of each different muscle's `MuscleTable`, (V3), in Hermite's form: the
co-energy and its slopes by strain, pressure and both, four numbers instead of a cell's sixteen. In
C they are the same polynomial, so that force and volume come from one table and no cycle creates
energy. At one strain the force in each cell is a cubic of the root of pressure, so that the inverse
finds its roots and extrema exactly. The header states the error of the table.

The inverse chooses as `Bundle.recruit` does, among recruitment states that are written as masks.
`inverse_states.c` takes the first state that gives the force, or of states that aren't nested that
of least fluid; `inverse_sets.c` has (B11), for units that have a pressure each. A joint's is in
`joint_table`.
"""

import os
from collections.abc import Callable, Sequence
from decimal import ROUND_CEILING, Context
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import __version__
from ..bundle import Bundle
from ..bundle.energetics import unit_volume_change
from ..bundle.force_curves import ROOT_TOLERANCE, TIE
from ..bundle.inverse import CLOSE
from ..bundle.states import states_of
from ..control import Joint
from ..core.module import unique_indices
from ..core.types import Values
from ..core.validation import HIGHEST_PRESSURE, check_choice, check_interval
from ..io.atomic import write_text
from ..muscle import Muscle
from ..muscle.table import MuscleTable, volume_errors
from .c_files import (
    c_array,
    check_c_name,
    concrete_bundle,
    length_ratios,
    render_template,
    table_strains,
)
from .joint_table import joint_errors, joint_values, stiffness_rounding


if TYPE_CHECKING:
    from ..control import Cascade


# nodes in pressure and strain: of a computer and of a microcontroller
SHAPES = {"double": (65, 81), "float": (33, 41)}
# any three: the volume is a cubic of strain, zero at rest
_VOLUME_STRAINS = np.array([0.05, 0.1, 0.2])
_LOWEST = -101325.0  # Pa, vacuum in the standard atmosphere
_ROUNDINGS = 12  # of a sum of six products in Hermite's form, for each of both coordinates
_DIGITS = {"double": 2.0**-53, "float": 2.0**-24}  # relative rounding
EDGE = {"double": 1e-12, "float": 2.0**-22}  # relative margin of the highest pressure: rounding


class BundleTables(NamedTuple):
    """Tables of a bundle: `surfaces` of its different muscles, the index of each unit's surface
    (`kinds`), its `counts` and `ratios` [-]; `errors` in words; `precision`, "double" or "float";
    the `target`, a bundle, or a joint of two, agonist's units first; a `controller`, or none.
    """

    surfaces: tuple[MuscleTable, ...]
    kinds: tuple[int, ...]
    counts: tuple[int, ...]
    ratios: tuple[float, ...]
    errors: str
    precision: str
    target: Bundle | Joint
    controller: "Cascade | None" = None

    @property
    def strains(self) -> tuple[float, float]:
        """Limits of the plates' strain [-], or a joint's angle [rad], within all units' tables."""
        ends = np.array([[float(x) for x in self.surfaces[k].strains] for k in self.kinds]).T
        begin, slope = self._plates
        low, high = np.sort((1 - (1 - ends) / np.array(self.ratios) - begin) / slope, axis=0)
        return float(np.max(low)), float(np.min(high))

    def unit_strains(self, strain: np.ndarray) -> np.ndarray:
        """Strains of each unit's muscles [-] at a `strain` of the plates [-], or an angle [rad]."""
        begin, slope = self._plates
        return 1 - np.array(self.ratios)[:, None] * (1 - begin - slope[:, None] * strain)

    @property
    def _plates(self) -> tuple[float, np.ndarray]:
        """Strain of each unit's plates [-] at the strain or angle 0, and its slope by that."""
        joint = self.target
        if not isinstance(joint, Joint):
            return 0.0, np.ones(len(self.kinds))
        first, second = joint.agonist, joint.antagonist
        arms = joint.moment_arm / float(first.length), -joint.moment_arm / float(second.length)
        return joint.strain, np.repeat(arms, [len(first.motor_units), len(second.motor_units)])

    @property
    def pressures(self) -> tuple[float, float]:
        """Limits of the gauge pressure [Pa]: of all units' tables, or of a controller's plant, as a
        closed chamber may come above the table, where the force is linear.
        """
        if self.controller is not None:
            return _LOWEST, float(np.max(self.controller.plant.muscles.highest_pressure))
        return _LOWEST, self.highest_supply

    @property
    def supply_pressure(self) -> float:
        """Gauge pressure [Pa] of the controller's supply, or the highest of the tables."""
        if self.controller is not None:
            return self.controller.plant.supply_pressure
        return self.highest_supply

    @property
    def highest_supply(self) -> float:
        """Highest supply pressure of the inverse [Pa]."""
        top = min(float(surface.highest_pressure) for surface in self.surfaces)
        return float(f"{top:.13g}")  # without the rounding of its root

    @property
    def roundings(self) -> np.ndarray:
        """Errors of single precision in the force of each unit [N]."""
        errors = [_rounding_error(self.surfaces[kind]) for kind in self.kinds]
        return np.array(self.counts) * errors

    @property
    def meets(self) -> float:
        """Largest miss of a force that meets a demand [N]; at least the rounding of all muscles."""
        return float(np.sum(self.roundings)) if self.precision == "float" else ROOT_TOLERANCE

    @property
    def limits_as_text(self) -> dict[str, str]:
        """Limits of strain [-] and pressure [Pa], rounded for comments and messages in C, by their
        names in templates.
        """
        low, high = (f"{x:.6f}" for x in self.strains)
        lowest, highest = (f"{x:.0f}" for x in self.pressures)
        return {"low": low, "high": high, "lowest_pressure": lowest, "highest": highest}

    def code(self, name: str) -> tuple[str, str]:
        """Header and source in C; `name`: prefix of all names."""
        surfaces = self.surfaces
        lines, columns = surfaces[0].coefficients.shape[:2]
        ends = np.array([[float(x) for x in surface.strains] for surface in surfaces])

        def number(value: float) -> str:
            """Number in C, with all its digits."""
            if self.precision == "float":
                return f"{np.format_float_scientific(np.float32(value), trim='0')}f"
            return repr(float(value))

        title = "A muscle" if len(self.kinds) == 1 else "A bundle of muscles"
        initializers = partial(c_array, number=number)
        values = {
            "title": title,
            "version": __version__,
            "name": name,
            "guard": name.upper(),
            "real": self.precision,
            **{name: name + "f" * (self.precision == "float") for name in ("sqrt", "pow")},
            "units": len(self.kinds),
            "kinds": len(surfaces),
            "lines": lines,
            "columns": columns,
            "lowest_pressure_real": number(_LOWEST),
            "highest_real": number(self.pressures[1] * (1 + EDGE[self.precision])),
            "errors": "\n".join(f" * {line}" for line in self.errors.splitlines()),
            "nodes": initializers([nodes(surface) for surface in surfaces]),
            "root_steps": initializers([float(surface.root_step) for surface in surfaces]),
            "tops": initializers([float(surface.highest_pressure) for surface in surfaces]),
            "lows": initializers(ends[:, 0]),
            "highs": initializers(ends[:, 1]),
            "cells": initializers((ends[:, 1] - ends[:, 0]) / columns),
            "lengths": initializers([float(surface.rest_length) for surface in surfaces]),
            "kind_of": c_array(self.kinds),
            "counts": initializers(self.counts),
            "ratios": initializers(self.ratios),
            **self.limits_as_text,
        }
        values |= {"meets": number(self.meets), "inverse_top": number(self.highest_supply)}
        values["digits"] = number(4 * _DIGITS[self.precision])
        values["cubics"] = render_template("cubics.c", values)
        if isinstance(self.target, Joint):
            kind, values["title"] = "joint", "A joint that two muscles or bundles pull"
            values |= joint_values(self.target, number)
        else:
            kind, values["controller"], values["controller_source"] = "bundle", "", ""
            values |= _inverse_code(self.target, self.highest_supply, self.meets, values, number)
            values["curves"] = render_template("table_curves.c", values)
        if self.controller is not None:
            from .controller import template_values  # needs JAX, a table doesn't

            values |= template_values(self.controller, values, number)
            values["controller"] = render_template("controller.h", values)
            values["controller_source"] = render_template("controller.c", values)
        values["functions"] = render_template(f"{kind}.h", values)
        values["functions_source"] = render_template(f"{kind}.c", values)
        return render_template("table.h", values), render_template("table.c", values)


def table_code(
    target: "Muscle | Bundle | Joint | Cascade",
    name: str = "muscle",
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> tuple[str, str]:
    """Header and source of a table in C.

    **Arguments:**

    - `target`: a muscle or bundle with numbers, not arrays; a `Joint` of two of them; or a
      `Cascade` that controls a bundle's force on gas by any policy but "batch", whose step is
      written as well.
    - `name`: prefix of all names in C.
    - `precision`: type of numbers in C, "double" or "float".
    - `highest_pressure`: gauge [Pa]; default: the bundle's supply pressure, or 1 MPa.
    - `shape`: nodes in pressure and in strain; default: 65 and 81, of floats 33 and 41; of a
      `Cascade` in double precision 161 and 201, as it has itself.

    **Raises:** `ValueError` for a name that C doesn't allow, and other invalid arguments.
    """
    return tabulate(target, precision, highest_pressure, shape).code(check_c_name(name))


def write_table(
    target: "Muscle | Bundle | Joint | Cascade",
    folder: str | os.PathLike[str],
    name: str = "muscle",
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> tuple[Path, Path]:
    """Write `NAME.h` and `NAME.c` of a table into a `folder`, created if it is missing; returns
    their paths. Other arguments, `highest_pressure` [Pa] among them, and errors: as `table_code`.
    """
    texts = table_code(target, name, precision, highest_pressure, shape)
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / f"{name}.h", folder / f"{name}.c"
    for path, text in zip(paths, texts, strict=True):
        write_text(path, text)
    return paths


def tabulate(
    target: "Muscle | Bundle | Joint | Cascade",
    precision: str = "double",
    highest_pressure: Values = None,
    shape: tuple[int, int] | None = None,
) -> BundleTables:
    """Tables of a muscle or bundle; arguments as of `table_code`: `highest_pressure` [Pa]."""
    check_choice(precision, SHAPES, "precision")
    if not isinstance(target, Muscle | Bundle | Joint):  # a controller needs JAX, a table doesn't
        from ..control.branches import SHAPE
        from .controller import ROUNDED_COMMANDS, tabulate_controller

        # in double precision Python's own, so that a replay of a run decides alike
        shape = shape or (SHAPE if precision == "double" else SHAPES[precision])
        controller = tabulate_controller(target, shape)
        plant = controller.plant
        tables = tabulate(plant.bundles[0], precision, plant.supply_pressure, shape)
        errors = tables.errors + ROUNDED_COMMANDS * (precision == "float")
        return tables._replace(errors=errors, controller=controller)
    if isinstance(target, Joint):
        bundles = [concrete_bundle(side) for side in (target.agonist, target.antagonist)]
        supply = target.highest_pressure
    else:
        bundles = [target := concrete_bundle(target)]
        supply = target.supply_pressure
    units = [unit for bundle in bundles for unit in bundle.motor_units]
    if highest_pressure is None:
        highest_pressure = HIGHEST_PRESSURE if supply is None else supply
    indices, kinds = unique_indices([unit.muscle for unit in units])
    limits = (0.0, HIGHEST_PRESSURE, "highest_pressure", "Pa")
    top = check_interval(highest_pressure, *limits, closed=(False, True))
    strains = [ends for bundle in bundles for ends in table_strains(bundle)]
    ratios = tuple(ratio for bundle in bundles for ratio in length_ratios(bundle))
    muscles = [units[i].muscle for i in indices]
    shape = shape or SHAPES[precision]
    surfaces = tuple(units[i].muscle.table(top, strains[i], shape) for i in indices)
    counts = tuple(int(unit.count) for unit in units)
    tables = BundleTables(surfaces, kinds, counts, ratios, "", precision, target)
    return tables._replace(errors=_error_text(tables, muscles))


def nodes(surface: MuscleTable) -> np.ndarray:
    """Values and slopes of a table at its nodes for Hermite interpolation, [line, column, 4]: the
    co-energy [J] and its slopes by strain, per cell [J], by pressure [m³], by both, per cell [m³].
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
    # each node from its cell, those of the last line and column from the cells before
    for a, rows in ((1, slice(1, None)), (0, slice(None, -1))):
        for b, cols in ((1, slice(1, None)), (0, slice(None, -1))):
            values = corner[..., 2 * a : 2 * a + 2, 2 * b : 2 * b + 2].copy()
            values[..., 1, :] /= by_P[a][..., None]
            tables[rows, cols] = values.reshape(lines, columns, 4)
    return tables


def _error_text(tables: BundleTables, muscles: Sequence[Muscle]) -> str:
    """Errors of one muscle's table, the largest of all kinds, and of the bundle's force, in words;
    `muscles`: of the different tables.
    """
    force = np.max([surface.errors for surface in tables.surfaces], axis=0)
    volumes = [
        np.quantile(volume_errors(surface, muscle.law), (0.5, 0.99, 1.0))
        for surface, muscle in zip(tables.surfaces, muscles, strict=True)
    ]
    volume = 1e6 * np.max(volumes, axis=0)
    text = (
        "Error of the table for one muscle, measured between its nodes and at its kinks:\n"
        f"force {force[0]:.1g} N (median), {force[1]:.1g} N (99th percentile), {_up(force[2])} N"
        f" (largest);\nvolume {volume[0]:.1g} mL (median), {volume[1]:.1g} mL (99th percentile),"
        f" {_up(volume[2])} mL (largest)."
    )
    joint = tables.target
    if isinstance(joint, Joint):
        errors = joint_errors(tables, joint, muscles)
        torque, stiffness = (list(map(_up, pair)) for pair in (errors.torque, errors.stiffness))
        text += (
            f"\nThe joint: torque {torque[0]} N m (largest in the inner half of the angles),"
            f" {torque[1]} N m (largest);\nstiffness, valves open, {errors.median:.1g} N m/rad"
            f" (median), {errors.most:.1g} N m/rad (99th percentile),\n{stiffness[0]} N m/rad"
            f" (largest in the inner half of the angles), {stiffness[1]} N m/rad (largest)."
        )
    elif np.sum(tables.counts) > 1:
        # muscles at one strain may err the same way, whatever their pressures
        largest = np.dot(tables.counts, [tables.surfaces[kind].errors[2] for kind in tables.kinds])
        text += f"\nAll muscles together: force {_up(largest)} N (the sum of the largest)."
    if tables.precision == "float":
        text += f"\nIts rounding adds up to {max(map(_rounding_error, tables.surfaces)):.1g} N"
        if isinstance(joint, Joint):
            torque = joint.moment_arm * np.sum(tables.roundings)
            stiffness = stiffness_rounding(tables, joint)
            text += f", of the joint to {torque:.1g} N m and {stiffness:.1g} N m/rad"
        text += "."
    return text


def _up(value: float) -> str:
    """Two digits of an error, rounded up."""
    return f"{float(Context(prec=2, rounding=ROUND_CEILING).create_decimal(float(value))):g}"


def _rounding_error(surface: MuscleTable) -> float:
    """Estimate of single precision's error in a force [N]: roundings of co-energy over a cell."""
    table = nodes(surface)
    low, high = (float(x) for x in surface.strains)
    step = (high - low) / (table.shape[1] - 1)
    largest = np.max(np.abs(table[..., 0])) + np.max(np.abs(table[..., 1]))
    return float(_ROUNDINGS * 2.0**-24 * largest / (step * float(surface.rest_length)))


def _inverse_code(
    bundle: Bundle, highest: float, meets: float, names: dict[str, Any], number: Callable
) -> dict[str, Any]:
    """Values of the templates for the inverse of a bundle in C, besides the `names`: up to the
    `highest` supply pressure [Pa], forces within `meets` of the demand [N]; `number` formats one.
    """
    kinds = unique_indices([unit.muscle for unit in bundle.motor_units])[1]
    states = states_of(bundle.scheme, len(kinds))
    sets, owners = states.sets(unique_indices(bundle.motor_units)[1])
    needs_fluid = states.independent or not states.nested
    values = names | {
        "scheme": bundle.scheme.name,
        "inverse_highest": f"{highest:.0f}",
        "meets_text": f"{meets:.1g}",
        "tie": number(max(TIE, meets / 2)),
        "close": number(CLOSE),
        "first_units": c_array([kinds.index(kind) for kind in range(max(kinds) + 1)]),
        "states": sets.size,
        "full": c_array(sets.full.astype(int)).replace("\n", " "),
        "throttled": c_array(sets.throttled.astype(int)).replace("\n", " "),
        "owners": c_array(owners + 1),
        "is_nested": int(not needs_fluid),
        "fluid": "0",
        "fluid_code": "",
    }
    if needs_fluid:
        values["fluid"] = "fluid_of(is_full[k], strain) + fluid_of(is_throttled[k], strain)"
        change = np.asarray(unit_volume_change(bundle, _VOLUME_STRAINS)) / _VOLUME_STRAINS[:, None]
        coefficients = np.linalg.solve(np.vander(_VOLUME_STRAINS, increasing=True), change).T
        values["volumes"] = c_array(coefficients, number)
        values["fluid_code"] = "\n" + render_template("inverse_fluid.c", values)
    files = "inverse_begin.c", "inverse_sets.c" if states.independent else "inverse_states.c"
    return values | {
        "inverse": render_template("inverse.h", values),
        "inverse_source": "".join(render_template(file, values) for file in files),
    }
