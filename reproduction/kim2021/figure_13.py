"""Fig. 13: free strain of a bundle against the pressure of its second unit, by four models."""

import equinox as eqx
import numpy as np
from matplotlib.figure import Figure

from fascicle.bundle import Bundle
from fascicle.bundle.reversal import Reversal, free_strain_curve, reversal
from fascicle.muscle import Muscle
from fascicle.muscle.tension.ideal import Ideal
from fascicle.plot.curves import draw_free_strain
from fascicle.plot.jumps import broken
from fascicle.plot.style import BLACK, GRAY, SINGLE, new_figure, styled
from fascicle.results.labelled import Variable

from ..claims import Claim, Criterion, over
from ..reproduced import Record
from . import setting


POINTS = 129
PRESSURES = np.linspace(0.0, setting.UNIT_1, POINTS)
SHORTER, WEAKER = (
    0.95,
    0.9,
)  # illustrative: a muscle's free strain and blocked force, over the model's
IDEAL, KLUTE = "ideal", "Klute–Hannaford"
CORRECTED, RESISTING = "corrected, no resistance", "corrected, with resistance"
LOOSE, TIGHT = "illustrative tuning, no resistance", "illustrative tuning, with resistance"


@setting.cached
def curves() -> dict[str, np.ndarray]:
    """Free strain over unit 2's pressure, by model; computed once."""
    plain, tuned = setting.muscle("figure_6"), setting.muscle("slenderness_10")
    ideal = eqx.tree_at(lambda m: m.tension, plain, Ideal())
    return {
        IDEAL: _curve(ideal, resistance=False),
        KLUTE: _curve(plain, resistance=False),
        CORRECTED: _curve(tuned, resistance=False),
        RESISTING: _curve(tuned, resistance=True),
        LOOSE: _curve(illustrative(), resistance=False),
        TIGHT: _curve(illustrative(), resistance=True),
    }


@setting.cached
def turning() -> Reversal:
    """The reversal point with resistance, computed once."""
    return reversal(pair(setting.muscle("slenderness_10")))


def illustrative(shorter: float = SHORTER) -> Muscle:
    """Slenderness 10 with (34) and (35) of a muscle that is a little weaker, and whose free strain
    is `shorter` [-] times the model's.
    """
    muscle = setting.muscle("slenderness_10")
    P = setting.TABLE[1:]  # at zero both are 0/0, and the identity
    mesh, bladder = muscle.tension.components(
        muscle.bladder, P, shorter * np.asarray(muscle.free_strain(P))
    )
    c1 = np.asarray(mesh) + np.asarray(bladder)
    blocked = np.asarray(muscle.blocked_force(P))
    c2 = WEAKER * blocked / (blocked - c1)
    tuning = setting.tuned(muscle.tuning, np.r_[0.0, c1], np.r_[1.0, c2])
    return eqx.tree_at(lambda m: m.tuning, muscle, tuning)


def pair(of: Muscle) -> Bundle:
    """Two motor units of one muscle each, unit 1 at its pressure of section 6."""
    return setting.bundle(of, (1, 1), setting.UNIT_1)


def _curve(of: Muscle, resistance: bool) -> np.ndarray:
    return free_strain_curve(pair(of), 2, PRESSURES, resistance=resistance)


def compute() -> Record:
    """The four models, and one illustrative tuning."""
    found, turn = curves(), turning()
    muscle = setting.muscle("slenderness_10")
    return Record(
        key="figure_13",
        title="Fig. 13. Bundle free strain by four models",
        conditions=(
            f"Two motor units of one muscle each, unit 1 at {setting.UNIT_1 / 1e3:g} kPa: "
            f"{setting.sizes(muscle)}, with Table 1's factors for slenderness 10.",
            f"{setting.UNTUNED} So the second and the third model coincide.",
            f"Illustrative, and not measured: a muscle whose free strain is {SHORTER:g} and whose "
            f"blocked force {WEAKER:g} times the model's at every pressure, tuned by (31) to (35).",
        ),
        data={
            "pressure": Variable(("pressure",), PRESSURES, "Pa", "motor unit 2's"),
            **{
                _key(name): Variable(("pressure",), values, "-", f"free strain, {name}")
                for name, values in found.items()
            },
        },
        draw=lambda: draw(found, turn),
        claims=(*claims(found, turn), lone_claim(*lone()), tuning_claim(*factors())),
        missing="The measured points exist only in the paper's picture; none are drawn here, and "
        "their distance from the model (within 10 %, one within 15 %) can't be checked.",
    )


