"""Commands on measured data: `calibrate`, `convert`, and `record` on a virtual dynamometer."""

import json
import math
import re
import textwrap
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.errors import InvalidInputError, require
from ..io.sanitize import dump_json, escape_invisible
from ..units import parse, pretty
from . import options
from .errors import UserError, user_errors
from .inputs import check_grid, load_laws, read_list, read_muscle, read_quantity
from .options import Command, argument, complete_target, flag, option, with_options
from .outputs import (
    check_file,
    print_line,
    print_table,
    print_written,
    result_folder,
    status,
    today,
    warnings_last,
    write_folder,
    write_text,
)


if TYPE_CHECKING:
    from ..calibrate.fitting import Prior
    from ..calibrate.model_selection import Selection
    from ..muscle import Muscle
    from ..records.record import Record
    from ..report.calibration import CalibrationResult

_LABEL_WIDTH = 35  # characters: a table fits next to it
_DOUBTS = 3  # in a line that is still read
_LINES = 10  # of a verdict with the constants: more are not read
_SHARE = "errors over the largest force"
_CRITERIA = (
    "left-out error: at pressures left out of the fit; pull at clipped: largest pull of the law"
    " where a reading is clipped; AIC, BIC: by the likelihood of all readings, also of clipped ones"
)
_TUNING = "tuning"  # among names to fit: the paper's method
_SIZES = {
    "length": "length",
    "outer_radius": "length",
    "wall_thickness": "length",
    "braid_angle": "angle",
}
DATA = argument(
    "DATA",
    "Files of a dynamometer, or patterns such as 'runs/*.csv', all of one muscle: text, .xlsx,"
    " .mat, .tdms or published .json with pressure, force, and strain, length or displacement; or"
    " torque and angle of a joint.",
)


