"""A scenario's supply, from its table."""

from typing import Any

from ..fluid import Accumulator, AdiabaticWall, Gas, Isothermal, PumpedAccumulator, Tank
from .places import Place
from .scenario_schema import PUMPED, pump_class


def supply_of(
    table: dict[str, Any], kind: type, medium: Any, room: dict[str, Any], place: Place
) -> Any:
    """The supply that a file describes.

    **Arguments:**

    - `table`: what its table says, by key [SI].
    - `kind`: its class [-].
    - `medium`: the fluid [-].
    - `room`: what is given of the room, by key: absolute pressure [Pa] and temperature [K].
    - `place`: where the table stands [-].

    **Returns:** the supply [-].

    **Raises:** `ValueError`, in one line with the key, for what can't be.
    """
    gas = isinstance(medium, Gas)
    if kind in (Accumulator, PumpedAccumulator) and gas:
        raise place.refuse(("kind",), "it holds a liquid: take constant or tank for a gas.")
    if kind is Tank and not gas:
        rule = "it holds a gas: take constant, accumulator or pumped for a liquid."
        raise place.refuse(("kind",), rule)
    if kind is PumpedAccumulator:
        return _pumped(table, medium, room, place)
    with place.naming():
        if kind is Tank:
            wall = table.pop("conductance", None)
            chamber: Any = Isothermal if wall is None else AdiabaticWall
            own = {} if wall is None else {"conductance": wall}
            return Tank(chamber(gas=medium, **own, **room), **table)
        if kind is Accumulator:
            return Accumulator(**table, liquid=medium, **room)
        if "room_temperature" in room:
            table.setdefault("supply_temperature", room["room_temperature"])
        around = {key: x for key, x in room.items() if key == "room_pressure"}
        return kind(**table, **around)


def _pumped(table: dict[str, Any], medium: Any, room: dict[str, Any], place: Place) -> Any:
    whole = Place(place.source, place.data, (), "scenario")
    kinds: dict[str, Any] = {"pump": pump_class(place.data, whole), **PUMPED}
    parts: dict[str, Any] = {}
    for key, kind in kinds.items():
        if key in table:
            given = table.pop(key) | ({"liquid": medium} if key == "pump" else {})
            with place.inner(key, kind="part").naming():
                parts[key] = kind(**given)
    with place.naming():
        return PumpedAccumulator(Accumulator(**table, liquid=medium, **room), **parts)
