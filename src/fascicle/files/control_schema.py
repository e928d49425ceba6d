"""The tables of a scenario that is controlled: `[control]`, and `[[demand]]` or `[sine]`."""

from functools import partial
from typing import Any

from pydantic import Field, StrictBool, create_model

from .schema import Section, key


_OPTIONS = {
    "band": "force", "sample_time": "time", "delay": "time", "highest_pressure": "pressure",
    "flow_limit": "number", "co_contraction": "force", "integral_time": "time",
    "force_gain": "number", "force_integral_time": "time", "pressure_time": "time",
}  # fmt: skip


def control_keys(turns: bool) -> dict[str, Any]:
    """Keys of a controlled scenario's file [-], of a load that `turns` or not."""
    may = partial(key, needed=False)
    keys: dict[str, Any] = {name: may(dimension) for name, dimension in _OPTIONS.items()}
    keys["position_gain"] = may("angular_stiffness" if turns else "stiffness")
    keys["velocity_gain"] = may("angular_damping" if turns else "damping")
    named: Any = (str, Field(examples=['"hand_over"']))
    control: Any = create_model(
        "ControlSection", __base__=Section, policy=named,
        compensate=(StrictBool | None, None), **keys,
    )  # fmt: skip
    where = "angle" if turns else "length"
    force = "moment" if turns else "force"
    demand: Any = create_model(
        "DemandSection", __base__=Section, time=key("time"), force=may(force),
        position=may(where),
    )  # fmt: skip
    sine: Any = create_model(
        "SineSection", __base__=Section, mean=key(where), amplitude=key(where),
        frequency=key("frequency"),
    )  # fmt: skip
    return {
        "control": (control, Field(examples=["[control]"])),
        "demand": (list[demand] | None, None),
        "sine": (sine | None, None),
    }
