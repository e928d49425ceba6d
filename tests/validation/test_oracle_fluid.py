"""Flows, fillings and energies of `fascicle.fluid` against closed forms and the oracle."""

import numpy as np
import oracle_fluid as oracle
import pytest
from numpy.testing import assert_allclose
from oracle_fluid import ROOM, WARM, R
from scipy.integrate import solve_ivp

from fascicle import fluid
from fascicle.fluid.flow_elements import in_series


C, B, SUPPLY, V = 2e-9, 0.3, 7e5, 1e-4  # of a small valve; absolute; a muscle's volume
valve = fluid.SonicValve(C, B)


def filled(chamber, ports, start, t, opening=1.0):
    """Absolute pressures and states of a rigid chamber at times `t`, and the mass that came in,
    between `ports` of a given absolute pressure and temperature.
    """
    p_s, T_s = ports

    def rates(_, state):
        s = state[: chamber.count]
        P = chamber.static_pressure(s, V)
        p, T = P + ROOM, chamber.temperature(s, P)
        flow = valve.flow(p_s, p, T_s, T, opening)
        enthalpy = chamber.gas.c_p * (T_s if flow > 0 else T) * flow
        return [*chamber.rates(s, P, flow, enthalpy, 0.0), flow]

    state = np.append(chamber.state_at(start - ROOM, V), 0.0)
    # each tolerance far below what is compared; in steps that see the law's kinks
    done = solve_ivp(
        rates, (0, t[-1]), state, t_eval=t, rtol=1e-11, atol=1e-14, max_step=t[-1] / 200
    )
    states = done.y[:-1].T
    return chamber.static_pressure(states, V) + ROOM, states, done.y[-1]


@pytest.mark.parametrize("pressures", [(7e5, 1e5), (7e5, 2.1e5), (7e5, 3e5), (7e5, 6.99e5),
                                       (7e5, 6.994e5), (7e5, 7e5), (2e5, 1.01325e5)])  # fmt: skip
@pytest.mark.parametrize(("b", "m"), [(0.05, 0.5), (0.3, 0.5), (0.528, 0.5), (0.2, 0.6)])
def test_valve_flows_as_the_standard_prints(pressures, b, m):
    of = fluid.SonicValve(C, b, m)
    for T in (WARM, 350.0):
        assert_allclose(
            of.flow(*pressures, T, 200.0), oracle.sonic(C, b, *pressures, T, m), rtol=1e-13
        )


def test_choked_filling_is_even():
    t = np.linspace(0, 0.07, 21)
    p, _, mass = filled(fluid.Isothermal(), (SUPPLY, WARM), ROOM, t)
    assert p[-1] < B * SUPPLY  # it was choked all the time
    assert_allclose(p, oracle.choked_filling(C, SUPPLY, V, ROOM, t), rtol=1e-9)
    assert_allclose(mass[-1], (p[-1] - ROOM) * V / (R * WARM), rtol=1e-9)


def test_subsonic_filling_follows_the_sine():
    start, t = 0.4 * SUPPLY, np.linspace(0, 0.45, 11)
    p, _, _ = filled(fluid.Isothermal(), (SUPPLY, WARM), start, t)
    assert p[-1] < 0.999 * SUPPLY
    expected = [oracle.subsonic_filling(C, B, SUPPLY, V, start, x) for x in t]
    assert_allclose(p, expected, rtol=1e-9)


def test_laminar_filling_is_exponential():
    start, t = 0.9995 * SUPPLY, np.linspace(0, 0.05, 11)
    p, _, _ = filled(fluid.Isothermal(), (SUPPLY, WARM), start, t)
    expected = np.array([oracle.laminar_filling(C, B, SUPPLY, V, start, x) for x in t])
    # of a remaining difference of 350 Pa and less; the pressure itself has 7e5
    assert_allclose(SUPPLY - p, SUPPLY - expected, rtol=1e-6, atol=1e-4)
    assert SUPPLY - p[-1] < 0.1 * (SUPPLY - start)


