"""`fascicle calibrate`: from a dynamometer's CSV to a tuned muscle that knows how sure it is."""

import datetime as dt
from typing import Annotated, Any

import typer

from ...io.sanitize import dump_json
from ..once import Once
from ..options import AsJson, Replace, complete_target
from ..outputs import folder_for, say
from ..problems import UserError, refusing
from ..telling import telling


Data = Annotated[
    list[str],
    typer.Argument(
        metavar="DATA.csv...",
        help="What a dynamometer wrote: pressure, force, and strain, length or displacement."
        " Several files are one muscle's.",
        show_default=False,
    ),
]


def _option(help_text: str, *names: str, metavar: str = "TEXT") -> Any:
    return typer.Option(*names, metavar=metavar, help=help_text, show_default=False)


Muscle = Annotated[
    str | None,
    typer.Option(
        "--muscle",
        "-m",
        metavar="FILE",
        help="The muscle to begin with: its file, or a named example.",
        autocompletion=complete_target,
        show_default=False,
    ),
]
Length = Annotated[
    str | None, _option("At rest, between the end fittings: 300mm.", "--length", metavar="LENGTH")
]
Radius = Annotated[
    str | None, _option("Of the bladder, at rest.", "--outer-radius", metavar="LENGTH")
]
Wall = Annotated[
    str | None, _option("Of the bladder, at rest.", "--wall-thickness", metavar="LENGTH")
]
Angle = Annotated[
    str | None, _option("Of a fiber from the axis, at rest.", "--braid-angle", metavar="ANGLE")
]
Material = Annotated[
    str | None, _option("The bladder's, by name: latex.", "--material", metavar="NAME")
]
Rest = Annotated[
    str | None,
    _option(
        "What strains and displacements refer to; left out, what the file says, else the"
        " muscle's length.",
        "--rest-length",
        metavar="LENGTH",
    ),
]
Unit = Annotated[
    list[str] | None,
    _option(
        "Unit of a column whose header has none: force=N. Repeated for others.",
        "--unit",
        metavar="ROLE=UNIT",
    ),
]
Column = Annotated[
    list[str] | None,
    _option(
        "Header of a column that isn't recognized: force='Load cell 2'. Repeated for others.",
        "--column",
        metavar="ROLE=HEADER",
    ),
]
Header = Annotated[
    int | None,
    typer.Option(
        "--header",
        metavar="LINE",
        min=1,
        help="Line of the columns' names, where titles stand above it; left out, it is looked for.",
        show_default=False,
    ),
]
Clipped = Annotated[
    bool,
    typer.Option("--clipped-at-zero", help="A force of exactly 0 means 0 or less."),
]
PushPositive = Annotated[
    bool,
    typer.Option("--push-positive", help="The file's forces are positive where the muscle pushes."),
]
Fit = Annotated[
    str | None,
    _option(
        "What is free: any of the names below that the muscle has, such as"
        " c10,c01,braid_angle,outer_radius; or tuning, the paper's way. Left out, what the data"
        " can tell is tried, and chosen by pressures left out.",
        "--fit",
        metavar="LIST",
    ),
]
Prior = Annotated[
    list[str] | None,
    _option(
        "What is known beforehand: outer_radius=12mm,0.5mm, a value and its standard deviation."
        " Repeated for others.",
        "--prior",
        metavar="NAME=VALUE,DEVIATION",
    ),
]
Tension = Annotated[str | None, _option("Law of tension.", "--tension", metavar="LAW")]
Buckling = Annotated[str | None, _option("Law of buckling.", "--buckling", metavar="LAW")]
Collapse = Annotated[str | None, _option("Law of collapse.", "--collapse", metavar="LAW")]
After = Annotated[str | None, _option("Law past collapse.", "--post-collapse", metavar="LAW")]
Ends = Annotated[str | None, _option("Law of the ends.", "--ends", metavar="LAW")]
Loss = Annotated[str, typer.Option("--loss", help="linear, or against outliers soft_l1 or cauchy.")]
Weights = Annotated[
    str, typer.Option("--weights", help="uniform, or level: each pressure counts the same.")
]
Starts = Annotated[int, typer.Option("--starts", min=1, max=64, help="Places to search from.")]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Of the random ones among them.")]
Intervals = Annotated[
    str,
    typer.Option(
        "--intervals",
        help="quick: linear, at once; or bootstrap: 199 simulated records, fitted anew.",
    ),
]
Posterior = Annotated[
    bool, typer.Option("--posterior", help="Also sample the posterior (needs numpyro).")
]
Compare = Annotated[
    bool, typer.Option("--compare", help="Also fit other laws, and compare them; takes minutes.")
]
Profiles = Annotated[bool, typer.Option("--profile/--no-profile", help="Profile each parameter.")]
Out = Annotated[
    str | None,
    typer.Option(
        "--out",
        "-o",
        metavar="FOLDER",
        help="Where muscle, report and figures go; left out, calibrated-DATA, and nowhere with"
        " --json.",
        show_default=False,
    ),
]


