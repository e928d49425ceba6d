"""Choose a muscle for a tendon: which, how many in parallel, how long, and which `rest_length`.

At the tendon's greatest length the muscle is stretched by no more than it may be; all shorter poses
contract it. A longer muscle contracts by a smaller share, and pulls more, so that the shortest one
whose pull at the supply's pressure has the margin in each pose is chosen. Among muscles and
numbers of them in parallel, the one that fills with the least fluid.

**Sign:** a moment arm is positive where a pull on the tendon raises the joint's coordinate; it is
the negative derivative of the tendon's length, as in OpenSim. MuJoCo's `actuator_moment` has the
other sign for an actuator that pushes.

**Assumes** rigid cords, that nothing else moves the joint, and that the muscle's law holds for
other lengths.
"""

import itertools
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from ..bundle import Bundle, MotorUnit
from ..core.errors import InvalidInputError
from ..core.types import Values
from ..core.validation import HIGHEST_PRESSURE, check_choice, check_interval, check_positive
from ..files import catalog
from ..files.measured_muscles import CatalogEntry
from ..muscle import Muscle
from ..repr_table import ReprTable, with_table_repr
from .attach import check_model
from .optional_imports import Model, mujoco


_LONGEST = 8.0  # strokes, where no room is given: a longer muscle contracts by less than 12.5 %
_HALVINGS = 30  # of the length's range: to a millionth of it
_STEP = 1e-5  # rad or m, of central differences: the length is known to 1e-16 m
_MOVES = 1e-6  # m/rad or m/m, the least moment arm that counts

Ranges = dict[str, Sequence[Values]]  # ends of joints' coordinates by name [rad or m]


class Route(NamedTuple):
    """A tendon's way: names of the `joints` that move it, their coordinates in `poses`, a row for
    each [rad or m], and of each pose the tendon's `lengths` [m] and `moment_arms` about the
    `torque_joint` [m, or - of a slide]. `spatial`: true of a tendon that has a path.
    """

    joints: tuple[str, ...]
    torque_joint: str
    poses: np.ndarray
    lengths: np.ndarray
    moment_arms: np.ndarray
    hinge: bool
    spatial: bool

    @property
    def coordinate(self) -> np.ndarray:
        """Coordinate of the torque's joint in each pose [rad or m]."""
        return self.poses[:, self.joints.index(self.torque_joint)]

    def format_coordinate(self, index: int) -> str:
        """Coordinate of the torque's joint in the pose `index`, with its unit."""
        value = float(self.coordinate[index])
        return f"{np.rad2deg(value):.0f} deg" if self.hinge else f"{1e3 * value:.1f} mm"


def trace_route(
    model: Model, tendon: str, joint: str | None, ranges: Ranges | None, points: int
) -> Route:
    """Trace a `tendon` of MuJoCo's compiled `model` over `points` of each joint that moves it;
    arguments are those of `size`. `InvalidInputError` for unknown names, and joints without range.
    """
    names = [model.tendon(i).name for i in range(model.ntendon)]
    index = names.index(check_choice(tendon, names, "tendon"))
    data = mujoco.MjData(model)

    def length(coordinates: dict[str, float]) -> float:
        data.qpos[:] = model.qpos0
        for name, value in coordinates.items():
            data.qpos[addresses[name]] = value
        mujoco.mj_fwdPosition(model, data)
        return float(data.ten_length[index])

    def moves_tendon(name: str) -> bool:
        """True if the joint changes the tendon's length over its range."""
        low, high = limits[name] or (-0.5, 0.5)
        # a wrapped tendon may leave a joint here and there
        lengths = [length({name: value}) for value in np.linspace(low, high, 7)]
        return float(np.ptp(lengths)) > _MOVES * (high - low)

    hinge, slide = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
    single = [model.joint(i) for i in range(model.njnt) if model.jnt_type[i] in {hinge, slide}]
    is_hinge = {x.name: int(x.type[0]) == hinge for x in single}
    addresses = {x.name: int(x.qposadr[0]) for x in single}
    limits: dict[str, tuple[float, float] | None] = {
        x.name: (float(x.range[0]), float(x.range[1])) if model.jnt_limited[x.id] else None
        for x in single
    }
    for name, ends in (ranges or {}).items():
        unit = "rad" if is_hinge[check_choice(name, is_hinge, "joint")] else "m"
        values = [check_interval(x, -np.inf, np.inf, "ranges", unit) for x in ends]
        limits[name] = float(min(values)), float(max(values))
    joints = [name for name in limits if moves_tendon(name)]
    if not joints:
        rule = f"{tendon!r} isn't moved by any hinge or slide joint"
        raise InvalidInputError("tendon", rule, tendon, shown="")
    for name in (*(ranges or {}), *([] if joint is None else [joint])):
        check_choice(name, joints, "joint")
    if joint is None and len(joints) > 1:
        rule = f"must be named for {tendon!r}, which several move: {', '.join(joints)}"
        raise InvalidInputError("joint", rule, None)
    if free := [name for name in joints if limits[name] is None]:
        remedy = f"pass ranges={{{free[0]!r}: (low, high)}}, or limit it in the model"
        raise InvalidInputError("ranges", f"must have the joint {free[0]!r}", None, remedy)
    about = joint or joints[0]
    grids = [np.linspace(*(limits[name] or (0.0, 0.0)), points) for name in joints]
    poses = np.array(list(itertools.product(*grids)))
    # each pose, and those beside it
    steps = np.array([[0.0], [-_STEP], [_STEP]]) * (np.array(joints) == about)
    lengths, shorter, longer = np.array(
        [[length(dict(zip(joints, pose + step, strict=True))) for pose in poses] for step in steps]
    )
    fixed = int(model.wrap_type[model.tendon_adr[index]]) == int(mujoco.mjtWrap.mjWRAP_JOINT)
    arms = (shorter - longer) / (2 * _STEP)
    return Route(tuple(joints), about, poses, lengths, arms, is_hinge[about], not fixed)


