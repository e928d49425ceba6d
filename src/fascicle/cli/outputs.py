"""Outputs of commands: tables for readers, JSON, CSV, files, pictures, and progress."""

import contextlib
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..io.sanitize import escape_invisible, sanitize_line
from .errors import UserError, user_errors


if TYPE_CHECKING:
    from ..results.labelled import Variable

SOURCE = "fascicle; laws of Kim, Mazzoleni and Bryant (2021), Actuators 10, 42"
_PICTURES = (".png", ".svg")
_MAX_LINE = 2000  # characters of a line that holds words of others
_FOLDERS = {"design": "designed", "calibrate": "calibrated"}  # begin of a folder's default name


def print_line(line: str, error: bool = False) -> None:
    """Print a line that holds words of others, such as file names, to standard output or error."""
    print(sanitize_line(line, _MAX_LINE), file=sys.stderr if error else sys.stdout)


def print_table(
    title: str,
    heads: Sequence[str],
    rows: Sequence[Sequence[str]],
    caption: str = "",
    keys: int = 1,
) -> None:
    """Print a table of texts, of one line or several each.

    Columns that do not fit follow below, beside the first `keys` ones again, which name a row.
    """
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    heads = [escape_invisible(head) for head in heads]
    console = Console(file=sys.stdout, highlight=False, markup=False)
    gap, widths = 3, _widths(heads, rows)
    if not console.is_terminal and not os.environ.get("COLUMNS"):  # a file has any width
        console.width = max(console.width, sum(widths) + gap * len(widths) + 2)
    if sum(widths) + gap * len(widths) > console.width - 2:  # narrow: heads of several lines
        heads, gap = [head.replace(" ", "\n") for head in heads], 1
        widths = _widths(heads, rows)
    for columns in _blocks([width + gap for width in widths], console.width - 1, keys):
        console.print(Text(sanitize_line(title, _MAX_LINE), style="bold"))
        table = Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, gap // 2, 0, gap // 2))
        for index in columns:
            table.add_column(Text(heads[index]), justify="right", no_wrap=True)
        for row in rows:
            lines = ([sanitize_line(line) for line in row[i].split("\n")] for i in columns)
            table.add_row(*(Text("\n".join(entry)) for entry in lines))
        console.print(table)
    if caption:
        console.print(Text(sanitize_line(caption, _MAX_LINE)))


def _widths(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    """The longest line of each column."""
    return [
        max(len(line) for entry in column for line in entry.split("\n"))
        for column in zip(heads, *rows, strict=True)
    ]


def _blocks(widths: Sequence[int], room: int, keys: int) -> list[list[int]]:
    """Columns in groups that fit, each with the first ones, which name the rows."""
    blocks, used = [[*range(keys)]], sum(widths[:keys])
    for index, width in enumerate(widths[keys:], start=keys):
        if used + width > room and len(blocks[-1]) > keys:
            blocks.append([*range(keys)])
            used = sum(widths[:keys])
        blocks[-1].append(index)
        used += width
    return blocks


def decimals(values: Any) -> int:
    """Decimals that show the largest of `values` to four figures."""
    largest = max((abs(float(x)) for x in values if math.isfinite(x)), default=1.0)
    return min(max(3 - math.floor(math.log10(largest or 1.0)), 0), 9)


def number(value: float, places: int) -> str:
    """Format a value with so many decimals; "-" where there is none."""
    if not math.isfinite(value):
        return "-"
    return f"{round(float(value), places) + 0.0:.{places}f}"  # + 0.0: no minus before a zero


_updates: list[Callable[[str], None]] = []  # of the line that is shown now, if any


@contextlib.contextmanager
def status(text: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is being done, and for how long; gives a function that updates it."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    if _updates:  # inside another one: one line shows both
        _updates[-1](text)
        yield _updates[-1]
        return
    from rich.console import Console
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True, markup=False), transient=True) as bar:
        task = bar.add_task(sanitize_line(text), total=None)
        _updates.append(lambda text: bar.update(task, description=sanitize_line(text)))
        try:
            yield _updates[-1]
        finally:
            _updates.pop()


