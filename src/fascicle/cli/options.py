"""The options that commands share, and the completion of their values."""

import contextlib
import pathlib
from typing import Annotated

import typer

from ..bundle.schemes import SCHEMES, listed


def complete_target(incomplete: str) -> list[str]:
    """Named examples and muscle files that begin so [-]."""
    from ..files import examples

    folder, slash, _ = incomplete.rpartition("/")
    files: list[str] = []
    with contextlib.suppress(OSError, ValueError):
        inside = sorted(entry.name for entry in pathlib.Path(f"{folder}{slash}" or ".").iterdir())
        files = [f"{folder}{slash}{name}" for name in inside if name.endswith(".toml")]
    return [name for name in [*examples(), *files] if name.startswith(incomplete)]


Target = Annotated[
    str,
    typer.Argument(
        metavar="FILE",
        help="A muscle file, or a named example (see `fascicle muscles`).",
        autocompletion=complete_target,
        show_default=False,
    ),
]
Pressure = Annotated[
    str,
    typer.Option(
        "--pressure",
        "-p",
        metavar="LIST",
        help="Gauge pressures: 34.5kPa, a list 0kPa,5psi or a range 0kPa:413.7kPa:68.95kPa.",
    ),
]
Strain = Annotated[
    str,
    typer.Option(
        "--strain",
        "-s",
        metavar="LIST",
        help="Contractions: 0.1, a list 0,0.1 or a range 0:0.33:0.03, both ends included.",
    ),
]
Pressures = Annotated[
    list[str] | None,
    typer.Option(
        "--pressure",
        "-p",
        metavar="LIST",
        help="Gauge pressures. Of a bundle one for each motor unit, 344.7kPa,0kPa; a unit's may"
        " be a range, 344.7kPa,0kPa:344.7kPa:34.47kPa. Repeated for further states.",
        show_default=False,
    ),
]
NoResistance = Annotated[
    bool,
    typer.Option("--no-resistance", help="Muscles past their own free strain don't push back."),
]
Supply = Annotated[
    str | None,
    typer.Option(
        "--supply",
        metavar="PRESSURE",
        help="Supply pressure, instead of the bundle's own.",
        show_default=False,
    ),
]
Levels = Annotated[
    str | None,
    typer.Option(
        "--levels",
        metavar="LIST",
        help="Throttled pressures of the curves; left out, seven from zero to the supply's.",
        show_default=False,
    ),
]
SpaceStrain = Annotated[
    str | None,
    typer.Option(
        "--strain",
        "-s",
        metavar="LIST",
        help="Contractions, rising; left out, up to the largest free strain.",
        show_default=False,
    ),
]
Scheme = Annotated[
    str | None,
    typer.Option(
        "--scheme",
        help=f"{listed()}, instead of the bundle's own.",
        autocompletion=lambda: list(SCHEMES),
        show_default=False,
    ),
]
Along = Annotated[
    str | None,
    typer.Option(
        "--path",
        help="isobaric or isotonic; left out, both.",
        autocompletion=lambda: ["isobaric", "isotonic"],
        show_default=False,
    ),
]
Forces = Annotated[
    str | None,
    typer.Option(
        "--force",
        metavar="LIST",
        help="Forces: 20N or 10N:100N:10N; left out, 80 up to the blocked force.",
        show_default=False,
    ),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print JSON, in SI units; --json FILE.json writes it there.")
]
AsCsv = Annotated[
    bool, typer.Option("--csv", help="Print CSV, in SI units; --csv FILE.csv writes it there.")
]
Out = Annotated[
    str | None,
    typer.Option(
        "--out",
        "-o",
        metavar="PATH",
        help="Also write the result there: .nc, .zarr, .csv or .json.",
        show_default=False,
    ),
]
Plot = Annotated[
    str | None,
    typer.Option(
        "--plot",
        metavar="PATH",
        help="Also draw it there: .png or .svg.",
        show_default=False,
    ),
]
Replace = Annotated[
    bool,
    typer.Option(
        "--force",
        "--overwrite",
        help="Replace files that are there, also where fascicle didn't write them.",
    ),
]
Overwrite = Annotated[
    bool,
    typer.Option(
        "--overwrite",
        help="Replace files that are there, also where fascicle didn't write them (--force is the"
        " demand).",
    ),
]

DEFAULT_PRESSURE = "0kPa:413.7kPa:68.95kPa"
DEFAULT_STRAIN = "0:0.33:0.03"
