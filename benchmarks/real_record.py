"""A measured muscle: the static force of a Festo DMSP-20-300, fitted and compared.

The record (Martens and Boblan 2017, table A1, CC BY 4.0) is not in the repository: it is found
under `FASCICLE_DATA`, or in `shared/data` beside the checkout. Printed, and written to the folder
of `--out`: the direct fit of four constants, its error at pressures left out of the fit, and the
same for other tension laws and for the published empirical one.

    python benchmarks/real_record.py --out docs/_static
"""

import argparse
import json
import math
import os
from dataclasses import asdict
from pathlib import Path

import numpy as np

import fascicle as fs


PATH = Path("martens-boblan-2017", "dmsp-20-300.csv")
FREE = ["c10", "c01", "braid_angle", "outer_radius"]
SIZES = ("--length", "300mm", "--outer-radius", "10mm", "--wall-thickness", "2mm",
         "--braid-angle", "28.6deg", "--rest-length", "300mm")  # fmt: skip


def find_record() -> Path | None:
    """Path of the record, `None` if it is not here."""
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    folders = [Path(os.environ.get("FASCICLE_DATA", beside)), beside]
    return next((folder / PATH for folder in folders if (folder / PATH).is_file()), None)


def main() -> None:
    """Fit, compare, print, and write."""
    from fascicle.calibrate.comparison import compare_tension
    from fascicle.calibrate.fitting import fit
    from fascicle.calibrate.model_selection import left_out_errors
    from fascicle.calibrate.plot_data import fit_plot
    from fascicle.plot import calibration as plot
    from fascicle.plot import to_bytes

    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=None)
    out = parser.parse_args().out
    path = find_record()
    if path is None:
        raise SystemExit(f"{PATH} was not found: set FASCICLE_DATA to the folder that has it.")
    record = fs.records.load(path, rest_length=0.3)
    # Festo's nominal sizes; the wall isn't given, and counts only together with C10 and C01
    nominal = fs.Muscle.from_dimensions(0.3, 10e-3, 2e-3, math.radians(28.6))
    direct = fit(record, nominal, FREE)
    errors = left_out_errors(direct)
    left_out = float(np.sqrt(np.nanmean(errors**2))) / (direct.rmse / direct.relative_rmse)
    laws = compare_tension(record, nominal)
    results = {
        "file": {"name": record.sources[0].name, "sha256": record.sources[0].sha256},
        "points": direct.points,
        "censored": direct.censored,
        "rmse": direct.rmse,
        "relative_rmse": direct.relative_rmse,
        "relative_left_out_rmse": left_out,
        "status": direct.status,
        "warnings": list(direct.warnings),
        "parameters": [asdict(parameter) for parameter in direct.parameters],
        "laws": [asdict(law) for law in laws],
    }
    print(f"rmse {direct.rmse:.2f} N, {direct.relative_rmse:.2%}; left out {left_out:.2%}")
    for parameter in direct.parameters:
        print(f"  {parameter.name:14s} {parameter.value:.5g}"
              f" [{parameter.low:.5g}, {parameter.high:.5g}]")  # fmt: skip
    for law in laws:
        print(f"{law.label:55s} {law.free}  {law.relative_rmse:7.2%}"
              f"  {law.relative_left_out_rmse:7.2%}  {law.aic:7.1f}")  # fmt: skip
    if out is not None:
        (out / "dmsp_20_300.json").write_text(json.dumps(results, indent=1) + "\n")
        (out / "dmsp_20_300.png").write_bytes(to_bytes(plot.fit(fit_plot(direct)), "png"))


if __name__ == "__main__":
    main()
