"""A view as a link, and back: an example by its name, any other muscle as its deflated file.

A link is data from a stranger: it is bounded, parsed as TOML, JSON and by `units`, and nothing in
it is a path or is run. Panel's own `Location.sync` reads JSON into parameters.
"""

import base64
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from ..bundle.energetics import PATHS
from ..bundle.schemes import SCHEMES
from ..core.errors import InvalidInputError
from ..core.validation import check_choice
from ..files import dumps, example, loads, named_muscles
from ..units import exact, parse
from . import state
from .scenario_setup import DEFAULT, Setup, check_policies, open_setup, page_scenarios


LONGEST = 16_000  # characters of a packed file: servers and browsers take addresses so long
_LARGEST_TEXT = 32_000  # bytes of the file in it: eight different tuned muscles take half of that
TOO_LARGE = "left-out"  # instead of a larger file
_LONGEST_NAME = 60  # characters


def to_query(view: state.View) -> dict[str, str]:
    """Query of the link of a `view`, by key."""
    if any(unit.own is not None for unit in view.units):
        query = {"file": pack(dumps(view.bundle)), "name": view.name}
    else:
        query = {"file": pack(dumps(view.muscle)), "name": view.name}
        if state.is_shipped(view.name, view.muscle):
            query = {"muscle": view.name}
        query["units"] = ",".join(f"{unit.count}" for unit in view.units)
    query |= {
        "supply": _text(view.supply, "pressure"),
        "scheme": view.scheme,
        "pressure": _text(view.pressure, "pressure"),
        "strain": _text(view.strain, "strain"),
        "pressures": ",".join(_text(P, "pressure") for P in view.pressures),
        "resistance": "on" if view.resistance else "off",
        "path": view.path,
        "show": ",".join(view.display_units[kind] for kind in state.DISPLAY_UNITS),
        "tab": view.tab,
    }
    if view.load is not None:
        query["load"] = _text(view.load, "force")
    setup = view.setup
    if setup.own or setup.values:
        query |= {"scenario_file": pack(setup.text()), "scenario": setup.name}
    elif setup.name != DEFAULT:
        query["scenario"] = setup.name
    if setup.policies:
        query["policies"] = ",".join(setup.policies)
    return query


def has_state(query: Mapping[str, str]) -> bool:
    """True for a link with a part of a view."""
    return any(key in query for key in _READERS)


def from_query(
    query: Mapping[str, str], start: state.View
) -> tuple[state.View, state.View, list[str]]:
    """View of a link, as far as it has none the `start` view; the view that was opened before its
    changes, for `reset`; and a message for each bad key.
    """
    view, errors = start, []
    for key, read in _READERS.items():
        if key not in query:
            continue
        try:
            view = read(view, query[key], query)
        except Exception as error:  # noqa: BLE001 whatever a link holds, the page opens
            reason = error if isinstance(error, ValueError) else "it can't be read."
            errors.append(f"{key} is left out of the link: {reason}")
    if len(view.pressures) != len(view.units):
        view = replace(view, pressures=(view.supply,) * len(view.units))
    pressures = tuple(min(P, view.supply) for P in view.pressures)
    view = replace(view, pressure=min(view.pressure, view.supply), pressures=pressures)
    name, opened = view.name.removesuffix(state.CHANGED), view
    if name != view.name and name in named_muscles():
        opened = state.view_of(example(name), name, view)
    return view, opened, errors


def pack(text: str, longest: int = LONGEST) -> str:
    """Text, deflated, in characters of a link; `TOO_LARGE` where there are more than `longest`."""
    raw = text.encode()
    packed = base64.urlsafe_b64encode(zlib.compress(raw, 9)).decode().rstrip("=")
    return packed if len(raw) <= _LARGEST_TEXT and len(packed) <= longest else TOO_LARGE


