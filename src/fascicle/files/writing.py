"""From a `Muscle` or a `Bundle` to a TOML file that reads back to the same bits.

Lines are put together here: each number is text with its unit before any TOML is, and tomlkit has
no inline tables spaced as people write them.
"""

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..bundle import Bundle
from ..bundle.schemes import name_of
from ..core.errors import InvalidInputError
from ..core.parameters import Constant
from ..io.atomic import write_text
from ..muscle import Muscle
from ..muscle.fitted_length import fit_info_entries
from ..muscle.law import AbstractLaw
from ..muscle.laws import LAWS, is_written_out
from ..muscle.materials import MATERIALS, MooneyRivlin
from ..muscle.tuning import Tuning
from ..units import DIMENSIONS, exact
from .calibration import calibration_text


def save(
    obj: Any, path: str | os.PathLike[str], calibration: Mapping[str, Any] | None = None
) -> None:
    """Write a muscle file, whole or not at all.

    **Arguments:**

    - `obj`: a `Muscle` or a `Bundle` [-].
    - `path`: where it goes [-]; a file that is there is replaced.
    - `calibration`: where it comes from [-], as `dumps` takes it.

    **Raises:** `ValueError` for anything that a file can't describe; `OSError` where it
    can't be written.
    """
    write_text(path, dumps(obj, calibration))


def dumps(obj: Any, calibration: Mapping[str, Any] | None = None) -> str:
    """Write what a muscle file holds.

    **Arguments:**

    - `obj`: a `Muscle` or a `Bundle` [-].
    - `calibration`: where it comes from [-]: text, numbers, booleans and lists of them by
      key, and one level of tables or lists of tables; `provenance` reads it back. Left out, the
      length at which a muscle that remembers one was fitted.

    **Returns:** the TOML [-]; `loads` gives back every parameter bitwise.

    **Raises:** `ValueError` for anything that a file can't describe.
    """
    text = "\n".join(["format = 1", "", *_lines(obj)]) + "\n"
    told = _remembered(obj) or None if calibration is None else calibration
    return text if told is None else f"{text}\n{calibration_text(told)}"


def _remembered(obj: Any) -> dict[str, Any]:
    """Of a muscle that was fitted, or a bundle of such ones alone: at which length."""
    muscles = [obj] if isinstance(obj, Muscle) else [unit.muscle for unit in obj.motor_units]
    told = [fit_info_entries(one) for one in muscles]
    same = all(one == muscles[0] for one in muscles) and all(one == told[0] for one in told)
    return told[0] if same else {}


def _lines(obj: Any) -> list[str]:
    if isinstance(obj, Muscle):
        return _muscle(obj, "muscle")
    if isinstance(obj, Bundle):
        return _bundle(obj)
    raise ValueError(f"only a Muscle or a Bundle can be saved, got {type(obj).__name__}.")


def _muscle(muscle: Muscle, table: str) -> list[str]:
    collapse = [
        f"law = {_law(muscle.collapse, 'collapse')}",
        f"transition_rate = {_number(muscle.transition_rate, 'transition_rate')}",
        *(f"{key} = {text}" for key, text in _own(muscle.collapse).items()),
    ]
    lines = [
        f"[{table}]",
        *(
            f"{name} = {_quantity(getattr(muscle, name), dimension, name)}"
            for name, dimension in (
                ("length", "length"),
                ("outer_radius", "length"),
                ("wall_thickness", "length"),
                ("braid_angle", "angle"),
            )
        ),
        f"material = {_material(muscle.material)}",
        *(
            f"{kind} = {_chosen(getattr(muscle, kind), kind)}"
            for kind in LAWS
            if kind != "collapse" and is_written_out(kind, getattr(muscle, kind))
        ),
        "",
        f"[{table}.collapse]",
        *collapse,
    ]
    tuning = _tuning(muscle.tuning)
    return [*lines, "", f"[{table}.tuning]", *tuning] if tuning else lines


def _chosen(law: Any, kind: str) -> str:
    """The law's name, with its own numbers where they aren't the default ones."""
    name, own = _law(law, kind), _own(law)
    if not own:
        return name
    return f"{{ law = {name}, {', '.join(f'{key} = {text}' for key, text in own.items())} }}"


def _own(law: AbstractLaw) -> dict[str, str]:
    """A law's numbers and what else it lets choose, by key; none where all are the default's."""
    numbers = {one.name: _written(getattr(law, one.name), one) for one in law.constants()}
    names = {one.name: json.dumps(getattr(law, one.name)) for one in law.switches()}
    usual = all(getattr(law, one.name) == one.default for one in law.constants()) and all(
        getattr(law, one.name) == one.options[0] for one in law.switches()
    )
    return {} if usual else numbers | names


