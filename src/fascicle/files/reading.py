"""From a TOML file to a `Muscle` or a `Bundle`, checked once, on the way in."""

import os
import re
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.validation import check_choice
from ..io.input_file import read_bytes
from ..io.toml import parse_toml
from ..muscle import Muscle
from ..muscle.fitted_length import END_PARAMETERS, warn_fitted_length, with_fitted_length
from ..muscle.law import AbstractLaw
from ..muscle.laws import LAWS
from ..muscle.materials import MooneyRivlin
from ..muscle.tuning import Tuning
from ..units import parse
from .faults import from_validation, line, nearest
from .kinds import check_kind
from .places import Place
from .schema import (
    BundleSection,
    FileSection,
    HingeSection,
    LawSection,
    MotorUnitSection,
    MuscleSection,
    Section,
    TuningSection,
)


_LARGEST_FILE = 1_000_000  # bytes; a muscle takes 500
_SECTIONS = ("material", "tuning", *LAWS)  # keys of one muscle that hold a table


def load(path: str | os.PathLike[str]) -> Muscle | Bundle:
    """Read a muscle file.

    **Arguments:** `path`: the TOML file [-].

    **Returns:** a `Bundle` if the file has a `[bundle]`, else its `Muscle` [-].

    **Raises:** `OSError` where it can't be read; `ValueError`, in one line with the path and
    the key, where what it says can't be.
    """
    return loads(text_of(Path(path)), source=str(path))