def check_file(
    option: str, path: str | Path, overwrite: bool, suffixes: Sequence[str] = ()
) -> None:
    """Refuse a file that can't be written, before the work begins; `option`: that names it."""
    from ..io.atomic import check_overwrite, check_writable

    if suffixes and Path(path).suffix.lower() not in suffixes:
        raise UserError(f"{option} {str(path)!r}: its name must end in {', '.join(suffixes)}.")
    with user_errors(f"{option} ".lstrip()):
        check_writable(path)
        check_overwrite(path, overwrite)


@contextlib.contextmanager
def write_file(
    option: str, path: str | Path, overwrite: bool, folder: bool = False
) -> Iterator[Path]:
    """Give a draft to write to, and put it at `path` once it is complete."""
    from ..io.atomic import check_overwrite, replace_whole

    with user_errors(f"{option} ".lstrip()):
        check_overwrite(path, overwrite)
        with replace_whole(path, folder) as draft:
            yield draft


def write_text(option: str, path: str | Path, overwrite: bool, text: str) -> None:
    """Write a text file, whole or not at all."""
    with write_file(option, path, overwrite) as draft:
        draft.write_text(text, encoding="utf-8", newline="\n")


def check_folder(folder: str | Path, overwrite: bool) -> None:
    """Refuse a folder of results that can't be written, before the work begins."""
    from ..io import atomic

    with user_errors("--out "):
        atomic.check_folder(folder, overwrite)


def write_folder(folder: Path, overwrite: bool, fill: Callable[[Path], object]) -> None:
    """Write a folder of results, once all of the files that `fill` writes are complete."""
    from ..io import atomic

    with user_errors("--out "):
        atomic.write_folder(folder, fill, overwrite)


def result_folder(
    command: str, out: str | None, source: str, as_json: bool, overwrite: bool
) -> Path | None:
    """Folder of a command's results, named after its `source`; `None` where none is written."""
    if out is None and as_json:
        return None
    folder = Path(f"{_FOLDERS[command]}-{Path(source).stem}" if out is None else out)
    check_folder(folder, overwrite)
    return folder


class Outputs:
    """Outputs of a command; refuses what can't be written before the work begins."""

    def __init__(
        self, as_json: bool, as_csv: bool, out: str | None, plot: str | None, overwrite: bool
    ):
        """**Arguments:** values of the options --json, --csv, --out, --plot and --overwrite."""
        if as_json and as_csv:
            raise UserError("--json and --csv: only one can be printed, drop one.")
        self.as_json, self.as_csv, self.out, self.plot = as_json, as_csv, out, plot
        self.overwrite = overwrite
        if out is not None:
            from ..io.atomic import check_overwrite
            from ..results.labelled import check_result_path

            with user_errors("--out "):
                check_result_path(out)
                check_overwrite(out, overwrite)
        if plot is not None:
            check_file("--plot", plot, overwrite, _PICTURES)

    def write(
        self,
        variables: Mapping[str, "Variable"],
        table: Callable[[], None],
        draw: Callable[[], Any] | None = None,
        *,
        title: str,
        notes: str = "",
    ) -> None:
        """Write the files, then print; `table` does so for a reader, `draw` makes the figure."""
        from ..results import labelled

        with status("writing the result") as update:
            if self.out is not None:
                about = {"notes": notes} if notes else {}
                is_folder = Path(self.out).suffix.lower() == ".zarr"
                with write_file("--out", self.out, self.overwrite, is_folder) as draft:
                    labelled.write(variables, draft, title=title, source=SOURCE, **about)
            if self.plot is not None and draw is not None:
                from ..plot import to_bytes

                update("drawing the picture")
                with user_errors():
                    picture = draw()
                with write_file("--plot", self.plot, self.overwrite) as draft:
                    draft.write_bytes(to_bytes(picture, draft.suffix.lower()[1:]))
        if self.as_json:
            print(labelled.to_json(variables))
        elif self.as_csv:
            sys.stdout.write(labelled.to_csv(variables))
        else:
            table()
            for path in (self.out, self.plot):
                if path is not None:
                    print_line(f"wrote {path}")