def _key(name: str) -> str:
    return name.replace(", ", "_").replace(" ", "_").replace("–", "_").lower()


@styled
def draw(found: dict[str, np.ndarray], turn: Reversal) -> Figure:
    """One panel, the reversal point marked."""
    figure, axes = new_figure(width=SINGLE, height=0.9 * SINGLE)
    ax = axes[0, 0]
    styles = ("-", "-", (0, (5, 4)), "-", (0, (5, 4)), "-")
    draw_free_strain(ax, PRESSURES, found, "$P_2$")
    for line, style in zip(ax.lines, styles, strict=True):
        line.set_linestyle(style)
    for line, color in zip(ax.lines, (GRAY, None, None, BLACK, None, None), strict=True):
        if color is not None:
            line.set_color(color)
    line = ax.lines[list(found).index(RESISTING)]
    curve, jump = broken(PRESSURES, found[RESISTING], turn)
    line.set_data(curve[0] / 1e3, curve[1])
    ax.plot(jump[0] / 1e3, jump[1], color=BLACK, linestyle=":")
    ax.plot(turn.pressure / 1e3, turn.free_strain, "o", color=BLACK, markersize=4)
    ax.annotate(
        "reversal", (turn.pressure / 1e3, turn.free_strain), (6, -8), ha="left",
        textcoords="offset points",
    )  # fmt: skip
    ax.set_ylim(0.205, 0.32)
    # between the ideal model and the others nothing is drawn
    ax.legend(loc="center", bbox_to_anchor=(0.5, 0.68), borderpad=0)
    return figure


def claims(found: dict[str, np.ndarray], turn: Reversal) -> tuple[Claim, ...]:
    """What the paper says of Fig. 13, of free strains [-] by model and the reversal point."""
    return (_reversal_claim(turn), _flat_claim(found), _stronger_claim(turn), _apart_claim(found))


def _reversal_claim(turn: Reversal) -> Claim:
    way = ", at last by a jump," if turn.jump else ""
    return Claim(
        key="free_strain_gradient_reversal",
        where="section 6, Fig. 13",
        kind="prediction",
        text="With resistance, as unit 2's pressure rises from zero the bundle's free strain "
        "first falls, then turns and rises.",
        quote="the free strain continues to decrease, until eventually, the kinematic forces "
        "generated by the FAM in MU 2 overcome the resistive forces, and free strain begins to "
        "increase",
        criteria=(
            Criterion(
                "fall of the free strain", turn.depth, ">", 1e-3,
                ours="a thousandth of the length; the paper gives no number",
            ),
            Criterion(
                "pressure where it turns over unit 1's", turn.pressure / setting.UNIT_1, "<", 1.0
            ),
        ),
        model=f"It falls from {turn.initial:.4f} by {turn.depth:.4f}{way} until P₂ = "
        f"{turn.pressure / 1e3:.1f} kPa, then rises.",
    )  # fmt: skip


def _flat_claim(found: dict[str, np.ndarray]) -> Claim:
    falls = {name: float(found[name][0] - found[name].min()) for name in (IDEAL, KLUTE, CORRECTED)}
    return Claim(
        key="no_reversal_without_resistance",
        where="section 6, Fig. 13",
        kind="definition",
        text="Models that neglect resistance don't show it.",
        quote="previous models did not capture the gradient reversal phenomenon",
        criteria=(
            Criterion(
                "largest fall of the free strain", max(falls.values()), "<", 1e-9,
                ours="roots are found to 1e-12",
            ),
        ),
        model="They can't: a unit that never pushes doesn't shorten the reach. "
        + ", ".join(f"{name} falls by {fall:.1g}" for name, fall in falls.items())
        + ".",
    )  # fmt: skip


def _stronger_claim(turn: Reversal) -> Claim:
    parts = setting.forces("slenderness_10")
    low = np.array([np.interp(turn.initial, parts.strain, row) for row in parts.force[:-1]])
    worst = int(np.argmin(low))
    return Claim(
        key="low_pressure_resists_more",
        where="section 6",
        kind="prediction",
        text="Muscles at low pressure resist more than inactive ones.",
        quote="resistive forces are stronger in low-pressure FAMs than in inactive FAMs",
        criteria=(
            Criterion("largest resistance over that without pressure", over(low[worst], low[0]),
                      ">", 1.0),
        ),
        model=f"At ε = {turn.initial:.3f} one muscle pushes with {-low[0]:.2f} N at 0 kPa and "
        f"{-low[worst]:.2f} N at {parts.pressure[worst] / 1e3:g} kPa.",
    )  # fmt: skip


