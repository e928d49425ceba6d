"""What the next motor unit takes, against the oracle and against printed figures."""

import oracle_control as oracle
import oracle_muscle
import pytest
from from_oracle import library_bundle
from numpy.testing import assert_allclose

from fascicle import control


pytestmark = pytest.mark.oracle

MUSCLE = oracle_muscle.Muscle(material=oracle_muscle.SILICONE)
SUPPLY = 413.7e3

# Fig. 6's muscle of silicone at 413.7 kPa, computed independently: n2, strain, F1max and D in N,
# p_d and p_on in kPa, to the digits given
TABLE = [
    (1, 0.15, 71.91, 4.542, 43.1, 82.6),
    (1, 0.20, 38.06, 6.513, 72.3, 145.8),
    (4, 0.20, 34.83, 26.05, 72.3, 145.8),
    (4, 0.24, 8.37, 34.66, 107.0, 264.9),
]


def library_pair(pair):
    units = ((pair.muscle, pair.n1), (pair.muscle, pair.n2))
    return library_bundle(units, supply_pressure=pair.supply)


@pytest.mark.parametrize(("n2", "strain", "largest", "dip", "at", "onset"), TABLE)
def test_the_table_comes_out_to_its_digits(n2, strain, largest, dip, at, onset):
    found = control.transition(library_pair(oracle.Pair(MUSCLE, 1, n2)), strain)
    assert_allclose(found.largest_force, largest, rtol=0, atol=5e-3)
    assert_allclose(found.dip, dip, rtol=0, atol=5e-4 if n2 == 1 else 5e-3)
    assert_allclose(found.dip_pressure / 1e3, at, rtol=0, atol=0.05)
    assert_allclose(found.onset_pressure / 1e3, onset, rtol=0, atol=0.05)


@pytest.mark.parametrize(
    ("buckling", "strain"),
    [("kim2021", e) for e in (-0.03, 0.0, 0.06, 0.15, 0.24, 0.31)] + [("elastica", 0.2)],
)
def test_transitions_agree(buckling, strain):
    muscle = oracle_muscle.Muscle(material=oracle_muscle.SILICONE, buckling=buckling)
    pair = oracle.Pair(muscle, 2, 3)
    found = control.transition(library_pair(pair), strain)
    dip, at = oracle.dip(pair, strain)
    # the oracle's search ends at 1e-3 Pa, of some 1e-4 N/Pa
    assert_allclose(found.dip, dip, rtol=1e-6, atol=1e-6)
    # a minimum is known to the root of that
    assert_allclose(found.dip_pressure, at, rtol=1e-4, atol=1)
    assert_allclose(found.onset_pressure, oracle.onset(pair, strain), rtol=1e-9)
    assert_allclose(found.largest_force, oracle.largest_force(pair, strain), rtol=1e-8, atol=1e-8)
    for P in (10e3, 100e3):
        gain = control.added_force(library_pair(pair), P, strain)
        assert_allclose(gain, oracle.gain(pair, P, strain), rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("strain", [0.1, 0.2])
def test_times_agree(strain):
    pair = oracle.Pair(MUSCLE, 1, 4)
    gas = control.hand_over_time(library_pair(pair), strain, control.GasValves(2e-3))
    oil = control.hand_over_time(library_pair(pair), strain, control.OilValves(1e-5))
    # the oracle's volumes are differences of its work: 1e-7 of them, a tenth of what they differ by
    assert_allclose(gas, oracle.gas_time(pair, strain, 2e-3), rtol=1e-5)
    assert_allclose(oil, oracle.oil_time(pair, strain, 1e-5), rtol=1e-5)


def test_with_the_straight_braids_volume_a_gas_is_too_early_and_oil_at_once():
    pair = oracle.Pair(MUSCLE, 1, 1)
    V = oracle_muscle.volume(MUSCLE, 0.2)
    straight = oracle.onset(pair, 0.2) * V / (287.05 * 293.15 * 1e-3)
    right = control.hand_over_time(library_pair(pair), 0.2, control.GasValves(1e-3))
    assert 0.65 < straight / right < 0.8
    assert control.hand_over_time(library_pair(pair), 0.2, control.OilValves(1e-5)) > 0.5


@pytest.mark.parametrize(("rate", "time"), [(0.0, 0.1), (40.0, 0.1), (400.0, 0.05), (-50.0, 0.2)])
def test_needed_reserves_agree(rate, time):
    pair = oracle.Pair(MUSCLE, 1, 1)
    found = control.needed_reserve(library_pair(pair), 0.2, rate, time)
    # between the grids' pressures, 400 and 512 to the onset
    assert_allclose(found, oracle.needed_reserve(pair, 0.2, rate, time), rtol=2e-3)


def test_the_last_start_is_the_criterions_where_the_first_valve_is_fast():
    pair = oracle.Pair(MUSCLE, 1, 1)
    bundle = library_pair(pair)
    begin, rate = 4.0, 10.0
    path = control.Path.of([0, 4], [begin, begin + 4 * rate], 0.2)
    valves = [control.GasValves(1.0), control.GasValves(1e-3)]
    found = control.crossing(bundle, path, valves, slack=1.0)
    t_c = oracle.gas_time(pair, 0.2, 1e-3)
    assert_allclose(found.fill_time, t_c, rtol=1e-5)
    assert_allclose(found.end - found.start, t_c, rtol=1e-4)
    # the valve's own course of pressure, not the even one of (X3); at the dip itself both look
    last = oracle.last_start(pair, 0.2, begin, rate, 1e-3)
    assert_allclose(found.start, last, rtol=0, atol=0.02 * t_c)
