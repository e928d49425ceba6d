"""A scenario of the page: its file, the values that a visitor changes, and the policies to compare.

The file's text is edited: comments and other keys stay. Nothing here imports the simulator.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import tomlkit

from ..bundle import Bundle
from ..core.errors import InvalidInputError
from ..core.validation import HIGHEST_PRESSURE, check_choice
from ..files import dumps, example, example_text, named_muscles, scenarios
from ..files.muscle_files import from_dict, parse_file
from ..muscle import Muscle
from ..units import exact, parse, pretty
from .texts import TEXTS


# what each of `control.POLICIES`, which takes the simulator to import, does
POLICIES = TEXTS["policies"]
DEFAULT = "raise_1_4"
LARGEST_FILE = 100_000  # bytes: a hundred times the shipped ones
# value that stands for the load, by its kind: key, label and dimension
_LOADS = {
    "hanging_mass": ("mass", "Mass of the load", "mass"),
    "inertia_spring_damper": ("mass", "Mass of the load", "mass"),
    "prescribed_motion": ("mean", "Contraction, held", "length"),
}
# values that stand for a valve's size: label and dimension
_SIZES = {
    "C": ("C", "sonic_conductance"),
    "area": ("area", "area"),
    "nominal_flow": ("flow", "volume_flow"),
    "Kv": ("Kv", "volume_flow"),
    "Cv": ("Cv", "number"),
}
_VALVES = {"valve": "Valve", "exhaust_valve": "Exhaust"}
_BY_UNIT = ("fluid", "run", *_VALVES)  # sections whose lists have an entry for each motor unit


class ScenarioValue(NamedTuple):
    """A `value` [SI] in a scenario's file that the page can change; `path`: such as "valve.C.0"."""

    path: str
    label: str
    dimension: str
    value: float

    @property
    def name(self) -> str:
        """Key of the value in its table."""
        return [key for key in self.path.split(".") if not key.isdigit()][-1]


@dataclass(frozen=True)
class Setup:
    """A scenario to simulate, with changes.

    `name` of the scenario; `own` text of a visitor's file, empty for a shipped one; changed
    `values` [SI] by path; `policies` to compare, none for that of the file.
    """

    name: str = DEFAULT
    own: str = ""
    values: tuple[tuple[str, float], ...] = ()
    policies: tuple[str, ...] = ()

    @property
    def source(self) -> str:
        """Text of the scenario's file, unchanged."""
        return self.own or example_text(self.name)

    @cached_property
    def tables(self) -> dict[str, Any]:
        """Content of the scenario's file."""
        return parse_file(self.source, self.name)

    @property
    def has_control(self) -> bool:
        """True for a scenario with [control], whose policy can be changed."""
        return isinstance(self.tables.get("control"), dict)

    @cached_property
    def file_fields(self) -> list[ScenarioValue]:
        """The scenario's quantities that can be changed, with the file's values."""
        return _fields(self.tables)

    @property
    def fields(self) -> list[ScenarioValue]:
        """The scenario's quantities that can be changed, each with this setup's value."""
        values = dict(self.values)
        return [x._replace(value=values.get(x.path, x.value)) for x in self.file_fields]

    def with_value(self, path: str, value: float) -> "Setup":
        """A copy whose quantity at a `path` has a `value` [SI]; `ValueError` on an unknown path or
        an impossible value.
        """
        fields = {field.path: field for field in self.file_fields}
        field = fields[check_choice(path, fields, "set")]
        is_pressure = field.dimension == "pressure"
        top = HIGHEST_PRESSURE if is_pressure else math.inf
        if field.dimension != "length" and not 0 < value <= top:  # a contraction may be negative
            limit = f" and at most {pretty(top, 'pressure')}" if is_pressure else ""
            shown = pretty(value, field.dimension)
            raise InvalidInputError(field.name, f"must be positive{limit}", value, shown=shown)
        values = {**dict(self.values), path: value}
        changed = tuple((key, x) for key, x in values.items() if x != fields[key].value)
        return replace(self, values=changed)

    def text(self, policy: str = "", bundle: Bundle | None = None) -> str:
        """Text of the file with the changed values, a `policy` and the page's `bundle`."""
        document: Any = tomlkit.parse(self.source)
        dimensions = {field.path: field.dimension for field in self.file_fields}
        for path, value in self.values:
            *keys, last = (int(key) if key.isdigit() else key for key in path.split("."))
            table = document
            for key in keys:
                table = table[key]
            table[last] = exact(value, dimensions[path])
        if policy and self.has_control and document["control"].get("policy") != policy:
            document["control"]["policy"] = policy
        if bundle is not None:
            _set_bundle(document, bundle)
        loads = any(path.startswith("load.") for path, _ in self.values)
        if self.has_control and (loads or bundle is not None):
            # another load is held by other pressures, those of the first demand
            document["run"].pop("pressures", None)
        return tomlkit.dumps(document)