class CalibrateCommand(Command):
    """The command whose help also lists the names for `--fit` and `--prior`."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002 as click calls it
        """Write the names after the options."""
        load_laws()  # for the help alone
        from ..calibrate.parameters import parameter_descriptions

        with formatter.section("Names for --fit and --prior (laws that have them in brackets)"):
            formatter.write_dl(list(parameter_descriptions().items()))


def read_pairs(texts: list[str] | None, name: str) -> dict[str, str]:
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


def read_options(
    rest_length: str | None = option(
        "Reference length of strains and displacements; default: the file's, else the muscle's.",
        metavar="LENGTH",
    ),
    unit: list[str] | None = option(
        "Unit of a column whose header has none: force=N; repeatable.", metavar="ROLE=UNIT"
    ),
    column: list[str] | None = option(
        "Header of an unrecognized column, with a ROLE as in --columns: force='Load cell 2';"
        " repeatable.",
        metavar="ROLE=HEADER",
    ),
    columns: str | None = option(
        "Columns in order, for files without a header: force[N],pressure[kPa],-,length[mm]; - skips"
        " one; also strain, displacement, torque, angle, moment_arm, time, branch, clipped.",
        metavar="NAMES",
    ),
    header: int | None = option(
        "Number of the line that names the columns; default: detected.", metavar="LINE", min=1
    ),
    rows: str | None = option(
        "Rows to read, counted from 1 below the header: 40:200, or 40: for all from row 40 on.",
        metavar="FIRST:LAST",
    ),
    table: str | None = option(
        "Sheet (.xlsx), matrix (.mat) or group (.tdms) of a file that has several; '*' for all.",
        metavar="NAME",
    ),
    decimal: str | None = option(
        "Decimal separator, . or , (the other may separate thousands); default: detected.",
        metavar="SIGN",
    ),
    pressure: str | None = option("Pressure of all readings of the files.", metavar="PRESSURE"),
    constant: list[str] | None = option(
        "Constant of all readings: length=167mm, force=2kgf; repeatable.", metavar="ROLE=VALUE"
    ),
    name_pattern: str | None = option(
        "Pattern of names of files or tables, with constants: {length}cm_{pressure}kPa, * for other"
        " text.",
        metavar="PATTERN",
    ),
    zero: list[str] | None = option(
        "Reading of a gauge at zero or at rest: force=8N, pressure=1.5kPa, displacement=2mm,"
        " torque=0.1Nm, angle=10deg; repeatable.",
        metavar="ROLE=VALUE",
    ),
    scale: list[str] | None = option(
        "Quantity of a gauge's signal: pressure=1.475bar/V, force=12N/V; --zero may be a"
        " signal then:"
        " pressure=0.2V; repeatable.",
        metavar="ROLE=VALUE/UNIT",
    ),
    resample: str | None = option(
        "Step of one clock, for channels that have clocks of their own: 0.1s.", metavar="TIME"
    ),
    sign: list[str] | None = option(
        "Positive direction of a column: displacement=extension, angle=extension; repeatable.",
        metavar="ROLE=DIRECTION",
    ),
    atmosphere: str | None = option(
        "Atmosphere to subtract from absolute pressures.", metavar="PRESSURE"
    ),
    moment_arm: str | None = option(
        "Moment arm of the muscle about the joint whose torque was measured; a table of"
        " arms by angle"
        " goes into the TOML file beside the record.",
        metavar="LENGTH",
    ),
    clipped_at_zero: bool = flag(
        "Clipping at zero: a force of exactly 0 means 0 or less.", "--clipped-at-zero"
    ),
    push_positive: bool = flag(
        "Sign of the file's forces: positive for a push.", "--push-positive"
    ),
) -> dict[str, Any]:
    """Arguments of `records.load` from the texts of the options of this module."""
    headers = read_pairs(column, "--column")
    if columns is not None and headers:
        raise UserError("--columns names all columns: leave out --column.")
    constants = read_pairs(constant, "--constant")
    signs = read_pairs(sign, "--sign")
    return {
        "rest_length": rest_length,
        "header": header,
        "rows": rows,
        "table": table,
        "decimal": decimal,
        "name_pattern": name_pattern,
        "resample": resample,
        "atmosphere": atmosphere,
        "moment_arm": moment_arm,
        "columns": headers if columns is None else columns,
        "units": read_pairs(unit, "--unit"),
        "constants": constants | ({} if pressure is None else {"pressure": pressure}),
        "zeros": read_pairs(zero, "--zero"),
        "scales": read_pairs(scale, "--scale"),
        "signs": signs | ({"force": "pushing"} if push_positive else {}),
        "clipped_at_zero": clipped_at_zero or None,
    }


def read_record(paths: list[str], options: dict[str, Any], length: float | None = None) -> "Record":
    """Read one record from files.

    **Arguments:**

    - `paths`: files and patterns.
    - `options`: arguments of `records.load`.
    - `length`: of the muscle at rest [m], for files that name no rest length; left out, they are
      refused.
    """
    from ..records import load
    from ..records.headers import MissingMetadataError

    with user_errors():
        try:
            return load(paths, **options, default_length=length)
        except MissingMetadataError as error:
            raise ValueError(error.message(_record_option)) from None


def _record_option(argument: str, role: str, value: str) -> str:
    """An argument of `records.load` as options of the command line."""
    if argument == "constants" and role == "pressure":
        return f"--pressure '{value}'"
    name = argument.removesuffix("s") if role else argument
    text = value.removesuffix(" positive") if argument == "signs" else value
    setting = f" {role}='{text}'" if role else f" '{text}'" if text else ""
    return f"--{name.replace('_', '-')}{setting}"


def record(
    file: str = options.TARGET,
    out: str = option(
        "Result file of the record: .csv, or .json for publication.",
        "--out -o",
        metavar="PATH",
        default=...,
    ),
    seed: int = options.SEED,
    pressure: str | None = option(
        "Gauge pressures: a list or a range; default: 0 to 413.7 kPa in 13 levels.",
        "--pressure -p",
        metavar="LIST",
    ),
    samples: int = option("Number of readings in one sweep.", default=200, min=2),
    one_way: bool = flag("Contraction only, without the return.", "--one-way"),
    noise: str = option(
        "Standard deviation of the force's noise, as a share of the largest force.",
        metavar="SHARE",
        default="0.5%",
    ),
    resolution: str = option("Resolution of the load cell.", metavar="FORCE", default="0N"),
    pressure_noise: str = option(
        "Standard deviation of the pressure's noise.", metavar="PRESSURE", default="0Pa"
    ),
    displacement_noise: str = option(
        "Standard deviation of the displacement's noise.", metavar="LENGTH", default="0mm"
    ),
    hysteresis: str = option(
        "Width of the hysteresis loop, as a share of the blocked force.",
        metavar="SHARE",
        default="0%",
    ),
    mullins: str = option(
        "Extra stiffness of new rubber (Mullins effect), as a share.", metavar="SHARE", default="0%"
    ),
    preconditioning: int = option("Number of cycles before the first reading.", default=5, min=0),
    length_scatter: str = option(
        "Standard deviation of the built length, as a share.", metavar="SHARE", default="0%"
    ),
    angle_scatter: str = option(
        "Standard deviation of the built braid angle.", metavar="ANGLE", default="0deg"
    ),
    clip: bool = flag("Tension-only load cell: a push reads zero.", "--clip"),
    overwrite: bool = options.OVERWRITE,
    as_json: bool = options.JSON,
) -> None:
    """Make a synthetic record of a muscle on a virtual dynamometer."""
    check_file("--out", out, overwrite)  # it may be a measurement
    settings: dict[str, Any] = {
        "samples": samples,
        "both_ways": not one_way,
        "preconditioning": preconditioning,
        "clip": clip,
        "noise": _read_share(noise, "--noise"),
        "resolution": read_quantity(resolution, "force", "--resolution"),
        "pressure_noise": read_quantity(pressure_noise, "pressure", "--pressure-noise"),
        "displacement_noise": read_quantity(displacement_noise, "length", "--displacement-noise"),
        "hysteresis": _read_share(hysteresis, "--hysteresis"),
        "mullins": _read_share(mullins, "--mullins"),
        "length_scatter": _read_share(length_scatter, "--length-scatter"),
        "angle_scatter": read_quantity(angle_scatter, "angle", "--angle-scatter"),
    }
    if pressure is not None:
        settings["pressures"] = read_list(pressure, "pressure", "--pressure")
    check_grid(len(settings.get("pressures", range(13))), samples * (1 if one_way else 2))
    muscle = read_muscle(file, "run `fascicle record` on each of its muscles")
    from ..records import VirtualDynamometer
    from ..records.published import file_text

    with user_errors():
        made = VirtualDynamometer(**settings).record(muscle, seed)
        text = file_text(made, out)
    write_text("--out", out, overwrite, text)
    summary = {
        "synthetic": True,
        "path": out,
        "seed": seed,
        "readings": len(made),
        "censored": int(made.censored.sum()),
        "rest_length": made.rest_length,
        "largest_strain": float(made.strain.max()),
        "largest_force": float(made.force.max()),
        "notes": list(made.notes),
    }
    if as_json:
        print(json.dumps(summary))
        return
    print_line(f"wrote {out}: {len(made)} synthetic readings, {summary['censored']} clipped")
    print(
        f"largest contraction {summary['largest_strain']:.4f}, largest force"
        f" {summary['largest_force']:.4g} N, seed {seed}"
    )


def _read_share(text: str, name: str) -> float:
    """Read a share, with its percent sign or none."""
    unit = re.match(r"\s*([+]?[\d.]+)\s*[^\W\d]", text)
    if unit is None:
        return read_quantity(text, "number", name)
    raise UserError(f"{name} must be a share, got {text!r}: write {unit[1]} %.")


@with_options("settings", read_options)
def convert(
    settings: dict[str, Any],
    data: list[str] = DATA,
    out: str = option(
        "Result file: .json of the schema fascicle-record/1, or .csv.",
        "--out -o",
        metavar="PATH",
        default=...,
    ),
    overwrite: bool = options.OVERWRITE,
    as_json: bool = options.JSON,
) -> None:
    """Convert a record of any format to CSV, or to JSON to publish."""
    check_file("--out", out, overwrite, (".json", ".csv"))
    measured = read_record(data, settings)
    from ..records.published import file_text

    with user_errors():
        text = file_text(measured, out)
    write_text("--out", out, overwrite, text)
    if as_json:
        print(json.dumps({"path": out, "readings": len(measured), "notes": list(measured.notes)}))
        return
    print_line(f"wrote {out}: {len(measured)} readings")
    for note in measured.notes:
        print_line(f"  {note}")


@with_options("settings_of_reading", read_options)
@warnings_last()
def calibrate(
    settings_of_reading: dict[str, Any],
    data: list[str] = DATA,
    muscle: str | None = option(
        "Muscle file to begin with, or a named example.",
        "--muscle -m",
        metavar="FILE",
        autocompletion=complete_target,
    ),
    length: str | None = option(
        "Muscle length between the end fittings, at rest, such as 300mm.", metavar="LENGTH"
    ),
    outer_radius: str | None = option("Outer radius of the bladder at rest.", metavar="LENGTH"),
    wall_thickness: str | None = option("Wall thickness of the bladder at rest.", metavar="LENGTH"),
    braid_angle: str | None = option("Angle of a fiber from the axis at rest.", metavar="ANGLE"),
    material: str | None = option("Material of the bladder: latex.", metavar="NAME"),
    fit: str | None = option(
        "Free parameters from the names below, such as c10,braid_angle, or tuning, the paper's"
        " method; default: selected by leave-one-pressure-out cross-validation.",
        metavar="LIST",
    ),
    prior: list[str] | None = option(
        "Prior value and standard deviation: outer_radius=12mm,0.5mm; repeatable.",
        metavar="NAME=VALUE,DEVIATION",
    ),
    tension: str | None = option("Law of tension.", metavar="LAW"),
    buckling: str | None = option("Law of buckling.", metavar="LAW"),
    collapse: str | None = option("Law of collapse.", metavar="LAW"),
    post_collapse: str | None = option("Law past collapse.", metavar="LAW"),
    ends: str | None = option("Law of the ends.", metavar="LAW"),
    loss: str = option("Loss: linear, or soft_l1 for data with outliers.", default="linear"),
    starts: int = option("Starting points of the search.", default=4, min=1, max=64),
    seed: int = options.SEED,
    posterior: bool = flag("Posterior samples (needs numpyro).", "--posterior"),
    compare: bool = flag("Comparison with other laws, in one picture.", "--compare"),
    profile: bool | None = option(
        "Likelihood profiles of all parameters, or of none; default: of those that the data barely"
        " determine.",
        "--profile/--no-profile",
    ),
    notebook: bool = flag("Notebook that draws record, curves and residuals.", "--notebook"),
    out: str | None = option(
        "Folder of muscle, report and figures; default: calibrated-DATA, none with --json.",
        "--out -o",
        metavar="FOLDER",
    ),
    overwrite: bool = options.OVERWRITE,
    verbose: bool = options.VERBOSE,
    as_json: bool = options.JSON,
) -> None:
    """Fit a muscle to dynamometer data, with uncertainties."""
    names = None if fit is None else [name.strip() for name in fit.split(",")]
    prior_texts = read_pairs(prior, "--prior")
    if notebook and out is None and as_json:
        raise UserError("--notebook: name its folder with --out, or drop --json.")
    stem = re.sub(r"[*?\[\]]+", "", Path(data[0]).stem)  # of a pattern, what files have in common
    folder = result_folder(out, f"calibrated-{stem or 'record'}", as_json, overwrite)
    start = read_start(
        muscle,
        {
            "length": length,
            "outer_radius": outer_radius,
            "wall_thickness": wall_thickness,
            "braid_angle": braid_angle,
            "material": material,
            "tension": tension,
            "buckling": buckling,
            "collapse": collapse,
            "post_collapse": post_collapse,
            "ends": ends,
        },
    )
    measured = read_record(data, settings_of_reading, float(start.length))
    _check(names, loss, posterior)
    settings = {"loss": loss, "starts": starts, "seed": seed}
    with user_errors(), status("reading") as update:
        from ..calibrate import fitting
        from ..calibrate import intervals as uncertainty
        from ..calibrate.model_selection import select_model
        from ..report.calibration import CalibrationResult, summary

        priors = _read_priors(prior_texts, start, names)
        choice = None
        if names is None:
            laws = ("ends",) if ends is not None else ()
            choice = select_model(
                measured, start, priors, **settings, given_laws=laws, progress=update
            )
            calibration = choice.calibration
        else:
            update("fitting")
            free = None if names == [_TUNING] else names
            calibration = fitting.fit(measured, start, free, priors, **settings, whole=False)
        result = _add_analyses(
            CalibrationResult(uncertainty.with_profiles(calibration), choice),
            measured,
            start,
            priors,
            settings,
            update,
            profile=False if folder is None else profile,
            posterior=posterior,
            compare=compare,
        )
    written: list[str] = []
    if folder is not None:
        with status("drawing the report"):
            written = _write(result, folder, overwrite, notebook)
    if as_json:
        # numbers that JSON lacks, NaN and infinity, are null
        print(dump_json(json.loads(dump_json(summary(result)), parse_constant=lambda _: None)))
        return
    _print_calibration(result, verbose)
    if folder is not None:
        print_written(folder, written, verbose)


def read_start(target: str | None, texts: Mapping[str, str | None]) -> "Muscle":
    """Read the muscle that a fit begins with.

    **Arguments:**

    - `target`: a path, or an example's name; `None` for a muscle of the sizes alone.
    - `texts`: sizes with units, and names of material and laws; they replace the file's.
    """
    flags = {name: f"--{name.replace('_', '-')}" for name in _SIZES}
    missing = [flag for name, flag in flags.items() if texts[name] is None]
    if target is None and missing:
        raise UserError(
            f"the muscle's sizes are needed: give --muscle FILE, or {', '.join(missing)}."
        )
    changes: dict[str, Any] = {
        name: read_quantity(text, _SIZES[name], flags[name]) if name in _SIZES else text
        for name, text in texts.items()
        if text is not None
    }
    if target is not None:
        muscle = read_muscle(target, "give --muscle the file of one of its muscles")
        with user_errors():
            return muscle.replace(**changes)
    load_laws()
    from ..muscle import Muscle

    with user_errors():
        return Muscle(**changes)


def _check(names: list[str] | None, loss: str, posterior: bool) -> None:
    """Refuse what would only fail after the fit."""
    if names is not None and _TUNING in names and len(names) > 1:
        raise UserError(
            f"--fit {','.join(names)}: {_TUNING} can't be combined: drop the other names."
        )
    if loss != "linear" and posterior:
        raise UserError("--posterior: needs --loss linear, a robust loss is no model of noise.")
    if posterior:
        require("numpyro")


def _read_priors(
    texts: Mapping[str, str], muscle: "Muscle", names: list[str] | None
) -> dict[str, "Prior"]:
    from ..calibrate.fitting import Prior
    from ..calibrate.parameters import select_parameters

    priors = {}
    for name, text in texts.items():
        flag = f"--prior {name}={text}"
        try:
            dimension = select_parameters([name], muscle)[0].dimension
        except InvalidInputError as error:
            raise InvalidInputError("prior", error.rule, name, error.remedy, shown="") from None
        if names not in (None, [_TUNING]) and name not in names:
            select_parameters(names, muscle)  # a misspelled name is reported first
            raise UserError(f"{flag}: {name} isn't fitted: add it to --fit, or drop the prior.")
        numbers = text.split(",")
        if len(numbers) != 2:
            raise UserError(f"{flag}: write a value and its standard deviation, with a comma.")
        prior = Prior(*(parse(number, dimension, f"--prior {name}") for number in numbers))
        if prior.deviation <= 0:
            raise UserError(
                f"{flag}: its standard deviation must be positive, got {numbers[1].strip()}."
            )
        priors[name] = prior
    return priors


def _add_analyses(
    result: "CalibrationResult",
    record: "Record",
    start: "Muscle",
    priors: Any,
    settings: Any,
    update: Callable[[str], None],
    *,
    profile: bool | None,
    posterior: bool,
    compare: bool,
) -> "CalibrationResult":
    """Add optional analyses to a result; `profile`: all if true, those of the fit if `None`."""
    fit = result.fit
    if profile is not False:
        update("profiling")
        from ..calibrate.intervals import profiles

        result = result._replace(profiles=profiles(fit) if profile else fit.profiles)
    if posterior:
        update("sampling")
        from ..calibrate.posterior import sample

        result = result._replace(posterior=sample(fit, seed=settings["seed"]))
    if compare:
        update("comparing laws")
        from ..calibrate import comparison

        # other laws of resisting force if that was fitted, else of tension
        pulling = fit.method == "constants" or fit.fit_data.pulls
        names = list(fit.names) if fit.method == "constants" or not pulling else None
        if pulling:
            settings = {**settings, "whole": False}
            laws = comparison.compare_tension(record, start, names, priors, **settings)
        else:
            laws = comparison.compare(record, start, names, priors, **settings)
        result = result._replace(comparison=laws)
    return result


def _write(result: "CalibrationResult", folder: Path, overwrite: bool, notebook: bool) -> list[str]:
    """Write muscle, report, curves and figures; returns the files' names."""
    from ..report.calibration import output_files

    content = output_files(result, today(), notebook)

    def fill(draft: Path) -> None:
        for name, raw in content.items():
            (draft / name).write_bytes(raw)

    write_folder(folder, overwrite, fill)
    return list(content)


