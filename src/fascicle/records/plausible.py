"""Whether numbers can be what their header says, or are in another unit or another sign.

A column of pressures in kPa under `pressure [Pa]` is no error that a parser sees; a fit would
come out with a muscle a thousand times too strong. So readings must lie where muscles do: gauge
pressures up to 1 MPa, contractions from −0.2 to 0.9, and a force that some muscle's cross
section could bear.
"""

from collections.abc import Callable

import numpy as np

from ..core.validation import HIGHEST_PRESSURE
from .columns import Column
from .spelling import OTHERS, factor, scaled


STRAINS = (-0.2, 0.9)  # a muscle stretched by a fifth has straight fibers
_LOWEST = 2e3  # Pa: a record that never gets there, but pulls, is in another unit
_WIDEST = 0.05  # m²: the largest muscles reach 6 kN at 0.6 MPa, a hundredth of it
_NOISE = (0.02, 5e3)  # of the highest pressure, and Pa: what a transducer's zero may be off
_NEARLY_NO_FORCE = 1.0  # N: too little to tell a unit by

Fault = Callable[[int, Column, str], ValueError]  # row, its column, the rule


def check_pressure(
    column: Column, raw: np.ndarray, force: np.ndarray, fault: Fault
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Gauge pressures, once they can be such.

    **Arguments:**

    - `column`: what the header says [-].
    - `raw`: the readings in its unit [-].
    - `force`: pulling force [N].
    - `fault`: makes the error [-].

    **Returns:** pressures [Pa], with noise below zero taken off, and what to note [-].

    **Raises:** `ValueError` for a unit that can't be, and for pressures below zero.
    """
    pressure = scaled(raw, column.factor)
    top, strongest = float(np.max(pressure)), float(np.max(np.abs(force)))
    row = int(np.argmax(pressure))
    if top > HIGHEST_PRESSURE:
        rule = f"{_amount(raw[row], column)} is above {HIGHEST_PRESSURE / 1e6:g} MPa"
        raise fault(row, column, f"{rule}, more than muscles bear{_meant(column, raw[row])}")
    if 0 < top <= _LOWEST and strongest > _NEARLY_NO_FORCE:
        rule = f"the highest is {_amount(raw[row], column)}, with forces up to {strongest:.3g} N"
        raise fault(row, column, f"{rule}{_meant(column, raw[row])}")
    lowest = int(np.argmin(pressure))
    if pressure[lowest] < -min(_NOISE[0] * max(top, 0.0), _NOISE[1]):
        raise fault(
            lowest, column, f"{_amount(raw[lowest], column)} is below zero by more than noise:"
            " write gauge pressures, without the transducer's offset.",
        )  # fmt: skip
    notes = []
    below = int(np.count_nonzero(pressure < 0))
    if below:
        notes.append(f"{below} pressures below zero, down to {pressure[lowest]:.3g} Pa, set to 0")
    if 90e3 < pressure[lowest] < 110e3 and top > 1.5 * pressure[lowest]:
        notes.append(
            f"the lowest pressure is {pressure[lowest] / 1e3:.4g} kPa: if that is the atmosphere,"
            " subtract it"
        )
    return np.maximum(pressure, 0.0), tuple(notes)


def check_force(
    column: Column, raw: np.ndarray, force: np.ndarray, pressure: np.ndarray, fault: Fault
) -> tuple[str, ...]:
    """Refuse forces that no muscle has, and say where none of them pulls.

    **Arguments:**

    - `column`: what the header says [-].
    - `raw`: the readings in its unit [-].
    - `force`: pulling force [N].
    - `pressure`: gauge pressure [Pa].
    - `fault`: makes the error [-].

    **Returns:** what to note [-].

    **Raises:** `ValueError` where force over pressure is too large an area.
    """
    row, top = int(np.argmax(np.abs(force))), float(np.max(pressure))
    area = abs(float(force[row])) / top if top > _LOWEST else 0.0
    if area > _WIDEST:
        least = _meant(column, raw[row], area / _WIDEST)
        rule = f"{_amount(raw[row], column)} at no more than {top / 1e3:.4g} kPa"
        raise fault(row, column, f"{rule} needs {area:.2g} m² of cross section{least}")
    if np.max(force) <= 0 < -np.min(force):
        return (
            "no reading pulls: if they do, turn the sign with --push-positive, or with"
            ' signs.force = "pushing positive"',
        )
    return ()


def check_strain(column: Column, raw: np.ndarray, strain: np.ndarray, fault: Fault) -> None:
    """Refuse contractions that no muscle has.

    **Arguments:**

    - `column`: what the header says [-].
    - `raw`: the readings in its unit [-].
    - `strain`: contraction [-].
    - `fault`: makes the error [-].

    **Raises:** `ValueError`, with the line of the worst reading.
    """
    low, high = STRAINS
    row = int(np.argmax(np.maximum(low - strain, strain - high)))
    if low <= strain[row] <= high:
        return
    got = _amount(raw[row], column)
    if column.role == "strain" and np.max(np.abs(strain)) > 1 and column.factor == 1:
        hint = "did you mean %? Write it in the header, such as `strain [%]`."
    elif column.role == "strain":
        hint = f"it must lie from {low} to {high}, check its unit and sign."
    else:
        beyond = "longer than at rest" if strain[row] < 0 else "shorter than at rest"
        hint = f"{abs(strain[row]):.3g} of it {beyond}: check rest length, unit and sign."
    raise fault(row, column, f"{got} is a contraction of {strain[row]:.4g}: {hint}")


def _amount(value: float, column: Column) -> str:
    return f"{value:.6g} {column.unit}".rstrip()


def _meant(column: Column, worst: float, too_large: float = 0.0) -> str:
    """Which unit would make sense of the worst reading, as a question."""
    for unit in OTHERS[column.role]:
        by = factor(unit, column.role)
        if column.role == "pressure" and not 10e3 <= worst * by <= HIGHEST_PRESSURE:
            continue
        if column.role == "force" and by > column.factor / too_large:
            continue
        if by != column.factor:
            return f": did you mean {unit}?"
    return ": check its unit."
