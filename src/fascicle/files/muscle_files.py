"""Muscle and bundle files: TOML to checked `Muscle` or `Bundle`, and back to the same bits."""

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ..bundle import Bundle, MotorUnit
from ..bundle.schemes import serializable_name
from ..core.errors import InvalidInputError
from ..core.module import with_fields
from ..core.validation import check_choice, warn_user
from ..io.atomic import write_text
from ..io.input_file import parse_toml, read_bytes
from ..muscle import Muscle, validation
from ..muscle.law import AbstractLaw, Declared
from ..muscle.laws import LAWS, is_written_out
from ..muscle.materials import MATERIALS, MooneyRivlin
from ..muscle.printing import SIZES
from ..muscle.tuning import Tuning
from ..table_model import FileError, did_you_mean, validate, value_at
from ..units import DIMENSIONS, exact, parse
from . import example_text, named_muscles, schema
from .schema import BundleSection, FileLocation


_MAX_FILE_SIZE = 1_000_000  # bytes; a muscle takes 500
# numbers of a tuning with their dimensions, and the values that a file leaves out
_TUNING = (
    ("youngs_modulus_factor", "number", 1),
    ("collapse_moment_factor", "number", 1),
    ("hinge_stiffness_factor", "number", 1),
    ("transition_rate", "number", None),
    ("dead_band", "pressure", 0),
)
_CALIBRATION = "calibration"


def load_muscle(path: str | os.PathLike[str]) -> Muscle | Bundle:
    """Read a muscle or bundle file, as `load`; a scenario is refused."""
    path = Path(path)
    return from_dict(read_file(path), str(path), path.parent)


def load_named(name: str, folder: Path | None, may_name_files: bool = True) -> Muscle | Bundle:
    """The muscle or bundle with a `name`: an example, a measured muscle, or a file in a `folder`.

    Without a folder, as in a text from elsewhere, no file is read. `may_name_files`: true if
    the file may name muscles by files of its own. Raises as `load`.
    """
    if name in named_muscles():
        return loads(example_text(name), name)
    if folder is None or not (folder / name).exists():
        rule = "is neither a file nor a named example" if folder else "is no named example"
        raise ValueError(f"{name!r} {rule}{did_you_mean(name, named_muscles())}")
    path = folder / name
    return from_dict(read_file(path), str(path), path.parent if may_name_files else None)


def loads(text: str, source: str = "<text>") -> Muscle | Bundle:
    """Read a muscle or bundle from the text of a file, as `load`; `source`: its name in errors."""
    return from_dict(parse_file(text, source), source)


