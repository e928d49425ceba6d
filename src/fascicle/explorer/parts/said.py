"""The library's own words in the units that the page shows: laws and checks speak of SI."""

import re
from collections.abc import Mapping

from ...units import DIMENSIONS


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?"


def in_units(text: str, units: Mapping[str, str]) -> str:
    """A refusal in the units shown.

    **Arguments:**

    - `text`: the library's [-], with amounts such as `0.008 m` or `(0, 1] m`.
    - `units`: shown, by dimension [-].

    **Returns:** the same [-] with its amounts in those units, six digits of each.
    """
    for dimension, unit in units.items():
        kind = DIMENSIONS[dimension]
        for written in {kind.si, kind.shown} - {unit, ""}:
            by = float(kind.factors[written]) / float(kind.factors[unit])
            # no unit that only begins like it: m², m/s, N*m
            found = rf"(?<![\w.])({_NUMBER})(?:, ({_NUMBER}))?([\])]?) {re.escape(written)}"
            text = re.sub(
                rf"{found}(?![\w/*^·²³])",
                lambda match, by=by, unit=unit: (
                    ", ".join(f"{float(x) * by:.6g}" for x in match.groups()[:2] if x)
                    + f"{match[3]} {unit}"
                ),
                text,
            )
    return text
