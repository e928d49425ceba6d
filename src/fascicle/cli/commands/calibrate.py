"""`fascicle calibrate`: fit a muscle to a dynamometer's CSV; print it, as JSON, and as files."""

import datetime as dt
import json
import math
import re
import shutil
import sys
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ...core.errors import InvalidInputError, require
from ...io.sanitize import dump_json, sanitize_line
from ...units import parse, pretty
from .. import options, reading
from ..errors import UserError, user_errors
from ..inputs import load_laws, read_muscle, read_quantity
from ..options import Command, complete_target, flag, option
from ..outputs import print_line, print_table, result_folder, status, write_folder


if TYPE_CHECKING:
    from ...calibrate.calibration import Calibration, Selection
    from ...calibrate.fitting import Prior
    from ...muscle import Muscle
    from ...records.record import Record


class CalibrateCommand(Command):
    """The command whose help also lists the names for `--fit` and `--prior`."""

    def format_epilog(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002 as click calls it
        """Write the names after the options."""
        load_laws()  # for the help alone
        from ...calibrate.parameters import parameter_descriptions

        with formatter.section("Names for --fit and --prior (of laws in brackets)"):
            formatter.write_dl(list(parameter_descriptions().items()))


COMMAND = CalibrateCommand

_TUNING = "tuning"  # among names to fit: the paper's method
_SIZES = {"length": "length", "outer_radius": "length", "wall_thickness": "length",
          "braid_angle": "angle"}  # fmt: skip
_LABEL_WIDTH = 35  # characters: a table fits next to it
_CRITERIA = (
    "AIC, BIC: by the likelihood of all readings, clipped ones too; at clipped: the largest pull of"
    " a law where a reading was clipped"
)


def run(
    data: list[str] = reading.DATA,
    muscle: str | None = option(
        "Muscle file to begin with, or a named example.",
        "--muscle -m",
        metavar="FILE",
        autocompletion=complete_target,
    ),
    length: str | None = option("Rest length between the end fittings: 300mm.", metavar="LENGTH"),
    outer_radius: str | None = option("Outer radius of the bladder at rest.", metavar="LENGTH"),
    wall_thickness: str | None = option("Wall thickness of the bladder at rest.", metavar="LENGTH"),
    braid_angle: str | None = option("Angle of a fiber from the axis at rest.", metavar="ANGLE"),
    material: str | None = option("Material of the bladder: latex.", metavar="NAME"),
    rest_length: str | None = reading.REST_LENGTH,
    unit: list[str] | None = reading.UNIT,
    column: list[str] | None = reading.COLUMN,
    columns: str | None = reading.COLUMNS,
    header: int | None = reading.HEADER,
    rows: str | None = reading.ROWS,
    table: str | None = reading.TABLE,
    pressure: str | None = reading.PRESSURE,
    constant: list[str] | None = reading.CONSTANT,
    name_pattern: str | None = reading.NAME_PATTERN,
    zero: list[str] | None = reading.ZERO,
    sign: list[str] | None = reading.SIGN,
    atmosphere: str | None = reading.ATMOSPHERE,
    clipped_at_zero: bool = reading.CLIPPED_AT_ZERO,
    push_positive: bool = reading.PUSH_POSITIVE,
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
    loss: str = option("Loss: linear, or against outliers soft_l1 or cauchy.", default="linear"),
    weights: str = option(
        "Weights: uniform, or level: equal for each pressure.", default="uniform"
    ),
    starts: int = option("Starting points of the search.", default=4, min=1, max=64),
    seed: int = options.SEED,
    intervals: str = option(
        "Method of intervals: quick (linear), or bootstrap (199 simulated records, refitted).",
        default="quick",
    ),
    posterior: bool = flag("Posterior samples (needs numpyro).", "--posterior"),
    compare: bool = flag("Comparison with other laws; takes minutes.", "--compare"),
    profile: bool | None = option(
        "Profiles of all parameters, or none in the report; default: those of the parameters that"
        " the data barely determine.",
        "--profile/--no-profile",
    ),
    out: str | None = option(
        "Folder of muscle, report and figures; default: calibrated-DATA, none with --json.",
        "--out -o",
        metavar="FOLDER",
    ),
    overwrite: bool = options.OVERWRITE,
    as_json: bool = options.JSON,
) -> None:
    """Fit a muscle to dynamometer data, with uncertainties."""
    names = None if fit is None else [name.strip() for name in fit.split(",")]
    prior_texts = reading.read_pairs(prior, "--prior")
    options_of_reading = reading.read_options(
        unit, column, columns, pressure, constant, zero, sign, clipped_at_zero=clipped_at_zero,
        push_positive=push_positive, rest_length=rest_length, header=header, rows=rows,
        table=table, name_pattern=name_pattern, atmosphere=atmosphere,
    )  # fmt: skip
    stem = re.sub(r"[*?\[\]]+", "", Path(data[0]).stem)  # of a pattern, what files have in common
    folder = result_folder(out, f"calibrated-{stem or 'record'}", as_json, overwrite)
    start = read_start(muscle, {
        "length": length, "outer_radius": outer_radius, "wall_thickness": wall_thickness,
        "braid_angle": braid_angle, "material": material, "tension": tension,
        "buckling": buckling, "collapse": collapse, "post_collapse": post_collapse, "ends": ends,
    })  # fmt: skip
    record, remarks = reading.read_record(data, options_of_reading, float(start.length))
    _check(names, loss, intervals, posterior)
    settings = {"loss": loss, "weights": weights, "starts": starts, "seed": seed}
    with user_errors(), status("reading") as update:
        from ...calibrate import fitting
        from ...calibrate import intervals as uncertainty
        from ...calibrate.model_selection import select_model

        priors = _read_priors(prior_texts, start, names)
        choice = None
        if names is None:
            choice = select_model(record, start, priors, **settings, progress=update)
            calibration = choice.calibration
        else:
            update("fitting")
            free = None if names == [_TUNING] else names
            calibration = fitting.fit(record, start, free, priors, **settings, whole=False)
        if intervals == "bootstrap":
            calibration = uncertainty.bootstrap(calibration, seed=seed, tell=update)
        result = Result(uncertainty.with_profiles(calibration), choice, remarks)
        if profile is not False and folder is not None:
            update("profiling")
            shown = uncertainty.profiles(result.fit) if profile else result.fit.profiles
            result = result._replace(profiles=shown)
        if posterior:
            from ...calibrate.posterior import sample

            update("sampling")
            result = result._replace(posterior=sample(result.fit, seed=seed))
        if compare:
            update("comparing laws")
            rows = _compare(record, start, result.fit, priors, settings)
            result = result._replace(comparison=rows)
    paths: list[str] = []
    if folder is not None:
        with status("writing the report"):
            paths = _write(result, folder, overwrite)
    if as_json:
        # numbers that JSON lacks, NaN and infinity, are null
        summary = json.loads(dump_json(_summary(result)), parse_constant=lambda _: None)
        print(dump_json(summary))
        return
    _print(result)
    if paths:
        print_line(f"wrote {', '.join(paths)}")


class Result(NamedTuple):
    """A calibration, how it was selected, and its optional analyses."""

    fit: "Calibration"
    choice: "Selection | None"
    remarks: tuple[str, ...]
    profiles: tuple[Any, ...] = ()
    posterior: Any = None
    comparison: tuple[Any, ...] = ()


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
    from ...muscle import Muscle

    with user_errors():
        return Muscle.from_dimensions(**changes)


def _check(names: list[str] | None, loss: str, intervals: str, posterior: bool) -> None:
    """Refuse what would only fail after the fit."""
    from ...core.validation import check_choice

    if names is not None and _TUNING in names and len(names) > 1:
        raise UserError(
            f"--fit {','.join(names)}: {_TUNING} can't be combined: drop the other names."
        )
    with user_errors():
        check_choice(intervals, ("quick", "bootstrap"), "intervals")
    if loss != "linear" and (posterior or intervals == "bootstrap"):
        flag = "--intervals bootstrap" if intervals == "bootstrap" else "--posterior"
        raise UserError(f"{flag}: needs --loss linear, a robust loss is no model of noise.")
    if posterior:
        require("numpyro")


def _read_priors(
    texts: Mapping[str, str], muscle: "Muscle", names: list[str] | None
) -> dict[str, "Prior"]:
    from ...calibrate.fitting import Prior
    from ...calibrate.parameters import select_parameters

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


def _compare(
    record: "Record", start: "Muscle", fit: "Calibration", priors: Any, settings: Any
) -> tuple[Any, ...]:
    """Fit other laws: of resisting force if that was fitted, else of tension."""
    from ...calibrate import comparison

    if fit.method == "constants" or fit.fit_data.pulls:
        names = list(fit.names) if fit.method == "constants" else None
        rows = comparison.compare_tension(record, start, names, priors, **settings, whole=False)
    else:
        rows = comparison.compare(record, start, list(fit.names), priors, **settings)
    return tuple(rows)


def _write(result: Result, folder: Path, overwrite: bool) -> list[str]:
    """Write muscle, report and figures; returns the files' paths."""
    from ...calibrate.plot_data import figures as draw
    from ...files.calibration_files import calibrated_files
    from ...plot import to_bytes
    from ...reports.calibration import report

    today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
    figures = draw(result.fit, result.profiles, result.posterior)
    drawn = {name: to_bytes(figure, "svg") for name, figure in figures.items()}
    page = report(
        result.fit, today, figures, result.profiles, result.posterior, list(result.comparison),
        remarks=result.remarks, drawn=drawn, choice=result.choice,
    )  # fmt: skip
    texts = calibrated_files(result.fit, today, result.choice) | {"report.html": page}
    content = {name: text.encode() for name, text in texts.items()}
    for name, figure in figures.items():
        content[f"{name}.png"], content[f"{name}.svg"] = to_bytes(figure, "png"), drawn[name]

    def fill(draft: Path) -> None:
        for name, raw in content.items():
            (draft / name).write_bytes(raw)

    write_folder(folder, overwrite, fill)
    return [str(folder / name) for name in content]


def _print(result: Result) -> None:
    """Print the fit for a reader."""
    from ...calibrate import messages

    fit = result.fit
    if fit.record.synthetic:
        print("synthetic: a model made these readings, no muscle was measured")
    # assumptions are always printed; a file's notes on itself are in the report
    for note in (*result.remarks, *(n for n in fit.record.notes if ": note: " not in n)):
        print_line(note)
    print_line("; ".join(messages.fit_data_lines(fit.fit_data)))
    if result.choice is not None:
        _print_choice(result.choice)
    rows = [
        [p.name, *messages.interval_texts(p), messages.identifiability_text(p)]
        for p in fit.parameters
    ]
    caption = f"intervals: {fit.intervals}"
    if any(row[-1] == "not known" for row in rows):
        caption += "; not known: the data alone do not determine it"
    if rows:
        print_table("Parameters", ["", "value", "90 % interval", ""], rows, caption)
    if result.comparison:
        rows = [
            [row.label, str(row.free), f"{row.rmse:.4g}", f"{row.left_out_rmse:.4g}",
             f"{row.clipped_pull:.4g}", f"{row.aic:.1f}", f"{row.bic:.1f}"]
            for row in result.comparison
        ]  # fmt: skip
        heads = ["", "free", "rmse", "left out", "at clipped", "AIC", "BIC"]
        print_table("Laws, errors in N", heads, rows, _CRITERIA)
    if (posterior := result.posterior) is not None:
        converged = "converged" if posterior.agrees else "not converged yet"
        print(
            f"posterior: {converged}, R-hat up to {max(posterior.r_hat):.4f}, effective sample size"
            f" {min(posterior.ess):.0f}, {posterior.divergences} divergences"
        )
    print(
        f"{fit.points} readings, {fit.censored} of them clipped: rmse {pretty(fit.rmse, 'force')},"
        f" {100 * fit.relative_rmse:.3g} % of the largest force; {fit.status}"
    )
    if fit.loop is not None:
        print_line(messages.hysteresis_message(fit))
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 10**6  # files: no limit
    for topic, lines in fit.warnings_by_topic.items():
        print_line(f"warning: {topic}:")
        for line in lines:
            print(textwrap.fill(sanitize_line(line, 2000), width, break_long_words=False,
                                initial_indent="- ", subsequent_indent="  "))  # fmt: skip


def _print_choice(choice: "Selection") -> None:
    """Print the candidates, and the reasons for the selected one."""

    def percent(fraction: float) -> str:
        return f"{100 * fraction:.3g} %" if math.isfinite(fraction) else "-"

    titles = {"pulling": "readings that pull", "all": "all readings"}
    for readings, title in titles.items():
        rows = [
            [textwrap.fill(candidate.label, _LABEL_WIDTH), str(candidate.constants),
             percent(candidate.relative_rmse), percent(candidate.relative_left_out_rmse),
             "selected" if candidate.chosen else ""]
            for candidate in choice.candidates
            if candidate.readings == readings
        ]  # fmt: skip
        if rows:
            heads = ["", "free", "rmse", "left out", ""]
            print_table(f"Fits of {title}: error over the largest force", heads, rows)
    for line in choice.reasons:
        print_line(line)


def _summary(result: Result) -> dict[str, Any]:
    """JSON of a calibration, in SI units."""

    def fields(source: Any, *names: str) -> dict[str, Any]:
        values = {name: getattr(source, name) for name in names}
        return {
            name: getattr(value, "tolist", lambda v=value: v)() for name, value in values.items()
        }

    fit = result.fit
    summary = {
        **fields(fit, "rmse", "relative_rmse", "points", "censored", "status"),
        "parameters": {
            p.name: fields(p, "value", "low", "high", "identifiable", "bound")
            for p in fit.parameters
        },
        "synthetic": fit.record.synthetic,
        "method": fit.method,
        "noise": float(fit.problem.noise),
        "warnings": list(fit.warnings),
        "notes": [*result.remarks, *fit.record.notes],
        "starts": fit.starts,
        "readings": fit.fit_data.counts(),
        "trends": [
            fields(trend, "along", "share", "chance", "found") for trend in fit.diagnosis.trends
        ],
        "runs": [vars(run) for run in fit.diagnosis.runs],
        "wider": dict(zip(fit.names, fit.wider.tolist(), strict=True)),
        "causes": [vars(cause) for cause in fit.diagnosis.causes],
        "untold": list(fit.diagnosis.confounded),
        "gauge": fit.gauge.faults,
        "channel_faults": [vars(fault) for fault in fit.fit_data.faults],
        "loop": None,
        "friction": None,
        "intervals": "quick" if fit.bootstrapped is None else "bootstrap",
    }
    if fit.loop is not None:
        summary["loop"] = fields(fit.loop, "pressure", "width", "share", "half")
    if (friction := fit.friction) is not None:
        springs = ("stiffness", "slip_force", "slip_force_slope")
        law = friction.law
        summary["friction"] = {
            **({name: [] for name in springs} if law is None else fields(law, *springs)),
            "told": list(friction.resolved),
            **fields(friction, "breakaway", "rmse", "pressures"),
        }  # fmt: skip
    if (choice := result.choice) is not None:
        summary["candidates"] = [
            vars(candidate) | {"names": list(candidate.names)} for candidate in choice.candidates
        ]
        summary["reasons"] = list(choice.reasons)
    if result.profiles:
        summary["profiles"] = {p.name: fields(p, "low", "high") for p in result.profiles}
    if (posterior := result.posterior) is not None:
        columns = (posterior.names, posterior.interval(), posterior.r_hat, posterior.ess)
        summary["posterior"] = {
            **fields(posterior, "agrees", "divergences"),
            "parameters": {
                name: {"low": float(low), "high": float(high), "r_hat": float(r_hat),
                       "ess": float(ess)}
                for name, (low, high), r_hat, ess in zip(*columns, strict=True)
            },
        }  # fmt: skip
    if result.comparison:
        summary["comparison"] = [vars(row) for row in result.comparison]
    return summary
