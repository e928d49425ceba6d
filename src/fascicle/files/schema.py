"""Schemas of muscle, bundle, task and catalog files, format 1: their keys and kinds of values.

A section knows units and types only; the constructors check values, and refuse them by the
argument's name, which a `FileLocation` turns into path, key, value and rule. A missing key is
`None` here, so that a default is written once, in the constructor.
"""

import contextlib
import re
import reprlib
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any, NamedTuple, ParamSpec, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    StrictInt,
    StrictStr,
    model_validator,
)

from ..core.errors import InvalidInputError
from ..muscle.laws import LAWS
from ..muscle.materials import MooneyRivlin
from ..muscle.products import thread_sizes
from ..table_model import FileError, PlainOrTable, Quantity, TableModel, value_at
from ..units import exact, parse, parse_list


# keys of a constructor's arguments by kind of section, if they aren't the arguments' names
_KEYS: dict[str, dict[str, tuple[str, ...]]] = {
    "muscle": {
        "transition_rate": ("collapse", "transition_rate"),
        **{constant.name: ("material", constant.name) for constant in MooneyRivlin.constants()},
    },
    **{kind: {kind: ("law",)} for kind in LAWS},
    "tuning": {
        "pressures": ("pressure",),
        "hinge_stiffness_slope": ("hinge_stiffness_factor", "slope"),
    },
    "bundle": {"motor_units": ("motor_unit",), "pressures": ("supply_pressure",)},
    "design": {"drawings": ("muscle",), "most_units": ()},
    "catalog": {"catalog": ()},
    "objectives": {"objectives": ()},
    "limits": {"objectives": ()},
    # a plant's parts are tables of the file, its initial state stands in [run]
    "scenario": {
        **{name: ("run", name) for name in ("pressures", "position", "law", "volume")},
        "units": ("spool",),
        "compliance": ("fluid", "compliance"),
    },
    "motion": {"position": ("load",), "pressures": ("run", "pressures")},
    "part": {"gas": ("medium",), "liquid": ("medium",)},
}
# tables that only one kind of file has, and its command; scenarios may have a muscle, too
_MUSCLE = "muscle or bundle"
_KINDS = {
    "scenario": (("load", "supply", "run", "schedule"), "`fascicle simulate` runs it"),
    "task": (("task", "design"), "`fascicle design` takes it"),
    _MUSCLE: (("muscle", "bundle"), "`fascicle force` and `fascicle bundle` take it"),
}


_P = ParamSpec("_P")
_R = TypeVar("_R")


class FileLocation(NamedTuple):
    """A section of a file: the file's `source`, the `data` of all its tables, the `keys` that lead
    to the section, and its `kind`, a key of `_KEYS` or another word.
    """

    source: str
    data: Any
    keys: tuple[Any, ...] = ()
    kind: str = ""

    def child(self, *keys: Any, kind: str = "") -> "FileLocation":
        """Location at `keys` below this one."""
        return self._replace(keys=self.keys + keys, kind=kind)

    def error(self, keys: tuple[Any, ...], rule: str) -> FileError:
        """Error for the value at `keys` below this location, which breaks a `rule`."""
        path = self.keys + keys
        names = [key for key in path if key != ""]  # a single muscle has the empty name
        return FileError(self.source, names, rule, value_at(self.data, path))

    @contextlib.contextmanager
    def error_context(self) -> Iterator[None]:
        """Context whose errors, also those of a file that is named here, get this location."""
        try:
            yield
        except (ValueError, OSError) as error:
            name = error.argument if isinstance(error, InvalidInputError) else ""
            keys = _KEYS.get(self.kind, {}).get(name, (name,) if name else ())
            raise self.error(keys, str(error)) from None

    def call(self, function: Callable[_P, _R], /, *args: _P.args, **kwargs: _P.kwargs) -> _R:
        """Result of a `function` whose errors get this location."""
        with self.error_context():
            return function(*args, **kwargs)


