"""What `fascicle calibrate` does between its options and its results: read, then fit."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ...units import parse, pretty
from ..inputs import read_muscle, read_one
from ..problems import UserError, refusing
from ..startup import prepare
from ..telling import telling
from .calibrate_results import Found


if TYPE_CHECKING:
    from ...calibrate.after.calibration import Calibration
    from ...calibrate.problem.beginning import Prior
    from ...muscle import Muscle
    from ...records.columns import MissingMetadataError
    from ...records.record import Record

TUNING = "tuning"  # among what is to be fitted: the paper's way
INTERVALS = ("quick", "bootstrap")
_SIZES = {"length": "length", "outer_radius": "length", "wall_thickness": "length",
          "braid_angle": "angle"}  # fmt: skip


@dataclass(frozen=True)
class Begin:
    """The muscle to begin with: a file or an example, sizes and laws that win over it, as
    they were typed.
    """

    target: str | None
    sizes: Mapping[str, str | None]
    laws: Mapping[str, str | None]


@dataclass(frozen=True)
class Reading:
    """The data's files, and what they don't say themselves, as it was typed."""

    paths: list[str]
    rest_length: str | None
    units: Mapping[str, str]
    columns: Mapping[str, str]
    clipped_at_zero: bool
    header: int | None = None
    push_positive: bool = False


@dataclass(frozen=True)
class Search:
    """What is fitted, and how."""

    names: list[str] | None
    priors: Mapping[str, str]
    loss: str
    weights: str
    starts: int
    seed: int
    posterior: bool
    compare: bool
    profile: bool
    intervals: str = INTERVALS[0]


def calibrated(begin: Begin, reading: Reading, search: Search, drawn: bool) -> Found:
    """Read the data and fit the muscle.

    **Arguments:**

    - `begin`: the muscle [-].
    - `reading`: the data [-].
    - `search`: what is fitted [-].
    - `drawn`: whether figures are made [-].

    **Returns:** what was found [-].
    """
    muscle = _muscle(begin)
    record, remarks = _record(reading, float(muscle.length))
    _check(search)
    how = {"loss": search.loss, "weights": search.weights, "starts": search.starts,
           "seed": search.seed}  # fmt: skip
    with refusing(), telling("reading") as tell:
        priors = _priors(search.priors, muscle, search.names)
        if search.names is None:
            from ...calibrate.fits.finding import find

            choice = find(record, muscle, priors, **how, tell=tell)
            made, found = choice.made, Found(choice.made, remarks, choice)
        else:
            from ...calibrate.fits.fitting import fit

            tell("fitting")
            names = None if search.names == [TUNING] else search.names
            made = fit(record, muscle, names, priors, **how, whole=False)
            found = Found(made, remarks)
        if search.intervals == "bootstrap":
            from ...calibrate.after.bootstrap import bootstrap

            made = bootstrap(made, seed=search.seed, tell=tell)
            found = replace(found, made=made)
        from ...calibrate.after.profiling import with_profiles

        made = with_profiles(made)
        found = replace(found, made=made)
        if search.profile:
            from ...calibrate.after.profiling import profiles

            tell("profiling")
            found = replace(found, profiles=profiles(made))
        if search.posterior:
            from ...calibrate.after.posterior import sample

            tell("sampling")
            found = replace(found, posterior=sample(made, seed=search.seed))
        if search.compare:
            tell("comparing laws")
            found = replace(found, comparison=_compared(record, muscle, made, priors, how))
        if drawn:
            from ...calibrate.after.pictures import figures

            tell("drawing")
            pictures = figures(made, found.profiles, found.posterior)
            found = replace(found, figures=pictures)
    return found


def _muscle(begin: Begin) -> "Muscle":
    missing = [f"--{name.replace('_', '-')}" for name in _SIZES if begin.sizes[name] is None]
    if begin.target is None and missing:
        raise UserError(
            f"the muscle's sizes are needed: give --muscle FILE, or {', '.join(missing)}."
        )
    sizes = {
        name: read_one(text, _SIZES[name], f"--{name.replace('_', '-')}")
        for name, text in begin.sizes.items()
        if text is not None
    }
    laws: dict[str, Any] = {name: text for name, text in begin.laws.items() if text is not None}
    if begin.target is None:
        prepare()
        from ...muscle import Muscle

        with refusing():
            return Muscle.from_dimensions(**sizes, **laws)
    muscle = read_muscle(begin.target, "give --muscle the file of one of its muscles")
    with refusing():
        return muscle.replace(**sizes, **laws)


def _record(reading: Reading, length: float) -> tuple["Record", tuple[str, ...]]:
    """The record, and what was assumed of it."""
    from ...records import join, load
    from ...records.columns import MissingMetadataError

    given = {
        "units": reading.units,
        "columns": reading.columns,
        "clipped_at_zero": True if reading.clipped_at_zero else None,
        "header": reading.header,
    }
    rest = None
    if reading.rest_length is not None:
        rest = read_one(reading.rest_length, "length", "--rest-length")
    assumed = False

    def one(path: str) -> "Record":
        nonlocal assumed
        try:
            return load(path, rest_length=rest, **given)
        except MissingMetadataError as error:
            if error.argument != "rest_length":
                raise
        # a length or displacement in a file that names no rest length
        record = load(path, rest_length=length, **given)
        assumed = True
        return record

    with refusing():
        try:
            record = join([one(path) for path in reading.paths])
        except MissingMetadataError as error:
            raise ValueError(f"{error.before}{_option(error)}{error.after}") from None
        record = replace(record, notes=tuple(map(_as_typed, record.notes)))
        if reading.push_positive:
            turned = "forces read with the other sign (--push-positive)"
            record = replace(record, force=-record.force, notes=(*record.notes, turned))
    if record.rest_length is None:
        record, assumed = replace(record, rest_length=length), True
    if not assumed:
        return record, ()
    return record, (
        f"rest length not given: strains are taken over the muscle's, {pretty(length, 'length')}",
    )


def _option(asked: "MissingMetadataError") -> str:
    """What is to be given, as this command's option."""
    name = {"columns": "--column", "units": "--unit", "rest_length": "--rest-length"}[
        asked.argument
    ]
    return f"{name} {asked.role}='{asked.value}'" if asked.role else name


