"""A view as a link, and back.

An example is given by its name; any other muscle is in the link itself, as its deflated file.
A link is data from a stranger: it is bounded, parsed as TOML, JSON and by `units`, and nothing in
it is a path or is run. That is why Panel's own `Location.sync`, which reads JSON into parameters,
isn't used; links also keep their units and their order of keys.
"""

import base64
import re
import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from ..bundle.energetics import PATHS
from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, check_finite, check_interval
from ..files import dumps, example, loads
from ..files.shipped_files import named_muscles
from ..units import exact, parse
from .pins import parse_pins, pins_text, shipped_muscle
from .scenario_setup import open_setup, read_setup, setup_query
from .state import DISPLAY_UNITS, MAPS, MOST_UNITS, TABS, Unit, View, check_units, view_of
from .widgets import message_in_units, unit_factor


LONGEST = 16_000  # characters of all packed files: servers and browsers take addresses so long
_LARGEST_TEXT = 32_000  # bytes of the file in it: eight different tuned muscles take half of that
TOO_LARGE = "left-out"  # instead of a larger file
# in this order: the muscle's file has the number of units, and the scenario's its fields
_LABELS = {
    "muscle": "the example", "file": "the muscle's file", "supply": "the supply pressure",
    "units": "the motor units", "scheme": "the recruitment", "pressure": "the pressure",
    "strain": "the contraction", "load": "the load", "pressures": "each motor unit's pressure",
    "resistance": "the resistance", "path": "the path", "map": "the map of efficiency",
    "show": "the units shown", "tab": "the tab",
    "pins": "the list of pinned curves", "scenario_file": "the scenario's file",
    "scenario": "the scenario", "set": "the scenario's fields", "policies": "the policies",
}  # fmt: skip
_CHOICES: Mapping[str, tuple[str, ...]] = {
    "scheme": tuple(SCHEMES),
    "path": PATHS,
    "map": MAPS,
    "tab": TABS,
}


def to_query(view: View) -> dict[str, str]:
    """Query of the link of a `view`, by key."""

    def pressure_text(value: float) -> str:
        return _exact_text(value, "pressure", view.display_units["pressure"])

    if any(unit.own is not None for unit in view.units):
        query = {"file": pack(dumps(view.bundle)), "name": view.name}
    else:
        query = {"file": pack(dumps(view.muscle)), "name": view.name}
        if view.name in named_muscles() and shipped_muscle(view.name) == view.muscle:
            query = {"muscle": view.name}
        query["units"] = ",".join(
            f"{unit.count}" + (f"@{unit.size!r}" if unit.size != 1 else "") for unit in view.units
        )
    query |= {
        "supply": pressure_text(view.supply),
        "scheme": view.scheme,
        "pressure": pressure_text(view.pressure),
        "strain": _exact_text(view.strain, "strain"),
        "pressures": ",".join(pressure_text(P) for P in view.pressures),
        "resistance": "on" if view.resistance else "off",
        "path": view.path,
        "map": view.map,
        "show": ",".join(view.display_units[kind] for kind in DISPLAY_UNITS),
        "tab": view.tab,
    }
    if view.load is not None:
        query["load"] = _exact_text(view.load, "force")
    if pins := view.pins[: linked_pins(view)]:
        query["pins"] = pack(pins_text(pins))
    if view.setup.own:
        query["scenario_file"] = pack(view.setup.own)
    return query | setup_query(view.setup)


def linked_pins(view: View) -> int:
    """Number of pins, from the first on, that the link of a `view` has room for."""
    has_one_muscle = all(unit.own is None for unit in view.units)
    room = LONGEST - len(pack(dumps(view.muscle if has_one_muscle else view.bundle)))
    room -= len(pack(view.setup.own)) if view.setup.own else 0
    numbers = range(len(view.pins), 0, -1)
    return next((n for n in numbers if pack(pins_text(view.pins[:n]), room) != TOO_LARGE), 0)


def has_state(query: Mapping[str, str]) -> bool:
    """True for a link with a part of a view."""
    return any(key in query for key in _LABELS)


def from_query(query: Mapping[str, str], start: View) -> tuple[View, list[str]]:
    """View of a link by key, the `start` view where it has none, and a message for each bad key."""
    view, errors = start, []
    for key in filter(query.__contains__, _LABELS):
        try:
            view = _apply_key(view, key, query[key], query)
        except ValueError as error:
            errors.append(_link_error_text(key, str(error)))
        except Exception:  # noqa: BLE001 whatever a link holds, the page opens
            errors.append(_link_error_text(key, f"`{key}` can't be read."))
    if len(view.pressures) != len(view.units):
        view = replace(view, pressures=(view.supply,) * len(view.units))
    if max(view.pressure, *view.pressures) > view.supply:
        limited = tuple(min(P, view.supply) for P in view.pressures)
        view = replace(view, pressure=min(view.pressure, view.supply), pressures=limited)
        if "pressure" in query or "pressures" in query:
            supply = _exact_text(view.supply, "pressure", view.display_units["pressure"])
            text = f"`pressure` must be at most the supply's, {supply}."
            errors.append(_link_error_text("pressure", text, "It is lowered."))
    return view, [message_in_units(line, view.display_units) for line in errors]


def _link_error_text(key: str, error: str, result: str = "It is left out.") -> str:
    """Sentences on the `error` of a link's `key` and its `result`, in the words of the page."""
    label = _LABELS[key]
    text = re.sub(r"^`\w+`", label, error)
    text = re.sub(r"^(?!.*\b(must|was|is|can't)\b)", f"{label} can't be read: ", text)
    return f"In the link, {text.replace('`', '')} {result}"


