"""The tables of a scenario that is controlled: `[control]`, and `[[demand]]` or `[sine]`."""

from typing import Annotated, Any

from pydantic import BeforeValidator, Field, StrictBool, create_model

from ..units import parse, sample
from .schema import Section


_OPTIONS = {
    "band": "force", "sample_time": "time", "delay": "time", "highest_pressure": "pressure",
    "flow_limit": "number", "co_contraction": "force", "integral_time": "time",
    "force_gain": "number", "force_integral_time": "time", "pressure_time": "time",
}  # fmt: skip


def _quantity(dimension: str) -> BeforeValidator:
    return BeforeValidator(lambda value, info: parse(value, dimension, info.field_name))


def _key(dimension: str, needed: bool = False) -> tuple[Any, Any]:
    kind: Any = Annotated[float | None, _quantity(dimension)]
    return kind, Field(examples=[sample(dimension)]) if needed else None


def control_keys(turns: bool) -> dict[str, Any]:
    """Keys of a controlled scenario's file [-], of a load that `turns` or not."""
    keys: dict[str, Any] = {name: _key(dimension) for name, dimension in _OPTIONS.items()}
    keys["position_gain"] = _key("angular_stiffness" if turns else "stiffness")
    keys["velocity_gain"] = _key("angular_damping" if turns else "damping")
    named: Any = (str, Field(examples=['"hand_over"']))
    control: Any = create_model(
        "ControlSection", __base__=Section, policy=named,
        compensate=(StrictBool | None, None), **keys,
    )  # fmt: skip
    where = "angle" if turns else "length"
    force = "moment" if turns else "force"
    demand: Any = create_model(
        "DemandSection", __base__=Section, time=_key("time", True), force=_key(force),
        position=_key(where),
    )  # fmt: skip
    sine: Any = create_model(
        "SineSection", __base__=Section, mean=_key(where, True), amplitude=_key(where, True),
        frequency=_key("frequency", True),
    )  # fmt: skip
    return {
        "control": (control, Field(examples=["[control]"])),
        "demand": (list[demand] | None, None),
        "sine": (sine | None, None),
    }
