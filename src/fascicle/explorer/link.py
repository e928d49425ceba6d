"""A view as a link, and back.

An example is given by its name; any other muscle is in the link itself, as its deflated file.
A link is data from a stranger: it is bounded, parsed as TOML and by `units`, and nothing in it is a
path or is run. That is why Panel's own `Location.sync`, which reads JSON into parameters, isn't
used; links also keep their units and their order of keys.
"""

import base64
import zlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from ..bundle.efficiency import PATHS
from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, LARGEST_STRAIN, check_interval
from ..files import dumps, example, examples, loads
from ..muscle import Muscle
from ..units import exact, parse
from .muscle_curves import check_compared
from .state import MOST_UNITS, SHOWN, TABS, Unit, View, check_units, view_of
from .widgets import message_in_units, unit_factor


LONGEST = 16_000  # characters of a packed file
_LARGEST_TEXT = 32_000  # bytes of the file in it: eight different tuned muscles take half of that
_TOO_LARGE = "left-out"  # instead of a larger file


def to_query(view: View) -> dict[str, str]:
    """Query of the link of a `view`, by key."""
    different = any(unit.own is not None for unit in view.units)

    def pressure(value: float) -> str:
        return _exact_text(value, "pressure", view.shown["pressure"])

    if different:
        query = {"file": pack(dumps(view.bundle)), "name": view.name}
    elif view.name in examples() and _is_example(view):
        query = {"muscle": view.name}
    else:
        query = {"file": pack(dumps(view.muscle)), "name": view.name}
    if not different:
        query["units"] = ",".join(
            f"{unit.count}" + (f"@{unit.size!r}" if unit.size != 1 else "") for unit in view.units
        )
    query |= {
        "supply": pressure(view.supply),
        "scheme": view.scheme,
        "pressure": pressure(view.pressure),
        "strain": _exact_text(view.strain, "strain"),
        "pressures": ",".join(pressure(P) for P in view.pressures),
        "resistance": "on" if view.resistance else "off",
        "path": view.path,
        "splits": ",".join("-".join(map(str, split)) for split in view.splits),
        "show": ",".join(view.shown[kind] for kind in SHOWN),
        "tab": view.tab,
    }
    if view.compared:
        query["compare"] = ",".join(view.compared)
    return query


def from_query(query: Mapping[str, str], start: View) -> tuple[View, list[str]]:
    """View of a link, and a message for each of its parts that can't be read.

    **Arguments:**

    - `query`: by key; unknown keys are ignored.
    - `start`: view for what the link doesn't say.
    """
    view, errors = start, []
    for key, read in _READERS.items():
        text = query.get(key)
        if text is None:
            continue
        try:
            view = read(view, text, query)
        except ValueError as error:
            errors.append(f"link: {error}")
        except Exception:  # noqa: BLE001 whatever a link holds, the page opens
            errors.append(f"link: `{key}` can't be read.")
    if len(view.pressures) != len(view.units):
        view = replace(view, pressures=(view.supply,) * len(view.units))
    if max(view.pressure, *view.pressures) > view.supply:
        limited = tuple(min(P, view.supply) for P in view.pressures)
        view = replace(view, pressure=min(view.pressure, view.supply), pressures=limited)
        if "pressure" in query or "pressures" in query:
            supply = _exact_text(view.supply, "pressure", view.shown["pressure"])
            errors.append(f"link: `pressure` must be at most the supply's, {supply}.")
    return view, [message_in_units(line, view.shown) for line in errors]


def pack(text: str) -> str:
    """Text of a file, deflated, in characters of a link; a word that says so if it is too large."""
    raw = text.encode()
    packed = base64.urlsafe_b64encode(zlib.compress(raw, 9)).decode().rstrip("=")
    return packed if len(raw) <= _LARGEST_TEXT and len(packed) <= LONGEST else _TOO_LARGE


def unpack(packed: str) -> str:
    """Text that was `packed`.

    **Raises:** `InvalidInputError` for anything else.
    """
    if packed == _TOO_LARGE:
        raise InvalidInputError("file", "was too large for a link", None, "open the file itself")
    if len(packed) > LONGEST:
        raise InvalidInputError("file", f"must be at most {LONGEST} characters", len(packed))
    inflate = zlib.decompressobj()
    try:
        raw = base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4))
        text = inflate.decompress(raw, _LARGEST_TEXT + 1)
        if len(text) <= _LARGEST_TEXT and inflate.eof:
            return text.decode()
    except (ValueError, zlib.error):  # not ASCII, base64, deflated or UTF-8
        text = b""
    if len(text) > _LARGEST_TEXT:
        raise InvalidInputError("file", f"must hold at most {_LARGEST_TEXT} bytes", None)
    raise InvalidInputError("file", "is no file that this explorer has packed", None)