def _written(value: Any, constant: Constant) -> str:
    unitless = DIMENSIONS[constant.dimension].unitless
    name = constant.name
    return _number(value, name) if unitless else _quantity(value, constant.dimension, name)


def _material(material: Any) -> str:
    if type(material) is not MooneyRivlin:
        raise InvalidInputError("material", "can be saved if it is a MooneyRivlin", material)
    entries = {one.name: _written(getattr(material, one.name), one) for one in material.constants()}
    for name, known in MATERIALS.items():
        if material == known:
            return json.dumps(name)
    return f"{{ {', '.join(f'{key} = {text}' for key, text in entries.items())} }}"


def _tuning(tuning: Tuning) -> list[str]:
    lines = []
    if np.size(tuning.pressures) > 1:  # the row at zero pressure alone is the identity
        for key, values, dimension in (
            ("pressure", tuning.pressures, "pressure"),
            ("c1", tuning.c1, "force"),
        ):
            texts = ", ".join(f'"{exact(float(x), dimension)}"' for x in _vector(values, key))
            lines.append(f"{key} = [{texts}]")
        lines.append(f"c2 = [{', '.join(repr(float(x)) for x in _vector(tuning.c2, 'c2'))}]")
    lines += [
        f"{key} = {_number(getattr(tuning, key), key)}"
        for key in ("youngs_modulus_factor", "collapse_moment_factor")
        if _scalar(getattr(tuning, key), key) != 1
    ]
    constant = _scalar(tuning.hinge_stiffness_factor, "hinge_stiffness_factor")
    slope = _scalar(tuning.hinge_stiffness_slope, "hinge_stiffness_slope")
    if slope:
        rise = exact(slope, "inverse_pressure")
        lines.append(f'hinge_stiffness_factor = {{ constant = {constant!r}, slope = "{rise}" }}')
    elif constant != 1:
        lines.append(f"hinge_stiffness_factor = {constant!r}")
    if tuning.transition_rate is not None:
        lines.append(f"transition_rate = {_number(tuning.transition_rate, 'transition_rate')}")
    if _scalar(tuning.dead_band, "dead_band"):
        lines.append(f"dead_band = {_quantity(tuning.dead_band, 'pressure', 'dead_band')}")
    return lines


def _bundle(bundle: Bundle) -> list[str]:
    texts: list[list[str]] = []  # of each different muscle, in the order of their first unit
    which = []
    for unit in bundle.motor_units:
        text = _muscle(unit.muscle, "muscle.@")
        if text not in texts:
            texts.append(text)
        which.append(texts.index(text))
    several = len(texts) > 1
    lines = []
    for index, text in enumerate(texts):
        table = f"[muscle.unit_{index + 1}" if several else "[muscle"
        lines += [entry.replace("[muscle.@", table, 1) for entry in text] + [""]
    lines.append("[bundle]")
    if bundle.supply_pressure is not None:
        lines.append(
            f"supply_pressure = {_quantity(bundle.supply_pressure, 'pressure', 'supply_pressure')}"
        )
    lines.append(f"scheme = {json.dumps(name_of(bundle.scheme))}")
    if bundle.plate_distance is not None:
        lines.append(f"length = {_quantity(bundle.plate_distance, 'length', 'length')}")
    for unit, index in zip(bundle.motor_units, which, strict=True):
        lines += ["", "[[bundle.motor_unit]]", f"count = {int(unit.count)}"]
        lines += [f'muscle = "unit_{index + 1}"'] if several else []
    return lines


def _law(law: Any, kind: str) -> str:
    name, known = getattr(law, "name", ""), LAWS[kind]
    if name not in known or type(law) is not known[name]:
        raise InvalidInputError(kind, f"can be saved if it is one of {', '.join(known)}", law)
    return json.dumps(name)


def _quantity(value: Any, dimension: str, key: str) -> str:
    return f'"{exact(_scalar(value, key), dimension)}"'


def _number(value: Any, key: str) -> str:
    number = _scalar(value, key)
    return repr(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def _scalar(value: Any, key: str) -> float:
    if np.shape(value) != ():
        raise InvalidInputError(
            key,
            f"has the shape {np.shape(value)}",
            None,
            "a file describes one muscle, save them apart",
        )
    return float(value)


def _vector(values: Any, key: str) -> Any:
    if np.ndim(values) != 1:
        raise InvalidInputError(
            key, f"has the shape {np.shape(values)}", None, "a file takes one list"
        )
    return np.asarray(values)
