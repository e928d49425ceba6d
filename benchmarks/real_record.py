"""A real muscle: the static force of a Festo DMSP-20-300, fitted and compared.

The record (Martens and Boblan 2017, table A1, CC BY 4.0) is not in the repository: it is
found under `FASCICLE_DATA`, or beside the checkout. Printed, and with `--out` written: the
direct fit of four constants, its error at pressures it did not see, and the same for other
tension laws and for the published empirical one.

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
from fascicle.calibrate.comparison import compare_tension
from fascicle.calibrate.fitting import fit
from fascicle.calibrate.model_selection import left_out_errors
from fascicle.calibrate.plot_data import fit_plot
from fascicle.plot import calibration as plot
from fascicle.plot import to_bytes


DATA = Path("martens-boblan-2017", "dmsp-20-300.csv")
FREE = ["c10", "c01", "braid_angle", "outer_radius"]


def find() -> Path:
    beside = Path(__file__).resolve().parents[2] / "shared" / "data"
    for folder in (os.environ.get("FASCICLE_DATA"), beside):
        if folder is not None and Path(folder, DATA).is_file():
            return Path(folder, DATA)
    raise SystemExit(f"{DATA}: not found: set FASCICLE_DATA to the folder that holds it.")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=None)
    out = parser.parse_args().out
    record = fs.records.load(find(), rest_length=0.3)
    # Festo's nominal sizes; the wall isn't given, and counts only together with C10 and C01
    nominal = fs.Muscle.from_dimensions(0.3, 10e-3, 2e-3, math.radians(28.6))
    made = fit(record, nominal, FREE)
    errors = left_out_errors(made)
    unseen = float(np.sqrt(np.nanmean(errors**2))) / (made.rmse / made.relative_rmse)
    rows = compare_tension(record, nominal)
    found = {
        "file": {"name": record.sources[0].name, "sha256": record.sources[0].sha256},
        "points": made.points,
        "censored": made.censored,
        "rmse": made.rmse,
        "relative_rmse": made.relative_rmse,
        "relative_left_out_rmse": unseen,
        "status": made.status,
        "warnings": list(made.warnings),
        "parameters": [asdict(one) for one in made.parameters],
        "laws": [asdict(one) for one in rows],
    }
    print(f"rmse {made.rmse:.2f} N, {made.relative_rmse:.2%}; unseen pressures {unseen:.2%}")
    for one in made.parameters:
        print(f"  {one.name:14s} {one.value:.5g} [{one.low:.5g}, {one.high:.5g}]")
    for row in rows:
        print(
            f"{row.label:55s} {row.free}  {row.relative_rmse:7.2%}"
            f"  {row.relative_left_out_rmse:7.2%}  {row.aic:7.1f}"
        )
    if out is not None:
        (out / "dmsp_20_300.json").write_text(json.dumps(found, indent=1) + "\n")
        (out / "dmsp_20_300.png").write_bytes(to_bytes(plot.fit(fit_plot(made)), "png"))


if __name__ == "__main__":
    main()
