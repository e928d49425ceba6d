r"""Force that the next motor unit takes before it pulls.

At the strain $\varepsilon$ the units before $k$ are at the supply's pressure, unit $k$ is
throttled, later ones are vented. As the next one is pressurized, it adds

$$g(p) = n_{k+1} \left[F_{k+1}(p, \varepsilon) - F_{k+1}(0, \varepsilon)\right], \tag{X1}$$

which is negative at first past its free strain: a pressurized muscle resists more. Its dip is
$D = -\min g$, at $p_d$; it ends at the onset $p_{on}$, the last root of $g$. Without that unit the
bundle holds at most

$$F_{max} = \sum_{i \le k} n_i F_i(P_s, \varepsilon) + \sum_{i > k} n_i F_i(0, \varepsilon),
  \qquad \rho = F_{max} - F_{demand} \tag{X2}$$

is its reserve, out of which unit $k$ makes up for the dip: quasi-statically there is none if and
only if $\rho \ge D$ while the next unit is pressurized. While the demand rises by $\dot F$, and the
hand-over takes $t_c$, the reserve when it begins must be

$$\rho \ge \max_{p \le p_{on}} \left[-g(p) + \dot F\, t_c\, \frac{p}{p_{on}}\right]. \tag{X3}$$

**Sign:** pulling force positive. **Source:** derived here, from the force law of Kim, Mazzoleni and
Bryant (2021); Kim and Bryant (2025) compensate the resisting force by a model, in hardware.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import elementwise

from ..bundle.bundle import Bundle
from ..bundle.pressurized import muscle_strain
from ..bundle.states import resolve_supply_pressure
from ..core.array_namespace import slices
from ..core.errors import InvalidInputError
from ..core.types import Batch, Values
from ..core.validation import HIGHEST_PRESSURE, check_finite, check_interval, check_nonnegative


_GRID = 129  # pressures that bracket a dip and its end, even in √p: finer than any fold of a law
_FRACTIONS = 513  # of an onset, for a rising demand: the grid's error is below 1e-5 of the dip
_BATCH = 50_000  # points of a law in one call, of some 2 µs each


class Transition(NamedTuple):
    """Transition to the next unit at each strain, (X1): depth of the `dip`, $D$ [N], the next
    unit's pressure at it, `dip_pressure` [Pa], and at its end, `onset_pressure` [Pa], inf if it has
    no end up to the supply's, and the `largest_force` of the units before [N].
    """

    dip: Batch
    dip_pressure: Batch
    onset_pressure: Batch
    largest_force: Batch


def added_force(bundle: Bundle, pressure: Values, strain: Values, unit: int = 2) -> Batch:
    """Force $g$ [N] that a `unit` of the `bundle`, counted from 1, adds at its gauge `pressure`
    [Pa] and a `strain` of the bundle [-], (X1); `InvalidInputError` for values off the domain.
    """
    check_unit(bundle, unit, first=1)
    P = check_interval(pressure, 0.0, HIGHEST_PRESSURE, "pressure", "Pa", "(gauge)", (True, True))
    return _added_force(bundle, unit, P, unit_strain(bundle, unit, strain))


def transition(
    bundle: Bundle, strain: Values, unit: int = 2, supply_pressure: Values = None
) -> Transition:
    """Dip of force of a `bundle` as its next `unit`, counted from 1, is pressurized at a `strain`
    [-]: a `Transition` [N], [Pa] of its shape. `supply_pressure` [Pa]: left out, the bundle's own.

    `InvalidInputError` for a unit that isn't among the second to the last, and values off the
    domain.
    """
    check_unit(bundle, unit)
    supply = resolve_supply_pressure(bundle, supply_pressure)
    eps = unit_strain(bundle, unit, strain)
    flat = np.reshape(eps, -1)
    parts = slices(len(flat), max(1, _BATCH // _GRID))
    batches = [_dip(bundle, unit, flat[part], supply) for part in parts]
    dip, pressure, onset = (
        np.concatenate(row).reshape(np.shape(eps))[()] for row in zip(*batches, strict=True)
    )
    pressures = np.where(np.arange(len(bundle.motor_units)) < unit - 1, supply, 0.0)
    return Transition(dip, pressure, onset, bundle.force(pressures, strain))


def needed_reserve(
    bundle: Bundle,
    strain: Values,
    force_rate: Values,
    time: Values,
    unit: int = 2,
    supply_pressure: Values = None,
) -> Batch:
    """Reserve [N] at which a hand-over must begin, (X3): the largest sum of lost force and
    risen demand up to the onset, inf if the unit gains nothing up to the supply's pressure.
    `force_rate` of the demand [N/s], `time` $t_c$ of the hand-over [s], zero or more; other
    arguments and errors as of `transition`: `strain` [-], `supply_pressure` [Pa].
    """
    rise = check_finite(force_rate, "force_rate", "N/s") * check_nonnegative(time, "time", "s")
    supply = resolve_supply_pressure(bundle, supply_pressure)
    state = transition(bundle, strain, unit, supply)
    gains = np.isfinite(state.onset_pressure)
    onset = np.where(gains, state.onset_pressure, supply)
    fraction = np.linspace(0.0, 1.0, _FRACTIONS)
    eps = np.asarray(unit_strain(bundle, unit, strain))[..., None]
    loss = -_added_force(bundle, unit, onset[..., None] * fraction, eps)
    need = np.max(loss + np.asarray(rise)[..., None] * fraction, axis=-1)
    # between the grid's pressures the dip itself is deeper, often a kink
    dip_fraction = np.where(gains, state.dip_pressure / np.maximum(onset, 1.0), 0.0)
    need = np.maximum(need, state.dip + rise * dip_fraction)
    return np.where(gains, np.maximum(need, 0.0), np.inf)[()]


def check_unit(bundle: Bundle, unit: int, first: int = 2) -> None:
    """Raise for a `unit` of the `bundle` that isn't among the `first` to the last."""
    count = len(bundle.motor_units)
    if isinstance(unit, bool) or unit != int(unit) or not first <= unit <= count:
        raise InvalidInputError("unit", f"must be a whole number in [{first}, {count}]", unit)