def check_kind(data: Mapping[str, Any], kind: str, source: str) -> None:
    """Refuse a file with tables of another kind than "muscle or bundle", "scenario" or "task"."""
    if kind != _MUSCLE and any(key in data for key in _KINDS[kind][0]):
        return
    for actual, (keys, command) in _KINDS.items():
        if actual != kind and (known := [key for key in keys if key in data]):
            rule = f"a {actual}, not a {kind}: {command}."
            raise FileError(source, known[:1], rule)


Length = Annotated[float, Quantity("length")]
Angle = Annotated[float, Quantity("angle")]
Force = Annotated[float, Quantity("force")]
Pressure = Annotated[float, Quantity("pressure")]
Number = Annotated[float, Quantity("number")]


class LawSection(TableModel):
    """`tension = { … }` and the like: a law by name. The other keys are numbers and switches that
    the law declares: `muscle_files` reads them when it has the law.
    """

    model_config = ConfigDict(extra="allow")
    law: StrictStr | None = None


class CollapseSection(LawSection):
    """`[muscle.collapse]`: the law, and the rate at which it is reached."""

    transition_rate: Number | None = None


class HingeSection(TableModel):
    """`hinge_stiffness_factor = { … }`: a factor that is affine in pressure."""

    constant: Number | None = None
    slope: Annotated[float, Quantity("inverse_pressure")] | None = None


class TuningSection(TableModel):
    """`[muscle.tuning]`: tables of C1 and C2 in pressure, four factors, the dead band."""

    pressure: list[Pressure] | None = None
    c1: list[Force] | None = None
    c2: list[Number] | None = None
    youngs_modulus_factor: Number | None = None
    collapse_moment_factor: Number | None = None
    hinge_stiffness_factor: PlainOrTable[Number, HingeSection] | None = None
    transition_rate: Number | None = None
    dead_band: Pressure | None = None


class MuscleSection(TableModel):
    """`[muscle]`, or one of several named ones."""

    length: Length = Field(examples=['"127 mm"'])
    outer_radius: Length = Field(examples=['"6.35 mm"'])
    wall_thickness: Length = Field(examples=['"1.6 mm"'])
    braid_angle: Angle = Field(examples=['"33 deg"'])
    material: PlainOrTable[StrictStr, dict[str, Any]] | None = None  # constants, as a law's
    tension: PlainOrTable[StrictStr, LawSection] | None = None
    buckling: PlainOrTable[StrictStr, LawSection] | None = None
    post_collapse: PlainOrTable[StrictStr, LawSection] | None = None
    ends: PlainOrTable[StrictStr, LawSection] | None = None
    collapse: CollapseSection | None = None
    tuning: TuningSection | None = None

    @model_validator(mode="before")
    @classmethod
    def _convert_sizes(cls, table: Any) -> Any:
        """Table with radius, wall and angle in place of diameters, or of a thread and its turns."""
        if not isinstance(table, dict):
            return table
        values = dict(table)

        def take(key: str, dimension: str) -> float:
            if key not in values:
                raise ValueError(f"{key} is missing: it belongs to the other sizes of the table")
            return parse(values.pop(key), dimension, key)

        def put(key: str, value: float, dimension: str) -> None:
            if key in values:
                raise ValueError(f"{key} follows from the other sizes: drop one of them")
            values[key] = exact(value, dimension)

        if "outer_diameter" in values:
            diameter = take("outer_diameter", "length")
            put("outer_radius", diameter / 2, "length")
            if "inner_diameter" in values:
                put("wall_thickness", (diameter - take("inner_diameter", "length")) / 2, "length")
        if {"thread_length", "turns"} & set(values):
            thread, turns = take("thread_length", "length"), take("turns", "number")
            length = parse(values.get("length"), "length", "length")
            radius, angle = thread_sizes(length, thread, turns)
            put("outer_radius", float(radius), "length")
            put("braid_angle", float(angle), "angle")
        return values


class MotorUnitSection(TableModel):
    """`[[bundle.motor_unit]]`: count and name of the muscles that share a pressure."""

    count: StrictInt | None = None
    muscle: StrictStr | None = None


class BundleSection(TableModel):
    """`[bundle]`: the supply, the recruitment scheme, the motor units in their order."""

    supply_pressure: Pressure | None = None
    scheme: StrictStr | None = None
    length: Length | None = None
    motor_unit: list[MotorUnitSection] = Field(
        default_factory=list[MotorUnitSection], examples=["{ count = 1 }"]
    )