def provenance(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Table `[calibration]` of a muscle file; empty if it has none. Raises as `load`."""
    data = read_file(Path(path))
    table = data.get(_CALIBRATION, {})
    if not isinstance(table, dict):
        raise FileLocation(str(path), data).error((_CALIBRATION,), "must be a table of keys.")
    return table


def save(
    obj: Any, path: str | os.PathLike[str], calibration: Mapping[str, Any] | None = None
) -> None:
    """Write the text of `dumps` to a file, completely or not at all; an existing file is replaced.
    `OSError` if it can't be written.
    """
    write_text(path, dumps(obj, calibration))


def dumps(obj: Any, calibration: Mapping[str, Any] | None = None) -> str:
    """TOML of a `Muscle` or a `Bundle`, from which `loads` gives back every parameter to the bit;
    `ValueError` for an object that a file can't describe.

    `calibration`: for `provenance`: text, numbers, booleans, lists and tables of them by key.
    Default: of a fitted muscle, its fitted length.
    """
    import tomlkit  # its import takes as long as reading a file

    if isinstance(obj, Muscle):
        muscles, data = [obj], {"muscle": _muscle_table(obj)}
    elif isinstance(obj, Bundle):
        muscles, data = [unit.muscle for unit in obj.motor_units], _bundle_tables(obj)
    else:
        kind = type(obj).__name__
        raise InvalidInputError("obj", "must be a Muscle or a Bundle", obj, shown=kind)
    text = tomlkit.dumps({"format": 1} | data)
    if calibration is None:
        # a bundle of equal fitted muscles has their fitted length
        entries = [validation.fit_info_entries(muscle) for muscle in muscles]
        equal = all(muscle == muscles[0] for muscle in muscles) and entries[1:] == entries[:-1]
        calibration = (entries[0] if equal else None) or None
    return text if calibration is None else f"{text}\n{calibration_text(calibration)}"


def calibration_text(entries: Mapping[str, Any]) -> str:
    """TOML of a `[calibration]` with these `entries`, as of `dumps`; its tables are last."""
    import tomlkit

    def plain(value: Any) -> Any:
        """NumPy's and JAX's scalars and arrays in Python's types."""
        if not hasattr(value, "tolist"):
            rule = "takes text, numbers, booleans, lists and tables"
            raise InvalidInputError(_CALIBRATION, rule, value, shown=f"a {type(value).__name__}")
        return value.tolist()

    table = json.loads(json.dumps(dict(entries), default=plain))
    return tomlkit.dumps({_CALIBRATION: table})


def read_file(path: Path) -> dict[str, Any]:
    """Tables of a file; `OSError` if it can't be read, else errors as of `parse_file`."""
    raw = read_bytes(path, _MAX_FILE_SIZE, "muscle file")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ValueError(f"{path}: not a text file; a muscle file is TOML in UTF-8.") from None
    return parse_file(text, str(path))


def parse_file(text: str, source: str) -> dict[str, Any]:
    """Tables of a file of format 1; `ValueError`, in one line with the file's name, `source`."""
    data = parse_toml(text, source)
    version = data.get("format")
    if version is not None and (version != 1 or isinstance(version, bool)):
        rule = "must be 1, the format that this version of fascicle reads."
        raise FileError(source, ["format"], rule, version)
    return data


def from_dict(data: dict[str, Any], source: str, folder: Path | None = None) -> Muscle | Bundle:
    """The muscle or bundle in a file's tables, whose muscles may be named by an example or a file
    in a `folder`; `ValueError` as `loads`.
    """
    schema.check_kind(data, "muscle or bundle", source)
    sections, units = data.get("muscle"), value_at(data, ("bundle", "motor_unit"))
    if sections is None:
        if isinstance(units, list) and units and all(value_at(x, ["muscle"]) for x in units):
            data = data | {"muscle": {}}  # each unit names its own
    elif isinstance(sections, str | dict) and not _are_named(sections):
        data = data | {"muscle": {"": sections}}
    file = validate(schema.MuscleFile, data, source)
    root, muscles = FileLocation(source, data), {}
    for name, section in file.muscle.items():
        location = root.child("muscle", name, kind="muscle")
        if isinstance(section, str):
            muscles[name] = _named_muscle(section, location._replace(kind=""), folder)
        else:
            muscles[name] = _muscle(section, location)
    if len(muscles) == 1:
        ((name, muscle),) = muscles.items()
        muscles = {name: _with_fitted_length(muscle, data.get(_CALIBRATION), root)}
    if file.bundle is not None:
        return _bundle(file.bundle, muscles, root.child("bundle", kind="bundle"), folder)
    if len(muscles) > 1:
        rule = f"write one for the muscles {', '.join(muscles)}, or keep one of them."
        raise FileError(source, ["bundle"], f"missing, {rule}")
    return next(iter(muscles.values()))


def _are_named(sections: str | dict[str, Any]) -> bool:
    """True for several muscles by name, false for a single one's name or table."""
    if isinstance(sections, str) or not sections:
        return False
    kinds = all(isinstance(section, str | dict) for section in sections.values())
    return kinds and sections.keys().isdisjoint(schema.MuscleSection.model_fields)


def _named_muscle(name: str, location: FileLocation, folder: Path | None) -> Muscle:
    """The muscle with a `name`, an example or a file in a `folder`."""
    muscle = location.call(load_named, name, folder, may_name_files=False)
    if isinstance(muscle, Bundle):
        raise location.error((), "is a bundle: name a muscle.")
    return muscle


def _with_fitted_length(muscle: Muscle, calibration: Any, root: FileLocation) -> Muscle:
    """The `muscle` with the fitted length of its file's `[calibration]`, if there is one."""
    text = calibration.get("fitted_length") if isinstance(calibration, dict) else None
    if text is None:
        return muscle
    try:
        length = parse(text, "length")
    except ValueError:
        rule = 'must be a length with its unit, such as "127 mm".'
        raise root.error((_CALIBRATION, "fitted_length"), rule) from None
    names = calibration.get("coordinate_names", ())
    ends = calibration.get("fitted_ends") is True or not validation.END_PARAMETERS.isdisjoint(names)
    muscle = with_fields(muscle, fitted_length=validation.FittedLength(length, ends))
    warn_user(validation.fitted_length_mismatch(muscle))
    return muscle


def _muscle(section: schema.MuscleSection, location: FileLocation) -> Muscle:
    arguments = section.model_dump(exclude_none=True, exclude={"material", "tuning", *LAWS})
    if section.collapse is not None and section.collapse.transition_rate is not None:
        arguments["transition_rate"] = section.collapse.transition_rate
    for kind in LAWS:
        if (law := getattr(section, kind)) is not None:
            arguments[kind] = _law(kind, law, location.child(kind, kind=kind))
    if section.tuning is not None:
        arguments["tuning"] = _tuning(section.tuning, location.child("tuning", kind="tuning"))
    if isinstance(material := section.material, dict):
        material = _material(material, location.child("material"))
    if material is not None:
        arguments["material"] = material
    return location.call(Muscle, **arguments)


def _material(section: dict[str, Any], location: FileLocation) -> MooneyRivlin:
    constants = _arguments(MooneyRivlin, "a material", section, location)
    with location.error_context():
        if not {"c10", "c01"} & set(constants) and "youngs_modulus" in constants:
            return MooneyRivlin.from_youngs_modulus(**constants)
        for name in ("c10", "c01"):
            if name not in constants:
                rule = "is missing, write c10 and c01, or youngs_modulus alone"
                raise InvalidInputError(name, rule, None)
        return MooneyRivlin(**constants)


def _law(kind: str, section: str | schema.LawSection, location: FileLocation) -> str | AbstractLaw:
    if isinstance(section, str):
        return section  # an unknown one is refused by the muscle
    laws = LAWS[kind]
    if section.law is None and kind != "collapse":
        raise location.error(("law",), f'missing, write law = "{laws.default.name}".')
    name = section.law or laws.default.name
    with location.error_context():  # a law that is there loads no other package
        law: Any = laws[name] if name in laws else check_choice(name, laws, kind)
    table, own_keys = section.model_extra or {}, type(section).model_fields
    return location.call(law, **_arguments(law, name, table, location, own_keys))


def _arguments(
    owner: type[Declared],
    name: str,
    table: Mapping[str, Any],
    location: FileLocation,
    other_keys: Iterable[str] = (),
) -> dict[str, Any]:
    """Arguments of a law or material from its table, which may have `other_keys` than these."""
    dimensions = {constant.name: constant.dimension for constant in owner.constants()}
    names = [field.name for field in attrs.fields(owner)]
    for key in table:
        if key not in names:
            hint = did_you_mean(key, [*names, *other_keys]) if names else ": it has none, drop it."
            raise location.error((key,), f"not a parameter of {name}{hint}")
    with location.error_context():  # the error names the key
        return {
            key: parse(value, dimensions[key], key) if key in dimensions else value
            for key, value in table.items()
        }


def _tuning(section: schema.TuningSection, location: FileLocation) -> Tuning:
    numbers = section.model_dump(exclude_none=True)
    if "pressure" in numbers:
        numbers["pressures"] = numbers.pop("pressure")
    hinge = numbers.pop("hinge_stiffness_factor", {})
    hinge = hinge if isinstance(hinge, dict) else {"constant": hinge}
    names = {"constant": "hinge_stiffness_factor", "slope": "hinge_stiffness_slope"}
    return location.call(Tuning, **numbers, **{names[key]: value for key, value in hinge.items()})


def _bundle(
    section: BundleSection, muscles: dict[str, Muscle], location: FileLocation, folder: Path | None
) -> Bundle:
    units, default, tables = [], next(iter(muscles), ""), list(muscles)
    for index, unit in enumerate(section.motor_unit):
        unit_location, name = location.child("motor_unit", index), unit.muscle
        if name is None and len(tables) > 1:
            rule = f"missing, write the name of its muscle: {', '.join(tables)}."
            raise unit_location.error(("muscle",), rule)
        if name is not None and name not in muscles:
            if name in named_muscles() or not tables or (folder and (folder / name).is_file()):
                muscles[name] = _named_muscle(name, unit_location.child("muscle"), folder)
            else:
                names = [muscle for muscle in tables if muscle]
                hint = ", drop the key: the only one is [muscle]."
                hint = did_you_mean(name, names) if names else hint
                raise unit_location.error(("muscle",), f"no such muscle in the file{hint}")
        muscle = muscles[default if name is None else name]
        with unit_location.error_context():
            units.append(MotorUnit(muscle, **unit.model_dump(exclude_none=True, include={"count"})))
    with location.error_context():
        return Bundle(units, **section.model_dump(exclude_none=True, exclude={"motor_unit"}))


def _muscle_table(muscle: Muscle) -> dict[str, Any]:
    """Table `[muscle]`; those of its laws are nested in it."""
    material = muscle.material
    if type(material) is not MooneyRivlin:
        raise InvalidInputError("material", "can be saved if it is a MooneyRivlin", material)
    names = (name for name, named in MATERIALS.items() if material == named)
    table: dict[str, Any] = {
        name: _entry(getattr(muscle, name), kind, name) for name, kind in SIZES.items()
    }
    table["material"] = next(names, None) or _constants(material)
    for kind in LAWS:
        law = getattr(muscle, kind)
        if kind != "collapse" and is_written_out(kind, law):
            entries = _law_entries(law, kind)
            table[kind] = entries if len(entries) > 1 else entries["law"]
    rate = _entry(muscle.transition_rate, "number", "transition_rate")
    table["collapse"] = _law_entries(muscle.collapse, "collapse") | {"transition_rate": rate}
    tuning = _tuning_entries(muscle.tuning)
    return table | {"tuning": tuning} if tuning else table


def _tuning_entries(tuning: Tuning) -> dict[str, Any]:
    entries: dict[str, Any] = {}
    if np.size(tuning.pressures) > 1:  # the row at zero pressure alone is the identity
        rows = {"pressure": tuning.pressures, "c1": tuning.c1, "c2": tuning.c2}
        units = {"pressure": "pressure", "c1": "force"}
        for key, values in rows.items():
            if np.ndim(values) != 1:
                rule = f"has the shape {np.shape(values)}"
                raise InvalidInputError(key, rule, None, "a file takes one list")
            entries[key] = [exact(x, units[key]) if key in units else x for x in map(float, values)]
    slope = _scalar(tuning.hinge_stiffness_slope, "hinge_stiffness_slope")
    for key, dimension, default in _TUNING:
        value = getattr(tuning, key)
        if key == "hinge_stiffness_factor" and slope:
            entries[key] = {"constant": float(value), "slope": exact(slope, "inverse_pressure")}
        elif value is not None and _scalar(value, key) != default:
            entries[key] = _entry(value, dimension, key)
    return entries


def _bundle_tables(bundle: Bundle) -> dict[str, Any]:
    """Tables `[muscle]`, or one for each different muscle, and `[bundle]`."""
    muscles: list[dict[str, Any]] = []  # in the order of their first unit
    units: list[dict[str, Any]] = []
    for unit in bundle.motor_units:
        table = _muscle_table(unit.muscle)
        if table not in muscles:
            muscles.append(table)
        units.append({"count": int(unit.count), "muscle": f"unit_{muscles.index(table) + 1}"})
    named = {f"unit_{index}": table for index, table in enumerate(muscles, 1)}
    if len(muscles) == 1:
        named, units = muscles[0], [{"count": unit["count"]} for unit in units]
    entries: dict[str, Any] = {}
    if bundle.supply_pressure is not None:
        entries["supply_pressure"] = _entry(bundle.supply_pressure, "pressure", "supply_pressure")
    if bundle.plate_distance is not None:
        entries["length"] = _entry(bundle.plate_distance, "length", "length")
    entries |= {"scheme": serializable_name(bundle.scheme), "motor_unit": units}
    return {"muscle": named, "bundle": entries}


def _law_entries(law: Any, kind: str) -> dict[str, Any]:
    """A law's name, and its constants and switches by key unless all are the defaults."""
    name, laws = getattr(law, "name", ""), LAWS[kind]
    if name not in laws or type(law) is not laws[name]:
        raise InvalidInputError(kind, f"can be saved if it is one of {', '.join(laws)}", law)
    switches = {switch.name: getattr(law, switch.name) for switch in law.switches()}
    if all(getattr(law, c.name) == c.default for c in law.constants()) and all(
        switches[switch.name] == switch.options[0] for switch in law.switches()
    ):
        return {"law": name}
    return {"law": name, **_constants(law), **switches}


def _constants(owner: Any) -> dict[str, Any]:
    """Constants of a law or material by key, as a file has them."""
    return {c.name: _entry(getattr(owner, c.name), c.dimension, c.name) for c in owner.constants()}


def _entry(value: Any, dimension: str, key: str) -> str | float:
    """Number of a file, or its text with a unit."""
    number = _scalar(value, key)
    if not DIMENSIONS[dimension].unitless:
        return exact(number, dimension)
    # beyond 10^15 a float is no exact whole number
    return int(number) if number.is_integer() and abs(number) < 1e15 else number


def _scalar(value: Any, key: str) -> float:
    if np.shape(value) != ():
        rule, remedy = f"has the shape {np.shape(value)}", "a file describes one muscle, save each"
        raise InvalidInputError(key, rule, None, remedy)
    return float(value)
