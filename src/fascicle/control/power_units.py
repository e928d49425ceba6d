r"""Shaft work of power units for the oil that a period of a sine draws.

The bundle is fed at the supply's pressure $P_s$. With the flow $Q$ that it draws, over a period,

$$W_{relief} = \frac{P_s \max Q}{\eta f}, \qquad
  W_{accumulator} = \frac{(P_s + b/2)}{\eta} \oint Q\, \mathrm{d}t, \qquad
  W_{sensing} = \frac{1}{\eta} \oint \min(P_{top} + c,\, P_s)\, Q\, \mathrm{d}t: \tag{K6}$$

`relief`, a pump of fixed displacement that always gives the largest flow of that sine, what is too
much over a relief valve; `accumulator`, one that is switched and charges an accumulator over a band
$b$ above $P_s$, from which a reducer feeds the bundle; `sensing`, one that gives what is drawn, at
the pressure $P_{top}$ of the highest unit that is fed and $c$ more.

**Assumes** one overall efficiency $\eta$ everywhere, which real pumps don't have, and a sensing
pump whose lower pressure still drives the flow: it is the best that one could do.
**Source:** Merritt (1967), Hydraulic Control Systems, for the kinds; these sizes are made up.
"""

from typing import Any

import numpy as np

from ..core.types import Numbers, Values
from ..core.validation import check_interval, check_positive
from .frequency_response import FrequencyResponse


POWER_UNITS = ("relief", "accumulator", "sensing")


def shaft_work(
    response: FrequencyResponse,
    supply_pressure: Values,
    density: Values,
    efficiency: Values = 0.8,
    band: Values = 80e3,
    margin: Values = 50e3,
) -> dict[str, Numbers]:
    """Shaft work of each of `POWER_UNITS` for a period, equation (K6).

    **Arguments:**

    - `response`: the sines [SI].
    - `supply_pressure`: gauge [Pa].
    - `density`: of the liquid [kg/m³].
    - `efficiency`: of pump and motor together [-].
    - `band`: $b$ [Pa].
    - `margin`: $c$ [Pa].

    **Returns:** work [J] by the power unit's name, of `response`'s shape.

    **Raises:** `ValueError` for values that can't be.
    """
    P_s = float(check_positive(supply_pressure, "supply_pressure", "Pa"))
    rho = float(check_positive(density, "density", "kg/m³"))
    eta = float(check_interval(efficiency, 0.0, 1.0, "efficiency", "-", closed=(False, True)))
    b, c = (
        float(check_interval(value, 0.0, np.inf, name, "Pa", closed=(True, False)))
        for name, value in (("band", band), ("margin", margin))
    )
    periods = response.time * response.frequencies
    Q = response.drawn / rho

    def period(values: Any) -> Numbers:
        return np.sum(values, axis=-1) * response.dt / periods

    return {
        "relief": P_s * np.max(Q, axis=-1) / (eta * response.frequencies),
        "accumulator": (P_s + b / 2) * period(Q) / eta,
        "sensing": period(np.minimum(response.top + c, P_s) * Q) / eta,
    }
