"""Commands of a bundle: `bundle`, `space`, `recruit` and `efficiency`."""

import math
from typing import Any

from . import options
from .errors import UserError, exit_incomplete, user_errors
from .inputs import (
    check_grid,
    read_bundle,
    read_list,
    read_quantity,
    read_rising_strains,
    read_states,
    read_supply,
)
from .options import option, with_options
from .outputs import Outputs, count_decimals, number, print_table, print_text, status


_ROWS = 12  # strains of the workspace that are printed, about: as many as fit on a screen
_LIMITS = {1: "largest", 2: "least"}  # the force that a demand of each status misses
_MAX_MESSAGES = 6  # above the table: with its first line, a summary of less than ten lines
_PATHS = ("isobaric", "isotonic")


@with_options("outputs", Outputs)
def bundle(
    outputs: Outputs,
    file: str = options.TARGET,
    units: str | None = options.UNITS,
    pressure: list[str] | None = options.PRESSURES,
    strain: str = options.STRAIN,
    no_resistance: bool = options.NO_RESISTANCE,
) -> None:
    """Compute a bundle's force and equilibria over contraction.

    An equilibrium is a strain at which the bundle without load can rest.
    """
    strains = read_list(strain, "strain", "--strain")
    target = read_bundle(file, units=units)
    states = read_states(pressure, target)
    unit_count = len(states[0])
    check_grid(len(states), unit_count, max(unit_count, len(strains)))
    from ..results.tables import bundle_equilibria, bundle_force

    resistance = not no_resistance
    with status("computing equilibria and forces"), user_errors():
        forces = bundle_force(target, states, strains, resistance)
        variables = {**forces, **bundle_equilibria(target, states, resistance)}

    def figure() -> Any:
        from ..plot.curves import bundle_force_strain, smooth

        pressures = states[0] if len(states) == 1 else states
        return bundle_force_strain(target, pressures, smooth(strains), resistance)

    outputs.write(variables, lambda: _print_forces(variables), figure, title=f"Bundle {file}")
    check_equilibria(variables)


def check_equilibria(variables: Any) -> None:
    """End a command with states that have no strain of zero force; `variables`: its result."""
    free = variables["free_strain"].values.tolist()
    missing = [f"{row}" for row, strain in enumerate(free, start=1) if math.isnan(strain)]
    if missing:
        exit_incomplete(
            f"no strain of zero force in state {', '.join(missing)}: the bundle pulls at every"
            " strain; lower its pressures."
        )


def print_states(variables: Any) -> None:
    """Print pressures, free strain and equilibria of states; `variables`: `bundle_equilibria`."""
    names = ("pressures", "free_strain", "equilibria", "stable")
    columns, rows = [variables[name].values.tolist() for name in names], []
    finite = [strain for strain in columns[1] if math.isfinite(strain)]
    if finite:
        limits = sorted({number(strain, 4) for strain in (min(finite), max(finite))})
        count = len(columns[1])
        states = "the state" if count == 1 else f"{count} states"
        print_text(f"Free strain of {states}: {' to '.join(limits)}.")
    for pressures, free, *equilibria in zip(*columns, strict=True):
        strains = [
            number(strain, 4) + ("" if is_stable else " u")
            for strain, is_stable in zip(*equilibria, strict=True)
            if math.isfinite(strain)  # a row with fewer equilibria is filled with NaN
        ]
        kilopascals = [f"{pressure / 1e3:.6g}" for pressure in pressures]
        rows.append([f"{len(rows) + 1}", *kilopascals, number(free, 4), ", ".join(strains)])
    heads = ["state", *_unit_heads(variables), "free strain [-]", "equilibria [-]"]
    has_unstable = not all(map(all, columns[3]))
    caption = _unstable_caption(has_unstable)
    print_table("Free strain and equilibria without load", heads, rows, caption)


def _unit_heads(variables: Any) -> list[str]:
    return [f"P{unit + 1} [kPa]" for unit in range(variables["pressures"].values.shape[-1])]


def _unstable_caption(is_marked: bool) -> str:
    """Caption that explains the mark "u", if the table has one."""
    text = "u: unstable, the force rises with strain there and the bundle leaves it"
    return text if is_marked else ""


