"""Outputs of commands: tables for readers, JSON, CSV, files, pictures, and progress."""

import contextlib
import datetime as dt
import math
import os
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..io import atomic
from ..io.sanitize import escape_invisible, sanitize_line
from . import options
from .errors import UserError, user_errors


if TYPE_CHECKING:
    from rich.console import Console

    from ..results.labelled import Variable

SOURCE = "fascicle; laws of Kim, Mazzoleni and Bryant (2021), Actuators 10, 42"
_MAX_LINE = 2000  # characters of a line with foreign text, such as file names
_MAX_NAMES = 2  # files of a kind that are named; more are counted
_MAX_WIDTH = 10**5  # characters of a table's line in a file: no limit in practice


def print_line(line: str, error: bool = False) -> None:
    """Print a line with foreign text, such as file names, to standard output or error."""
    print(sanitize_line(line, _MAX_LINE), file=sys.stderr if error else sys.stdout)


@contextlib.contextmanager
def warnings_last() -> Iterator[None]:
    """Print the warnings of a command after its output."""
    with warnings.catch_warnings(record=True) as caught:
        try:
            yield
        finally:
            with contextlib.suppress(OSError, ValueError):  # standard output may be lost
                sys.stdout.flush()
    for warning in caught:
        warnings.showwarning(warning.message, warning.category, warning.filename, warning.lineno)


def print_text(text: str, style: str = "") -> None:
    """Print a paragraph, wrapped at words on a narrow terminal."""
    from rich.text import Text

    _console().print(Text(sanitize_line(text, _MAX_LINE), style=style))


def _console() -> "Console":
    """Console of standard output, without a limit of width in a file."""
    from rich.console import Console

    console = Console(file=sys.stdout, highlight=False, markup=False)
    if not console.is_terminal and not os.environ.get("COLUMNS"):
        console.width = _MAX_WIDTH
    return console


def print_table(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    caption: str = "",
    key_columns: int = 1,
) -> None:
    """Print a table; columns that don't fit follow below, with the first `key_columns` again.

    Cells have one line or several.
    """
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    console = _console()
    labels = [escape_invisible(head) for head in heads]
    texts = [["\n".join(map(sanitize_line, cell.split("\n"))) for cell in row] for row in rows]
    keys, others = [*range(key_columns)], [*range(key_columns, len(heads))]

    def table(columns: Sequence[int], narrow: bool) -> Table:
        """Table of some columns; a narrow one has heads broken at spaces, and no padding."""
        made = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 0 if narrow else 1))
        for column in columns:
            label = labels[column].replace(" ", "\n") if narrow else labels[column]
            made.add_column(Text(label), justify="right", no_wrap=True)
        for row in texts:
            made.add_row(*(Text(row[column]) for column in columns))
        return made

    def width(columns: Sequence[int], narrow: bool) -> int:
        made, unlimited = table(columns, narrow), console.options.update(max_width=_MAX_WIDTH)
        return made.__rich_measure__(console, unlimited).maximum

    parts = [others]
    if narrow := width([*keys, *others], False) >= console.width:
        parts, room = [], 0
        for column in others:
            needed = width([column], True) - 1  # without the left edge
            if needed > room:
                parts, room = [*parts, []], console.width - width(keys, True)
            parts[-1].append(column)
            room -= needed
    for index, part in enumerate(parts):
        print_text(f"{title}{' (continued)' if index else ''}", "bold")
        console.print(table([*keys, *part], narrow))
    if caption:
        print_text(caption)


def count_decimals(values: Any) -> int:
    """Decimals that show the largest of `values` to four figures."""
    largest = max((abs(float(x)) for x in values if math.isfinite(x)), default=1.0)
    return min(max(3 - math.floor(math.log10(largest or 1.0)), 0), 9)


def kilopascals(pressure: float) -> str:
    """A pressure [Pa] in kPa."""
    return f"{pressure / 1e3:.6g}"