class WithNames(Once):
    """The command whose help also lists what `--fit` and `--prior` take, as the laws declare it:
    these are loaded for the help alone.
    """

    def format_epilog(self, ctx: Any, formatter: Any) -> None:  # noqa: ARG002 as click calls it
        """Write the names after the options."""
        from ..startup import prepare

        prepare()
        from ...calibrate.problem.parameters import every

        with formatter.section("Names for --fit and --prior (of laws in brackets)"):
            formatter.write_dl(list(every().items()))


def run(
    data: Data,
    muscle: Muscle = None,
    length: Length = None,
    outer_radius: Radius = None,
    wall_thickness: Wall = None,
    braid_angle: Angle = None,
    material: Material = None,
    rest_length: Rest = None,
    unit: Unit = None,
    column: Column = None,
    header: Header = None,
    clipped_at_zero: Clipped = False,
    push_positive: PushPositive = False,
    fit: Fit = None,
    prior: Prior = None,
    tension: Tension = None,
    buckling: Buckling = None,
    collapse: Collapse = None,
    post_collapse: After = None,
    ends: Ends = None,
    loss: Loss = "linear",
    weights: Weights = "uniform",
    starts: Starts = 4,
    seed: Seed = 0,
    intervals: Intervals = "quick",
    posterior: Posterior = False,
    compare: Compare = False,
    profile: Profiles = True,
    out: Out = None,
    overwrite: Replace = False,
    as_json: AsJson = False,
) -> None:
    """Fit a muscle to what a dynamometer measured, and say how sure it is."""
    from .calibrate_work import Begin, Reading, Search, calibrated

    begin = Begin(
        muscle,
        {"length": length, "outer_radius": outer_radius, "wall_thickness": wall_thickness,
         "braid_angle": braid_angle},
        {"material": material, "tension": tension, "buckling": buckling, "collapse": collapse,
         "post_collapse": post_collapse, "ends": ends},
    )  # fmt: skip
    reading = Reading(
        data, rest_length, pairs(unit, "--unit"), pairs(column, "--column"), clipped_at_zero,
        header, push_positive,
    )  # fmt: skip
    search = Search(
        None if fit is None else [name.strip() for name in fit.split(",")],
        pairs(prior, "--prior"), loss, weights, starts, seed, posterior, compare,
        profile and not (as_json and out is None), intervals,
    )  # fmt: skip
    folder = folder_for("calibrate", out, data[0], as_json, overwrite)
    found = calibrated(begin, reading, search, drawn=folder is not None)
    written: list[str] = []
    if folder is not None:
        with refusing("--out "), telling("writing the report"):
            today = f"{dt.datetime.now().astimezone():%Y-%m-%d}"
            written = found.write(folder, today, overwrite)
    if as_json:
        print(dump_json(found.summary()))
        return
    found.show()
    if written:
        say(f"wrote {', '.join(written)}")


def pairs(texts: list[str] | None, option: str) -> dict[str, str]:
    """What stands on either side of an option's equals signs.

    **Arguments:**

    - `texts`: each `NAME=VALUE` [-].
    - `option`: its name [-].

    **Returns:** values by name [-].
    """
    out = {}
    for text in texts or []:
        name, equals, value = text.partition("=")
        if not equals or not name.strip() or not value.strip():
            raise UserError(f"{option} {text!r}: write NAME=VALUE.")
        if name.strip() in out:
            raise UserError(f"{option} {text!r}: {name.strip()} stands there twice.")
        out[name.strip()] = value.strip()
    return out
