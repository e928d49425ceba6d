"""Files and standard output of commands; what can't be written is refused before the work."""

import contextlib
import datetime as dt
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import fascicle as fs

from .. import results
from ..io import atomic
from . import options
from .errors import UserError, user_errors
from .terminal import print_line, status


PICTURES = (".png", ".svg", ".pdf")
SOURCE = "fascicle; laws of Kim, Mazzoleni and Bryant (2021), Actuators 10, 42"


def check_file(
    option: str, path: str | Path, overwrite: bool, suffixes: Sequence[str] = ()
) -> None:
    """Refuse a file that can't be written, before the work begins; `option`: its option's name."""
    if suffixes and Path(path).suffix.lower() not in suffixes:
        raise UserError(f"{option} {str(path)!r}: its name must end in {', '.join(suffixes)}.")
    with user_errors(f"{option} ".lstrip()):
        atomic.check_writable(path)
        atomic.check_overwrite(path, overwrite)


@contextlib.contextmanager
def replace_output(option: str, path: str | Path, overwrite: bool) -> Iterator[Path]:
    """As `open_replacement`, with errors that name the `option`."""
    prefix = f"{option} ".lstrip()
    with user_errors(prefix), atomic.open_replacement(path, overwrite) as draft:
        yield draft


def write_text(option: str, path: str | Path, overwrite: bool, text: str) -> None:
    """Write a text file, whole or not at all."""
    with replace_output(option, path, overwrite) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


@contextlib.contextmanager
def print_if_lost(show: Callable[[], None]) -> Iterator[None]:
    """Context that writes a result; `show` prints it if that fails, so that no work is lost."""
    try:
        yield
    except UserError:
        show()
        raise


def write_picture(option: str, path: str | Path, overwrite: bool, figure: Any) -> None:
    """Write a `figure`, whole or not at all, as the file's suffix says."""
    with replace_output(option, path, overwrite) as draft:
        draft.write_bytes(fs.plot.to_bytes(figure, draft.suffix.lower()[1:]))


def today() -> str:
    """Date in the local time zone, such as "2026-05-04"."""
    return f"{dt.datetime.now().astimezone():%Y-%m-%d}"


def result_folder(out: str | None, default: str, as_json: bool, overwrite: bool) -> Path | None:
    """Folder of a command's results, checked; `None` if JSON is printed and no folder is named."""
    if out is None and as_json:
        return None
    folder = Path(default if out is None else out)
    if folder.suffix.lower() in (".json", ".csv", ".nc"):
        raise UserError(f"--out {out!r}: names a folder of several files; --json prints one.")
    with user_errors("--out "):
        atomic.check_folder(folder, overwrite)
    return folder


class Outputs:
    """Outputs of a command; refuses what can't be written before the work begins."""

    def __init__(
        self,
        as_json: options.Json = False,
        as_csv: options.Csv = False,
        out: options.Out = None,
        plot: options.Plot = None,
        overwrite: options.Overwrite = False,
    ):
        if as_json and as_csv:
            raise UserError("--json and --csv: only one can be printed, drop one.")
        self.as_json, self.as_csv, self.out, self.plot = as_json, as_csv, out, plot
        self.overwrite = overwrite
        if out is not None:
            from ..results.labelled import check_result_path

            with user_errors("--out "):
                check_result_path(out)
                atomic.check_overwrite(out, overwrite)
        if plot is not None:
            check_file("--plot", plot, overwrite, PICTURES)

    def write(
        self,
        variables: "Mapping[str, results.Variable]",
        table: Callable[[], None],
        figure: Callable[[], Any] | None = None,
        *,
        title: str,
        notes: str = "",
        findings: Sequence[Mapping[str, Any]] | None = None,
    ) -> None:
        """Write the files, then print; `table` prints for a reader, `figure` returns --plot's;
        `findings` stand in JSON, printed or written.
        """
        from ..results import labelled

        def show() -> None:
            if self.as_json:
                print(labelled.to_json(variables, findings))
            elif self.as_csv:
                sys.stdout.write(labelled.to_csv(variables))
            else:
                table()

        with print_if_lost(show), status("writing the result") as update:
            if self.out is not None:
                attributes = {"notes": notes} if notes else {}
                with replace_output("--out", self.out, self.overwrite) as draft:
                    labelled.write(
                        variables, draft, findings, title=title, source=SOURCE, **attributes
                    )
            if self.plot is not None and figure is not None:
                update("drawing the picture")
                with user_errors():
                    drawn = figure()
                write_picture("--plot", self.plot, self.overwrite, drawn)
        show()
        if not (self.as_json or self.as_csv):
            for path in filter(None, (self.out, self.plot)):
                print_line(f"wrote {path}")
