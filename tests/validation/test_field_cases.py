"""Files in the manner of people's own, and what they were refused or misread for."""

import pytest
from measured import measured

from fascicle.records import load
from fascicle.records.columns import MissingMetadataError


def test_a_rigs_clock_does_not_stop_the_reading():
    record = load(measured("field-cases/06_timestamps.csv"), rest_length=0.18)
    assert record.time is None and record.force.max() > 100
    assert any("`Time` not read as time" in note for note in record.notes)


@pytest.mark.parametrize(
    ("name", "column", "unit"),
    [("07_hanging_mass", "Load (g)", "gf"), ("07b_mass_kg", "Mass (kg)", "kgf")],
)
def test_hanging_masses_are_weights(name, column, unit):
    path, given = measured(f"field-cases/{name}.csv"), {"columns": {"force": column}}
    with pytest.raises(MissingMetadataError) as asked:
        load(path, rest_length=0.18, **given)
    assert (asked.value.argument, asked.value.role, asked.value.value) == ("units", "force", unit)
    record = load(path, rest_length=0.18, units={"force": unit}, **given)
    assert record.force.min() == pytest.approx(0.2 * 9.80665)  # N: the lightest mass, of 200 g
