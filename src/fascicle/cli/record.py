"""Commands on measured data: `calibrate`, `convert`, and `record` on a virtual dynamometer."""

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import fascicle as fs

from .. import calibrate as fitting
from .. import records
from ..core.errors import InvalidInputError, require
from ..io import atomic
from ..io.sanitize import dump_json, escape_invisible
from ..units import parse, pretty
from . import options
from .errors import UserError, user_errors
from .inputs import check_grid, load_laws, read_list, read_muscle
from .options import Command, Text, Texts, argument, complete_target, flag, option, with_options
from .outputs import check_file, print_if_lost, result_folder, today, write_text
from .terminal import print_line, status


if TYPE_CHECKING:
    from ..calibrate.comparison import LawComparison
    from ..report.calibration import CalibrationResult

_DOUBTS = 3  # in a line that is still read
_LINES = 10  # of a verdict with the constants: more are not read
_TUNING = "tuning"  # among names to fit: the paper's method
DATA = argument(
    "DATA",
    "Files of a dynamometer, or patterns such as 'runs/*.csv', all of one muscle: text, .xlsx,"
    " .mat, .tdms or published .json with pressure, force, and strain, length or displacement; or"
    " torque and angle of a joint.",
)


class CalibrateCommand(Command):
    """The command whose help also lists the names for `--fit` and `--prior`."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:
        """Write the names after the options."""
        load_laws()  # for the help alone
        from ..calibrate.parameters import parameter_descriptions

        with formatter.section("Names for --fit and --prior (laws that have them in brackets)"):
            formatter.write_dl(list(parameter_descriptions().items()))


def read_pairs(texts: Texts, name: str) -> dict[str, str]:
    """Read values by name of an option's `NAME=VALUE`s."""
    pairs: dict[str, str] = {}
    for text in texts or []:
        key, _, value = map(str.strip, text.partition("="))
        if not key or not value:
            raise UserError(f"{name} {text!r}: write NAME=VALUE.")
        if key in pairs:
            raise UserError(f"{name} {text!r}: {key} was given twice: give it once.")
        pairs[key] = value
    return pairs


class Reading(NamedTuple):
    """Options of how files are read."""

    rest_length: Text = option("Length at no strain; default: the file's, else muscle's.", "LENGTH")
    unit: Texts = option("Unit that a header lacks: force=N; repeatable.", "ROLE=UNIT")
    column: Texts = option("Header of a column: force='Load cell 2'; repeatable.", "ROLE=HEADER")
    columns: Text = option(
        "Columns in order, for files without a header: force[N],pressure[kPa],-,length[mm]; - skips"
        " one; also strain, displacement, torque, angle, moment_arm, time, branch, clipped.",
        "NAMES",
    )
    header: int | None = option("Line that names the columns; default: detected.", "LINE", min=1)
    rows: Text = option("Rows, from 1 below the header: 40:200, or 40: to the end.", "FIRST:LAST")
    table: Text = option("Sheet (.xlsx), matrix (.mat) or group (.tdms), or '*' for all.", "NAME")
    decimal: Text = option("Decimal separator, . or , ; default: detected.", "SIGN")
    pressure: Text = option("Pressure of all readings of the files.", "PRESSURE")
    constant: Texts = option("Constant of all readings: length=167mm; repeatable.", "ROLE=VALUE")
    name_pattern: Text = option("Constants in names: {length}cm_{pressure}kPa*.", "PATTERN")
    zero: Texts = option("Reading of a gauge at zero or rest: force=8N; repeatable.", "ROLE=VALUE")
    scale: Texts = option("Gauge's quantity: force=12N/V; repeatable.", "ROLE=VALUE/UNIT")
    resample: Text = option("Step of one clock, for channels that have their own: 0.1s.", "TIME")
    sign: Texts = option("Positive way: displacement=extension; repeatable.", "ROLE=DIRECTION")
    atmosphere: Text = option("Atmosphere to subtract from absolute pressures.", "PRESSURE")
    moment_arm: Text = option("Moment arm about the joint whose torque was measured.", "LENGTH")
    clipped_at_zero: bool = flag("A force of exactly 0 means 0 or less.", "--clipped-at-zero")
    push_positive: bool = flag("Forces are positive for a push.", "--push-positive")


def read_record(
    paths: list[str], reading: Reading, length: float | None = None
) -> "records.Record":
    """Read one record from files and patterns; `length`: of the muscle at rest [m], for files that
    name no rest length.
    """
    settings = reading._asdict()
    pairs = {
        f"{name}s": read_pairs(settings.pop(name), f"--{name}")
        for name in ("unit", "column", "constant", "zero", "scale", "sign")
    }
    if (pressure := settings.pop("pressure")) is not None:
        pairs["constants"]["pressure"] = pressure
    if settings.pop("push_positive"):
        pairs["signs"]["force"] = "pushing"
    settings["clipped_at_zero"] = reading.clipped_at_zero or None
    if reading.columns is None:
        settings["columns"] = pairs["columns"]
    elif pairs["columns"]:
        raise UserError("--columns names all columns: leave out --column.")
    with user_errors():
        try:
            return records.load(paths, **{**pairs, **settings}, default_length=length)
        except records.MissingMetadataError as error:
            raise ValueError(error.message(_record_option)) from None