@dataclass(frozen=True, eq=False)
class SizeTrial:
    """A muscle of a `length` [m] that was tried: its `name`, the `count` in parallel, the `margin`
    of its pull over the one that is needed [-], and the `fluid` that fills it [m³].
    """

    name: str
    muscle: Muscle
    count: int
    length: float
    rest_length: float
    margin: float
    fluid: float

    def pull(self, pressure: float, lengths: np.ndarray) -> np.ndarray:
        """Pull of all its muscles [N] at a `pressure` [Pa] and `lengths` of the tendon [m]."""
        strain = (self.rest_length - lengths) / self.length
        return self.count * np.asarray(self.muscle.force(pressure, strain))


def _sizing_table(sizing: "Sizing") -> ReprTable:
    route, chosen = sizing.route, sizing.chosen
    low, high = sizing.strains
    arms = 1e3 * route.moment_arms
    facts = [
        ("muscle", f"{chosen.count} × {chosen.name}, {1e3 * chosen.length:.0f} mm long"),
        ("rest_length", f"{1e3 * chosen.rest_length:.1f} mm of the tendon"),
        ("margin", f"{100 * chosen.margin:.0f} % at {sizing.pressure / 1e3:g} kPa"),
        ("tendon", f"{1e3 * route.lengths.min():.1f} to {1e3 * route.lengths.max():.1f} mm"),
        ("contraction", f"{100 * low:.1f} to {100 * high:.1f} %"),
        ("moment arm", f"{arms.min():.1f} to {arms.max():.1f} mm about {route.torque_joint}"),
    ]
    texts = "{0.count} × {0.name}", "{1:.0f}", "{2:.0f}", "{3:.3g}"
    rows = [
        [text.format(c, 1e3 * c.length, 100 * c.margin, 1e6 * c.fluid) for text in texts]
        for c in sizing.candidates
    ]
    heads = ("muscle", "length [mm]", "margin [%]", "fluid [mL]")
    return ReprTable(f"A muscle for {sizing.tendon!r}", facts, heads, rows)


@with_table_repr(
    _sizing_table, lambda s: f"<Sizing of {s.tendon!r}: {s.chosen.count} × {s.chosen.name}>"
)
@dataclass(frozen=True, eq=False)
class Sizing:
    """A muscle for a `tendon`, from `size`.

    `route`: of the tendon. `torque`: the one asked for in each pose [N·m, or N of a slide].
    `pressure`: of the supply [Pa]. `candidates`: muscles that have the margin, least fluid first.
    """

    tendon: str
    route: Route
    torque: np.ndarray
    pressure: float
    candidates: tuple[SizeTrial, ...]

    @property
    def chosen(self) -> SizeTrial:
        """The candidate that takes the least fluid."""
        return self.candidates[0]

    @property
    def rest_length(self) -> float:
        """Tendon's length with the muscle at rest [m], for `attach`."""
        return self.chosen.rest_length

    @property
    def bundle(self) -> Bundle:
        """Chosen muscles, one motor unit, for `attach`."""
        return Bundle([MotorUnit(self.chosen.muscle, self.chosen.count)], self.pressure)

    @property
    def strains(self) -> tuple[float, float]:
        """Least and largest strain of the chosen muscle [-]."""
        strains = (self.rest_length - self.route.lengths) / self.chosen.length
        return float(strains.min()), float(strains.max())

    @property
    def available_torque(self) -> np.ndarray:
        """Torque of the chosen muscles at the supply's pressure in each pose [N·m or N]."""
        pull = self.chosen.pull(self.pressure, self.route.lengths)
        return self.route.moment_arms * pull