def parse_splits(text: str) -> tuple[tuple[int, ...], ...]:
    """Splits of muscles to compare, from a text such as `1+4, 2+3`."""
    splits = []
    for part in text.replace("-", "+").split(","):
        try:
            counts = tuple(int(count) for count in part.split("+"))
        except ValueError:
            raise InvalidInputError(
                "splits", "must be like 1+4, 2+3", text[:40], "whole numbers joined by +"
            ) from None
        if len(counts) < 2:
            raise InvalidInputError("splits", "must have two motor units or more each", part)
        check_units(tuple(Unit(count) for count in counts))
        splits.append(counts)
    if len(splits) > 4:
        raise InvalidInputError("splits", "must be four at most", len(splits))
    return tuple(splits)


def _is_example(view: View) -> bool:
    return _example_muscle(view.name) == view.muscle


@lru_cache(maxsize=64)
def _example_muscle(name: str) -> Muscle:
    """Muscle of an example, read once: a link is written after every move."""
    return view_of(example(name), name).muscle


def _exact_text(value: float, dimension: str, shown: str = "") -> str:
    """A `value` [SI] that reads back exactly.

    In the unit `shown`, or another of the page's, where it has few digits there.
    """
    for unit in (shown, *SHOWN["pressure"]) if shown else ():
        text = f"{value / unit_factor(unit, dimension):.10g}{unit}"
        if parse(text, dimension) == value:
            return text
    return exact(value, dimension).replace(" ", "")


def _read_example(view: View, text: str, query: Mapping[str, str]) -> View:
    if "file" in query:
        return view
    return view_of(example(text), text, view)


def _read_file(view: View, text: str, query: Mapping[str, str]) -> View:
    name = query.get("name", "linked")[:60]
    return view_of(loads(unpack(text), source=name), name, view)


def _read_units(view: View, text: str, _: Mapping[str, str]) -> View:
    units = []
    for part in text.split(",")[: MOST_UNITS + 1]:
        count, _at, size = part.partition("@")
        try:
            units.append(Unit(int(count), float(size or 1)))
        except ValueError:
            raise InvalidInputError("units", "must be like 1,4@0.5", text[:40]) from None
    check_units(tuple(units))
    return replace(view, units=tuple(units), pressures=(view.supply,) * len(units))


def _read_pressures(view: View, text: str, _: Mapping[str, str]) -> View:
    values = tuple(_gauge_pressure(P) for P in text.split(",")[:MOST_UNITS])
    return replace(view, pressures=values) if len(values) == len(view.units) else view


def _gauge_pressure(text: str) -> float:
    value = parse(text, "pressure")
    return float(
        check_interval(value, 0.0, HIGHEST_PRESSURE, "pressure", "Pa", "(gauge)", (True, True))
    )


def _choice_reader(name: str, known: tuple[str, ...]) -> Callable[..., View]:
    def read(view: View, text: str, _: Mapping[str, str]) -> View:
        if text not in known:
            raise InvalidInputError(name, f"must be one of {', '.join(known)}", text[:40])
        return replace(view, **{name: text})

    return read


def _read_supply(view: View, text: str, _: Mapping[str, str]) -> View:
    value = _gauge_pressure(text)
    if value <= 0:
        raise InvalidInputError("supply", "must be positive", value, shown=f"{value:g} Pa")
    return replace(view, supply=value)


def _read_strain(view: View, text: str, _: Mapping[str, str]) -> View:
    value = check_interval(
        parse(text, "strain"), 0.0, LARGEST_STRAIN, "strain", "-", closed=(True, True)
    )
    return replace(view, strain=float(value))


def _read_shown(view: View, text: str, _: Mapping[str, str]) -> View:
    units = text.split(",")
    shown = dict(zip(SHOWN, units, strict=False))
    if len(units) != len(SHOWN) or any(unit not in SHOWN[kind] for kind, unit in shown.items()):
        raise InvalidInputError("show", "must be units such as kPa,mm,N", text[:40])
    return replace(view, shown=shown)


def _read_compared(view: View, text: str, _: Mapping[str, str]) -> View:
    return replace(view, compared=check_compared(tuple(text.split(","))))


# in this order: the muscle says how many units there are
_READERS: Mapping[str, Callable[[View, str, Any], View]] = {
    "muscle": _read_example,
    "file": _read_file,
    "supply": _read_supply,
    "units": _read_units,
    "scheme": _choice_reader("scheme", tuple(SCHEMES)),
    "pressure": lambda view, text, _: replace(view, pressure=_gauge_pressure(text)),
    "strain": _read_strain,
    "pressures": _read_pressures,
    "resistance": lambda view, text, _: replace(view, resistance=text != "off"),
    "path": _choice_reader("path", PATHS),
    "splits": lambda view, text, _: replace(view, splits=parse_splits(text)),
    "show": _read_shown,
    "tab": _choice_reader("tab", TABS),
    "compare": _read_compared,
}
