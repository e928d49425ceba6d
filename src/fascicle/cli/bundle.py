"""Commands of a bundle: `bundle`, `space`, `recruit` and `efficiency`."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import fascicle as fs

from .. import results
from . import options
from .errors import UserError, exit_incomplete, user_errors
from .inputs import check_grid, read_bundle, read_list, read_rising_strains, read_states
from .options import Text, option, with_options
from .outputs import Outputs
from .terminal import count_decimals, grid, kpa, number, print_table, print_text, status


_ROWS = 12  # strains of the workspace that are printed, about: as many as fit on a screen
_PATHS = ("isobaric", "isotonic")
_UNSTABLE = "u: unstable, the force rises with strain there and the bundle leaves it"
# marks of a force by the status of its demand, and what they mean
_MARKS = {1: " <", 2: " >"}
_MEANINGS = {
    " <": "<: the largest force there, less than the demand",
    " >": ">: the least force there, more than the demand",
    " u": _UNSTABLE,
}


@with_options("outputs", Outputs)
def bundle(
    outputs: Outputs,
    file: options.Target,
    units: options.Units = None,
    pressure: options.Pressures = None,
    strain: options.Strain = options.DEFAULT_STRAIN,
    no_resistance: options.NoResistance = False,
) -> None:
    """Compute a bundle's force and equilibria over contraction.

    An equilibrium is a strain at which the bundle without load can rest.
    """
    strains = read_list(strain, "strain", "--strain")
    target = read_bundle(file, units)
    states = read_states(pressure, target)
    unit_count = len(states[0])
    check_grid(len(states), unit_count, max(unit_count, len(strains)))
    resistance = not no_resistance
    with status("computing equilibria and forces"), user_errors():
        forces = fs.tables.bundle_force(target, states, strains, resistance)
        variables = {**forces, **fs.tables.bundle_equilibria(target, states, resistance)}

    def print_tables() -> None:
        print_states(variables)
        forces = grid(variables["force"].values.T)
        rows = [[f"{x:.6g}", *row] for x, row in zip(strains, forces, strict=True)]
        print_table("Force by strain", ["strain [-]", *_state_heads(len(states))], rows)

    def figure() -> Any:
        curves, pressures = fs.plot.curves, states[0] if len(states) == 1 else states
        return curves.bundle_force_strain(target, pressures, curves.smooth(strains), resistance)

    outputs.write(variables, print_tables, figure, title=f"Bundle {file}")
    check_equilibria(variables)


def check_equilibria(variables: "Mapping[str, results.Variable]") -> None:
    """End a command with states that have no strain of zero force; `variables`: its result."""
    free = variables["free_strain"].values.tolist()
    missing = [f"{row}" for row, strain in enumerate(free, start=1) if math.isnan(strain)]
    if missing:
        exit_incomplete(
            f"no strain of zero force in state {', '.join(missing)}: the bundle pulls at every"
            " strain; lower its pressures."
        )


def print_states(variables: "Mapping[str, results.Variable]") -> None:
    """Print pressures, free strain and equilibria of states; `variables`: `bundle_equilibria`."""
    names = ("pressures", "free_strain", "equilibria", "stable")
    columns, rows = [variables[name].values.tolist() for name in names], []
    for pressures, free, equilibria, stable in zip(*columns, strict=True):
        strains = [
            number(strain, 4) + ("" if is_stable else " u")
            for strain, is_stable in zip(equilibria, stable, strict=True)
            if math.isfinite(strain)  # a row with fewer equilibria is filled with NaN
        ]
        cells = [*map(kpa, pressures), number(free, 4), ", ".join(strains)]
        rows.append([f"{len(rows) + 1}", *cells])
    heads = ["state", *_unit_heads(variables), "free strain [-]", "equilibria [-]"]
    caption = "" if all(map(all, columns[3])) else _UNSTABLE
    print_table("Free strain and equilibria without load", heads, rows, caption)


def _state_heads(count: int) -> list[str]:
    return [f"state {state} [N]" for state in range(1, count + 1)]


def _unit_heads(variables: "Mapping[str, results.Variable]") -> list[str]:
    return [f"P{unit + 1} [kPa]" for unit in range(variables["pressures"].values.shape[-1])]


@with_options("outputs", Outputs)
def space(
    outputs: Outputs,
    file: options.Target,
    units: options.Units = None,
    supply: options.Supply = None,
    levels: Text = option("Throttled pressures; default: seven up to the supply's.", "LIST"),
    strain: options.RisingStrain = None,
    scheme: options.Scheme = None,
    no_resistance: options.NoResistance = False,
) -> None:
    """Compute the workspaces of recruitment states.

    A state's workspace is the range of forces that it reaches at each contraction. Where those of
    two states overlap, the one with fewer motor units takes less fluid.
    """
    strains = read_rising_strains(strain)
    throttled = None if levels is None else read_list(levels, "pressure", "--levels")
    target = read_bundle(file, units)
    unit_count = len(target.motor_units)
    check_grid(max(unit_count, len(throttled or ())), unit_count, len(strains or range(201)))
    with status("computing the workspace of each state"), user_errors():
        workspace = fs.recruitment.workspace(
            target, supply, throttled or 7, strains, resistance=not no_resistance, scheme=scheme
        )
        variables = fs.tables.space(workspace)

    def figure() -> Any:
        from ..plot.workspace import workspace as draw

        return draw(workspace, fs.recruitment.overlap(workspace))

    outputs.write(variables, lambda: _print_space(variables), figure, title=f"Space of {file}")


def _print_space(variables: "Mapping[str, results.Variable]") -> None:
    values = {name: variable.values for name, variable in variables.items()}
    strains, high = values["strain"], values["high"]
    decimals = count_decimals(high.ravel())
    supply = f"supply pressure {kpa(values['supply_pressure'])} kPa"
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
        heads = ["states", "overlap area [N]", "largest width [N]", "at strain [-]"]
        print_table("Overlap of states", heads, rows)
    rows = []
    for strain, *ends in zip(strains, values["low"].T, high.T, strict=True):
        low, top = ([number(force, decimals) for force in edge] for edge in ends)
        rows.append([f"{strain:.4g}", *map(" to ".join, zip(low, top, strict=True))])
    step = max(1, round(len(strains) / _ROWS))
    heads = ["strain [-]", *_state_heads(len(high))]
    title = f"Range of force of each state, {values['scheme']} recruitment, {supply}"
    print_table(title, heads, rows[::step])


class JointDemand(NamedTuple):
    """Options of a joint that two bundles pull in opposite directions."""

    torque: Text = option("Demanded torques of a joint that two of FILE pull (5N*m).", "LIST")
    stiffness: Text = option("Demanded stiffness of the joint (60N*m/rad).", "VALUE")
    angle: Text = option("Angle of the joint (10deg).", "VALUE")
    moment_arm: Text = option("Moment arm of the joint (50mm).", "VALUE")


@with_options("joint", JointDemand)
def recruit(
    joint: JointDemand,
    file: options.Target,
    units: options.Units = None,
    force: Text = option("Demanded forces: 40N, or 20N,40N, or 0N:100N:10N.", "LIST", "--force -f"),
    strain: str = option(
        "Contractions; of a joint, that of both sides at the angle 0.", "LIST", "--strain -s", ...
    ),
    supply: options.Supply = None,
    scheme: options.Scheme = None,
    no_resistance: options.NoResistance = False,
    as_json: options.Json = False,
    as_csv: options.Csv = False,
    out: options.Out = None,
    overwrite: options.Overwrite = False,
) -> None:
    """Find the pressures that give a force at a contraction.

    Of several solutions, the one that takes the least fluid comes first; the table lists the
    others. With --torque, --stiffness, --angle and --moment-arm: the pressures of a joint.
    """
    missing = [name for name, text in joint._asdict().items() if text is None]
    if force is None and missing:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in missing)
        raise UserError(f"recruit needs --force, or of a joint {names}, too.")
    outputs = Outputs(as_json, as_csv, out, None, overwrite)
    target = read_bundle(file, units)
    if force is None:
        _recruit_joint(target, joint, strain, supply, outputs, f"Joint of two {file}")
        return
    forces, strains = read_list(force, "force", "--force"), read_list(strain, "strain", "--strain")
    unit_count = len(target.motor_units)
    check_grid(len(forces), len(strains), unit_count, unit_count)
    import numpy as np

    from ..bundle.states import resolve_scheme

    demands = np.array(forces)
    with status(f"finding the pressures of {len(forces) * len(strains)} demands"), user_errors():
        result = fs.recruitment.recruit(
            target, demands[:, None], strains, supply, scheme, resistance=not no_resistance
        )
        variables = fs.tables.recruited(result, demands, np.array(strains))
    is_free = resolve_scheme(target, scheme).independent
    title = f"Recruitment of {file}"
    outputs.write(variables, lambda: _print_pressures(variables, is_free), title=title)
    if count := int((result.status != 0).sum()):
        exit_incomplete(
            f"{count} of {result.status.size} demands can't be reached; the table has the nearest"
            " force. Change the force, the strain or the supply pressure."
        )


def _recruit_joint(
    target: "fs.Bundle", joint: JointDemand, strain: str, supply: Text, outputs: Outputs, title: str
) -> None:
    """Find the pressures of a `joint`, with a muscle or bundle on both sides."""
    torques = read_list(joint.torque or "", "moment", "--torque")
    with user_errors():
        if supply is not None:
            target = target.replace(supply_pressure=supply)
        pair = fs.Joint(target, target, joint.moment_arm, strain)
        result = pair.pressures(joint.angle, torques, joint.stiffness)
    heads = ["torque [N·m]", "agonist [kPa]", "antagonist [kPa]", "stiffness [N·m/rad]", "status"]
    rows = [
        [f"{T:.6g}", kpa(agonist), kpa(antagonist), f"{K:.6g}", f"{code}"]
        for agonist, antagonist, T, K, code in zip(*result, strict=True)
    ]
    caption = "status: 0 reached, 1 stiffness too high, 2 too low, 3 torque out of reach"
    variables = fs.tables.joint_pressures(result)
    outputs.write(variables, lambda: print_table(caption, heads, rows), title=title)
    if count := int((result.status != 0).sum()):
        exit_incomplete(f"{count} of {len(rows)} demands can't be reached; see the nearest.")


def _print_pressures(variables: "Mapping[str, results.Variable]", is_free: bool) -> None:
    import numpy as np

    values = {name: variable.values for name, variable in variables.items()}
    decimals, rows = count_decimals(values["force"].ravel()), []
    for index, code in np.ndenumerate(values["status"]):
        demand, strain = f"{values['demand'][index[0]]:.6g}", f"{values['strain'][index[1]]:.6g}"
        force, state = number(values["force"][index], decimals), values["state"][index]
        names = ("pressure", "state", "stable")
        solutions = zip(*(values[f"solution_{name}"][index] for name in names), strict=True)
        alternatives = [
            f"{other}: {kpa(pressure)} kPa{'' if is_stable else ' u'}"
            for pressure, other, is_stable in solutions
            if other and (pressure, other) != (values["throttled_pressure"][index], state)
        ]
        mark = _MARKS.get(int(code), "" if values["stable"][index] else " u")
        pressures = map(kpa, values["pressures"][index])
        cells = [f"{state}", *pressures, force + mark, "\n".join(alternatives) or "-"]
        rows.append([demand, strain, *cells])
    heads = ["demand [N]", "strain [-]", "state", *_unit_heads(variables), "force [N]"]
    captions = []
    if any(row[-1] != "-" for row in rows):
        captions = ["other solutions: recruitment state, and pressure of its throttled motor unit"]
    text = "".join(cell for row in rows for cell in row[-2:])
    captions += [meaning for mark, meaning in _MEANINGS.items() if mark in text]
    title = "Pressures for each demand" + ", those of least fluid" * is_free
    print_table(title, [*heads, "other solutions"], rows, "; ".join(captions), keys=2)


@with_options("outputs", Outputs)
def efficiency(
    outputs: Outputs,
    file: options.Target,
    units: options.Units = None,
    supply: options.Supply = None,
    path: Text = option(
        "Path of the work: isobaric or isotonic; default: both.", autocompletion=lambda: [*_PATHS]
    ),
    force: Text = option("Forces of a table; default: 80, for the average alone.", "LIST"),
    strain: options.RisingStrain = None,
    scheme: options.Scheme = None,
    no_resistance: options.NoResistance = False,
) -> None:
    """Compute the average efficiency of isobaric and isotonic work.

    The average is over a bundle's force-strain workspace. With --force, a table gives the
    efficiency of each point, too.
    """
    strains = read_rising_strains(strain)
    forces = None if force is None else read_list(force, "force", "--force")
    target = read_bundle(file, units)
    paths = _PATHS if path is None else (path,)
    check_grid(len(target.motor_units), len(forces or range(80)), len(strains or range(225)))
    arguments = (forces, strains, not no_resistance, scheme)
    with status("finding efficiencies"), user_errors():
        maps = [fs.energetics.efficiency_map(target, supply, path, *arguments) for path in paths]
        variables = fs.tables.efficiency(maps)

    def figure() -> Any:
        from ..plot.workspace import efficiency as draw

        return draw(*maps)

    def print_tables() -> None:
        _print_efficiency(variables, forces is not None)

    outputs.write(variables, print_tables, figure, title=f"Efficiency of {file}")
    fractions = variables["reached"].values
    # a map without demanded forces extends past the workspace: only an empty one is incomplete
    if not fractions.all() or (forces is not None and fractions.min() < 1):
        pairs = zip(fractions, paths, strict=True)
        texts = ", ".join(f"{100 * fraction:.3g} % {path}" for fraction, path in pairs)
        exit_incomplete(
            f"the bundle doesn't reach all points ({texts}): the others have no efficiency."
        )


def _print_efficiency(variables: "Mapping[str, results.Variable]", points: bool) -> None:
    values = {name: variable.values for name, variable in variables.items()}
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
    for path, matrix in zip(values["path"], values["efficiency"], strict=True):
        cells, labels = grid(matrix, 4), forces
        heads = ["force [N]", *(f"strain {strain}" for strain in strains)]
        if len(strains) > len(forces):  # the longer list runs down the page
            cells, labels = grid(matrix.T, 4), strains
            heads = ["strain [-]", *(f"{force} N" for force in forces)]
        rows = [[label, *row] for label, row in zip(labels, cells, strict=True)]
        caption = "-: out of reach" if any("-" in row for row in cells) else ""
        print_table(f"Efficiency [-], {path}", heads, rows, caption)


COMMANDS = {"bundle": bundle, "space": space, "recruit": recruit, "efficiency": efficiency}