def size(
    model: Model,
    tendon: str,
    muscles: Any,
    torque: Values | Callable[[np.ndarray], Values],
    pressure: Values,
    joint: str | None = None,
    ranges: Ranges | None = None,
    points: int = 21,
    counts: Sequence[int] = (1, 2, 3, 4),
    margin: float = 0.2,
    stretch: float = 0.0,
    longest: Values = None,
) -> Sizing:
    """Size a muscle to a tendon.

    **Arguments:**

    - `model`: MuJoCo's `MjModel`, or an `MjSpec`, which is compiled.
    - `tendon`: name of a fixed or a spatial tendon.
    - `muscles`: one; names of measured ones; `fascicle.catalog`; or pairs of a name and a muscle.
      Their lengths don't count.
    - `torque`: asked for about the joint [N·m], positive where it raises the coordinate; one, one
      for each pose, or a function of the poses, rows of coordinates of all joints that move the
      tendon [rad]. Of a slide, a force [N].
    - `pressure`: of the supply [Pa].
    - `joint`: the torque's; may be left out if one joint moves the tendon.
    - `ranges`: ends of joints' coordinates by name [rad or m]; left out, the model's limits.
    - `points`: of each joint's range [-].
    - `counts`: numbers of muscles in parallel that are tried [-].
    - `margin`: least share of pull above the one that is needed [-].
    - `stretch`: strain by which the muscle may be stretched [-].
    - `longest`: room for its length [m]; left out, eight strokes, or a spatial tendon's length.

    **Raises:** `InvalidInputError`, which says what would help, if none will do.
    """
    check_model(model, "model", ("MjModel", "MjSpec"))
    if hasattr(model, "compile"):
        model = model.compile()
    P = float(check_interval(pressure, 0.0, HIGHEST_PRESSURE, "pressure", "Pa"))
    stretch = float(check_interval(stretch, 0.0, 0.1, "stretch", "-", closed=(True, True)))
    route = trace_route(model, tendon, joint, ranges, int(points))
    demand = _demand(route, torque)
    pull = _needed_pull(route, demand, tendon)
    active = pull > 0
    stroke, end = float(np.ptp(route.lengths)), float(route.lengths.max())
    if longest is not None:
        room = float(check_positive(longest, "longest", "m"))
    else:  # at rest the muscle is no longer than a spatial tendon
        room = min(_LONGEST * stroke, end / (1 + stretch) if route.spatial else np.inf)

    def trial(name: str, muscle: Muscle, count: int, length: float) -> SizeTrial:
        sized, rest_length = muscle.replace(length=length), end - stretch * length
        fluid = count * float(sized.volume(0.0))
        trial = SizeTrial(name, sized, count, length, rest_length, 0.0, fluid)
        ratios = trial.pull(P, route.lengths[active]) / pull[active]
        return replace(trial, margin=float(np.min(ratios)) - 1.0)

    def shortest(name: str, muscle: Muscle, count: int) -> SizeTrial:
        """The shortest one that has the margin, or else the longest."""
        best, low = trial(name, muscle, count, room), 0.0
        for _ in range(_HALVINGS if best.margin >= margin else 0):
            middle = (low + best.length) / 2
            try:
                tried = trial(name, muscle, count, middle)
            except InvalidInputError:  # too short for its radius, or its contraction
                low = middle
                continue
            low, best = (low, tried) if tried.margin >= margin else (middle, best)
        return best

    named, trials = _named(muscles), []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of each length that is tried
        for name, entry in named.items():
            with suppress(InvalidInputError):  # its law refuses even the longest one
                trials += [shortest(name, _muscle_of(entry), count) for count in counts]
    good = sorted((x for x in trials if x.margin >= margin), key=lambda x: x.fluid)
    if not good:
        room_text = f"{1e3 * stroke:.0f} mm in {1e3 * room:.0f} mm of room"
        rule = f"have none for {tendon!r} and its stroke of {room_text}"
        raise InvalidInputError("muscles", rule, None, _remedy(trials, margin, P))
    sizing = Sizing(tendon, route, demand, P, tuple(good))
    sizing.chosen.muscle.replace()  # warns if its law was fitted at another length
    entry = named[sizing.chosen.name]
    if isinstance(entry, CatalogEntry) and entry.extrapolations(P, sizing.strains[1]):
        text = f"{entry.name}: an extrapolation, it was measured at {entry.range}."
        warnings.warn(text, stacklevel=2)
    return sizing