def _print_forces(variables: Any) -> None:
    """Print the free strains, and a table of force over strain by recruitment state."""
    print_states(variables)
    force = variables["force"].values
    decimals = count_decimals(force.ravel())
    rows = [
        [f"{strain:.6g}", *(number(value, decimals) for value in values)]
        for strain, values in zip(variables["strain"].values, force.T, strict=True)
    ]
    heads = ["strain [-]", *(f"state {state + 1} [N]" for state in range(len(force)))]
    print_table("Force by strain", heads, rows)


@with_options("outputs", Outputs)
def space(
    outputs: Outputs,
    file: str = options.TARGET,
    units: str | None = options.UNITS,
    supply: str | None = options.SUPPLY,
    levels: str | None = option(
        "Pressures of the throttled motor unit; default: seven from zero to the supply pressure.",
        metavar="LIST",
    ),
    strain: str | None = options.SPACE_STRAIN,
    scheme: str | None = options.SCHEME,
    no_resistance: bool = options.NO_RESISTANCE,
) -> None:
    """Compute the workspaces of recruitment states.

    A state's workspace is the range of forces that it reaches at each contraction; those of two
    states may overlap.
    """
    pressure, strains = read_supply(supply), read_rising_strains(strain)
    throttled = None if levels is None else read_list(levels, "pressure", "--levels")
    target = read_bundle(file, pressure, units)
    unit_count = len(target.motor_units)
    check_grid(max(unit_count, len(throttled or ())), unit_count, len(strains or range(201)))
    from ..bundle import recruitment
    from ..results import tables

    with status("computing the workspace of each state"), user_errors():
        workspace = recruitment.workspace(
            target, pressure, throttled or 7, strains, resistance=not no_resistance, scheme=scheme
        )
        variables = tables.space(workspace)

    def figure() -> Any:
        from ..plot.workspace import workspace as draw

        return draw(workspace, recruitment.overlap(workspace))

    outputs.write(
        variables, lambda: _print_space(variables, unit_count), figure, title=f"Space of {file}"
    )


def _print_space(variables: Any, units: int) -> None:
    values = {name: variable.values for name, variable in variables.items()}
    strains, high, low = values["strain"], values["high"], values["low"]
    decimals = count_decimals(high.ravel())
    print_text(
        f"{units} motor unit{'s' * (units > 1)}, {values['scheme']} recruitment, supply pressure"
        f" {values['supply_pressure'] / 1e3:.6g} kPa: forces up to {number(high.max(), decimals)} N"
        f" at a strain of {strains[high.max(axis=0).argmax()]:.4g}."
    )
    rows = []
    names = ("overlap_states", "overlap_area", "overlap_low", "overlap_high")
    for states, area, bottom, top in zip(*(values[name] for name in names), strict=True):
        widths = (top - bottom).tolist()
        width = max((width for width in widths if width > 0), default=None)  # NaN: no overlap
        widest = ["-", "-"]
        if width is not None:
            widest = [f"{width:.4g}", f"{strains[widths.index(width)]:.4g}"]
        rows.append([f"{states[0]} and {states[1]}", f"{area:.4g}", *widest])
    if rows:
        print_text(
            "Where states overlap, each of them reaches the force; the one with fewer motor units"
            " takes less fluid."
        )
        heads = ["states", "overlap area [N]", "largest width [N]", "at strain [-]"]
        print_table("Overlap of states", heads, rows)
    elif units > 1:
        print_text("One state reaches the whole workspace: there is no overlap.")
    rows = [
        [
            f"{strains[j]:.4g}",
            *(
                f"{number(bottom[j], decimals)} to {number(top[j], decimals)}"
                for bottom, top in zip(low, high, strict=True)
            ),
        ]
        for j in range(0, len(strains), max(1, round(len(strains) / _ROWS)))
    ]
    heads = ["strain [-]", *(f"state {state + 1} [N]" for state in range(len(high)))]
    print_table("Range of force of each state", heads, rows)


