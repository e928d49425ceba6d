"""Options that commands share, and the class of all commands."""

import contextlib
import functools
import inspect
import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

from ..bundle.schemes import SCHEMES, format_names
from ..core.errors import InvalidInputError
from .errors import UserError


# arguments of the library, and the parameters of commands that set them
_PARAMETERS = {
    "supply_pressure": "supply",
    "pressures": "pressure",
    "states": "pressure",
    "strains": "strain",
    "forces": "force",
    "names": "fit",
    "units": "unit",
    "columns": "column",
    "constants": "constant",
    "zeros": "zero",
    "signs": "sign",
}


def option(text: str, names: str = "", *, default: Any = None, **settings: Any) -> Any:
    """Typer's description of an option, the default of a command's parameter.

    **Arguments:**

    - `text`: its help.
    - `names`: its spellings, separated by spaces; default: made of the parameter's name.
    - `default`: shown in the help, unless it is `None`; an ellipsis if it is required.
    - `settings`: further ones of `typer.Option`.
    """
    show = default not in (None, ...)
    return typer.Option(default, *names.split(), help=text, show_default=show, **settings)


def flag(text: str, names: str) -> Any:
    """Flag, off by default; `text`: its help, `names`: its spellings, separated by spaces."""
    return typer.Option(False, *names.split(), help=text, show_default=False)


def argument(metavar: str, text: str, default: Any = ..., **settings: Any) -> Any:
    """Argument of a command; `text`: its help."""
    show = default not in (None, ...)
    return typer.Argument(default, metavar=metavar, help=text, show_default=show, **settings)


def with_options(name: str, group: Callable[..., Any]) -> Callable[[Callable], Callable]:
    """Give a command the options of a `group`, a function or class whose parameters they are; the
    command gets what the group makes of them as its parameter `name`.
    """

    def decorate(command: Callable) -> Callable:
        added = inspect.signature(group).parameters
        own = {k: p for k, p in inspect.signature(command).parameters.items() if k != name}

        @functools.wraps(command)
        def run(**values: Any) -> Any:
            made = group(**{key: values.pop(key) for key in added})
            return command(**values, **{name: made})

        parameters = [*own.values(), *added.values()]
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {p.name: p.annotation for p in parameters}
        return run

    return decorate


def complete_target(incomplete: str) -> list[str]:
    """Named examples, measured muscles, and TOML files by path, that begin with `incomplete`."""
    from ..files import named_muscles

    folder, slash, _ = incomplete.rpartition("/")
    files: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        names = sorted(entry.name for entry in Path(f"{folder}{slash}" or ".").iterdir())
        files = [f"{folder}{slash}{name}" for name in names if name.endswith(".toml")]
    return [name for name in [*named_muscles(), *files] if name.startswith(incomplete)]


_TARGET = (
    "Muscle or bundle file, a named example (see `fascicle muscles`) or a measured muscle"
    " (`fascicle muscles --measured`)."
)
TARGET = argument("FILE", _TARGET, autocompletion=complete_target)
TARGET_OR_EXAMPLE = argument("FILE", _TARGET, "kim2021_figure_6", autocompletion=complete_target)
DEFAULT_PRESSURE = "0kPa:413.7kPa:68.95kPa"
PRESSURE = option(
    "Gauge pressures: one (34.5kPa), a list (0kPa,5psi) or a range (start:stop:step).",
    "--pressure -p",
    metavar="LIST",
    default=DEFAULT_PRESSURE,
)
PRESSURES = option(
    "Gauge pressures, one value or range per motor unit: 344.7kPa,0kPa:100kPa:50kPa; repeat for"
    " more; default: the recruitment states at full pressure.",
    "--pressure -p",
    metavar="LIST",
)
STRAIN = option(
    "Contractions: one (0.1), a list (0,0.1) or a range (start:stop:step, ends included).",
    "--strain -s",
    metavar="LIST",
    default="0:0.33:0.03",
)
SPACE_STRAIN = option(
    "Contractions in rising order; default: up to the largest free strain.",
    "--strain -s",
    metavar="LIST",
)
NO_RESISTANCE = flag(
    "Without resistance: muscles don't push back past their free strain.", "--no-resistance"
)
UNITS = option(
    "Numbers of muscles of the motor units that FILE's muscle makes: 1,4.", metavar="LIST"
)
SUPPLY = option("Supply pressure; default: the bundle's.", "--supply", metavar="PRESSURE")
SCHEME = option(
    f"Recruitment scheme: {format_names()}; default: the bundle's.",
    "--scheme",
    autocompletion=lambda: list(SCHEMES),
)
SEED = option("Random seed.", "--seed", default=0, min=0)
JSON = flag("JSON in SI units on standard output.", "--json")
CSV = flag("CSV in SI units on standard output.", "--csv")
VERBOSE = flag("Tables and details on the terminal, too.", "--verbose")
OUT = option("Result file: .nc, .zarr, .csv or .json.", "--out -o", metavar="PATH")
PLOT = option("Figure file: .png, .svg or .pdf.", "--plot", metavar="PATH")
OVERWRITE = flag(
    "Replacement of existing files, including files not created by fascicle.", "--overwrite"
)


class Command(TyperCommand):
    """A command that refuses repeated options, and names options in the library's messages."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, of which click would take the last of several."""
        if not ctx.resilient_parsing:  # else the shell completes them
            _, _, order = self.make_parser(ctx).parse_args(args=list(args))
            for parameter, count in Counter[Any](order).items():
                single = parameter.param_type_name == "option" and not parameter.is_flag
                if count > 1 and single and not parameter.multiple:
                    name, remedy = _longest_spelling(parameter), "give it once"
                    if parameter.metavar == "LIST":
                        remedy = f"pass one comma-separated list: {name} VALUE,VALUE"
                    times = "twice" if count == 2 else f"{count} times"
                    raise UserError(f"{name} was given {times}: {remedy}.")
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; a user's mistake is named by its option."""
        try:
            return super().invoke(ctx)
        except UserError as error:
            error.args = (self._with_option_names(error),)
            raise

    def _with_option_names(self, error: UserError) -> str:
        """Message of an error with option names in place of Python's arguments."""
        text, cause = str(error), error.__cause__
        if not isinstance(cause, InvalidInputError):
            return text
        names = {p.name: _longest_spelling(p) for p in self.params if p.param_type_name == "option"}
        names |= {argument: names[p] for argument, p in _PARAMETERS.items() if p in names}
        if cause.argument == "supply_pressure" and cause.value is None and "supply" in names:
            return f"--supply is required: {cause.remedy}; give one, such as --supply 400kPa."
        # of a remedy in Python and in options, such as `path="isotonic" (--path isotonic)`
        text = re.sub(r"\w+=\S+ \((--[^)]+)\)", r"\1", text)
        return re.sub(r"`(\w+)`", lambda match: names.get(match[1], match[0]), text)


def _longest_spelling(parameter: Any) -> str:
    """Longest spelling of an option, the first of several."""
    return max(parameter.opts, key=len)