def _print_calibration(result: "CalibrationResult", verbose: bool) -> None:
    """Print the verdict and the constants; with `verbose`, all tables and warnings."""
    from ..report.calibration_words import constant_rows, gauge_error_texts, verdict_lines

    fit = result.fit
    first, last = verdict_lines(fit, result.choice)
    gauges = [f"{text[0].lower()}{text[1:]}" for text in gauge_error_texts(fit)]
    doubts = [*gauges, *fit.record.doubts]
    if doubts:
        remainder = f"; {len(doubts) - _DOUBTS} more in the report" if len(doubts) > _DOUBTS else ""
        last.insert(0, f"Check: {'; '.join(doubts[:_DOUBTS])}{remainder}.")
    for line in first:
        print_line(line)
    # the verdict names the others, and the report has them
    rows = constant_rows(tuple(e for e in fit.parameters if e.identifiable and not e.bound))
    count = len(result.choice.candidates) if result.choice is not None else 0
    chosen = f", best of {count} candidate sets," if count else ""
    if rows:
        print(f"Constants{chosen} with 90 % intervals (linear approximation):")
    elif fit.parameters:
        print(f"Constants{chosen.rstrip(',')}: the data determine none of them.")
    else:
        print(f"Constants: as given{chosen.rstrip(',')}; none was fitted.")
    last += _analysis_lines(result)
    # with the heading of the constants, and the line on the files that were written
    room = len(rows) if verbose else max(_LINES - len(first) - len(last) - 2, 1)
    shown = rows if len(rows) <= room else rows[: room - 1]
    widths = [max((len(row[i]) for row in shown), default=0) for i in range(2)]
    for name, value, interval in shown:
        print(escape_invisible(f"  {name:<{widths[0]}}  {value:>{widths[1]}}  {interval}"))
    if further := [f"{name} {value} ({interval})" for name, value, interval in rows[len(shown) :]]:
        print(escape_invisible(f"  {'also ' if shown else ''}{', '.join(further)}"))
    for line in last:
        print_line(line)
    if verbose:
        _print_details(result)


