"""The sections of a muscle file, format 1: their keys and the kind of value of each.

A section knows units and types only. What a muscle may be is the laws' own business: their
constructors refuse it, and `reading` adds the file's name and key to what they say. A key
that is left out stays `None` here, so a default is written in one place, the constructor.
"""

from typing import Annotated, Any

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictInt,
    StrictStr,
    Tag,
)

from ..units import parse


def _reader(dimension: str) -> BeforeValidator:
    def read(value: Any, info: Any) -> float:
        return parse(value, dimension, info.field_name)

    return BeforeValidator(read)


Length = Annotated[float, _reader("length")]
Angle = Annotated[float, _reader("angle")]
Force = Annotated[float, _reader("force")]
Pressure = Annotated[float, _reader("pressure")]
InversePressure = Annotated[float, _reader("inverse_pressure")]
Number = Annotated[float, _reader("number")]

# a value that is either plain or a table: the choice is by type, so an error names one key
PLAIN, TABLE = "(plain)", "(table)"
CHOICES = (("material",), ("tension",), ("hinge_stiffness_factor",), ("catalog",))


def _plain_or_table(value: Any) -> str:
    return TABLE if isinstance(value, dict) else PLAIN


class Section(BaseModel):
    """A table of a muscle file; a key it doesn't know is refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class MaterialSection(Section):
    """`material = { … }`: a rubber by its constants, or by its modulus alone."""

    c10: Pressure | None = None
    c01: Pressure | None = None
    youngs_modulus: Pressure | None = None
    poisson_ratio: Number | None = None


class TensionSection(Section):
    """`tension = { … }`: the law and its own numbers; which of them it has is its business."""

    law: StrictStr = Field(examples=['"tondu_lopez"'])
    strain_factor: Number | None = None
    strain_factor_rise: Number | None = None
    decay_pressure: Pressure | None = None
    force_factor: Number | None = None
    pressure_term: StrictStr | None = None


class CollapseSection(Section):
    """`[muscle.collapse]`: the law, the factor on its moment, the transition rate."""

    law: StrictStr | None = None
    factor: Number | None = None
    transition_rate: Number | None = None


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
    tension: (
        Annotated[
            Annotated[StrictStr, Tag(PLAIN)] | Annotated[TensionSection, Tag(TABLE)],
            Discriminator(_plain_or_table),
        ]
        | None
    ) = None
    buckling: StrictStr | None = None
    post_collapse: StrictStr | None = None
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