def recruit(
    file: str = options.TARGET,
    units: str | None = options.UNITS,
    force: str | None = option(
        "Demanded forces: one (40N), a list (20N,40N) or a range (0N:100N:10N).",
        "--force -f",
        metavar="LIST",
    ),
    strain: str = option(
        "Contractions: one (0.12), a list (0,0.1) or a range (0:0.2:0.05); of a joint, that of"
        " both sides at the angle 0.",
        "--strain -s",
        metavar="LIST",
        default=...,
    ),
    torque: str | None = option(
        "Demanded torques of a joint that two of these pull in opposite directions (5N*m).",
        metavar="LIST",
    ),
    stiffness: str | None = option("Demanded stiffness of the joint (60N*m/rad).", metavar="VALUE"),
    angle: str | None = option("Angle of the joint (10deg).", metavar="VALUE"),
    moment_arm: str | None = option("Moment arm of the joint (50mm).", metavar="VALUE"),
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
    others. With --torque, --stiffness, --angle and --moment-arm: the pressures of a joint.
    """
    if force is None:
        joint = {
            "--torque": torque,
            "--stiffness": stiffness,
            "--angle": angle,
            "--moment-arm": moment_arm,
        }
        if missing := [name for name, value in joint.items() if value is None]:
            raise UserError(f"recruit needs --force, or of a joint {', '.join(missing)}, too.")
        outputs = Outputs(as_json, as_csv, out, None, overwrite)
        _recruit_joint(file, units, joint, strain, supply, outputs)
        return
    forces, strains = read_list(force, "force", "--force"), read_list(strain, "strain", "--strain")
    pressure = read_supply(supply)
    outputs = Outputs(as_json, as_csv, out, None, overwrite)
    target = read_bundle(file, pressure, units)
    unit_count = len(target.motor_units)
    check_grid(len(forces), len(strains), unit_count, unit_count)
    import numpy as np

    from ..bundle import recruitment
    from ..bundle.states import resolve_scheme
    from ..results.tables import recruited

    demands = np.array(forces)
    with status(f"finding the pressures of {len(forces) * len(strains)} demands"), user_errors():
        result = recruitment.recruit(
            target, demands[:, None], strains, pressure, scheme, resistance=not no_resistance
        )
        variables = recruited(result, demands, np.array(strains))
    is_free = resolve_scheme(target, scheme).independent
    title = f"Recruitment of {file}"
    outputs.write(variables, lambda: _print_pressures(variables, is_free), title=title)
    unreached = variables["status"].values
    if count := int((unreached != 0).sum()):
        exit_incomplete(
            f"{count} of {unreached.size} demands can't be reached; the table has the nearest"
            " force. Change the force, the strain or the supply pressure."
        )


def _recruit_joint(
    file: str,
    units: str | None,
    joint: dict[str, Any],
    strain: str,
    supply: str | None,
    outputs: Outputs,
) -> None:
    """Find the pressures of a `joint`'s options, with a file's muscle or bundle on both sides."""
    torques = read_list(joint["--torque"], "moment", "--torque")
    stiffness = read_quantity(joint["--stiffness"], "angular_stiffness", "--stiffness")
    angle = read_quantity(joint["--angle"], "angle", "--angle")
    arm = read_quantity(joint["--moment-arm"], "length", "--moment-arm")
    contraction = read_quantity(strain, "strain", "--strain")
    pressure = read_supply(supply)
    target = read_bundle(file, pressure, units)
    if pressure is not None:
        target = target.replace(supply_pressure=pressure)
    from ..control import Joint
    from ..results.tables import joint_pressures

    with user_errors():
        result = Joint(target, target, arm, contraction).pressures(angle, torques, stiffness)
    heads = ["torque [N·m]", "agonist [kPa]", "antagonist [kPa]", "stiffness [N·m/rad]", "status"]
    rows = [
        [f"{T:.6g}", f"{P1 / 1e3:.6g}", f"{P2 / 1e3:.6g}", f"{K:.6g}", f"{code}"]
        for P1, P2, T, K, code in zip(*result, strict=True)
    ]
    caption = "status: 0 reached, 1 stiffness too high, 2 too low, 3 torque out of reach"
    outputs.write(
        joint_pressures(result),
        lambda: print_table(caption, heads, rows),
        title=f"Joint of two {file}",
    )
    if count := int((result.status != 0).sum()):
        exit_incomplete(f"{count} of {len(rows)} demands can't be reached; see the nearest.")


def _print_pressures(variables: Any, is_free: bool) -> None:
    import numpy as np

    values = {name: variable.values for name, variable in variables.items()}
    decimals = count_decimals(values["force"].ravel())
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
        others = "\n".join(alternatives) or "-"
        rows.append([demand, strain, f"{state}", *pressures, force + mark, others])
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
    unit_heads = _unit_heads(variables)
    heads = ["demand [N]", "strain [-]", "state", *unit_heads, "force [N]", "other solutions"]
    unstable = any(" u" in "\n".join(row[-2:]) for row in rows)
    captions = [_unstable_caption(unstable)]
    if any(row[-1] != "-" for row in rows):
        captions.insert(
            0, "other solutions: recruitment state, and pressure of its throttled motor unit"
        )
    caption = "; ".join(filter(None, captions))
    print_table("Pressures for each demand", heads, rows, caption, key_columns=2)


@with_options("outputs", Outputs)
def efficiency(
    outputs: Outputs,
    file: str = options.TARGET,
    units: str | None = options.UNITS,
    supply: str | None = options.SUPPLY,
    path: str | None = option(
        "Path of the work: isobaric or isotonic; default: both.",
        autocompletion=lambda: list(_PATHS),
    ),
    force: str | None = option(
        "Forces of a table: 20N or 10N:100N:10N; default: 80, for the average alone.",
        metavar="LIST",
    ),
    strain: str | None = options.SPACE_STRAIN,
    scheme: str | None = options.SCHEME,
    no_resistance: bool = options.NO_RESISTANCE,
) -> None:
    """Compute the average efficiency of isobaric and isotonic work.

    The average is over a bundle's force-strain workspace. With --force, a table gives the
    efficiency of each point, too.
    """
    if path is not None and path not in _PATHS:
        raise UserError(f"--path {path}: choose one of {', '.join(_PATHS)}.")
    pressure, strains = read_supply(supply), read_rising_strains(strain)
    forces = None if force is None else read_list(force, "force", "--force")
    target = read_bundle(file, pressure, units)
    paths = _PATHS if path is None else (path,)
    check_grid(len(target.motor_units), len(forces or range(80)), len(strains or range(225)))
    from ..bundle.energetics import efficiency_map
    from ..results import tables

    with status("finding efficiencies"), user_errors():
        maps = [
            efficiency_map(target, pressure, path, forces, strains, not no_resistance, scheme)
            for path in paths
        ]
        variables = tables.efficiency(maps)

    def figure() -> Any:
        from ..plot.workspace import efficiency as draw

        return draw(*maps)

    def table() -> None:
        _print_efficiency(variables, forces is not None)

    outputs.write(variables, table, figure, title=f"Efficiency of {file}")
    fractions = variables["reached"].values
    # a map without demanded forces extends past the workspace: only an empty one is incomplete
    if not fractions.all() or (forces is not None and fractions.min() < 1):
        pairs = zip(fractions, paths, strict=True)
        texts = ", ".join(f"{100 * fraction:.3g} % {path}" for fraction, path in pairs)
        exit_incomplete(
            f"the bundle doesn't reach all points ({texts}): the others have no efficiency."
        )


def _print_efficiency(variables: Any, points: bool) -> None:
    values = {name: variable.values.tolist() for name, variable in variables.items()}
    columns = (values[name] for name in ("path", "average", "reached"))
    for path, average, fraction in zip(*columns, strict=True):
        print_text(
            f"{path}: average efficiency {number(average, 4)} over the points within reach,"
            f" {100 * fraction:.0f} % of the grid of forces and strains"
        )
    if not points:
        return
    forces = [f"{force:.6g}" for force in values["force"]]
    strains = [f"{strain:.4g}" for strain in values["strain"]]
    for path, grid in zip(values["path"], values["efficiency"], strict=True):
        cells = [[number(value, 4) for value in row] for row in grid]
        heads, labels = ["force [N]", *(f"strain {strain}" for strain in strains)], forces
        if len(strains) > len(forces):  # the longer list runs down the page
            heads, labels = ["strain [-]", *(f"{force} N" for force in forces)], strains
            cells = [[*column] for column in zip(*cells, strict=True)]
        rows = [[label, *row] for label, row in zip(labels, cells, strict=True)]
        caption = "-: out of reach" if any("-" in row for row in cells) else ""
        print_table(f"Efficiency [-], {path}", heads, rows, caption)


COMMANDS = {"bundle": bundle, "space": space, "recruit": recruit, "efficiency": efficiency}