class MuscleFile(TableModel):
    """A muscle or bundle file; a muscle without a name has the empty name."""

    format: StrictInt = Field(examples=["1"])
    muscle: dict[str, PlainOrTable[StrictStr, MuscleSection]] = Field(examples=["[muscle]"])
    bundle: BundleSection | None = None
    calibration: dict[str, Any] | None = None  # for readers and programs, no part of the muscle
    entry: "EntrySection | None" = None  # as above


class Price(NamedTuple):
    """An `amount` of a `currency`, of a piece or an SI unit."""

    amount: float
    currency: str


_PRICE = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*([^\W\d_]{1,6}|[€$£¥])\s*(?:/\s*(\S.*?))?\s*")
_MAX_PRICE = 1e9  # of a currency: more is a slip
_MAX_BLOCK = 2**20  # designs: their arrays still fit into memory
_MAX_DRAWS = 100_000  # of a design: an hour
_PRICED = {None: "", "length": "/m", "volume": "/m^3", "energy": "/kWh"}  # units of examples


def parse_price(text: Any, name: str, dimension: str | None = None) -> Price:
    """Parse a price, such as "95 EUR" of a piece, or "0.025 EUR/m^3" by a unit of `dimension`;
    `ValueError`, in one line about the key `name`, for another text.
    """
    match = _PRICE.fullmatch(text) if isinstance(text, str) and len(text) <= 60 else None
    if match is None or bool(match[3]) != bool(dimension) or float(match[1]) > _MAX_PRICE:
        rule = f'must be a price, such as "95 EUR{_PRICED[dimension]}"'
        raise InvalidInputError(name, rule, text, shown=reprlib.repr(text))
    amount, currency, unit = match.groups()
    # a normal cubic meter is often written Nm³
    plain = re.sub(r"^N?m(\^?3|³)$", "m^3", unit or "")
    size = parse(f"1 {plain}", dimension, name) if dimension else 1.0
    return Price(float(amount) / size, currency)


def _price_parser(dimension: str | None) -> BeforeValidator:
    return BeforeValidator(lambda text, info: parse_price(text, str(info.field_name), dimension))


def _quantity_parser(dimension: str) -> BeforeValidator:
    """Parser of a quantity, a list or range in the command line's syntax, or a list of these."""

    def parse_quantities(value: Any, info: Any) -> tuple[float, ...]:
        values: list[float] = []
        for entry in value if isinstance(value, list) else [value]:
            if isinstance(entry, str) and (":" in entry or "," in entry):
                values += parse_list(entry, dimension, info.field_name)
            else:
                values.append(parse(entry, dimension, info.field_name))
        return tuple(values)

    return BeforeValidator(parse_quantities)


def _as_list(value: Any) -> list[Any]:
    """One entry stands for a list of it."""
    if value == []:
        raise ValueError("must be an entry, or a list of them")
    return value if isinstance(value, list) else [value]


PriceEach = Annotated[Price, _price_parser(None)]
Names = Annotated[tuple[StrictStr, ...], BeforeValidator(_as_list)]
Integers = Annotated[tuple[StrictInt, ...], BeforeValidator(_as_list)]
Lengths = Annotated[tuple[float, ...], _quantity_parser("length")]
Angles = Annotated[tuple[float, ...], _quantity_parser("angle")]
Forces = Annotated[tuple[float, ...], _quantity_parser("force")]
Pressures = Annotated[tuple[float, ...], _quantity_parser("pressure")]
Strains = Annotated[tuple[float, ...], _quantity_parser("strain")]
Times = Annotated[tuple[float, ...], _quantity_parser("time")]
Numbers = Annotated[tuple[float, ...], _quantity_parser("number")]


def _check_ends(values: tuple[float, ...]) -> tuple[float, ...]:
    """The `values` [SI] if they are the ends of a range."""
    if len(values) != 2 or not values[0] < values[1]:
        raise ValueError("must be a list of two, the least and the largest")
    return values


_Text = Annotated[StrictStr, Field(min_length=1)]


