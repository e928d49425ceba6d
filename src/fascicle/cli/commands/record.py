"""`fascicle record`: a virtual dynamometer's CSV of a muscle, synthetic and labelled so."""

import json
import re
from typing import Any

from .. import options
from ..errors import UserError, user_errors
from ..inputs import check_grid, read_list, read_muscle, read_quantity
from ..options import flag, option
from ..outputs import check_file, print_line, write_text


def run(
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
    from ...records import VirtualDynamometer
    from ...records.published import file_text

    with user_errors():
        record = VirtualDynamometer(**settings).record(muscle, seed)
        text = file_text(record, out)
    write_text("--out", out, overwrite, text)
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
    print_line(f"wrote {out}: {len(record)} synthetic readings, {summary['censored']} clipped")
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


COMMANDS = {"record": run}