def _set_bundle(document: Any, bundle: Bundle) -> None:
    """Set a scenario's `bundle`; lists by unit become as long, their last entry repeated."""
    number = len(bundle.motor_units)
    tables = tomlkit.parse(dumps(bundle))
    for key in ("muscle", "bundle"):
        document.pop(key, None)
        if key in tables:
            document[key] = tables[key]
    sections = [document[key] for key in _BY_UNIT if key in document]
    for section in (*sections, *document.get("schedule", [])):
        for key, values in section.items():
            if isinstance(values, list):
                section[key] = [*values, *[values[-1]] * number][:number]


def open_setup(text: str, name: str) -> Setup:
    """Setup of a visitor's file; `ValueError`, in one line, for one that the page can't run."""
    setup = Setup(name, text)
    data = setup.tables
    if not {"load", "run", "schedule"} & data.keys():
        raise ValueError(
            f"{name}: this is no scenario, without [load] and [run]: open a muscle or bundle at the"
            " top of the page."
        )
    bundle, friction = data.get("bundle"), data.get("hysteresis")
    if isinstance(bundle, list):
        raise ValueError(f"{name}: the page runs one bundle, not two: use `fascicle simulate`.")
    other_files = {
        f"bundle = {str(bundle)[:60]!r}": isinstance(bundle, str) and bundle not in named_muscles(),
        'hysteresis: kind = "measured"': isinstance(friction, dict)
        and friction.get("kind") == "measured",
    }
    for key, is_other in other_files.items():
        if is_other:
            raise ValueError(
                f"{name}: {key} names another file, which the page can't read: name a shipped"
                " bundle, write its values into this file, or use `fascicle simulate`."
            )
    return setup


def bundle_of(setup: Setup) -> Muscle | Bundle:
    """Muscle or bundle in the file of a `setup`; `ValueError` where there is none."""
    data = setup.tables
    if isinstance(data.get("bundle"), str):
        return example(data["bundle"])
    inline = {key: data[key] for key in ("format", "muscle", "bundle") if key in data}
    return from_dict(inline, setup.name)


def page_scenarios() -> dict[str, str]:
    """Descriptions of the shipped scenarios of one bundle, by name: a joint has two."""
    texts = {name: parse_file(example_text(name), name) for name in scenarios()}
    return {
        name: text
        for name, text in scenarios().items()
        if not isinstance(texts[name].get("bundle"), list)
    }


def _fields(data: Mapping[str, Any]) -> list[ScenarioValue]:
    """Quantities of a scenario's tables that can be changed."""
    fields = []
    rows: list[tuple[str, str, str, object]] = []
    load, supply = data.get("load"), data.get("supply")
    if isinstance(load, dict) and load.get("kind") in _LOADS:
        key, label, dimension = _LOADS[load["kind"]]
        rows.append((f"load.{key}", label, dimension, load.get(key)))
    if isinstance(supply, dict):
        rows.append(("supply.pressure", "Supply pressure", "pressure", supply.get("pressure")))
    for section, title in _VALVES.items():
        valve = data.get(section)
        for key, (label, dimension) in _SIZES.items():
            value = valve.get(key) if isinstance(valve, dict) else None
            path, text = f"{section}.{key}", f"{title} {label}"
            if not isinstance(value, list):
                rows.append((path, text, dimension, value))
                continue
            for i, x in enumerate(value):
                rows.append((f"{path}.{i}", f"{text}, unit {i + 1}", dimension, x))
    for path, label, dimension, value in rows:
        try:
            fields.append(ScenarioValue(path, label, dimension, parse(value, dimension)))
        except (ValueError, TypeError):  # missing, or an error that the run reports
            continue
    return fields


def check_policies(setup: Setup, policies: list[str]) -> tuple[str, ...]:
    """Check `policies` of a `setup`, and return them in the order of `POLICIES`."""
    if policies and not setup.has_control:
        rule = "need a scenario with [control]: this one is commanded by a schedule"
        raise InvalidInputError("policies", rule, None)
    for policy in policies:
        check_choice(policy, POLICIES, "policies")
    return tuple(policy for policy in POLICIES if policy in policies)
