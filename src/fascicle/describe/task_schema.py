"""The sections of a task file, format 1: what is demanded, what may be built, what is good."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, StrictBool, StrictInt, StrictStr

from ..units import parse, parse_list
from .schema import Angle, Number, Pressure, Section


def _values(dimension: str) -> BeforeValidator:
    """A quantity, a list or range as the command line writes it, or a list of them."""

    def read(value: Any, info: Any) -> tuple[float, ...]:
        entries = value if isinstance(value, list) else [value]
        found: list[float] = []
        for entry in entries:
            if isinstance(entry, str) and (":" in entry or "," in entry):
                found += parse_list(entry, dimension, info.field_name)
            else:
                found.append(parse(entry, dimension, info.field_name))
        return tuple(found)

    return BeforeValidator(read)


def _entries(kind: type, rule: str) -> BeforeValidator:
    """One entry or a list of them."""

    def read(value: Any, info: Any) -> tuple[Any, ...]:
        entries = value if isinstance(value, list) else [value]
        if not entries or any(type(entry) is not kind for entry in entries):
            raise ValueError(f"`{info.field_name}` must be {rule}, or a list of them.")
        return tuple(entries)

    return BeforeValidator(read)


Lengths = Annotated[tuple[float, ...], _values("length")]
Angles = Annotated[tuple[float, ...], _values("angle")]
Forces = Annotated[tuple[float, ...], _values("force")]
Strains = Annotated[tuple[float, ...], _values("strain")]
Times = Annotated[tuple[float, ...], _values("time")]
Numbers = Annotated[tuple[float, ...], _values("number")]
Names = Annotated[tuple[str, ...], _entries(str, "a name")]
Integers = Annotated[tuple[int, ...], _entries(int, "a whole number")]


class TaskSection(Section):
    """`[task]`: a named example, or forces at strains with weights or times."""

    example: StrictStr | None = None
    name: StrictStr | None = None
    source: StrictStr | None = None
    force: Forces | None = None
    strain: Strains | None = None
    weight: Numbers | None = None
    time: Times | None = None
    supply_pressure: Pressure = Field(examples=['"413.7 kPa"'])
    scheme: StrictStr | None = None


class DesignSection(Section):
    """`[design]`: the muscles to choose from, their numbers, splits and sizes."""

    muscle: Names = Field(examples=['"kim2021_slenderness_10"'])
    muscles: Integers | None = None
    splits: Names | None = None
    radius: Lengths | None = None
    radius_rule: StrictStr | None = None
    length: Lengths | None = None
    braid_angle: Angles | None = None
    wall_ratio: Numbers | None = None
    unit_factors: Numbers | None = None
    buckling: StrictStr | None = None


class SweepSection(Section):
    """`[sweep]`: of a study, how its designs are cut up."""

    block: StrictInt | None = None


class ScatterSection(Section):
    """`[scatter]`: how unlike muscles come out, and whether constants are drawn too."""

    length: Number | None = None
    braid_angle: Angle | None = None
    draws: StrictInt | None = None
    calibrated: StrictBool | None = None


class TaskFileSection(Section):
    """A whole task file."""

    format: StrictInt = Field(examples=["1"])
    task: TaskSection = Field(examples=["[task]"])
    design: DesignSection = Field(examples=["[design]"])
    objectives: dict[str, StrictStr] | None = None
    limits: dict[str, dict[str, Any]] | None = None
    scatter: ScatterSection | None = None
    sweep: SweepSection | None = None