def _as_typed(note: str) -> str:
    return note.replace("give clipped_at_zero = true", "give --clipped-at-zero")


def _check(search: Search) -> None:
    """Refuse what would only fail after the fit."""
    if search.names is not None and TUNING in search.names and len(search.names) > 1:
        raise UserError(f"--fit {','.join(search.names)}: {TUNING} stands alone.")
    from ...core.validation import check_choice

    with refusing():
        check_choice(search.intervals, INTERVALS, "intervals")
    if search.intervals == "bootstrap" and search.loss != "linear":
        raise UserError(
            "--intervals bootstrap: needs --loss linear, a robust loss is no model of noise."
        )
    if not search.posterior:
        return
    from importlib.util import find_spec

    if search.loss != "linear":
        raise UserError("--posterior: needs --loss linear, a robust loss is no model of noise.")
    if find_spec("numpyro") is None:
        from ...calibrate.after.posterior import INSTALL

        raise UserError(INSTALL)


def _priors(
    texts: Mapping[str, str], muscle: "Muscle", names: list[str] | None
) -> dict[str, "Prior"]:
    from ...calibrate.problem.beginning import Prior
    from ...calibrate.problem.parameters import named
    from ...core.errors import InvalidInputError

    out = {}
    for name, text in texts.items():
        try:
            dimension = named([name], muscle)[0].dimension
        except InvalidInputError as error:
            raise InvalidInputError("prior", error.rule, name, error.remedy, shown="") from None
        if names not in (None, [TUNING]) and name not in names:
            named(names, muscle)  # a slip there is the cause
            raise UserError(
                f"--prior {name}={text}: {name} isn't fitted: add it to --fit, or drop the prior."
            )
        parts = text.split(",")
        if len(parts) != 2:
            raise UserError(
                f"--prior {name}={text}: write a value and its standard deviation, between them"
                " a comma."
            )
        out[name] = Prior(*(parse(part, dimension, f"--prior {name}") for part in parts))
        if out[name].deviation <= 0:
            rule = "its standard deviation must be positive, got"
            raise UserError(f"--prior {name}={text}: {rule} {parts[1].strip()}.")
    return out


def _compared(
    record: "Record", muscle: "Muscle", made: "Calibration", priors: Any, how: dict[str, Any]
) -> list[Any]:
    """Laws side by side: of what resists where that was fitted, else of tension."""
    from ...calibrate.fits import comparing

    if made.method == "constants" or made.taken.pulls:
        names = list(made.names) if made.method == "constants" else None
        return comparing.compare_tension(record, muscle, names, priors, **how, whole=False)
    return comparing.compare(record, muscle, list(made.names), priors, **how)
