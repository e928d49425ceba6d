"""Prices as text: an amount and its currency, for one, or by a unit: `0.025 EUR/m^3`.

Currencies aren't converted: what a file gives must be in one.
"""

import math
import re
from typing import Any, NamedTuple

from ..units import parse


_PRICE = re.compile(
    r"\s*([€$£¥])?\s*(\d+\.?\d*|\.\d+)\s*([^\W\d_]{1,6}|[€$£¥])?\s*(?:(?:/|\bper\b)\s*(\S.*?))?\s*"
)
_MOST = 1e9  # of a currency, for one of what is bought
_EXAMPLES = {None: "95 EUR", "volume": "0.025 EUR/m^3", "energy": "0.30 EUR/kWh",
             "length": "40 EUR/m"}  # fmt: skip


class Price(NamedTuple):
    """An `amount` [-] of a `currency`, for one or for the SI unit of what is bought."""

    amount: float
    currency: str


def parse_price(text: Any, name: str, per: str | None = None) -> Price:
    """Read a price.

    **Arguments:**

    - `text`: such as "95 EUR" or "0.025 EUR/m^3" [-]; of air, the m³ is a normal one.
    - `name`: what to call it in an error [-].
    - `per`: the dimension it is for, a key of `DIMENSIONS` [-]; left out, it is for one.

    **Returns:** the price [-].

    **Raises:** `ValueError` for anything else, in one line.
    """
    what = f'`{name}` must be a price, such as "{_EXAMPLES[per]}"'
    shown = repr(text)
    shown = shown if len(shown) <= 60 else f"{shown[:40]}…{shown[-1]}"
    match = _PRICE.fullmatch(text) if isinstance(text, str) and len(text) <= 60 else None
    if match is None:
        raise ValueError(f"{what}, got {shown}.")
    sign, digits, word, unit = match.groups()
    if bool(sign) == bool(word):
        raise ValueError(f"{what}, got {shown}: write one currency.")
    if bool(unit) != (per is not None):
        more = "by which unit?" if per else "it is for one, drop the unit."
        raise ValueError(f"{what}, got {shown}: {more}")
    amount = float(digits)
    if not math.isfinite(amount) or amount > _MOST:
        raise ValueError(f"{what}, got {shown}: it must lie in [0, {_MOST:g}].")
    if per is None or not unit:
        return Price(amount, sign or word)
    # a normal cubic meter is written Nm³ by many
    plain = re.sub(r"^N?m(\^?3|³)$", "m^3", unit)
    try:
        size = parse(f"1 {plain}", per, name)
    except ValueError:
        raise ValueError(f"{what}, got {shown}: {unit!r} is no unit of {per}.") from None
    return Price(amount / size, sign or word)