class EntrySection(TableModel):
    """`[entry]` of a measured muscle's file, as in `docs/_static/measured-muscle.toml`."""

    title: _Text = Field(examples=['"Festo DMSP-20-300"'])
    maker: _Text = Field(examples=['"Festo"'])
    source: _Text = Field(examples=['"Author (year). Title. Journal volume, pages"'])
    url: Annotated[StrictStr, Field(pattern="^https?://")] = Field(examples=['"https://doi.org/…"'])
    license: _Text = Field(examples=['"CC BY 4.0"'])
    sizes: _Text = Field(examples=['"inner diameter 20 mm, length 300 mm"'])
    measured: _Text = Field(examples=['"126 readings at 21 pressures and 6 lengths"'])
    assumed: Names = Field(examples=['["…"]'])
    record: Annotated[StrictStr, Field(pattern=r"^[\w-]+\.csv$")] | None = None
    rest_length: Length | None = None
    pressure: Annotated[Pressures, AfterValidator(_check_ends)] | None = None
    strain: Annotated[Strains, AfterValidator(_check_ends)] | None = None
    rmse: Force | None = None
    relative_rmse: Number | None = None
    largest_error: Annotated[float, Quantity("strain")] | None = None


class EntryFile(BaseModel):
    """A measured muscle's file without the muscle."""

    entry: EntrySection = Field(examples=["[entry]"])
    calibration: dict[str, Any] = {}


class TaskSection(TableModel):
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


class ProductSection(TableModel):
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
    price_per_length: Annotated[Price, _price_parser("length")] | None = None
    mass: Annotated[float, Quantity("mass")] | None = None
    mass_per_length: Annotated[float, Quantity("linear_density")] | None = None
    largest_pressure: Pressure | None = None
    largest_strain: Annotated[float, Quantity("strain")] | None = None
    source: StrictStr | None = None


class CatalogFile(TableModel):
    """A catalog file."""

    format: StrictInt = Field(examples=["1"])
    product: list[ProductSection] = Field(examples=["[[product]]"])


class PricesSection(TableModel):
    """`[prices]`: of a valve or muscle, of air by normal volume, and of energy."""

    valve: PriceEach | None = None
    muscle: PriceEach | None = None
    air: Annotated[Price, _price_parser("volume")] | None = None
    energy: Annotated[Price, _price_parser("energy")] | None = None


class DesignSection(TableModel):
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
    density: Annotated[float, Quantity("density")] | None = None
    catalog: (
        PlainOrTable[StrictStr, Annotated[list[ProductSection], BeforeValidator(_as_list)]] | None
    ) = None


class SweepSection(TableModel):
    """`[sweep]`: number of designs in a block."""

    block: Annotated[StrictInt, Field(ge=1, le=_MAX_BLOCK)] | None = None


class ScatterSection(TableModel):
    """`[scatter]`: of fabrication, of the model, and `calibrated` of the fitted constants."""

    enabled: StrictBool | None = None
    length: Number | None = None
    wall_thickness: Number | None = None
    braid_angle: Angle | None = None
    model_error: Number | None = None
    draws: Annotated[StrictInt, Field(ge=2, le=_MAX_DRAWS)] | None = None
    calibrated: StrictBool | None = None


class CycleSection(TableModel):
    """`[cycle]`: times to lift and release, or one for both; each unit's hose; b of the valves."""

    time: Annotated[float | None, Quantity("time")] = Field(None, examples=['"0.5 s"'])
    lift: Annotated[float | None, Quantity("time")] = Field(None, examples=['"0.3 s"'])
    release: Annotated[float | None, Quantity("time")] = Field(None, examples=['"0.2 s"'])
    per_minute: Number = Field(examples=["20"])
    hose_length: Length | None = None
    b: Number | None = None


class TaskFileSection(TableModel):
    """A task file."""

    format: StrictInt = Field(examples=["1"])
    task: TaskSection = Field(examples=["[task]"])
    design: DesignSection = Field(examples=["[design]"])
    objectives: dict[str, StrictStr] | None = None
    limits: dict[str, Any] | None = None
    prices: PricesSection | None = None
    scatter: ScatterSection | None = None
    cycle: CycleSection | None = None
    sweep: SweepSection | None = None
