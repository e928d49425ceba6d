"""`fascicle muscles`: the named examples and the measured muscles."""

import json
import sys

from .. import options
from ..errors import UserError, user_errors
from ..inputs import load_laws
from ..options import argument, complete_target, flag
from ..outputs import number, print_table


_HEADS = ("name", "length [mm]", "outer diameter [mm]", "pressure [kPa]", "contraction [%]",
          "error [N]", "error [%]", "basis", "license")  # fmt: skip
_CAPTION = (
    "pressure, contraction: largest measured values; error: root mean square, in N and in % of the"
    " largest force; basis: whose fit it is, published or of `fascicle calibrate` (fit); -: not"
    " published. Every command takes a muscle by its name; `fascicle muscles NAME` prints it with"
    " its source."
)


def run(
    name: str | None = argument(
        "NAME", "Example or measured muscle to print.", None, autocompletion=complete_target
    ),
    measured: bool = flag("Measured muscles, with ranges and errors of their fits.", "--measured"),
    as_json: bool = options.JSON,
) -> None:
    """List example or measured muscles, or print the file of one."""
    from ...files import example_text, examples

    if name is not None:
        if measured:
            raise UserError("NAME and --measured: a name prints one muscle, drop one of them.")
        with user_errors():
            text = example_text(name)
        sys.stdout.write(json.dumps({"name": name, "toml": text}) + "\n" if as_json else text)
    elif measured:
        _print_measured(as_json)
    elif as_json:
        print(json.dumps(examples()))
    else:
        for example, description in examples().items():
            print(f"{example:24}{description}")


def _print_measured(as_json: bool) -> None:
    load_laws()
    from ...files import catalog

    entries = list(catalog.values())
    if as_json:
        print(json.dumps({entry.name: entry.as_dict() for entry in entries}))
        return
    rows = []
    for entry in entries:
        pressure, strain = (ends and ends[1] for ends in entry.range)
        numbers = (
            (float(entry.muscle.length), 1e3, 1), (2 * float(entry.muscle.outer_radius), 1e3, 1),
            (pressure, 1e-3, 0), (strain, 100, 1),
            (entry.error.rmse, 1, 2), (entry.error.relative_rmse, 100, 2),
        )  # fmt: skip
        cells = ["-" if x is None else number(factor * x, digits) for x, factor, digits in numbers]
        rows.append([entry.name, *cells, entry.basis, entry.license.partition(";")[0]])
    print_table("Measured muscles", _HEADS, rows, _CAPTION)
