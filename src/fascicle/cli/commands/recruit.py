"""`fascicle recruit`: the recruitment state and pressures that give a force at a strain."""

from typing import Any

from .. import options
from ..errors import exit_incomplete, user_errors
from ..inputs import check_grid, read_bundle, read_list, read_supply
from ..options import option
from ..outputs import Outputs, count_decimals, number, print_table, print_text, status
from .bundle import unstable_caption


_LIMITS = {1: "largest", 2: "least"}  # the force that a demand of each status misses
_MAX_MESSAGES = 6  # above the table: with its first line, a summary of less than ten lines


def run(
    file: str = options.TARGET,
    force: str = option(
        "Demanded forces: one (40N), a list (20N,40N) or a range (0N:100N:10N).",
        "--force -f",
        metavar="LIST",
        default=...,
    ),
    strain: str = option(
        "Contractions: one (0.12), a list (0,0.1) or a range (0:0.2:0.05).",
        "--strain -s",
        metavar="LIST",
        default=...,
    ),
    supply: str | None = options.SUPPLY,
    scheme: str | None = options.SCHEME,
    no_resistance: bool = options.NO_RESISTANCE,
    as_json: bool = options.JSON,
    as_csv: bool = options.CSV,
    out: str | None = options.OUT,
    overwrite: bool = options.OVERWRITE,
) -> None:
    """Find the pressures that give a force at a contraction.

    Of several solutions, the one that takes the least fluid comes first; the table lists the
    others.
    """
    forces, strains = read_list(force, "force", "--force"), read_list(strain, "strain", "--strain")
    pressure = read_supply(supply)
    outputs = Outputs(as_json, as_csv, out, None, overwrite)
    bundle = read_bundle(file, pressure)
    units = len(bundle.motor_units)
    check_grid(len(forces), len(strains), units, units)
    import numpy as np

    from ...bundle import recruitment
    from ...bundle.states import resolve_scheme
    from ...results.tables import recruited

    demands = np.array(forces)
    with status(f"finding the pressures of {len(forces) * len(strains)} demands"), user_errors():
        result = recruitment.recruit(
            bundle, demands[:, None], strains, pressure, scheme, resistance=not no_resistance
        )
        variables = recruited(result, demands, np.array(strains))
    is_free = resolve_scheme(bundle, scheme).independent
    outputs.write(variables, lambda: _print(variables, is_free), title=f"Recruitment of {file}")
    unreached = variables["status"].values
    if count := int((unreached != 0).sum()):
        exit_incomplete(
            f"{count} of {unreached.size} demands can't be reached; the table has the nearest"
            " force. Change the force, the strain or the supply pressure."
        )


def _print(variables: Any, is_free: bool) -> None:
    values = {name: variable.values for name, variable in variables.items()}
    decimals = count_decimals(values["force"].ravel())
    import numpy as np

    rows, messages = [], []
    for index, code in np.ndenumerate(values["status"]):
        demand, strain = f"{values['demand'][index[0]]:.6g}", f"{values['strain'][index[1]]:.6g}"
        force, state = number(values["force"][index], decimals), values["state"][index]
        solution = values["throttled_pressure"][index], state
        alternatives = [
            f"{other_state}: {pressure / 1e3:.6g} kPa{'' if is_stable else ' u'}"
            for pressure, other_state, is_stable in zip(
                *(values[f"solution_{name}"][index] for name in ("pressure", "state", "stable")),
                strict=True,
            )
            if other_state and (pressure, other_state) != solution
        ]
        pressures = [f"{pressure / 1e3:.6g}" for pressure in values["pressures"][index]]
        mark = "" if values["stable"][index] else " u"
        rows.append(
            [demand, strain, f"{state}", *pressures, force + mark, "\n".join(alternatives) or "-"]
        )
        if code:
            limit = f"the {_LIMITS[int(code)]} force there is {force} N"
            messages.append(f"{demand} N at a strain of {strain} is out of reach: {limit}.")
    if len(rows) == 1 and not messages:
        demand, strain, state, *pressures, _, _ = rows[0]
        texts = ", ".join(f"P{unit} {text} kPa" for unit, text in enumerate(pressures, start=1))
        print_text(f"{demand} N at a strain of {strain}: recruitment state {state}, {texts}.")
    else:
        print_text(f"{len(rows) - len(messages)} of {len(rows)} demands can be reached.")
    for message in messages[:_MAX_MESSAGES]:
        print_text(message)
    if len(messages) > _MAX_MESSAGES:
        print_text(f"{len(messages) - _MAX_MESSAGES} more are out of reach, see the table.")
    if is_free:
        print_text("Of a range of solutions, the table has the one that takes the least fluid.")
    units = [f"P{unit + 1} [kPa]" for unit in range(values["pressures"].shape[-1])]
    heads = ["demand [N]", "strain [-]", "state", *units, "force [N]", "other solutions"]
    caption = unstable_caption(rows)
    if any(row[-1] != "-" for row in rows):
        note = "other solutions: recruitment state, and pressure of its throttled motor unit"
        caption = "; ".join(filter(None, [note, caption]))
    print_table("Pressures for each demand", heads, rows, caption, key_columns=2)