def test_adiabatic_filling_warms_up():
    t = np.linspace(0, 0.4, 9)
    p, states, _ = filled(fluid.AdiabaticWall(), (SUPPLY, WARM), ROOM, t)
    T = fluid.AdiabaticWall().temperature(states)
    assert_allclose(T, oracle.adiabatic_filling(WARM, ROOM, WARM, p), rtol=1e-9)
    assert np.all(np.diff(T) > 0) and T[-1] < oracle.GAMMA * WARM
    # while it chokes, pressure rises γ times as fast as in an isothermal one
    slow, _, _ = filled(fluid.Isothermal(), (SUPPLY, WARM), ROOM, np.linspace(0, 0.05, 2))
    fast, _, _ = filled(fluid.AdiabaticWall(), (SUPPLY, WARM), ROOM, np.linspace(0, 0.05, 2))
    assert_allclose((fast[1] - ROOM) / (slow[1] - ROOM), oracle.GAMMA, rtol=1e-9)


def test_adiabatic_discharge_keeps_its_entropy():
    t = np.linspace(0, 0.4, 9)
    p, states, _ = filled(fluid.AdiabaticWall(), (ROOM, WARM), SUPPLY, t)
    T = fluid.AdiabaticWall().temperature(states)
    assert p[-1] < 0.5 * SUPPLY
    assert_allclose(T, oracle.adiabatic_discharge(WARM, SUPPLY, p), rtol=1e-9)


def test_a_wall_goes_from_adiabatic_to_isothermal():
    t = np.linspace(0, 0.2, 3)
    ends = [
        filled(fluid.AdiabaticWall(G), (SUPPLY, WARM), ROOM, t)[0][-1] for G in (0.0, 0.1, 30.0)
    ]
    isothermal = filled(fluid.Isothermal(), (SUPPLY, WARM), ROOM, t)[0][-1]
    assert ends[0] > ends[1] > ends[2] > isothermal
    # what is left falls as 1/G: some c_v ṁ/G of the temperature, and so of the pressure
    assert_allclose(ends[2], isothermal, rtol=0.02)


def test_no_opening_no_flow_in_time():
    p, _, mass = filled(fluid.AdiabaticWall(), (SUPPLY, WARM), ROOM, np.linspace(0, 1, 3), 0.0)
    assert_allclose(p, ROOM, rtol=1e-13)
    assert np.all(mass == 0)


def test_two_in_series_meet_the_pressure_between():
    rng = np.random.default_rng(15)
    low = 1e5

    def random():
        return 10 ** rng.uniform(-9.5, -7.5), rng.uniform(0.1, 0.55)

    for _ in range(60):
        first, second = random(), random()
        pair = in_series(*first, *second)
        assert 0 < pair[1] < 1

        def off(high, laminar, first=first, second=second, pair=pair):
            flow = fluid.SonicValve(*pair).flow(high, low, WARM, WARM)
            return abs(flow / oracle.sonic_pair(first, second, high, low, laminar) - 1)

        # exact where it chokes, and toward equal pressures but for a share of 1 − r = 0.005
        assert off(1e8, 1.0) < 1e-11
        assert off(low / 0.995, 1.0) < 5e-4
        # between them the pair is an ellipse by assumption, within 2 %
        assert max(off(p, 1.0) for p in np.geomspace(1.02, 20, 12) * low) < 0.02
        # where one of them is in its linear end and the pair isn't
        assert max(off(low / r, 0.999) for r in (0.998, 0.995)) < 0.08
        # all linear: of two equal ones half flows, of the pair's one end 1/√2
        assert off(low / 0.9995, 0.999) < 0.415


