"""The sections of a task file, format 1: what is demanded, what may be built, what is good."""

from typing import Annotated, Any

from pydantic import (
    BeforeValidator,
    Discriminator,
    Field,
    StrictBool,
    StrictInt,
    StrictStr,
    Tag,
)

from ..core.errors import InvalidInputError
from ..units import parse, parse_list
from .prices import Price, parse_price
from .schema import PLAIN, TABLE, Angle, Length, Number, Pressure, Section


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
            raise InvalidInputError(info.field_name, f"must be {rule}, or a list of them", None)
        return tuple(entries)

    return BeforeValidator(read)


def _one(dimension: str) -> BeforeValidator:
    def read(value: Any, info: Any) -> float:
        return parse(value, dimension, info.field_name)

    return BeforeValidator(read)


def _price(per: str | None) -> BeforeValidator:
    def read(value: Any, info: Any) -> Price:
        return parse_price(value, info.field_name, per)

    return BeforeValidator(read)


def _a_list(value: Any) -> Any:
    """One table is a list of one."""
    return [value] if isinstance(value, dict) else value


def _name_or_tables(value: Any) -> str:
    return TABLE if isinstance(value, list) else PLAIN


Mass = Annotated[float, _one("mass")]
LinearDensity = Annotated[float, _one("linear_density")]
Density = Annotated[float, _one("density")]
Strain = Annotated[float, _one("strain")]
PriceEach = Annotated[Price, _price(None)]
PricePerVolume = Annotated[Price, _price("volume")]
PricePerEnergy = Annotated[Price, _price("energy")]
PricePerLength = Annotated[Price, _price("length")]
Lengths = Annotated[tuple[float, ...], _values("length")]
Angles = Annotated[tuple[float, ...], _values("angle")]
Forces = Annotated[tuple[float, ...], _values("force")]
Strains = Annotated[tuple[float, ...], _values("strain")]
Times = Annotated[tuple[float, ...], _values("time")]
Numbers = Annotated[tuple[float, ...], _values("number")]
Names = Annotated[tuple[str, ...], _entries(str, "a name")]
Integers = Annotated[tuple[int, ...], _entries(int, "a whole number")]


class TaskSection(Section):
    """`[task]`: a named example, or forces at strains or strokes, with weights or times."""

    example: StrictStr | None = None
    name: StrictStr | None = None
    source: StrictStr | None = None
    force: Forces | None = None
    strain: Strains | None = None
    stroke: Lengths | None = None
    weight: Numbers | None = None
    time: Times | None = None
    supply_pressure: Pressure = Field(examples=['"413.7 kPa"'])
    scheme: StrictStr | None = None
    fluid: StrictStr | None = None


class ProductSection(Section):
    """`[[design.catalog]]`, or `[[product]]` of a catalog's own file: a muscle that is sold."""

    name: StrictStr = Field(examples=['"DMSP-20"'])
    muscle: StrictStr | None = None
    outer_radius: Length | None = None
    outer_diameter: Length | None = None
    inner_diameter: Length | None = None
    wall_thickness: Length | None = None
    braid_angle: Angle | None = None
    length: Lengths | None = None
    least_length: Length | None = None
    most_length: Length | None = None
    price: PriceEach | None = None
    price_per_length: PricePerLength | None = None
    mass: Mass | None = None
    mass_per_length: LinearDensity | None = None
    largest_pressure: Pressure | None = None
    largest_strain: Strain | None = None
    source: StrictStr | None = None


class CatalogFileSection(Section):
    """A whole catalog file."""

    format: StrictInt = Field(examples=["1"])
    product: list[ProductSection] = Field(examples=["[[product]]"])


class PricesSection(Section):
    """`[prices]`: what things cost, for one or by their unit; the m³ of air is a normal one."""

    valve: PriceEach | None = None
    muscle: PriceEach | None = None
    air: PricePerVolume | None = None
    energy: PricePerEnergy | None = None


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
    density: Density | None = None
    catalog: (
        Annotated[
            Annotated[StrictStr, Tag(PLAIN)] | Annotated[list[ProductSection], Tag(TABLE)],
            Discriminator(_name_or_tables),
            BeforeValidator(_a_list),
        ]
        | None
    ) = None


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
    limits: dict[str, Any] | None = None
    prices: PricesSection | None = None
    scatter: ScatterSection | None = None
    sweep: SweepSection | None = None
