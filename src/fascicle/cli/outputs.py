"""What a command gives: a readable table, or JSON or CSV; and files beside it."""

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..io.sanitize import sanitize_line
from .problems import UserError, refusing
from .telling import telling


if TYPE_CHECKING:
    from ..results.labelled import Variable

_PICTURES = (".png", ".svg")
_LONGEST = 2000  # characters of a line
_MADE = {"design": "designed", "calibrate": "calibrated"}  # names of folders begin with


class Outputs:
    """Where a command's result goes; refuses what can't be written before the work begins."""

    def __init__(
        self,
        as_json: bool,
        as_csv: bool,
        out: str | None,
        plot: str | None,
        overwrite: bool,
        flag: str = "--force",
    ):
        """**Arguments:**

        - `as_json`: print JSON [-].
        - `as_csv`: print CSV [-].
        - `out`: where the result is written [-], or `None`.
        - `plot`: where its picture is drawn [-], or `None`.
        - `overwrite`: whether whatever stands there is replaced [-].
        - `flag`: the option that says so [-].
        """
        if as_json and as_csv:
            raise UserError("--json and --csv: both can't be printed, take one.")
        self.as_json, self.as_csv, self.out, self.plot = as_json, as_csv, out, plot
        self.overwrite, self.flag = overwrite, flag
        if out is not None:
            from ..files.ours import check_file
            from ..results.labelled import check_result_path

            with refusing("--out "):
                check_result_path(out)
                check_file(out, overwrite, flag)
        if plot is not None:
            from ..files.ours import check_file
            from ..io.atomic import check_writable

            if Path(plot).suffix.lower() not in _PICTURES:
                raise UserError(f"--plot {plot!r}: its name must end in {', '.join(_PICTURES)}.")
            with refusing("--plot "):
                check_writable(plot)
                check_file(plot, overwrite, flag)

    def give(
        self,
        variables: Mapping[str, "Variable"],
        table: Callable[[], None],
        draw: Callable[[], Any] | None = None,
        *,
        json_variables: Mapping[str, "Variable"] | None = None,
        title: str,
        notes: str = "",
    ) -> None:
        """Write the files, then print.

        **Arguments:**

        - `variables`: the result [-].
        - `table`: prints it for a reader [-].
        - `draw`: makes its figure [-].
        - `json_variables`: what JSON shows, if not just that [-].
        - `title`: what it is [-].
        - `notes`: on what it isn't [-].
        """
        about = {"notes": notes} if notes else {}
        from ..files.ours import replacing
        from ..results import labelled as results

        with refusing(), telling("writing the result") as tell:
            if self.out is not None:
                folder = Path(self.out).suffix.lower() == ".zarr"
                with replacing(self.out, self.overwrite, self.flag, folder) as draft:
                    results.write(variables, draft, title=title, source=SOURCE, **about)
            if self.plot is not None and draw is not None:
                from ..plot import to_bytes

                tell("drawing the picture")
                picture = draw()
                with replacing(self.plot, self.overwrite, self.flag) as draft:
                    draft.write_bytes(to_bytes(picture, draft.suffix.lower()[1:]))
        if self.as_json:
            print(results.to_json(json_variables or variables))
        elif self.as_csv:
            sys.stdout.write(results.to_csv(variables))
        else:
            table()
            for path in (self.out, self.plot):
                if path is not None:
                    say(f"wrote {path}")


def folder_for(
    command: str, out: str | None, path: str, as_json: bool, overwrite: bool
) -> Path | None:
    """Where the files of a command go.

    **Arguments:**

    - `command`: "design" or "calibrate" [-].
    - `out`: the folder that was asked for [-], or `None`.
    - `path`: of what the command reads first [-].
    - `as_json`: whether JSON is printed [-].
    - `overwrite`: whether others' files may be replaced [-].

    **Returns:** the folder [-], checked; `None` where nothing is written.
    """
    from ..files.ours import check_folder

    if out is None and as_json:
        return None
    folder = Path(f"{_MADE[command]}-{Path(path).stem}" if out is None else out)
    with refusing("--out "):
        check_folder(folder, command, overwrite)
    return folder


def say(line: str, error: bool = False) -> None:
    """Print a `line` [-] that holds words of others: names of files, notes; `error`: whether to
    standard error [-].
    """
    print(sanitize_line(line, _LONGEST), file=sys.stderr if error else sys.stdout)


SOURCE = "fascicle; laws of Kim, Mazzoleni and Bryant (2021), Actuators 10, 42"
