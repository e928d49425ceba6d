"""Where a muscle comes from, as the `[calibration]` of its file.

What stands there is a report for readers and programs, not part of the muscle: loading passes
over it. It may hold anything that TOML can, one table deep; tomlkit spells it.
"""

from collections.abc import Mapping
from typing import Any

from ..core.errors import InvalidInputError


_TABLE = "calibration"


def calibration_text(calibration: Mapping[str, Any]) -> str:
    """The text of a `[calibration]` that reads back to the same values.

    **Arguments:** `calibration`: text, numbers, booleans and lists of them by key, and one
    level of tables or lists of tables [-].

    **Returns:** the TOML [-], its tables last.

    **Raises:** `ValueError` for what TOML has no value for, and for deeper tables.
    """
    import tomlkit  # takes as long as all else that a file needs

    return tomlkit.dumps({_TABLE: {key: _entry(value, key) for key, value in calibration.items()}})


def _entry(value: Any, key: str) -> Any:
    if isinstance(value, Mapping):
        return {name: _plain(one, name) for name, one in value.items()}
    entries = value if isinstance(value, list | tuple) else ()
    if entries and all(isinstance(one, Mapping) for one in entries):
        return [_entry(one, key) for one in entries]
    return _plain(value, key)


def _plain(value: Any, key: str) -> Any:
    if hasattr(value, "tolist"):  # NumPy's and JAX's scalars and arrays
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(one, key) for one in value]
    if isinstance(value, bool | str | int | float):
        return value
    raise InvalidInputError(
        _TABLE,
        "takes text, numbers, booleans, lists and one level of tables",
        (type(value).__name__, key),
        shown=f"a {type(value).__name__} for {key!r}",
    )