def _analysis_lines(result: "CalibrationResult") -> list[str]:
    """Lines on a comparison of laws and on samples of the posterior."""
    lines = []
    if result.comparison is not None:
        best = result.comparison.rows[0]
        lines.append(
            f"Best of {len(result.comparison.rows)} laws, by AIC: {best.label}, error"
            f" {pretty(best.rmse, 'force', 3)}."
        )
    if (posterior := result.posterior) is not None:
        converged = "converged" if posterior.agrees else "not converged yet"
        lines.append(
            f"Posterior: {converged}, R-hat up to {max(posterior.r_hat):.4f}, effective sample size"
            f" {min(posterior.ess):.0f}, {posterior.divergences} divergences."
        )
    return lines


def _print_details(result: "CalibrationResult") -> None:
    """Print how readings were read, the candidates, the compared laws, and all warnings."""
    from ..report import calibration_words as words

    fit = result.fit
    for line in (*fit.record.notes, *words.fit_data_lines(fit.fit_data)):
        print_line(line)
    if result.choice is not None:
        _print_choice(result.choice)
    if result.comparison is not None:
        rows = [
            [
                textwrap.fill(row.label, _LABEL_WIDTH),
                str(row.free),
                f"{row.rmse:.4g}",
                f"{row.left_out_rmse:.4g}",
                f"{row.clipped_pull:.4g}",
                f"{row.aic:.1f}",
                f"{row.bic:.1f}",
            ]
            for row in result.comparison.rows
        ]
        heads = [
            "law",
            "fitted constants",
            "rms error [N]",
            "left-out error [N]",
            "pull at clipped [N]",
            "AIC",
            "BIC",
        ]
        print_table("Laws compared", heads, rows, _CRITERIA)
    for line in words.search_lines(fit.solutions):
        print_line(f"Search: {line}.")
    print_line(f"Intervals: {words.interval_method(fit)}.")
    if fit.loop is not None:
        print_line(words.hysteresis_message(fit))
    for topic, lines in words.warnings_by_topic(fit).items():
        print_line(f"Warnings ({topic}):")
        for line in lines:
            print_line(f"- {line}")


def _print_choice(choice: "Selection") -> None:
    """Print the candidates, and the reasons for the selected one."""
    from ..report.calibration_words import candidate_label, selection_reasons

    def percent(fraction: float) -> str:
        """Text of a fraction in percent; "-" if it isn't finite."""
        return f"{100 * fraction:.3g}" if math.isfinite(fraction) else "-"

    titles = {"pulling": "readings that pull", "all": "all readings"}
    for readings, title in titles.items():
        rows = [
            [
                textwrap.fill(candidate_label(candidate), _LABEL_WIDTH),
                str(candidate.constants),
                percent(candidate.relative_rmse),
                percent(candidate.relative_left_out_rmse),
                "selected" if candidate.chosen else "",
            ]
            for candidate in choice.candidates
            if candidate.readings == readings
        ]
        if rows:
            heads = ["fitted constants", "number", "rms error [%]", "cross-validated error [%]", ""]
            print_table(f"Candidates, fitted to {title}", heads, rows, _SHARE)
    for line in selection_reasons(choice):
        print_line(line)


COMMANDS = {"record": record, "convert": convert, "calibrate": calibrate}
COMMAND_CLASSES = {"calibrate": CalibrateCommand}
