"""`fascicle record`: a virtual dynamometer's CSV of a muscle, synthetic and labelled so."""

import json
import re
from typing import Annotated, Any

import typer

from ..inputs import check_grid, read_list, read_muscle, read_one
from ..options import AsJson, Replace, Target
from ..outputs import say
from ..problems import UserError, refusing


Out = Annotated[
    str,
    typer.Option("--out", "-o", metavar="PATH", help="Where the CSV goes.", show_default=False),
]
Seed = Annotated[int, typer.Option("--seed", min=0, help="Of everything that is drawn.")]
Pressure = Annotated[
    str | None,
    typer.Option(
        "--pressure",
        "-p",
        metavar="LIST",
        help="Gauge pressures: a list or a range; left out, 0 to 413.7 kPa in 13 levels.",
        show_default=False,
    ),
]
Samples = Annotated[int, typer.Option("--samples", min=2, help="Readings in one sweep.")]
OneWay = Annotated[bool, typer.Option("--one-way", help="Contract only, record no way back.")]
Noise = Annotated[
    str,
    typer.Option("--noise", metavar="SHARE", help="Of the load cell, over the largest force."),
]
Resolution = Annotated[
    str, typer.Option("--resolution", metavar="FORCE", help="Step of the load cell's readings.")
]
PressureNoise = Annotated[
    str, typer.Option("--pressure-noise", metavar="PRESSURE", help="Of the transducer.")
]
DisplacementNoise = Annotated[
    str, typer.Option("--displacement-noise", metavar="LENGTH", help="Of the gauge of length.")
]
Hysteresis = Annotated[
    str,
    typer.Option(
        "--hysteresis", metavar="SHARE", help="Width of the loop, over the blocked force."
    ),
]
Mullins = Annotated[
    str, typer.Option("--mullins", metavar="SHARE", help="How much stiffer new rubber is.")
]
Preconditioning = Annotated[
    int, typer.Option("--preconditioning", min=0, help="Cycles before the first reading.")
]
LengthScatter = Annotated[
    str, typer.Option("--length-scatter", metavar="SHARE", help="Of fabrication, in length.")
]
AngleScatter = Annotated[
    str, typer.Option("--angle-scatter", metavar="ANGLE", help="Of fabrication, in braid angle.")
]
Clip = Annotated[bool, typer.Option("--clip", help="The gauge only pulls: a push reads zero.")]


def run(
    file: Target,
    out: Out,
    seed: Seed = 0,
    pressure: Pressure = None,
    samples: Samples = 200,
    one_way: OneWay = False,
    noise: Noise = "0.5%",
    resolution: Resolution = "0N",
    pressure_noise: PressureNoise = "0Pa",
    displacement_noise: DisplacementNoise = "0mm",
    hysteresis: Hysteresis = "0%",
    mullins: Mullins = "0%",
    preconditioning: Preconditioning = 5,
    length_scatter: LengthScatter = "0%",
    angle_scatter: AngleScatter = "0deg",
    clip: Clip = False,
    overwrite: Replace = False,
    as_json: AsJson = False,
) -> None:
    """Test a muscle on a virtual dynamometer, into a CSV that says it is synthetic.

    The noises and scatters are standard deviations.
    """
    from ...files.ours import check_file, replacing
    from ...io.atomic import check_writable

    with refusing("--out "):
        check_writable(out)
        check_file(out, overwrite)  # it may be a measurement
    settings: dict[str, Any] = {
        "samples": samples,
        "both_ways": not one_way,
        "preconditioning": preconditioning,
        "clip": clip,
        "noise": _share(noise, "--noise"),
        "resolution": read_one(resolution, "force", "--resolution"),
        "pressure_noise": read_one(pressure_noise, "pressure", "--pressure-noise"),
        "displacement_noise": read_one(displacement_noise, "length", "--displacement-noise"),
        "hysteresis": _share(hysteresis, "--hysteresis"),
        "mullins": _share(mullins, "--mullins"),
        "length_scatter": _share(length_scatter, "--length-scatter"),
        "angle_scatter": read_one(angle_scatter, "angle", "--angle-scatter"),
    }
    if pressure is not None:
        settings["pressures"] = read_list(pressure, "pressure", "--pressure")
    levels = len(settings.get("pressures", range(13)))
    check_grid(levels, samples * (1 if one_way else 2))
    muscle = read_muscle(file, "run `fascicle record` on each of its muscles")
    from ...records import VirtualDynamometer, write

    with refusing():
        record = VirtualDynamometer(**settings).record(muscle, seed)
        with replacing(out, overwrite) as draft:
            write(record, draft)
    summary = {
        "synthetic": True,
        "path": out,
        "seed": seed,
        "readings": len(record),
        "censored": int(record.censored.sum()),
        "rest_length": record.rest_length,
        "largest_strain": float(record.strain.max()),
        "largest_force": float(record.force.max()),
        "notes": list(record.notes),
    }
    if as_json:
        print(json.dumps(summary))
        return
    say(f"wrote {out}: {len(record)} synthetic readings, {summary['censored']} of them clipped")
    print(
        f"contraction to {summary['largest_strain']:.4f},"
        f" force to {summary['largest_force']:.4g} N, seed {seed}"
    )


def _share(text: str, option: str) -> float:
    """The share that an `option` [-] names; `text`: with its percent sign or none [-]."""
    number = re.match(r"\s*([+]?[\d.]+)\s*[^\W\d]", text)
    if number is None:
        return read_one(text, "number", option)
    raise UserError(f"{option} must be a share, got {text!r}: write {number[1]} %.")