@pytest.mark.parametrize("opening", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("hose", [(0.3, 0.004), (2.0, 0.004), (5.0, 0.006)])
def test_a_valve_with_a_hose_meets_the_pressure_between(hose, opening):
    C, b, low = 1e-8, 0.3, 1e5
    line = fluid.Line(*hose)
    valve = fluid.SonicValve(C, b, line=line)
    own, behind = (opening * C, b), (line.conductance, line.critical_pressure_ratio)
    for high in np.append(np.geomspace(1.02, 20, 12), 1 / 0.995) * low:
        onward = valve.flow(high, low, WARM, WARM, opening)
        back = -valve.flow(low, high, WARM, WARM, opening)
        # the pair is an ellipse by assumption, within 2 %
        assert_allclose(onward, oracle.sonic_pair(own, behind, high, low, 1.0), rtol=0.02)
        assert_allclose(back, oracle.sonic_pair(behind, own, high, low, 1.0), rtol=0.02)
    # exact where it chokes
    choked = valve.flow(1e8, low, WARM, WARM, opening)
    assert_allclose(choked, oracle.sonic_pair(own, behind, 1e8, low, 1.0), rtol=1e-11)


@pytest.mark.parametrize("diameter", [0.002, 0.004, 0.012])
@pytest.mark.parametrize("length", [0.1, 1.0, 10.0])
def test_hoses_are_near_fannos(length, diameter):
    hose = fluid.Line(length, diameter)
    # smooth plastic has f = 0.016 to 0.025 at such flows; the fit is of real hoses with fittings
    expected = oracle.fanno_conductance(length, diameter, 0.02)
    assert_allclose(hose.conductance, expected, rtol=0.17)
    assert 0 < hose.critical_pressure_ratio < 0.61


@pytest.mark.parametrize(("p", "T"), [(7e5, WARM), (7e5, 400.0), (5e4, 250.0), (ROOM, WARM)])
def test_exergies_are_those_of_reversible_paths(p, T):
    room = (ROOM, WARM)
    # differences of some 1e5 J/kg
    assert_allclose(fluid.AIR.flow_exergy(p, T, *room), oracle.flow_exergy(p, T), atol=1e-7)
    expected = oracle.stored_exergy(2e-4, p, T)
    assert_allclose(fluid.AIR.stored_exergy(2e-4, p, T, *room), expected, atol=1e-11)
    assert expected >= 0


def test_a_supplys_exergy_is_the_isothermal_work():
    e = fluid.AIR.flow_exergy(SUPPLY, WARM, ROOM, WARM)
    assert_allclose(e, R * WARM * np.log(SUPPLY / ROOM), rtol=1e-14)


@pytest.mark.parametrize("pressure", [-9e4, 1e3, 1e5, 1e6, 1.39e7, 1.41e7, 1e8])
@pytest.mark.parametrize("liquid", [fluid.OIL, fluid.WATER])
def test_energies_of_liquids(liquid, pressure):
    flow, stored = oracle.liquid_energies(liquid.reference_density, liquid.bulk_modulus, pressure)
    assert_allclose(liquid.flow_energy(pressure), flow, rtol=1e-12)
    assert_allclose(liquid.stored_energy(pressure), stored, rtol=1e-11)
    both = liquid.stored_energy(pressure) + pressure / liquid.density(pressure)
    assert_allclose(both, liquid.flow_energy(pressure), rtol=1e-12)


@pytest.mark.parametrize("n", [1.0, 1.0001, 1.2, 1.4])
def test_accumulator(n):
    of = fluid.Accumulator(1e-3, 2e5, 8e5, n)
    taken = of.stored_volume(8e5)
    p_0 = 2e5 + ROOM
    assert_allclose(oracle.accumulator_pressure(1e-3, p_0, n, taken), 8e5 + ROOM, rtol=1e-13)
    of_liquid = oracle.liquid_energies(850.0, 1.4e9, 8e5)[1] * of.initial_state()[0]
    expected = oracle.accumulator_energy(1e-3, p_0, n, taken) + of_liquid
    assert_allclose(of.stored_energy(of.initial_state()), expected, rtol=1e-11)


def test_accumulator_gives_what_it_took():
    """Oil, too, at its own bulk modulus: energy out is ṁ h(P), and mass comes back as pressure."""
    of = fluid.Accumulator(1e-3, 2e5, 8e5, 1.3)
    start = of.initial_state()
    assert_allclose(of.pressure_at(start), 8e5, rtol=1e-13)

    def rates(_, state):
        flow = 0.02
        given = fluid.OIL.flow_energy(of.pressure_at(state[:1])) * flow
        return [*of.rates(state[:1], -flow, 0.0), given]

    done = solve_ivp(rates, (0, 10), [*start, 0.0], rtol=1e-11, atol=1e-12)
    end, given = done.y[:1, -1], done.y[1, -1]
    assert_allclose(of.stored_energy(start) - of.stored_energy(end), given, rtol=1e-9)


def test_hose_and_orifice_share_the_pressure():
    hose = fluid.Line(2.0, 0.004, viscosity=0.04, friction_factor=0.03)
    of = fluid.Orifice(2e-6, 850.0, 0.611, 1.0, hose)
    for opening in (0.1, 1.0):
        for drop in (1e4, 4e5):
            flow = of.flow(drop, 0.0, opening=opening)
            through = oracle.orifice_pressure_drop(2e-6 * opening, 0.611, 850.0, flow)
            along = oracle.hose_pressure_drop(2.0, 0.004, 0.04, 850.0, 0.03, flow)
            # the transition's part falls as (Δp_cr/Δp)²/2, here of a pascal
            assert_allclose(through + along, drop, rtol=1e-8)


def test_liquid_chamber_keeps_its_energy():
    """Through a cycle of volume and mass: Σ ṁ h(P) − ∫ P dV = what is stored."""
    of = fluid.LiquidChamber(compliance=2e-13, dead_volume=1e-5)

    def volume(t):
        return 1e-4 * (1 + 0.2 * np.sin(3 * t)), 6e-5 * np.cos(3 * t)

    def rates(t, state):
        V, rate = volume(t)
        m = state[:1]
        P = of.static_pressure(m, V)
        flow = fluid.OIL.reference_density * rate + 1e-4 * np.cos(5 * t)
        in_and_out = flow * fluid.OIL.flow_energy(P) - P * rate
        return [*of.rates(m, P, flow, 0.0, rate), in_and_out]

    start = of.state_at(3e5, 1e-4)
    done = solve_ivp(rates, (0, 2), [*start, 0.0], rtol=1e-11, atol=1e-14, max_step=0.01)
    end, given = done.y[:1, -1], done.y[1, -1]
    P = of.static_pressure(end, volume(2.0)[0])
    assert_allclose(of.stored_energy(end, P) - of.stored_energy(start, 3e5), given, rtol=1e-7)


@pytest.mark.parametrize("G", [0.0, 0.5])
def test_first_and_second_law_of_a_wall(G):
    """A piston round a cycle: energy closes, exergy is lost through the wall alone."""
    of = fluid.AdiabaticWall(G)

    def volume(t):
        return 1e-4 * (1 - 0.3 * np.sin(t)), -3e-5 * np.cos(t)

    def rates(t, state):
        V, rate = volume(t)
        s = state[:2]
        P = of.static_pressure(s, V)
        heat = of.heat_flow(s, P, 0.0, 0.0, rate)
        T = of.temperature(s)
        lost = heat * (1 - WARM / T)
        return [*of.rates(s, P, 0.0, 0.0, rate), (P + ROOM) * rate, P * rate, heat, lost]

    start = of.state_at(2e5, 1e-4)
    done = solve_ivp(rates, (0, 8), [*start, 0, 0, 0, 0], rtol=1e-11, atol=1e-13, max_step=0.02)
    end, (done_work, gauge_work, heat, lost) = done.y[:2, -1], done.y[2:, -1]
    assert_allclose(end[1] - start[1], -done_work - heat, rtol=0, atol=1e-9)  # of 100 J
    stored = of.stored_energy(end, of.static_pressure(end, volume(8.0)[0])) - of.stored_energy(
        start, 2e5
    )
    assert_allclose(stored, -gauge_work - lost, rtol=0, atol=1e-9)
    assert (lost > 0) == (G > 0)
