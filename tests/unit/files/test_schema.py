import pytest
from numpy.testing import assert_allclose

from fascicle.files.schema import parse_price


@pytest.mark.parametrize(
    ("text", "per", "amount", "currency"),
    [
        ("95 EUR", None, 95.0, "EUR"),
        ("€95.50", None, 95.5, "€"),
        ("95$", None, 95.0, "$"),
        ("0 USD", None, 0.0, "USD"),
        ("0.025 EUR/m^3", "volume", 0.025, "EUR"),
        ("0.025 EUR/Nm³", "volume", 0.025, "EUR"),
        ("0.025 EUR per m3", "volume", 0.025, "EUR"),
        ("2 EUR/L", "volume", 2000.0, "EUR"),
        ("0.36 EUR/kWh", "energy", 1e-7, "EUR"),
        ("40 EUR/m", "length", 40.0, "EUR"),
    ],
)
def test_prices_are_read(text, per, amount, currency):
    price = parse_price(text, "valve", per)
    assert_allclose(price.amount, amount, rtol=1e-12)
    assert price.currency == currency


@pytest.mark.parametrize(
    ("text", "per", "message"),
    [
        ("95", None, "write one currency"),
        (True, None, "got True"),
        ("-5 EUR", None, 'such as "95 EUR"'),
        ("95 EUR", "volume", "add the unit"),
        ("95 EUR/s", "volume", "'s' is no unit of volume"),
        ("1" + "0" * 12 + " EUR", None, "must lie in"),
        ("9" * 400 + " EUR", None, "must be a price"),
        ("95\nEUR\n/m\n", "volume", "is no unit"),
    ],
)
def test_invalid_prices_are_one_line(text, per, message):
    with pytest.raises(ValueError) as refused:  # noqa: PT011 the line is looked at
        parse_price(text, "valve", per)
    line = str(refused.value)
    assert line.startswith("`valve` must be a price") and message in line and "\n" not in line
