"""From a `Muscle` or a `Bundle` to a TOML file that reads back to the same bits."""

import json
import os
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from ..bundle import Bundle
from ..bundle.scheme import name_of
from ..muscle import Muscle
from ..muscle.collapse import COLLAPSE_LAWS, POST_COLLAPSE_LAWS
from ..muscle.materials import MATERIALS, MooneyRivlin
from ..muscle.muscle import BUCKLING_LAWS
from ..muscle.tension import TENSION_LAWS
from ..muscle.tuning import Tuning
from ..units import exact
from .atomic import write_text
from .calibration import calibration_lines


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
      key, and one level of tables or lists of tables; `provenance` reads it back.

    **Returns:** the TOML [-]; `loads` gives back every parameter bitwise.

    **Raises:** `ValueError` for anything that a file can't describe.
    """
    lines = ["format = 1", "", *_lines(obj)]
    if calibration is not None:
        lines += ["", *calibration_lines(calibration)]
    return "\n".join(lines) + "\n"


def _lines(obj: Any) -> list[str]:
    if isinstance(obj, Muscle):
        return _muscle(obj, "muscle")
    if isinstance(obj, Bundle):
        return _bundle(obj)
    raise ValueError(f"only a Muscle or a Bundle can be saved, got {type(obj).__name__}.")


def _muscle(muscle: Muscle, table: str) -> list[str]:
    collapse = [
        f"law = {_law(muscle.collapse, COLLAPSE_LAWS, 'collapse')}",
        f"transition_rate = {_number(muscle.transition_rate, 'transition_rate')}",
    ]
    if _scalar(muscle.collapse.factor, "factor") != 1:
        collapse.append(f"factor = {_number(muscle.collapse.factor, 'factor')}")
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
        f"tension = {_tension(muscle.tension)}",
        f"buckling = {_law(muscle.buckling, BUCKLING_LAWS, 'buckling')}",
        f"post_collapse = {_law(muscle.post_collapse, POST_COLLAPSE_LAWS, 'post_collapse')}",
        "",
        f"[{table}.collapse]",
        *collapse,
    ]
    tuning = _tuning(muscle.tuning)
    return [*lines, "", f"[{table}.tuning]", *tuning] if tuning else lines


def _tension(law: Any) -> str:
    """The law's name, with its own numbers where they aren't the default ones."""
    name = _law(law, TENSION_LAWS, "tension")
    entries, defaults = {}, type(law)()
    for key in (field.name for field in fields(law)):
        value = getattr(law, key)
        if isinstance(value, str):
            entries[key] = json.dumps(value)
        elif law.parameters[key] == "number":
            entries[key] = _number(value, key)
        else:
            entries[key] = _quantity(value, law.parameters[key], key)
    if all(getattr(law, key) == getattr(defaults, key) for key in entries):
        return name
    return f"{{ law = {name}, {', '.join(f'{key} = {text}' for key, text in entries.items())} }}"


def _material(material: Any) -> str:
    if type(material) is not MooneyRivlin:
        raise ValueError(f"`material` can be saved if it is a MooneyRivlin, got {material!r}.")
    names = ("c10", "c01", "youngs_modulus", "poisson_ratio")
    values = [_scalar(getattr(material, name), name) for name in names]
    for name, known in MATERIALS.items():
        if values == [float(getattr(known, key)) for key in names]:
            return json.dumps(name)
    *stiffnesses, ratio = values
    entries = [
        f'{key} = "{exact(x, "pressure")}"' for key, x in zip(names, stiffnesses, strict=False)
    ]
    return f"{{ {', '.join(entries)}, poisson_ratio = {ratio!r} }}"


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


def _law(law: Any, known: Any, key: str) -> str:
    name = getattr(law, "name", None)
    if name not in known or type(law) is not known[name]:
        raise ValueError(f"`{key}` can be saved if it is one of {', '.join(known)}, got {law!r}.")
    return json.dumps(name)


def _quantity(value: Any, dimension: str, key: str) -> str:
    return f'"{exact(_scalar(value, key), dimension)}"'


def _number(value: Any, key: str) -> str:
    number = _scalar(value, key)
    return repr(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)


def _scalar(value: Any, key: str) -> float:
    if np.shape(value) != ():
        raise ValueError(
            f"`{key}` has the shape {np.shape(value)}:"
            " a file describes one muscle, save them apart."
        )
    return float(value)


def _vector(values: Any, key: str) -> Any:
    if np.ndim(values) != 1:
        raise ValueError(f"`{key}` has the shape {np.shape(values)}: a file takes one list.")
    return np.asarray(values)
