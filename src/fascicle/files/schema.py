"""The sections of a muscle file, format 1: their keys and the kind of value of each.

A section knows units and types only. What a muscle may be is the laws' own business: their
constructors refuse it, and `reading` adds the file's name and key to what they say. A key
that is left out stays `None` here, so a default is written in one place, the constructor. The
keys of a law are those of the constants that it declares.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictInt,
    StrictStr,
    Tag,
    create_model,
)

from ..core.parameters import Constant
from ..muscle.laws import LAWS
from ..muscle.materials import MooneyRivlin
from ..units import parse, sample


def quantity(dimension: str, many: bool = False) -> BeforeValidator:
    """What reads text with a unit of a `dimension` [-], a list of it too where there may be `many`
    [-].
    """

    def read(value: Any, info: Any) -> Any:
        name = info.field_name
        if many and isinstance(value, list) and value:
            return np.array([parse(entry, dimension, name) for entry in value])
        return parse(value, dimension, name)

    return BeforeValidator(read)


def key(dimension: str, many: bool = False, needed: bool = True) -> tuple[Any, Any]:
    """A key of a section [-]: its value's kind, and what stands for it; arguments as `quantity`'s,
    and whether it is `needed` [-].
    """
    kind: Any = Annotated[Any, quantity(dimension, many)]
    return kind, Field(examples=[sample(dimension)]) if needed else None


Length = Annotated[float, quantity("length")]
Angle = Annotated[float, quantity("angle")]
Force = Annotated[float, quantity("force")]
Pressure = Annotated[float, quantity("pressure")]
InversePressure = Annotated[float, quantity("inverse_pressure")]
Number = Annotated[float, quantity("number")]

# a value that is either plain or a table: the choice is by type, so an error names one key
PLAIN, TABLE = "(plain)", "(table)"
_CHOICES = ("material", "hinge_stiffness_factor", "catalog", *LAWS)
CHOICES = tuple((key,) for key in _CHOICES)


def _plain_or_table(value: Any) -> str:
    return TABLE if isinstance(value, dict) else PLAIN


class Section(BaseModel):
    """A table of a muscle file; a key it doesn't know is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class LawSection(Section):
    """`tension = { … }` and the like: a law by name, with its own numbers."""

    law: StrictStr | None = None


def _float(reader: BeforeValidator) -> Any:
    return Annotated[float | None, reader]  # no file says `None`: it is left out


def _keys(constants: Iterable[Constant]) -> dict[str, Any]:
    return {one.name: (_float(quantity(one.dimension)), None) for one in constants}


def _reader_of(kind: str, name: str) -> BeforeValidator:
    """As `_reader`, of a constant of whichever law of that kind was chosen above it."""
    known = {
        law.name: one.dimension
        for law in LAWS[kind].values()
        for one in law.constants()
        if one.name == name
    }

    first = next(iter(LAWS[kind]))

    def read(value: Any, info: Any) -> float:
        # where the law has none of this name it is refused later, by its own name
        dimension = known.get(info.data.get("law") or first, next(iter(known.values())))
        return parse(value, dimension, info.field_name)

    return BeforeValidator(read)


def _table(kind: str, **first: Any) -> type[LawSection]:
    """The table of a kind of law: all that its laws declare."""
    keys: dict[str, Any] = {}
    for law in LAWS[kind].values():
        for one in law.constants():
            keys[one.name] = (_float(_reader_of(kind, one.name)), None)
        keys |= {one.name: (str | None, None) for one in law.switches()}
    return create_model(f"{kind.title()}Section", __base__=LawSection, **first, **keys)


def _chosen(kind: str) -> Any:
    """A law by name or, where its kind has any with numbers of their own, by a table."""
    laws = LAWS[kind].values()
    most = max(laws, key=lambda law: len(law.constants()))
    if not any(law.constants() or law.switches() for law in laws):
        return StrictStr
    table = _table(kind, law=(StrictStr, Field(examples=[f'"{most.name}"'])))
    return Annotated[
        Annotated[StrictStr, Tag(PLAIN)] | Annotated[table, Tag(TABLE)],
        Discriminator(_plain_or_table),
    ]


if TYPE_CHECKING:  # made of what the laws declare, which no type checker sees
    MaterialSection = Section
    CollapseSection = LawSection
    Tension = Buckling = PostCollapse = Ends = str | LawSection
else:
    MaterialSection = create_model(
        "MaterialSection", __base__=Section, **_keys(MooneyRivlin.constants())
    )
    CollapseSection = _table("collapse", transition_rate=(Number | None, None))
    Tension, Buckling, PostCollapse, Ends = map(
        _chosen, ("tension", "buckling", "post_collapse", "ends")
    )


class HingeSection(Section):
    """`hinge_stiffness_factor = { … }`: a factor that is affine in pressure."""

    constant: Number | None = None
    slope: InversePressure | None = None


class TuningSection(Section):
    """`[muscle.tuning]`: tables of C1 and C2 in pressure, four factors, the dead band."""

    pressure: list[Pressure] | None = None
    c1: list[Force] | None = None
    c2: list[Number] | None = None
    youngs_modulus_factor: Number | None = None
    collapse_moment_factor: Number | None = None
    hinge_stiffness_factor: (
        Annotated[
            Annotated[Number, Tag(PLAIN)] | Annotated[HingeSection, Tag(TABLE)],
            Discriminator(_plain_or_table),
        ]
        | None
    ) = None
    transition_rate: Number | None = None
    dead_band: Pressure | None = None


class MuscleSection(Section):
    """`[muscle]`, or one of several named ones."""

    length: Length = Field(examples=['"127 mm"'])
    outer_radius: Length = Field(examples=['"6.35 mm"'])
    wall_thickness: Length = Field(examples=['"1.6 mm"'])
    braid_angle: Angle = Field(examples=['"33 deg"'])
    material: (
        Annotated[
            Annotated[StrictStr, Tag(PLAIN)] | Annotated[MaterialSection, Tag(TABLE)],
            Discriminator(_plain_or_table),
        ]
        | None
    ) = None
    tension: Tension | None = None
    buckling: Buckling | None = None
    post_collapse: PostCollapse | None = None
    ends: Ends | None = None
    collapse: CollapseSection | None = None
    tuning: TuningSection | None = None


class MotorUnitSection(Section):
    """`[[bundle.motor_unit]]`: how many muscles share a pressure, and which."""

    count: StrictInt | None = None
    muscle: StrictStr | None = None


class BundleSection(Section):
    """`[bundle]`: the supply, the recruitment scheme, the motor units in their order."""

    supply_pressure: Pressure | None = None
    scheme: StrictStr | None = None
    length: Length | None = None
    motor_unit: list[MotorUnitSection] = Field(
        default_factory=list[MotorUnitSection], examples=["{ count = 1 }"]
    )


class FileSection(Section):
    """A whole file; one unnamed muscle is filed under the empty name."""

    format: StrictInt = Field(examples=["1"])
    muscle: dict[str, MuscleSection] = Field(examples=["[muscle]"])
    bundle: BundleSection | None = None
    calibration: dict[str, Any] | None = None  # where the muscle comes from: `provenance`