def unit_strain(bundle: Bundle, unit: int, strain: Values) -> Batch:
    """Strain of a unit's muscles [-] at a `strain` of the plates [-], (B7): it differs for muscles
    that are longer or shorter than the `bundle`. `unit` counts from 1.
    """
    eps = bundle._check_strain(strain)
    return eps if bundle.ratios is None else muscle_strain(bundle.ratios[..., unit - 1], eps)


def _added_force(bundle: Bundle, unit: int, pressure: Batch, strain: Batch) -> Batch:
    """Force [N] that all muscles of a unit add at a `pressure` [Pa], without checks."""
    motor_unit = bundle.motor_units[unit - 1]
    pressurized, empty = (
        motor_unit.muscle.law.at(P) for P in (pressure + 0.0 * strain, 0.0 * strain)
    )
    with np.errstate(all="ignore"):  # of branches that aren't selected
        return motor_unit.count * (pressurized.pulling_force(strain) - empty.pulling_force(strain))


def _dip(
    bundle: Bundle, unit: int, strain: np.ndarray, supply: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth [N] and pressure [Pa] of the dip, and the onset [Pa], at each strain."""

    def added(pressure: np.ndarray, strain: np.ndarray) -> np.ndarray:
        return np.asarray(_added_force(bundle, unit, pressure, strain))

    batch, end = np.arange(len(strain)), _GRID - 1
    grid = supply * np.linspace(0.0, 1.0, _GRID)[:, None] ** 2 + 0.0 * strain
    values = added(grid, strain)
    last = end - np.argmax(values[::-1] <= 0, axis=0)
    bracket = grid[last, batch], grid[np.minimum(last + 1, end), batch]
    onset = elementwise.find_root(added, bracket, args=(strain,)).x
    onset = np.where(last == end, np.inf, np.where(last == 0, 0.0, onset))
    k = np.argmin(values, axis=0)
    inside = np.clip(k, 1, end - 1)
    lowest = elementwise.find_minimum(
        added, tuple(grid[inside + side, batch] for side in (-1, 0, 1)), args=(strain,)
    )
    deeper = lowest.f_x < values[k, batch]  # not at an end of the grid, nor where it is nan
    best = np.where(deeper, lowest.x, grid[k, batch])
    depth = np.where(deeper, lowest.f_x, values[k, batch])
    falls = depth < 0
    return np.where(falls, -depth, 0.0), np.where(falls, best, 0.0), onset
