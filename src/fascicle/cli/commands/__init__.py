"""The `fascicle` command and its subcommands: a module each, with options, calls and printing.

Nothing heavy is imported here: each command imports the laws when it runs, so that `--help` and the
shell's completion answer at once.
"""

from importlib import import_module
from typing import Annotated

import typer

from ..options import Command


# in the order of `fascicle --help`
_COMMANDS = (
    "force", "free-strain", "bundle", "space", "recruit", "efficiency", "simulate", "record",
    "convert", "calibrate", "explore", "export", "design", "sweep", "reproduce", "muscles", "laws",
    "init",
)  # fmt: skip

app = typer.Typer(
    name="fascicle",
    help="Model, calibrate and design fluidic artificial (McKibben) muscles and their bundles.",
    rich_markup_mode=None,  # plain help: rich would take longer to import than everything else
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _name in _COMMANDS:
    _module = import_module(f".{_name.replace('-', '_')}", __name__)
    app.command(_name, cls=getattr(_module, "COMMAND", Command))(_module.run)


def _print_version(value: bool) -> None:
    if value:
        from fascicle import __version__

        typer.echo(f"fascicle {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    _: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Version number."),
    ] = False,
) -> None:
    pass
