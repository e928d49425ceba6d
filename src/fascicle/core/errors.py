"""Errors: invalid input, and libraries that are not installed."""

from importlib.util import find_spec
from numbers import Number
from typing import Any


class InvalidInputError(ValueError):
    """A value that breaks a rule, for people in a line, for programs in its fields.

    - `argument`: name of the argument.
    - `rule`: broken rule, in words.
    - `value`: it, the first one of many, in the line's unit; `None` where there is none to show.
    - `remedy`: what to do, in words; empty where the rule says it.
    """

    def __init__(
        self, argument: str, rule: str, value: Any, remedy: str = "", shown: str | None = None
    ):
        """**Arguments:**

        - `argument`, `rule`, `value`, `remedy`: the fields.
        - `shown`: the value in the line, with its unit; left out, as Python writes it; empty
          where the rule has it already.
        """
        self.argument, self.rule, self.value, self.remedy = argument, rule, value, remedy
        if shown is None:
            # a number without NumPy's name around it
            text = str(value) if isinstance(value, Number) else repr(value)
            shown = "" if value is None else text
        space = "" if rule.startswith((",", ":")) else " "
        got = f", got {shown}" if shown else ""
        then = f": {remedy}" if remedy else ""
        text = f"`{argument}`{space}{rule}{got}{then}"
        super().__init__(text if text.endswith("?") else f"{text}.")
        self._shown = shown

    def __reduce__(self) -> tuple[Any, ...]:
        # a worker's refusal comes back whole
        return type(self), (self.argument, self.rule, self.value, self.remedy, self._shown)


_EXTRAS = {
    "jax": "jax", "jaxlib": "jax", "equinox": "jax", "diffrax": "jax", "matplotlib": "plot",
    "pandas": "data", "xarray": "data", "netCDF4": "data", "moocore": "design", "pymoo": "design",
    "optax": "design", "SALib": "design", "dask": "sweep", "zarr": "sweep", "panel": "explorer",
    "bokeh": "explorer", "tornado": "explorer", "casadi": "export", "mujoco": "robots",
    "gymnasium": "robots", "numpyro": "posterior",
}  # fmt: skip


class MissingExtraError(ImportError):
    """A library that isn't installed, and the command that installs it."""


def missing_extra(error: BaseException) -> MissingExtraError | None:
    """Error for an import that failed; `None` for a library of no extra.

    **Arguments:** `error`: the exception of the import.

    **Returns:** an error in one line, with the command that installs the library.
    """
    library = (getattr(error, "name", None) or "").split(".")[0]
    if not isinstance(error, ModuleNotFoundError) or library not in _EXTRAS:
        return None
    message = f"{library} is not installed: pip install 'fascicle[{_EXTRAS[library]}]'"
    return MissingExtraError(message, name=library)


def require(library: str) -> None:
    """Refuse, in one line, where a library is not installed.

    **Arguments:** `library`: what it is imported as.

    **Raises:** `MissingExtraError` with the command that installs it.
    """
    if find_spec(library) is None:
        raise missing_extra(ModuleNotFoundError(name=library)) or ImportError(library)
