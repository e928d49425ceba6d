"""The `fascicle` command: its subcommands, and how it ends.

A user's mistake is one line on standard error and exit code 2. Nothing heavy is imported
here: each command imports the laws when it runs, so `--help` and the shell's completion
answer at once.
"""

import contextlib
import inspect
import io
import os
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Annotated

import typer

from ..core.errors import MissingExtraError, missing_extra
from ..io.input_file import watch_inputs
from ..io.sanitize import sanitize_line
from .commands.bundle import run as bundle
from .commands.calibrate import WithNames
from .commands.calibrate import run as calibrate
from .commands.design import run as design
from .commands.efficiency import run as efficiency
from .commands.explore import run as explore
from .commands.export import run as export
from .commands.force import run as force
from .commands.free_strain import run as free_strain
from .commands.init import run as init
from .commands.muscles import run as muscles
from .commands.record import run as record
from .commands.recruit import run as recruit
from .commands.reproduce import run as reproduce
from .commands.simulate import run as simulate
from .commands.space import run as space
from .commands.sweep import run as sweep
from .interrupts import CODE, not_dropped, unheard_at_exit
from .into_file import into, misnamed, parted
from .once import Once
from .problems import UserError, as_typed, too_large, wrong_usage


_LONGEST = 600  # characters of a message
_BUG = 70  # as sysexits has it


app = typer.Typer(
    name="fascicle",
    help="Fluidic artificial muscles and their bundles, from the braid angle to the force.",
    rich_markup_mode=None,  # plain help: rich would take longer to import than all the rest
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for _name, _run in {
    "force": force,
    "free-strain": free_strain,
    "bundle": bundle,
    "space": space,
    "recruit": recruit,
    "efficiency": efficiency,
    "simulate": simulate,
    "record": record,
    "calibrate": calibrate,
    "explore": explore,
    "export": export,
    "design": design,
    "sweep": sweep,
    "reproduce": reproduce,
    "muscles": muscles,
    "init": init,
}.items():
    app.command(_name, cls=WithNames if _name == "calibrate" else Once)(_run)


def _version(wanted: bool) -> bool:
    if wanted:
        from fascicle import __version__

        typer.echo(f"fascicle {__version__}")
        raise typer.Exit
    return wanted


@app.callback()
def _app(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one command and exit.

    With 0 if it did what was asked; 1 if a claim failed, or something from outside ended it; 2 for
    a user's mistake; 3 if not all of what was asked for can be reached; 70 for a bug; 130 for
    Ctrl-C.

    **Arguments:** `arguments`: those of the command line [-]; left out, the process's own.
    """
    given = list(sys.argv[1:] if arguments is None else arguments) or ["--help"]
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # an ASCII terminal still gets its numbers
    warnings.showwarning = _warner()
    with not_dropped():
        code, message = _run(given)
        unheard_at_exit()
    if message:
        _say(f"error: {message}")
    sys.exit(code)


def _open_streams() -> None:
    """Keep a closed stream's number from the next file that is opened. What is then printed is
    lost for standard error, and for standard output an error.
    """
    ways = {"stdin": (os.O_RDONLY, "r"), "stdout": (os.O_RDONLY, "w"), "stderr": (os.O_WRONLY, "w")}
    for number, (name, (way, mode)) in enumerate(ways.items()):
        if getattr(sys, name) is None:
            handle = os.open(os.devnull, way)
            if handle != number:
                os.dup2(handle, number)
                os.close(handle)
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115 for good


def _warner() -> Callable[..., None]:
    """What says each of a command's warnings once, in one line, as its errors are said."""
    said: set[str] = set()

    def warn(message: Warning | str, *_: object, **__: object) -> None:
        if str(message) not in said:
            said.add(str(message))
            _say(f"warning: {message}")

    return warn


def _say(line: str) -> None:
    with contextlib.suppress(OSError):
        sys.stderr.write(f"{sanitize_line(' '.join(line.split()), _LONGEST)}\n")


def _run(arguments: list[str]) -> tuple[int, str]:
    """Exit code of a command [-], and what to say."""
    code, message = 0, ""
    try:
        arguments, option, path = parted(arguments)
        flags = _flags(arguments).get("overwrite", ())
        given = any(flag in arguments for flag in flags)
        flag = min(flags, key=len, default="another name")
        outputs = {option: path} if path else {}
        with watch_inputs(), into(path, option, given, flag):
            result = app(arguments, prog_name="fascicle", standalone_mode=False, obj=outputs)
        sys.stdout.flush()
        code = result if isinstance(result, int) else 0
    except UserError as error:
        code, message = error.code, as_typed(error, _options(arguments))
    except (KeyboardInterrupt, typer.Abort):
        code = CODE
    except OSError as error:  # of standard output itself
        _drop_output()
        if not isinstance(error, BrokenPipeError):  # `| head` has seen enough, and is no mistake
            code, message = 2, f"standard output: can't be written: {error.strerror or error}."
        else:
            code = 1
    except Exception as error:
        if mistyped := wrong_usage(error):
            code, message = 2, misnamed(arguments, mistyped) or mistyped
        elif memory := too_large(error):
            code, message = 2, memory
        elif missing := error if isinstance(error, MissingExtraError) else missing_extra(error):
            code, message = 2, str(missing)
        elif os.environ.get("FASCICLE_TRACEBACK", "") not in ("", "0"):
            raise
        else:
            code, message = (
                _BUG,
                (
                    f"{type(error).__name__}: {error}. That is a bug in fascicle, please report it;"
                    " with FASCICLE_TRACEBACK=1 it shows where."
                ),
            )
    return code, message


def _options(arguments: list[str]) -> dict[str, str]:
    """The option for each argument of the command that was typed [-]."""
    return {name: flags[0].split("/")[0] for name, flags in _flags(arguments).items()}


def _flags(arguments: list[str]) -> dict[str, list[str]]:
    """All spellings of the options of the command that was typed, by its argument's name [-]."""
    commands = {one.name: one.callback for one in app.registered_commands}
    run = next((commands[name] for name in arguments if name in commands), None)
    found = {}
    for name, kind in (inspect.get_annotations(run) if run else {}).items():
        for told in getattr(kind, "__metadata__", ()):
            # typer keeps the first spelling where a default would stand
            spelled = (getattr(told, "default", None), *(getattr(told, "param_decls", None) or ()))
            names = [one for one in spelled if isinstance(one, str) and one[:2] == "--"]
            if names:
                found[name] = names
    return found


def _drop_output() -> None:
    """Let the interpreter's own last flush go nowhere."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