def _apart_claim(found: dict[str, np.ndarray]) -> Claim:
    apart = float(np.abs(found[KLUTE] - found[CORRECTED]).max())
    return Claim(
        key="corrected_curve_differs",
        where="section 6, Fig. 13",
        kind="input",
        text="The corrected Klute–Hannaford model gives another curve than the uncorrected one.",
        quote="the corrected Klute–Hannaford model neglecting resistive force",
        criteria=(
            Criterion("largest difference of free strain", apart, ">", 1e-6, ours="rounding"),
        ),
        model=f"They differ by {apart:.1g} of strain.",
        chosen="C₁(P) and C₂(P): the identity, for want of the paper's.",
        why="The correction is C₁(P) and C₂(P), which the paper shows nowhere; the identity "
        "stands for them here. The illustrative tuning shows the kind of change that they make.",
    )


def lone() -> tuple[float, float, float]:
    """Free strain of 1 + 1 with unit 2 inactive, and of one muscle alone [-], at unit 1's pressure;
    and the largest force of the bundle over that of the muscle, strain by strain up to there [N].
    """
    muscle = setting.muscle("slenderness_10")
    alone = float(muscle.free_strain(setting.UNIT_1))
    strain = np.linspace(0.0, alone, 101)[1:]
    together = pair(muscle).force([setting.UNIT_1, 0.0], strain)
    gain = setting.array(together) - setting.array(muscle.force(setting.UNIT_1, strain))
    return turning().initial, alone, float(gain.max())


def lone_claim(bundle: float, alone: float, gain: float) -> Claim:
    """What the paper says of a bundle beside one muscle: free strains of the `bundle` and of one
    `alone` [-], and the largest `gain` of force [N].
    """
    return Claim(
        key="bundle_below_a_single_muscle",
        where="section 1",
        kind="prediction",
        text="With an inactive unit beside it, a muscle's free strain and force are lower than "
        "alone.",
        quote="resulting in a bundle force output and free strain that is lower than what would be "
        "predicted using a model or experimental characterization of a single FAM",
        criteria=(
            Criterion("free strain of 1 + 1 over that of one", over(bundle, alone), "<", 1.0),
            Criterion("largest force of 1 + 1 less that of one, at a strain", gain, "<", 0.0, "N"),
        ),
        model=f"At {setting.UNIT_1 / 1e3:g} kPa the free strain is {bundle:.4f} in 1 + 1 and "
        f"{alone:.4f} alone; at no strain is the force less than {-gain:.2g} N lower.",
    )  # fmt: skip


def factors() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """C₁ [N] and C₂ [-] by (34) and (35) of a muscle that contracts less than the model; and C₁ [N]
    of one that contracts more by as much.
    """
    less, more = illustrative().tuning, illustrative(2.0 - SHORTER).tuning
    c1, c2, opposite = (setting.array(one)[1:] for one in (less.c1, less.c2, more.c1))
    return c1, c2, opposite


def tuning_claim(c1: np.ndarray, c2: np.ndarray, opposite: np.ndarray) -> Claim:
    """What the paper says of its tuning: of `c1` [N] and `c2` [-] over pressure of a muscle that
    contracts less than the model, and of the `opposite` C₁ [N] of one that contracts more.
    """
    return Claim(
        key="tuning_factors_are_positive",
        where="section 5.1",
        kind="definition",
        text="C₁ and C₂ are positive: by (34) and (35), of a muscle whose free strain the model "
        "overpredicts.",
        quote="Both factors are greater than zero and have no upper bound",
        criteria=(
            Criterion(f"least C₁, free strain {SHORTER:g} times", float(c1.min()), ">", 0.0, "N"),
            Criterion("least C₂ of the same", float(c2.min()), ">", 0.0),
            Criterion(
                f"largest C₁, free strain {2 - SHORTER:g} times", float(opposite.max()), "<", 0.0,
                "N", ours="where it is not overpredicted, the statement can't hold",
            ),
        ),
        model=f"C₁ from {c1.min():.2f} to {c1.max():.2f} N and C₂ from {c2.min():.2f} to "
        f"{c2.max():.2f} for a muscle that contracts and pulls less than the model. The identity "
        "that stands for the paper's tables in Figs 12 to 14 has C₁ = 0 and C₂ = 1.",
    )  # fmt: skip