def provenance(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Read where a muscle file's muscle comes from.

    **Arguments:** `path`: the TOML file [-].

    **Returns:** its `[calibration]` as nested tables and lists [-]; empty if it has none.

    **Raises:** as `load`, for what stands outside of the other tables.
    """
    source = os.fspath(path)
    table = parsed(text_of(Path(path)), source).get("calibration", {})
    if not isinstance(table, dict):
        raise ValueError(line(source, ["calibration"], "must be a table of keys.", table))
    return table


def text_of(path: Path) -> str:
    """The text of a TOML file; `path`: where it stands [-]."""
    raw = read_bytes(path, _LARGEST_FILE, "muscle file")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file; a muscle file is TOML in UTF-8.") from None


def loads(text: str, source: str = "<text>") -> Muscle | Bundle:
    """Read what a muscle file holds.

    **Arguments:**

    - `text`: the TOML [-].
    - `source`: what to call it in an error [-].

    **Returns:** as `load` [-].

    **Raises:** `ValueError` as `load`.
    """
    return described(parsed(text, source), source)


def described(data: dict[str, Any], source: str) -> Muscle | Bundle:
    """The muscle or bundle in a file's tables; `data`: they [-], `source`: of what file [-].
    `ValueError` as `load`.
    """
    check_kind(data, "muscle or bundle", source)
    data = _filed(data)
    try:
        file = FileSection.model_validate(data)
    except ValidationError as error:
        message = from_validation(error, source, data, FileSection)
        raise ValueError(message) from None
    muscles = {
        name: _muscle(section, Place(source, data, ("muscle", name), "muscle"))
        for name, section in file.muscle.items()
    }
    if len(muscles) == 1:
        (name,) = muscles
        muscles[name] = _fitted(muscles[name], data.get("calibration"), source)
    if file.bundle is not None:
        return _bundle(file.bundle, muscles, Place(source, data, ("bundle",), "bundle"))
    if len(muscles) > 1:
        names = ", ".join(muscles)
        raise ValueError(
            f"{source}: several muscles ({names}) and no [bundle]: keep one, or add a [bundle]."
        )
    return next(iter(muscles.values()))


def _fitted(muscle: Muscle, calibration: Any, source: str) -> Muscle:
    """The `muscle` with the length that its file's `[calibration]` is of, if it says one."""
    told = calibration.get("fitted_length") if isinstance(calibration, dict) else None
    if told is None:
        return muscle
    names = calibration.get("coordinate_names", ())
    try:
        length = parse(told, "length")
    except ValueError:
        rule = 'must be a length with its unit, such as "127 mm".'
        raise ValueError(line(source, ["calibration", "fitted_length"], rule, told)) from None
    ends = calibration.get("fitted_ends") is True or not END_PARAMETERS.isdisjoint(names)
    with_fitted_length(muscle, length, ends)
    warn_fitted_length(muscle)
    return muscle


def parsed(text: str, source: str) -> dict[str, Any]:
    """The tables [-] of a file of this format, from its `text` [-]; `source` [-] names it."""
    try:
        data = parse_toml(text, source)
    except ValueError as error:
        raise ValueError(_of_twice(str(error), text)) from None
    version = data.get("format")
    if version is not None and (version != 1 or isinstance(version, bool)):
        rule = "must be 1, the format that this version of fascicle reads."
        raise ValueError(line(source, ["format"], rule, version))
    return data


def _of_twice(told: str, text: str) -> str:
    """What is `told` of a text that is no TOML [-], with the key's name where one stands twice."""
    place = re.search(r"(not TOML: )Cannot overwrite a value \(at (?:line (\d+)|end)", told)
    if place is None:
        return told
    # the place is where the value ends; at the end of the text, on its last line
    lines = text.rstrip().replace("\r\n", "\n").split("\n")
    number = int(place[2] or len(lines))
    key = lines[number - 1].partition("=")[0].strip()
    return f"{told[: place.end(1)]}{key} is there twice, again on line {number}: keep one."


def _filed(data: dict[str, Any]) -> dict[str, Any]:
    """`data` with its muscles by name; one unnamed muscle goes under the empty name."""
    muscles = data.get("muscle")
    if not isinstance(muscles, dict):
        return data
    named = muscles and all(
        isinstance(section, dict) and name not in MuscleSection.model_fields
        for name, section in muscles.items()
    )
    if not named:
        return data | {"muscle": {"": muscles}}
    return data


def _muscle(section: MuscleSection, place: Place) -> Muscle:
    given: dict[str, Any] = {
        name: value for name, value in section if value is not None and name not in _SECTIONS
    }
    if section.collapse is not None:
        given |= section.collapse.model_dump(exclude_none=True, include={"transition_rate"})
    for kind in LAWS:
        if (chosen := getattr(section, kind)) is not None:
            given[kind] = _law(kind, chosen, place.inner(kind, kind=kind))
    if section.tuning is not None:
        given["tuning"] = _tuning(section.tuning, place.inner("tuning", kind="tuning"))
    with place.naming():
        if section.material is not None:
            given["material"] = _material(section.material)
        return Muscle.from_dimensions(**given)


def _material(material: str | Section) -> str | MooneyRivlin:
    if isinstance(material, str):
        return material
    given = material.model_dump(exclude_none=True)
    if not {"c10", "c01"} & set(given) and "youngs_modulus" in given:
        return MooneyRivlin.from_youngs_modulus(**given)
    for name in ("c10", "c01"):
        if name not in given:
            raise InvalidInputError(
                name, "is missing, write c10 and c01, or youngs_modulus alone", None
            )
    return MooneyRivlin(**given)


def _law(kind: str, chosen: str | LawSection, place: Place) -> str | AbstractLaw:
    if isinstance(chosen, str):
        return chosen  # an unknown one is the muscle's to refuse
    laws = LAWS[kind]
    name = chosen.law or next(iter(laws))
    with place.naming():
        law: Any = laws[check_choice(name, laws, kind)]
    known = [field.name for field in fields(law)]
    given = chosen.model_dump(exclude_none=True, exclude={"law", "transition_rate"} - {*known})
    for key in given:
        if key not in known:
            rule = nearest(key, known) if known else ": it has none, drop it."
            raise place.refuse((key,), f"not a parameter of {name}{rule}")
    with place.naming():
        return law(**given)


def _tuning(tuning: TuningSection, place: Place) -> Tuning:
    given = tuning.model_dump(exclude_none=True, exclude={"pressure", "hinge_stiffness_factor"})
    if tuning.pressure is not None:
        given["pressures"] = tuning.pressure
    hinge = tuning.hinge_stiffness_factor
    if isinstance(hinge, HingeSection):
        names = {"constant": "hinge_stiffness_factor", "slope": "hinge_stiffness_slope"}
        given |= {names[key]: value for key, value in hinge if value is not None}
    elif hinge is not None:
        given["hinge_stiffness_factor"] = hinge
    with place.naming():
        return Tuning(**given)


def _bundle(section: BundleSection, muscles: Mapping[str, Muscle], place: Place) -> Bundle:
    units = [
        _motor_unit(unit, muscles, place.inner("motor_unit", index, kind="motor_unit"))
        for index, unit in enumerate(section.motor_unit)
    ]
    with place.naming():
        return Bundle(units, **section.model_dump(exclude_none=True, exclude={"motor_unit"}))


def _motor_unit(
    section: MotorUnitSection, muscles: Mapping[str, Muscle], place: Place
) -> MotorUnit:
    name = section.muscle
    if name is None and len(muscles) > 1:
        rule = f"missing, write which muscle it has: {', '.join(muscles)}."
        raise place.refuse(("muscle",), rule)
    if name is not None and name not in muscles:
        named = [known for known in muscles if known]
        hint = nearest(name, named) if named else ", drop the key: the only one is [muscle]."
        raise place.refuse(("muscle",), f"no such muscle in the file{hint}")
    muscle = next(iter(muscles.values())) if name is None else muscles[name]
    with place.naming():
        return MotorUnit(muscle, **section.model_dump(exclude_none=True, include={"count"}))