def _record_option(argument: str, role: str, value: str) -> str:
    """An argument of `records.load` as options of the command line."""
    if argument == "constants" and role == "pressure":
        return f"--pressure '{value}'"
    name = argument.removesuffix("s") if role else argument
    text = value.removesuffix(" positive") if argument == "signs" else value
    setting = f" {role}='{text}'" if role else f" '{text}'" if text else ""
    return f"--{name.replace('_', '-')}{setting}"


class Machine(NamedTuple):
    """Options of a virtual dynamometer, named as its arguments."""

    samples: int = option("Number of readings in one sweep.", default=200, min=2)
    noise: str = option("Noise of the force, over the largest force.", "SHARE", default="0.5%")
    resolution: str = option("Resolution of the load cell.", "FORCE", default="0N")
    pressure_noise: str = option("Noise of the pressure.", "PRESSURE", default="0Pa")
    displacement_noise: str = option("Noise of the displacement.", "LENGTH", default="0mm")
    hysteresis: str = option("Width of the loop, over the blocked force.", "SHARE", default="0%")
    mullins: str = option("Extra stiffness of new rubber (Mullins).", "SHARE", default="0%")
    preconditioning: int = option("Number of cycles before the first reading.", default=5, min=0)
    length_scatter: str = option("Scatter of the built length.", "SHARE", default="0%")
    angle_scatter: str = option("Scatter of the built braid angle.", "ANGLE", default="0deg")
    clip: bool = flag("Tension-only load cell: a push reads zero.", "--clip")


