"""Inputs of commands: muscles, bundles, scenarios, quantities; loading of the laws."""

import contextlib
import itertools
import logging
import math
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import fascicle as fs

from .. import files
from ..units import parse, parse_list
from .errors import UserError, user_errors
from .terminal import status


MAX_GRID = 1_000_000  # points of a table: a slip in a step must not fill the memory


def load_laws() -> None:
    """Import the laws, with JAX quiet, on the CPU unless `JAX_PLATFORMS` is set, and its compiled
    functions cached on disk unless `FASCICLE_NO_CACHE=1`, here and in processes started from here.
    """
    # the CPU is always present; XLA's own log is on standard error
    variables = {"JAX_PLATFORMS": "cpu", "TF_CPP_MIN_LOG_LEVEL": "3"}
    if (folder := _cache_folder()) is not None:
        variables["JAX_COMPILATION_CACHE_DIR"] = str(folder)
        # below this, reading the file costs as much as compiling
        variables["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0.1"
    for name, value in variables.items():
        os.environ[name] = os.environ.get(name) or value  # JAX reads them when it is imported
    for name in ("jax", "matplotlib"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    warnings.filterwarnings("ignore", module=r"jax(lib)?(\.|$)")  # not modules such as jaxtyping
    with status("loading the laws"):
        from ..core.validation import BareNumberWarning
        from ..files import muscle_files  # noqa: F401 and with it all laws
    warnings.simplefilter("ignore", BareNumberWarning)  # options and files have units


def _cache_folder() -> Path | None:
    """Folder of compiled functions; `None` if it can't be written or `FASCICLE_NO_CACHE` is set."""
    variable = "LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME"
    with contextlib.suppress(OSError, RuntimeError, ValueError):  # RuntimeError: no home
        folder = Path(os.environ.get(variable, "") or "~/.cache").expanduser() / "fascicle/compiled"
        if os.environ.get("FASCICLE_NO_CACHE", "") in ("", "0") and folder.is_absolute():
            folder.mkdir(parents=True, exist_ok=True)
            return folder if os.access(folder, os.W_OK) else None
    return None


def read_target(target: str) -> Any:
    """Read a `Muscle` or `Bundle` by path or shipped name; a file of that name comes first."""
    if not is_path(target) and target in files.scenarios():
        raise UserError(f"{target}: a scenario, not a muscle or bundle: use `fascicle simulate`.")
    with user_errors():
        text = None if is_path(target) else files.example_text(target)
        load_laws()
        from ..files.muscle_files import load_muscle, loads  # scenarios would need JAX

        return load_muscle(target) if text is None else loads(text, target)


def read_scenario(
    target: str, units: str | None = None, mass: str | None = None
) -> "files.Scenario":
    """Read a `Scenario` by path or name; a file of that name comes first. Of a bundle, or a muscle
    with its `units`: one that lifts a `mass`.
    """
    path = Path(target) if is_path(target) else None
    with user_errors():
        if path is None:
            files.example_text(target)  # refuses an unknown name
        load_laws()  # the settings of JAX, which scenarios import
        scenario = files.example(target) if path is None else files.load(path)
    if not isinstance(scenario, files.Scenario):
        with user_errors():
            kilograms = None if mass is None else parse(mass, "mass", "--mass")
            return files.lift_scenario(read_bundle(target, units), target, path, kilograms)
    if mass is not None:
        raise UserError(f"--mass {mass}: {target} is a scenario: write the mass in its [load].")
    if units is not None:
        raise UserError(f"--units {units}: {target} is a scenario, which names its bundle.")
    return scenario


def is_path(target: str) -> bool:
    """True for a file, and for a text that looks like the path of a missing one."""
    if "/" in target or "\\" in target or target.endswith(".toml"):
        return True
    try:
        return Path(target).exists()
    except (OSError, ValueError):  # too long for a name, or a NUL in it
        return False


def read_muscle(name: str, remedy: str) -> "fs.Muscle":
    """Read a muscle; `remedy`: advice for a bundle."""
    muscle = read_target(name)
    if isinstance(muscle, fs.Muscle):
        return muscle
    raise UserError(f"{name}: a bundle, not a muscle: {remedy}.")


def read_bundle(name: str, units: str | None = None) -> "fs.Bundle":
    """Read a bundle, or a muscle as a bundle of its `units`, such as "1,4"; default: of one."""
    target = read_target(name)
    if isinstance(target, fs.Bundle):
        if units is not None:
            raise UserError(f"--units {units}: FILE is a bundle, which has its motor units.")
        return target
    counts = [text.strip() for text in (units or "1").split(",")]
    if not all(text.isdecimal() and int(text) > 0 for text in counts):
        raise UserError(f"--units {units}: give whole numbers of muscles between commas: 1,4.")
    return fs.Bundle([fs.MotorUnit(target, int(text)) for text in counts])


def read_states(texts: list[str] | None, bundle: "fs.Bundle") -> list[list[float]]:
    """Read pressures [Pa] of a bundle's motor units, a row for each state.

    Each text has a pressure or a range for every unit, between commas; ranges are combined. Without
    texts the states are the fully activated ends of the recruitment states.
    """
    units = len(bundle.motor_units)
    if not texts:
        if bundle.supply_pressure is None:
            raise UserError("--pressure is required: the bundle has no supply pressure.")
        supply = float(bundle.supply_pressure)
        return [[supply] * active + [0.0] * (units - active) for active in range(1, units + 1)]
    states = []
    for text in texts:
        entries = text.split(",")
        if len(entries) != units:
            raise UserError(
                f"--pressure {text}: {len(entries)} pressures for {units} motor units:"
                " give one for each, between commas."
            )
        ranges = [read_list(entry, "pressure", "--pressure") for entry in entries]
        check_grid(*map(len, ranges))
        states += [list(state) for state in itertools.product(*ranges)]
        check_grid(len(states))
    return states


def read_list(text: str, dimension: str, option: str) -> list[float]:
    """Read an option's list or range, in the SI unit of its dimension."""
    with user_errors():
        return parse_list(text, dimension, option)


def read_rising_strains(text: str | None) -> list[float] | None:
    """Read contractions [-] that rise from each to the next, if there are any."""
    strains = None if text is None else read_list(text, "strain", "--strain")
    if strains is not None and any(b <= a for a, b in itertools.pairwise(strains)):
        raise UserError("--strain must rise from each value to the next: sort its values.")
    return strains


def check_grid(*sizes: int) -> None:
    """Refuse a table of more than `MAX_GRID` points, the product of its `sizes`."""
    if math.prod(sizes) > MAX_GRID:
        points = " x ".join(map(str, sizes))
        raise UserError(f"{points} points are more than {MAX_GRID}: take fewer.")