def _named(muscles: Any) -> Mapping[str, Muscle | CatalogEntry]:
    """Muscles, or entries of the catalog, by name."""
    if isinstance(muscles, Muscle):
        return {"muscle": muscles}
    try:
        entries = [muscles] if isinstance(muscles, str) else muscles
        entries = muscles.items() if isinstance(muscles, Mapping) else entries
        named = dict((x, catalog[x]) if isinstance(x, str) else x for x in entries)
        _ = [_muscle_of(entry).length for entry in named.values()]
    except InvalidInputError:
        raise
    except (TypeError, ValueError, AttributeError):
        rule = "must be a muscle, names, or pairs of a name and a muscle"
        kind = type(muscles).__name__
        raise InvalidInputError("muscles", rule, None, shown=kind) from None
    return named


def _muscle_of(entry: Muscle | CatalogEntry) -> Muscle:
    """The muscle of an `entry` of the catalog, or itself."""
    return entry if isinstance(entry, Muscle) else entry.muscle


def _demand(route: Route, torque: Values | Callable[[np.ndarray], Values]) -> np.ndarray:
    """Torque that is asked for in each pose [N·m or N]."""
    values = torque(route.poses) if callable(torque) else torque
    unit = "N*m" if route.hinge else "N"
    values = check_interval(values, -np.inf, np.inf, "torque", unit)
    if np.shape(values) not in {(), (len(route.poses),)}:
        rule = f"must be one, or one for each of the {len(route.poses)} poses"
        raise InvalidInputError("torque", rule, None, shown=f"the shape {np.shape(values)}")
    values = np.broadcast_to(values, len(route.poses)) + 0.0
    if not values.any():
        raise InvalidInputError("torque", "must not vanish in all poses", 0.0)
    return values


def _needed_pull(route: Route, demand: np.ndarray, tendon: str) -> np.ndarray:
    """Pull that gives the `demand` in each pose [N]; refused where the tendon turns the joint the
    other way.
    """
    wrong = (demand * route.moment_arms <= 0) & (demand != 0)
    if wrong.any():
        i = int(np.argmax(np.where(wrong, np.abs(demand), 0.0)))
        arm, unit = 1e3 * route.moment_arms[i], "N·m" if route.hinge else "N"
        where = f"{route.torque_joint} at {route.format_coordinate(i)}"
        rule = f"must have the sign of the moment arm of {tendon!r}, {arm:.1f} mm with {where}"
        side = "a muscle pulls only: route the tendon on the joint's other side"
        remedy = f"{side}, or ask for torques of that sign only (zero elsewhere)"
        text = f"{demand[i]:.3g} {unit}"
        raise InvalidInputError("torque", rule, float(demand[i]), remedy, shown=text)
    return np.divide(demand, route.moment_arms, out=np.zeros_like(demand), where=demand != 0)


def _remedy(trials: list[SizeTrial], margin: float, pressure: float) -> str:
    """Remedy where no trial has the margin."""
    best = max(trials, key=lambda x: x.margin, default=None)
    if best is None or best.margin <= -1.0:
        text = "they contract past their free strain: give more room (`longest`), a smaller moment"
        return f"{text} arm, which shortens the stroke, or let them be stretched (`stretch`)"
    min_count = math.ceil(best.count * (1 + margin) / (1 + best.margin))
    text = f"the best, {best.count} × {best.name}, has a margin of {100 * best.margin:.0f} %"
    text += f" where {100 * margin:.0f} % is asked for: take {min_count} in parallel (`counts`),"
    return f"{text} thicker ones, more than {pressure / 1e3:g} kPa, or more room (`longest`)"