def unpack(packed: str) -> str:
    """Text that was `packed`; raises `InvalidInputError` for anything else."""
    if packed == TOO_LARGE:
        raise InvalidInputError("file", "was too large for a link", None, "open the file itself")
    if len(packed) > LONGEST:
        raise InvalidInputError("file", f"must be at most {LONGEST} characters", len(packed))
    inflate, rule = zlib.decompressobj(), "is no file that this explorer has packed"
    try:
        raw = base64.urlsafe_b64decode(packed + "=" * (-len(packed) % 4))
        raw = inflate.decompress(raw, _LARGEST_TEXT + 1)
        if len(raw) <= _LARGEST_TEXT and inflate.eof:
            return raw.decode()
        if len(raw) > _LARGEST_TEXT:
            rule = f"must hold at most {_LARGEST_TEXT} bytes"
    except (ValueError, zlib.error):  # not ASCII, base64, deflated or UTF-8
        pass
    raise InvalidInputError("file", rule, None)


def _text(value: float, dimension: str) -> str:
    """A `value` [SI] that reads back exactly."""
    return exact(value, dimension).replace(" ", "")


# readers of keys: each returns the view with the text of its key


def _read_muscle(view: state.View, text: str, query: Mapping[str, str]) -> state.View:
    check_choice(text, named_muscles(), "muscle")
    return view if "file" in query else state.view_of(example(text), text, view)


def _read_file(view: state.View, text: str, query: Mapping[str, str]) -> state.View:
    name = query.get("name", "linked")[:_LONGEST_NAME]
    return state.view_of(loads(unpack(text), source=name), name, view)


def _read_unit_counts(view: state.View, text: str, _: Mapping[str, str]) -> state.View:
    """View with motor units of so many muscles each, such as "1,4"."""
    try:
        units = tuple(state.Unit(int(n)) for n in text.split(",")[: state.MOST_UNITS + 1])
    except ValueError:
        raise InvalidInputError("units", "must be like 1,4", text[:40]) from None
    state.check_units(units)
    return replace(view, units=units, pressures=(view.supply,) * len(units))


def _read_display_units(view: state.View, text: str, _: Mapping[str, str]) -> state.View:
    units = text.split(",")
    for kind, unit in zip(state.DISPLAY_UNITS, units, strict=True):
        check_choice(unit, state.DISPLAY_UNITS[kind], "show")
    return replace(view, display_units=dict(zip(state.DISPLAY_UNITS, units, strict=True)))


def _read_scenario(view: state.View, text: str, query: Mapping[str, str]) -> state.View:
    if "scenario_file" in query:
        setup = open_setup(unpack(query["scenario_file"]), text[:_LONGEST_NAME])
    else:
        setup = Setup(check_choice(text, page_scenarios(), "scenario"))
    return replace(view, setup=setup)


def _read_policies(view: state.View, text: str, _: Mapping[str, str]) -> state.View:
    policies = check_policies(view.setup, text.split(","))
    return replace(view, setup=replace(view.setup, policies=policies))


_Reader = Callable[[state.View, str, Mapping[str, str]], state.View]


def _quantity(name: str, dimension: str) -> _Reader:
    return lambda view, text, _: replace(
        view, **{name: state.check_value(name, parse(text, dimension))}
    )


def _choice(name: str, options: Sequence[str]) -> _Reader:
    return lambda view, text, _: replace(view, **{name: check_choice(text, options, name)})


def _read_pressures(view: state.View, text: str, _: Mapping[str, str]) -> state.View:
    values = (parse(value, "pressure") for value in text.split(",")[: state.MOST_UNITS])
    return replace(view, pressures=tuple(state.check_value("pressure", x) for x in values))


# in this order: the muscle's file has the number of units, and the scenario's its policies
_READERS: Mapping[str, _Reader] = {
    "muscle": _read_muscle,
    "file": _read_file,
    "supply": _quantity("supply", "pressure"),
    "units": _read_unit_counts,
    "scheme": _choice("scheme", tuple(SCHEMES)),
    "pressure": _quantity("pressure", "pressure"),
    "strain": _quantity("strain", "strain"),
    "load": _quantity("load", "force"),
    "pressures": _read_pressures,
    "resistance": lambda view, text, _: replace(view, resistance=text != "off"),
    "path": _choice("path", PATHS),
    "show": _read_display_units,
    "tab": _choice("tab", state.TABS),
    "scenario": _read_scenario,
    "policies": _read_policies,
}
