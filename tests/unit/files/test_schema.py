import pytest
from numpy.testing import assert_allclose

from fascicle.core.errors import InvalidInputError
from fascicle.files.schema import parse_price


@pytest.mark.parametrize(
    ("text", "per", "amount", "currency"),
    [
        ("95 EUR", None, 95.0, "EUR"),
        ("95.50 €", None, 95.5, "€"),
        ("0 USD", None, 0.0, "USD"),
        ("0.025 EUR/m^3", "volume", 0.025, "EUR"),
        ("0.025 EUR/Nm³", "volume", 0.025, "EUR"),
        ("2 EUR/L", "volume", 2000.0, "EUR"),
        ("0.36 EUR/kWh", "energy", 1e-7, "EUR"),
        ("40 EUR/m", "length", 40.0, "EUR"),
    ],
)
def test_prices_are_read(text, per, amount, currency):
    price = parse_price(text, "valve", per)
    assert_allclose(price.amount, amount, rtol=1e-12)
    assert price.currency == currency


INVALID = {
    None: ("95", True, "-5 EUR", "1" + "0" * 12 + " EUR", "9" * 400 + " EUR"),
    "volume": ("95 EUR", "95 EUR/s", "95\nEUR\n/m\n"),
}


@pytest.mark.parametrize("per", INVALID)
def test_invalid_prices_are_one_line(per):
    for text in INVALID[per]:
        with pytest.raises(InvalidInputError) as refused:
            parse_price(text, "valve", per)
        assert refused.value.argument == "valve" and "\n" not in str(refused.value)
