"""What a command is given: the muscle or bundle, pressures and strains."""

import difflib
import itertools
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..units import parse, parse_list
from .problems import UserError, refusing
from .startup import prepare


if TYPE_CHECKING:
    from ..bundle import Bundle
    from ..muscle import Muscle

MAX_GRID = 1_000_000  # points of a table: a slip in a step must not fill the memory


def read_target(target: str) -> Any:
    """The muscle or bundle in a file, or that is a named example.

    **Arguments:** `target`: a path, or a name [-]; a file of that name comes first.

    **Returns:** a `Muscle` or a `Bundle` [-].
    """
    from ..files import examples

    found = _found(target)
    if not found and is_scenario(target):
        raise UserError(f"{target}: a scenario, not a muscle or bundle: use `fascicle simulate`.")
    if not found and target not in examples():
        raise _unknown(target, examples(), "example", "see `fascicle muscles`.")
    prepare()
    from ..files import example
    from ..files.reading import load

    with refusing():
        return load(target) if found else example(target)


def read_scenario(target: str) -> Any:
    """The scenario in a file, or that has a name.

    **Arguments:** `target`: a path, or a name [-]; a file of that name comes first.

    **Returns:** a `Scenario` [-].
    """
    from ..files import scenarios

    found = _found(target)
    if not found and target not in scenarios():
        raise _unknown(target, scenarios(), "scenario", f"choose one of {', '.join(scenarios())}.")
    prepare()
    from ..files import example, load_scenario

    with refusing():
        return load_scenario(target) if found else example(target)


def is_scenario(target: str) -> bool:
    """Whether a file, or what has that name, is a scenario; `target`: a path, or a name [-]."""
    from ..files import scenarios

    if not _found(target):
        return target in scenarios()
    from ..files.reading import parsed, text_of

    with refusing():
        return "load" in parsed(text_of(Path(target)), target)


def read_muscle(target: str, instead: str) -> "Muscle":
    """The muscle in a file, or that is a named example.

    **Arguments:**

    - `target`: a path, or a name [-].
    - `instead`: what is to be done with a bundle, in words [-].

    **Returns:** the muscle [-].
    """
    found = read_target(target)
    if is_bundle(found):
        raise UserError(f"{target}: a bundle, not a muscle: {instead}.")
    return found


def read_bundle(target: str, unsupplied: bool = False) -> "Bundle":
    """The bundle in a file, or that is a named example; a muscle alone is a bundle of one.

    **Arguments:**

    - `target`: a path, or a name [-].
    - `unsupplied`: whether it is to have a supply pressure of its own [-], which a muscle hasn't.

    **Returns:** the bundle [-].
    """
    found = read_target(target)
    if unsupplied and not is_bundle(found):
        raise UserError(
            "--supply: missing, a muscle has none of its own: give one, such as --supply 400kPa."
        )
    from ..bundle import Bundle, MotorUnit  # only now: JAX is made ready first

    return found if is_bundle(found) else Bundle([MotorUnit(found)])


def is_bundle(found: Any) -> bool:
    """Whether what was found [-] is a bundle."""
    from ..bundle import Bundle

    return isinstance(found, Bundle)


def read_states(texts: list[str] | None, bundle: "Bundle") -> list[list[float]]:
    """The pressures of a bundle's motor units, state by state.

    **Arguments:**

    - `texts`: each a pressure or a range for every unit, between commas [-]; ranges are
      combined. `None`: the fully activated end of each recruitment state.
    - `bundle`: whose [-].

    **Returns:** pressures [Pa], one for each motor unit in each state.
    """
    units = len(bundle.motor_units)
    if not texts:
        if bundle.supply_pressure is None:
            raise UserError("--pressure: missing, since the bundle has no supply pressure.")
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
        check_grid(*map(len, ranges), len(states) + 1)
        states += [list(state) for state in itertools.product(*ranges)]
    return states


def read_list(text: str, dimension: str, option: str) -> list[float]:
    """The values of an option.

    **Arguments:**

    - `text`: a list, a range or both [-].
    - `dimension`: what each is [-].
    - `option`: its name [-].

    **Returns:** the values [-].
    """
    with refusing():
        return parse_list(text, dimension, option)


def read_one(text: str, dimension: str, option: str) -> float:
    """The value of an option.

    **Arguments:**

    - `text`: a quantity [-].
    - `dimension`: what it is [-].
    - `option`: its name [-].

    **Returns:** the value [SI unit of the dimension].
    """
    with refusing():
        return parse(text, dimension, option)


def check_grid(*sizes: int) -> None:
    """Refuse a table of more than `MAX_GRID` points; `sizes` [-] are those of its sides."""
    total = 1
    for size in sizes:
        total *= size
    if total > MAX_GRID:
        raise UserError(
            f"{' x '.join(map(str, sizes))} points are more than {MAX_GRID}: take fewer."
        )


def _found(target: str) -> bool:
    """Whether there is such a file."""
    try:
        return Path(target).exists()
    except (OSError, ValueError):  # too long for a name, or a NUL in it
        return False


def _unknown(target: str, known: Iterable[str], kind: str, otherwise: str) -> UserError:
    near = difflib.get_close_matches(target, list(known), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]}?" if near else otherwise
    looks_like_path = "/" in target or "\\" in target or target.endswith(".toml")
    what = "no such file" if looks_like_path else f"no such file or named {kind}"
    shown = target if target.isprintable() else repr(target)
    shown = shown if len(shown) < 200 else f"{shown[:100]}…"
    end = f", {hint}" if near or not looks_like_path else "."
    return UserError(f"{shown}: {what}{end}")
