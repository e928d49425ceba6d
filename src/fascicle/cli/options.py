"""Options that commands share, and the class of all commands."""

import contextlib
import functools
import inspect
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand

from ..bundle.schemes import SCHEMES, format_names
from ..core.errors import InvalidInputError
from ..files import named_muscles
from .errors import UserError


# arguments of the library, and parameters of commands that set them, where names differ by more
# than a plural
_PARAMETERS = {"supply_pressure": "supply", "states": "pressure", "names": "fit", "folder": "out"}
Text = str | None
Texts = list[str] | None


def option(
    text: str, metavar: str = "", names: str = "", default: Any = None, **settings: Any
) -> Any:
    """Typer's description of an option, the default of a command's parameter.

    `text`: its help; `metavar`: name of its value; `names`: its spellings, separated by spaces, by
    default made of the parameter's name; `default`: an ellipsis if it is required.
    """
    return typer.Option(default, *names.split(), help=text, metavar=metavar or None, **settings)


def flag(text: str, names: str) -> Any:
    """Flag, off by default; `text`: its help, `names`: its spellings, separated by spaces."""
    return option(text, "", names, False)


def argument(metavar: str, text: str, default: Any = ..., **settings: Any) -> Any:
    """Argument of a command; `text`: its help."""
    return typer.Argument(default, metavar=metavar, help=text, **settings)


def with_options(name: str, group: Callable[..., Any]) -> Callable[[Callable], Callable]:
    """Give a command the options of a `group`, a function or class whose parameters they are; the
    command gets what the group makes of them as its parameter `name`.
    """

    def decorate(command: Callable) -> Callable:
        added = inspect.signature(group).parameters
        own = {k: p for k, p in inspect.signature(command).parameters.items() if k != name}

        @functools.wraps(command)
        def run(**values: Any) -> Any:
            values[name] = group(**{key: values.pop(key) for key in added})
            return command(**values)

        parameters = [*own.values(), *added.values()]
        run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
        run.__annotations__ = {p.name: p.annotation for p in parameters}
        return run

    return decorate


def complete_target(incomplete: str) -> list[str]:
    """Named examples, measured muscles, and TOML files by path, that begin with `incomplete`."""
    folder, slash, _ = incomplete.rpartition("/")
    files: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        names = sorted(entry.name for entry in Path(f"{folder}{slash}" or ".").iterdir())
        files = [f"{folder}{slash}{name}" for name in names if name.endswith(".toml")]
    return [name for name in [*named_muscles(), *files] if name.startswith(incomplete)]


def _shared(text: str, metavar: str = "", names: str = "", **settings: Any) -> Any:
    """Description of an option in the type of parameters, which have the default."""
    return typer.Option(*names.split(), help=text, metavar=metavar or None, **settings)


_TARGET = "Muscle or bundle file, or a name from `fascicle muscles` [--measured]."
Target = Annotated[
    str, typer.Argument(metavar="FILE", help=_TARGET, autocompletion=complete_target)
]
_PRESSURES = "Gauge pressures: 34.5kPa, or 0kPa,5psi, or start:stop:step."
Pressure = Annotated[str, _shared(_PRESSURES, "LIST", "--pressure -p")]
DEFAULT_PRESSURE = "0kPa:413.7kPa:68.95kPa"
DEFAULT_STRAIN = "0:0.33:0.03"
_STATES = (
    "Gauge pressures: of a muscle a list or range, of a bundle a value or range per motor unit,"
    " 344.7kPa,0kPa:100kPa:50kPa, repeatable; default: its recruitment states at full pressure."
)
Pressures = Annotated[Texts, _shared(_STATES, "LIST", "--pressure -p")]
_STRAINS = "Contractions: 0.1, or 0,0.1, or start:stop:step"
Strain = Annotated[str, _shared(f"{_STRAINS}.", "LIST", "--strain -s")]
_RISING = f"{_STRAINS}, rising; default: up to the free strain."
RisingStrain = Annotated[Text, _shared(_RISING, "LIST", "--strain -s")]
NoResistance = Annotated[bool, _shared("No push past the free strain.", "", "--no-resistance")]
Units = Annotated[Text, _shared("Numbers of FILE's muscle in motor units: 1,4.", "LIST")]
Supply = Annotated[Text, _shared("Supply pressure; default: the bundle's.", "PRESSURE")]
_SCHEME = f"Recruitment scheme: {format_names()}; default: the bundle's."
Scheme = Annotated[Text, _shared(_SCHEME, autocompletion=lambda: list(SCHEMES))]
Seed = Annotated[int, _shared("Random seed.", min=0)]
Json = Annotated[bool, _shared("JSON in SI units on standard output.", "", "--json")]
Csv = Annotated[bool, _shared("CSV in SI units on standard output.", "", "--csv")]
Out = Annotated[Text, _shared("Result file: .nc, .csv or .json.", "PATH", "--out -o")]
_FOLDER = "Folder of results; default: named for the input, none with --json."
OutFolder = Annotated[Text, _shared(_FOLDER, "FOLDER", "--out -o")]
Plot = Annotated[Text, _shared("Figure file: .png, .svg or .pdf.", "PATH")]
Overwrite = Annotated[bool, _shared("Replacement of any existing files.", "", "--overwrite")]


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
                    raise UserError(f"{name} was given {count} times: {remedy}.")
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run the command; a user's mistake is named by its option."""
        try:
            return super().invoke(ctx)
        except UserError as error:
            if isinstance(cause := error.__cause__, InvalidInputError):
                options = {p.name: p for p in self.params if p.param_type_name == "option"}
                name = _PARAMETERS.get(cause.argument, cause.argument)
                parameter = options.get(name) or options.get(name.removesuffix("s"))
                if parameter is not None:
                    error.args = (cause.line(_longest_spelling(parameter)),)
            raise


def _longest_spelling(parameter: Any) -> str:
    return max(parameter.opts, key=len)
