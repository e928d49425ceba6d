"""Numbers beside a picture, in the units shown."""

from collections.abc import Mapping

from .widgets import factor


def volume(value: float, length: str) -> str:
    """A volume's `value` [m³] beside lengths in a unit `length` [-]."""
    if length == "in":
        return f"{value / factor('in', 'length') ** 3:.4g} in³"
    return f"{value * 1e6:.4g} cm³"


def moment(value: float, units: Mapping[str, str]) -> str:
    """A moment's `value` [N·m] in the `units` shown [-] of force and length, meters for
    millimeters.
    """
    length = "m" if units["length"] == "mm" else units["length"]
    scale = factor(units["force"], "force") * factor(length, "length")
    return f"{value / scale:.4g} {units['force']}·{length}"


def table(rows: dict[str, str]) -> str:
    """Two columns [-] of what and how much [-]."""
    rows = {what: f"−{told[1:]}" if told[:1] == "-" else told for what, told in rows.items()}
    cells = "".join(
        f'<tr><th style="text-align:left;font-weight:400;opacity:.75;padding:1px 14px 1px 0">{what}'
        f'</th><td style="font-variant-numeric:tabular-nums">{value}</td></tr>'
        for what, value in rows.items()
    )
    return f'<table style="font-size:13.5px;border-collapse:collapse">{cells}</table>'