@with_options("machine", Machine)
def record(
    machine: Machine,
    file: options.Target,
    out: str = option("Result file: .csv, or .json to publish.", "PATH", "--out -o", ...),
    pressure: Text = option(
        "Gauge pressures; default: 13 from 0 to 413.7 kPa.", "LIST", "--pressure -p"
    ),
    one_way: bool = flag("Contraction only, without the return.", "--one-way"),
    seed: options.Seed = 0,
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> None:
    """Make a synthetic record of a muscle on a virtual dynamometer."""
    check_file("--out", out, overwrite, (".json", ".csv"))  # it may be a measurement
    settings: dict[str, Any] = {**machine._asdict(), "both_ways": not one_way}
    if pressure is not None:
        settings["pressures"] = read_list(pressure, "pressure", "--pressure")
    check_grid(len(settings.get("pressures", range(13))), machine.samples * (1 if one_way else 2))
    muscle = read_muscle(file, "run `fascicle record` on each of its muscles")
    with user_errors():
        synthetic = records.VirtualDynamometer(**settings).record(muscle, seed)
    _write_record(synthetic, out, overwrite)
    strain, force = float(synthetic.strain.max()), float(synthetic.force.max())
    clipped = int(synthetic.censored.sum())
    if as_json:
        summary = {
            "synthetic": True, "path": out, "seed": seed, "readings": len(synthetic),
            "censored": clipped, "rest_length": synthetic.rest_length, "largest_strain": strain,
            "largest_force": force, "notes": list(synthetic.notes),
        }  # fmt: skip
        print(json.dumps(summary))
        return
    print_line(f"wrote {out}: {len(synthetic)} synthetic readings, {clipped} clipped")
    print(f"largest contraction {strain:.4f}, largest force {force:.4g} N, seed {seed}")


def _write_record(measured: "records.Record", out: str, overwrite: bool) -> None:
    from ..records.published import file_text

    with user_errors():
        text = file_text(measured, out)
    write_text("--out", out, overwrite, text)


@with_options("reading", Reading)
def convert(
    reading: Reading,
    data: list[str] = DATA,
    out: str = option(
        "Result file: .json of the schema fascicle-record/1, or .csv.", "PATH", "--out -o", ...
    ),
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> None:
    """Convert a record of any format to CSV, or to JSON to publish."""
    from ..report.words import record_lines

    check_file("--out", out, overwrite, (".json", ".csv"))
    measured = read_record(data, reading)
    lines = record_lines(measured)
    _write_record(replace(measured, notes=tuple(lines)), out, overwrite)
    if as_json:
        findings = [finding.to_json() for finding in measured.findings]
        answer = {"path": out, "readings": len(measured), "findings": findings, "notes": lines}
        print(dump_json(answer))
        return
    print_line(f"wrote {out}: {len(measured)} readings")
    for line in lines:
        print_line(f"  {line}")


class Start(NamedTuple):
    """Options of the muscle that a fit begins with, named as a muscle's arguments."""

    length: Text = option("Length between the end fittings, at rest, such as 300mm.", "LENGTH")
    outer_radius: Text = option("Outer radius of the bladder at rest.", "LENGTH")
    wall_thickness: Text = option("Wall thickness of the bladder at rest.", "LENGTH")
    braid_angle: Text = option("Angle of a fiber from the axis at rest.", "ANGLE")
    material: Text = option("Material of the bladder: latex.", "NAME")
    tension: Text = option("Law of tension.", "LAW")
    buckling: Text = option("Law of buckling.", "LAW")
    collapse: Text = option("Law of collapse.", "LAW")
    post_collapse: Text = option("Law past collapse.", "LAW")
    ends: Text = option("Law of the ends.", "LAW")


@with_options("reading", Reading)
@with_options("sizes", Start)
def calibrate(
    reading: Reading,
    sizes: Start,
    data: list[str] = DATA,
    muscle: Text = option(
        "Muscle to begin with.", "FILE", "--muscle -m", autocompletion=complete_target
    ),
    fit: Text = option(
        "Free parameters from the names below, such as c10,braid_angle, or tuning, the paper's"
        " method; default: selected by leave-one-pressure-out cross-validation.",
        "LIST",
    ),
    prior: Texts = option(
        "Prior value and standard deviation: outer_radius=12mm,0.5mm; repeatable.",
        "NAME=VALUE,DEVIATION",
    ),
    loss: str = option("Loss: linear, or soft_l1 for data with outliers.", default="linear"),
    starts: int = option("Starting points of the search.", default=4, min=1, max=64),
    posterior: bool = flag("Posterior samples (needs numpyro).", "--posterior"),
    compare: bool = flag("Comparison with other laws, in one picture.", "--compare"),
    profile: bool | None = option(
        "Likelihood profiles of all parameters, or none; default: of those barely determined.",
        names="--profile/--no-profile",
    ),
    seed: options.Seed = 0,
    out: options.OutFolder = None,
    overwrite: options.Overwrite = False,
    as_json: options.Json = False,
) -> None:
    """Fit a muscle to dynamometer data, with uncertainties."""
    names = None if fit is None else [name.strip() for name in fit.split(",")]
    prior_texts = read_pairs(prior, "--prior")
    stem = re.sub(r"[*?\[\]]+", "", Path(data[0]).stem)  # of a pattern, what files have in common
    folder = result_folder(out, f"calibrated-{stem or 'record'}", as_json, overwrite)
    start = read_start(muscle, sizes)
    measured = read_record(data, reading, float(start.length))
    # what would only fail after the fit
    if names is not None and _TUNING in names and len(names) > 1:
        raise UserError(f"--fit {fit}: {_TUNING} can't be combined: drop the other names.")
    if posterior:
        if loss != "linear":
            raise UserError("--posterior: needs --loss linear, a robust loss is no model of noise.")
        require("numpyro")
    settings = {"loss": loss, "starts": starts, "seed": seed}
    with user_errors(), status("reading") as update:
        from ..calibrate import intervals
        from ..report.calibration import CalibrationResult, output_files

        priors = _read_priors(prior_texts, start)
        choice = None
        if names is None:
            laws = [kind for kind in ("ends", "material") if getattr(sizes, kind) is not None]
            laws += ["material"] if muscle is not None else []
            choice = fitting.select_model(
                measured, start, priors, **settings, given_laws=laws, progress=update
            )
            calibration = choice.calibration
        else:
            update("fitting")
            free = None if names == [_TUNING] else names
            calibration = fitting.fit(measured, start, free, priors, **settings, whole=False)
        update("analyzing")
        fit_result = intervals.with_profiles(calibration)
        profiles = () if folder is None or profile is False else fit_result.profiles
        if folder is not None and profile:
            profiles = fitting.profiles(fit_result)
        result = CalibrationResult(
            fit_result,
            choice,
            profiles,
            fitting.sample(fit_result, seed=seed) if posterior else None,
            _compare(fit_result, start, priors, settings) if compare else None,
        )
    show = partial(_show, result, as_json)
    content: dict[str, bytes] = {}
    if folder is not None:
        with print_if_lost(show), status("drawing the report"), user_errors("--out "):
            content = output_files(result, today())

            def fill(draft: Path) -> None:
                for name, raw in content.items():
                    (draft / name).write_bytes(raw)

            atomic.write_folder(folder, fill, overwrite)
    show()
    if folder is not None and not as_json:
        print_line(f"wrote {folder}: {', '.join(content)}")


def _show(result: "CalibrationResult", as_json: bool) -> None:
    """Print a calibration for a reader, or as JSON."""
    from ..report.calibration import summary

    if as_json:
        # numbers that JSON lacks, NaN and infinity, are null
        print(dump_json(json.loads(dump_json(summary(result)), parse_constant=lambda _: None)))
    else:
        _print_calibration(result)


def read_start(target: str | None, sizes: Start) -> "fs.Muscle":
    """Read the muscle that a fit begins with, by path or example's name if there is one."""
    changes = {name: text for name, text in sizes._asdict().items() if text is not None}
    if target is not None:
        muscle = read_muscle(target, "give --muscle the file of one of its muscles")
        with user_errors():
            return muscle.replace(**changes)
    needed = ("length", "outer_radius", "wall_thickness", "braid_angle")
    if missing := [f"--{name.replace('_', '-')}" for name in needed if name not in changes]:
        raise UserError(
            f"the muscle's sizes are needed: give --muscle FILE, or {', '.join(missing)}."
        )
    load_laws()
    with user_errors():
        return fs.Muscle(**changes)


def _read_priors(texts: Mapping[str, str], muscle: "fs.Muscle") -> dict[str, "fitting.Prior"]:
    from ..calibrate.parameters import select_parameters

    priors = {}
    for name, text in texts.items():
        try:
            dimension = select_parameters([name], muscle)[0].dimension
        except InvalidInputError as error:
            raise InvalidInputError("prior", error.rule, name, error.remedy, shown="") from None
        numbers = text.split(",")
        if len(numbers) != 2:
            raise UserError(
                f"--prior {name}={text}: write a value and its standard deviation, with a comma."
            )
        values = (parse(number, dimension, f"--prior {name}") for number in numbers)
        priors[name] = fitting.Prior(*values)
    return priors


def _compare(
    fit: "fitting.Calibration", start: "fs.Muscle", priors: Any, settings: dict[str, Any]
) -> "LawComparison":
    """Compare laws of resisting force if that was fitted, else of tension."""
    pulling = fit.method == "constants" or fit.fit_data.pulls
    names = list(fit.names) if fit.method == "constants" or not pulling else None
    if pulling:
        settings = {**settings, "whole": False}
    compare = fitting.compare_tension if pulling else fitting.compare
    return compare(fit.record, start, names, priors, **settings)


def _print_calibration(result: "CalibrationResult") -> None:
    """Print the verdict and the constants; the report has all tables and warnings."""
    from ..report import calibration_words as words
    from ..report.words import record_doubts

    fit, choice, posterior = result.fit, result.choice, result.posterior
    first, last = words.verdict_lines(fit, choice)
    gauges = [f"{text[0].lower()}{text[1:]}" for text in words.gauge_error_texts(fit)]
    if doubts := [*gauges, *record_doubts(fit.record)]:
        more = f"; {len(doubts) - _DOUBTS} more in the report" if len(doubts) > _DOUBTS else ""
        last.insert(0, f"Check: {'; '.join(doubts[:_DOUBTS])}{more}.")
    if damping := words.damping_message(fit):
        last.append(damping)
    if result.comparison is not None:
        best, count = result.comparison.rows[0], len(result.comparison.rows)
        error = pretty(best.rmse, "force", 3)
        last.append(f"Best of {count} laws, by AIC: {best.label}, error {error}.")
    if posterior is not None:
        converged = "converged" if posterior.agrees else "not converged yet"
        last.append(
            f"Posterior: {converged}, R-hat up to {max(posterior.r_hat):.4f}, effective sample size"
            f" {min(posterior.ess):.0f}, {posterior.divergences} divergences."
        )
    # the verdict names the others, and the report has them
    rows = words.constant_rows(tuple(e for e in fit.parameters if e.identifiable and not e.bound))
    chosen = f", best of {len(choice.candidates)} candidate sets" if choice else ""
    note = ": the data determine none" if fit.parameters else ": as given, none was fitted"
    note = ", with 90 % intervals (linear approximation):" if rows else f"{note}."
    for line in (*first, f"Constants{chosen}{note}"):
        print_line(line)
    # with the heading of the constants, and the line on the files that were written
    room = max(_LINES - len(first) - len(last) - 2, 1)
    count = len(rows) if len(rows) <= room else room - 1
    widths = [max((len(row[i]) for row in rows[:count]), default=0) for i in range(2)]
    for name, value, interval in rows[:count]:
        print(escape_invisible(f"  {name:<{widths[0]}}  {value:>{widths[1]}}  {interval}"))
    if further := [f"{name} {value} ({interval})" for name, value, interval in rows[count:]]:
        print_line(f"{'also ' if count else ''}{', '.join(further)}")
    for line in last:
        print_line(line)


COMMANDS = {"record": record, "convert": convert, "calibrate": calibrate}
COMMAND_CLASSES = {"calibrate": CalibrateCommand}