def pack(text: str, longest: int = LONGEST) -> str:
    """Text, deflated, in characters of a link; `TOO_LARGE` where there are more than `longest`."""
    raw = text.encode()
    packed = base64.urlsafe_b64encode(zlib.compress(raw, 9)).decode().rstrip("=")
    return packed if len(raw) <= _LARGEST_TEXT and len(packed) <= longest else TOO_LARGE


def unpack(packed: str, key: str = "file") -> str:
    """Text that was `packed`; raises `InvalidInputError` of a `key` for anything else."""
    if packed == TOO_LARGE:
        raise InvalidInputError(key, "was too large for a link", None, "open the file itself")
    if len(packed) > LONGEST:
        raise InvalidInputError(key, f"must be at most {LONGEST} characters", len(packed))
    inflate, raw = zlib.decompressobj(), b""
    try:
        raw = base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4))
        raw = inflate.decompress(raw, _LARGEST_TEXT + 1)
        if len(raw) <= _LARGEST_TEXT and inflate.eof:
            return raw.decode()
    except (ValueError, zlib.error):  # not ASCII, base64, deflated or UTF-8
        raw = b""
    if len(raw) > _LARGEST_TEXT:
        raise InvalidInputError(key, f"must hold at most {_LARGEST_TEXT} bytes", None)
    raise InvalidInputError(key, "is no file that this explorer has packed", None)


def _exact_text(value: float, dimension: str, unit: str = "") -> str:
    """A `value` [SI] that reads back exactly: in a unit of the page, where it has few digits."""
    for written in (unit, *DISPLAY_UNITS["pressure"]) if unit else ():
        text = f"{value / unit_factor(written, dimension):.10g}{written}"
        if parse(text, dimension) == value:
            return text
    return exact(value, dimension).replace(" ", "")


def _apply_key(view: View, key: str, text: str, query: Mapping[str, str]) -> View:
    """The `view` with the `text` of a `key` of a `query`; `ValueError` for an invalid one."""
    if key in ("muscle", "file"):
        return _open_muscle(view, key, text, query)
    if key == "units":
        units = tuple(_parse_motor_unit(entry, text) for entry in text.split(",")[: MOST_UNITS + 1])
        check_units(units)
        return replace(view, units=units, pressures=(view.supply,) * len(units))
    if key == "pressures":
        values = tuple(_parse_gauge_pressure(P) for P in text.split(",")[:MOST_UNITS])
        return replace(view, pressures=values) if len(values) == len(view.units) else view
    if key in _CHOICES:
        if text not in _CHOICES[key]:
            rule = f"must be one of {', '.join(_CHOICES[key])}"
            raise InvalidInputError(key, rule, text[:40])
        return replace(view, **{key: text})
    if key in _FIELDS:
        name, parse_field = _FIELDS[key]
        return replace(view, **{name: parse_field(text)})
    if key == "scenario_file":
        setup = open_setup(unpack(text), query.get("scenario", "linked")[:60])
    else:
        setup = read_setup(view.setup, key, text)
    return replace(view, setup=setup)


def _open_muscle(view: View, key: str, text: str, query: Mapping[str, str]) -> View:
    """View of the example or the packed file in a link; the file comes first."""
    if key == "muscle":
        if text not in named_muscles():
            raise InvalidInputError("muscle", "must be one of the list above", text[:40])
        return view if "file" in query else view_of(example(text), text, view)
    name = query.get("name", "linked")[:60]
    return view_of(loads(unpack(text), source="`file` can't be read"), name, view)


def _parse_motor_unit(entry: str, text: str) -> Unit:
    """Motor unit of an `entry` such as 4@0.5, count and size; an error shows the `text` of all."""
    count, _, size = entry.partition("@")
    try:
        return Unit(int(count), float(size or 1))
    except ValueError:
        raise InvalidInputError("units", "must be like 1,4@0.5", text[:40]) from None


def _parse_gauge_pressure(text: str, name: str = "pressure") -> float:
    value = parse(text, "pressure")
    if name == "supply" and value <= 0:
        raise InvalidInputError(name, "must be positive", value, shown=f"{value:g} Pa")
    check_interval(value, 0.0, HIGHEST_PRESSURE, "pressure", "Pa", "(gauge)", (True, True))
    return value


def _parse_strain(text: str) -> float:
    value = parse(text, "strain")
    check_interval(value, 0.0, LARGEST_STRAIN, "strain", "-", closed=(True, True))
    return value


def _parse_display_units(text: str) -> dict[str, str]:
    """Units by dimension of a link's `show`: of pressure, length and force, such as `kPa,mm,N`."""
    units = text.split(",")
    display_units = dict(zip(DISPLAY_UNITS, units, strict=False))
    if len(units) != len(DISPLAY_UNITS) or any(
        unit not in DISPLAY_UNITS[kind] for kind, unit in display_units.items()
    ):
        raise InvalidInputError("show", "must be units such as kPa,mm,N", text[:40])
    return display_units


# field of the view, and parser of its text, by key
_FIELDS: Mapping[str, tuple[str, Callable[[str], Any]]] = {
    "supply": ("supply", lambda text: _parse_gauge_pressure(text, "supply")),
    "pressure": ("pressure", _parse_gauge_pressure),
    "strain": ("strain", _parse_strain),
    "load": ("load", lambda text: float(check_finite(parse(text, "force"), "load", "N"))),
    "resistance": ("resistance", lambda text: text != "off"),
    "show": ("display_units", _parse_display_units),
    "pins": ("pins", lambda text: parse_pins(unpack(text, "pins"))),
}