def number(value: float, decimals: int) -> str:
    """A value with so many decimals; "-" if it is not finite."""
    if not math.isfinite(value):
        return "-"
    return f"{round(float(value), decimals) + 0.0:.{decimals}f}"  # + 0.0: no minus before a zero


@contextlib.contextmanager
def status(text: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is being done, and for how long; gives a function that updates it."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    console = Console(stderr=True, markup=False)
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task(sanitize_line(text), total=None)
        yield lambda text: progress.update(task, description=sanitize_line(text), refresh=True)


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
def replace_output(
    option: str, path: str | Path, overwrite: bool, is_own: Callable[[Path], bool] | None = None
) -> Iterator[Path]:
    """Context of a path, not yet made, of a draft that becomes `path`; errors name `option`.

    `is_own`: for a folder, as of `open_replacement`.
    """
    prefix = f"{option} ".lstrip()
    with user_errors(prefix), atomic.open_replacement(path, overwrite, is_own) as draft:
        yield draft


def write_text(option: str, path: str | Path, overwrite: bool, text: str) -> None:
    """Write a text file, whole or not at all."""
    with replace_output(option, path, overwrite) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


def write_folder(folder: Path, overwrite: bool, fill: Callable[[Path], object]) -> list[str]:
    """Write a folder of results, once all of the files that `fill` writes are complete; returns
    their names.
    """
    with user_errors("--out "):
        return atomic.write_folder(folder, fill, overwrite)


def today() -> str:
    """Date in the local time zone, such as "2026-05-04"."""
    return f"{dt.datetime.now().astimezone():%Y-%m-%d}"


def print_written(folder: Path, names: Sequence[str], verbose: bool) -> None:
    """Print a `folder` and the `names` of the files written into it; with `verbose`, paths."""
    if verbose:
        print_line(f"wrote {', '.join(str(folder / name) for name in names)}")
        return
    kinds = Counter(Path(name).suffix for name in names)
    pages = [name for name in names if kinds[Path(name).suffix] <= _MAX_NAMES]
    groups = [f"{kinds[kind]} {kind[1:]}" for kind in kinds if kinds[kind] > _MAX_NAMES]
    print_line(f"wrote {folder}{os.sep}: {', '.join([*pages, *groups])}; --verbose prints details")


def result_folder(out: str | None, default: str, as_json: bool, overwrite: bool) -> Path | None:
    """Folder of a command's results, checked; `None` if JSON is printed and no folder is named."""
    if out is None and as_json:
        return None
    folder = Path(default if out is None else out)
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
            check_file("--plot", plot, overwrite, (".png", ".svg", ".pdf"))

    def write(
        self,
        variables: Mapping[str, "Variable"],
        table: Callable[[], None],
        figure: Callable[[], Any] | None = None,
        *,
        title: str,
        notes: str = "",
    ) -> None:
        """Write the files, then print.

        **Arguments:** `table`: prints for a reader; `figure`: returns that of --plot.
        """
        from ..results import labelled

        with status("writing the result") as update:
            if self.out is not None:
                attributes = {"notes": notes} if notes else {}
                is_own = labelled.is_zarr if Path(self.out).suffix.lower() == ".zarr" else None
                with replace_output("--out", self.out, self.overwrite, is_own) as draft:
                    labelled.write(variables, draft, title=title, source=SOURCE, **attributes)
            if self.plot is not None and figure is not None:
                from ..plot import to_bytes

                update("drawing the picture")
                with user_errors():
                    drawn = figure()
                with replace_output("--plot", self.plot, self.overwrite) as draft:
                    draft.write_bytes(to_bytes(drawn, draft.suffix.lower()[1:]))
        if self.as_json:
            print(labelled.to_json(variables))
        elif self.as_csv:
            sys.stdout.write(labelled.to_csv(variables))
        else:
            table()
            for path in filter(None, (self.out, self.plot)):
                print_line(f"wrote {path}")
