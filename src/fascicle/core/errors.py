"""Errors: invalid input, and libraries that are not installed."""

from importlib.util import find_spec
from numbers import Number


class InvalidInputError(ValueError):
    """A value that breaks a rule: one line for people, fields for programs.

    - `argument`: name of the argument; `rule`: broken rule, in words.
    - `value`: the value, the first bad one of an array, in the line's unit; or `None`.
    - `remedy`: what to do, in words; empty where the rule says it.
    """

    def __init__(
        self, argument: str, rule: str, value: object, remedy: str = "", shown: str | None = None
    ):
        """`shown`: text of the value with its unit; default: as Python writes it; empty: none."""
        self.argument, self.rule, self.value, self.remedy = argument, rule, value, remedy
        if (value_text := shown) is None and value is not None:
            # a number without NumPy's name around it
            value_text = str(value) if isinstance(value, Number) else repr(value)
        self._value_text = value_text or ""
        super().__init__(self.line(f"`{argument}`"))

    def line(self, subject: str) -> str:
        """The line for people, about a `subject` in place of the argument: a label on a page."""
        space = "" if self.rule.startswith((",", ":")) else " "
        line = f"{subject}{space}{self.rule}"
        line += f", got {self._value_text}" if self._value_text else ""
        line += f": {self.remedy}" if self.remedy else ""
        return line if line.endswith("?") else f"{line}."

    def __reduce__(self) -> tuple:
        # the error of a worker process arrives with its fields
        return type(self), (self.argument, self.rule, self.value, self.remedy, self._value_text)


_EXTRAS = {
    "jax": "jax", "jaxlib": "jax", "equinox": "jax", "diffrax": "jax", "matplotlib": "plot",
    "pandas": "data", "xarray": "data", "netCDF4": "data", "openpyxl": "data",
    "nptdms": "tdms", "moocore": "design", "pymoo": "design",
    "dask": "sweep", "zarr": "sweep", "panel": "explorer",
    "bokeh": "explorer", "tornado": "explorer", "mujoco": "robots",
    "gymnasium": "robots", "numpyro": "posterior",
}  # fmt: skip


class MissingExtraError(ImportError):
    """A library that isn't installed, and the command that installs it."""


def missing_extra(error: BaseException) -> MissingExtraError | None:
    """`MissingExtraError` for a failed import; `None` for a library that is in no extra."""
    library = (getattr(error, "name", None) or "").split(".")[0]
    if not isinstance(error, ModuleNotFoundError) or library not in _EXTRAS:
        return None
    message = f"{library} is not installed: pip install 'fascicle[{_EXTRAS[library]}]'"
    return MissingExtraError(message, name=library)


def require(library: str) -> None:
    """Raise `MissingExtraError` where a `library`, by its import name, is not installed."""
    if find_spec(library) is None:
        raise missing_extra(ModuleNotFoundError(name=library)) or ImportError(library)
