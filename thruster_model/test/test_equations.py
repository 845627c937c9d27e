"""The equations: values by hand, invariants, and a second, independent way."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thruster_model.equations.dead_zone import (
    dead_zone,
    dead_zone_crossing_time,
    dead_zone_inverse,
    ramp_limited,
)
from thruster_model.equations.inversion import (
    speed_for_thrust,
    speed_for_thrust_as_printed,
    speed_for_thrust_map,
)
from thruster_model.equations.thruster import (
    ambient_acceleration,
    axial_acceleration,
    input_map,
    rotor_acceleration,
    thrust,
    torque,
)
from thruster_model.parameter_set_io import load_parameter_set

SIMPLIFIED = load_parameter_set("simplified").coefficients
HL = load_parameter_set("hl").coefficients
HQ = load_parameter_set("hq").coefficients

speeds = st.floats(-300, 300)
flows = st.floats(-1, 1)
forces = st.floats(-100, 100)


def printed_3_9(u, p):
    """(3.9) case by case, as the thesis prints it."""
    if u <= p.delta_u1:
        return p.c_u1 * (u - p.delta_u1)
    return 0.0 if u < p.delta_u2 else p.c_u2 * (u - p.delta_u2)


@pytest.mark.parametrize(
    ("name", "found", "by_hand"),
    [
        ("(3.9) forward", input_map(3.0, SIMPLIFIED), 709.0 * (3.0 - 0.9254)),
        ("(3.9) reverse", input_map(-5.0, SIMPLIFIED), 793.6 * (-5.0 + 0.8475)),
        ("(3.9) inside", input_map(0.5, SIMPLIFIED), 0.0),
        ("(3.5) forward", thrust(100.0, 0.0, SIMPLIFIED), 8.248e-4 * (10000.0 - 2.187e-3)),
        ("(3.5) reverse", thrust(-100.0, 0.0, SIMPLIFIED), 9.548e-4 * (-10000.0 + 0.032)),
        ("(3.11) reverse", torque(-100.0, 0.0, SIMPLIFIED), 1.577e-5 * (-10000.0 + 0.0215)),
        ("(3.11) inside", torque(0.1, 0.0, SIMPLIFIED), 0.0),
        ("(3.8)", rotor_acceleration(100.0, 0.3, 1500.0, SIMPLIFIED), -1130.0 - 67.66 * 0.3 + 1500.0),
        ("(4.12)", thrust(100.0, 0.1, HL), 14.67 - 0.4146 * 100.0 * 0.1),
        ("(4.14) reverse", thrust(-100.0, -0.2, HQ), -14.67 + 0.3755 * 100.0 * 0.2 + 37.71 * 0.04),
        ("(4.15)", torque(100.0, 0.2, HQ), 0.02804 - 9.948e-12 * 20.0 - 9.975e-8 * 0.04),
        ("(4.4)", axial_acceleration(0.1, 0.05, 10.0, HL), -0.1102 - 67.37 * 0.1 * (0.1 - 0.89 * 0.05) + 0.1232),
        ("(4.5)", ambient_acceleration(-0.2, 10.0, HL), 0.2396 * 0.2 + 1.258 * 0.04 + 0.04855),
        ("(3.20)", dead_zone_crossing_time(-0.8475, 0.9254, 100.0), 0.017729),
        ("(3.6) forward", speed_for_thrust_map(10.0, SIMPLIFIED), math.sqrt(10.0 / 8.248e-4 + 2.187e-3)),
        ("(3.6) reverse", speed_for_thrust_map(-10.0, SIMPLIFIED), -math.sqrt(10.0 / 9.548e-4 + 0.032)),
    ],
)
def test_an_equation_gives_the_value_worked_out_by_hand(name, found, by_hand):
    assert found == pytest.approx(by_hand, rel=1e-12), name


@given(u=st.floats(-5, 5))
def test_the_dead_zone_is_the_printed_one_case_by_case(u):
    assert input_map(u, HL) == pytest.approx(printed_3_9(u, HL), rel=1e-12, abs=1e-12)


@given(a=st.floats(-4000, 4000).filter(lambda a: a == 0 or abs(a) > 1e-9))
def test_3_10_inverts_3_9(a):
    u = dead_zone_inverse(a, HL.c_u1, HL.delta_u1, HL.c_u2, HL.delta_u2)
    assert dead_zone(u, HL.c_u1, HL.delta_u1, HL.c_u2, HL.delta_u2) == pytest.approx(a, rel=1e-9, abs=1e-9)


def test_3_10_leaves_what_is_not_a_number():
    assert np.isnan(dead_zone_inverse(np.nan, HL.c_u1, HL.delta_u1, HL.c_u2, HL.delta_u2))


@given(force=forces.filter(lambda f: abs(f) > 1e-6))
def test_3_6_inverts_3_5(force):
    assert thrust(speed_for_thrust_map(force, SIMPLIFIED), 0.0, SIMPLIFIED) == pytest.approx(force, rel=1e-9)


def test_an_idle_command_never_spins_a_propeller():
    assert speed_for_thrust_map(0.0, SIMPLIFIED) == 0.0
    for v in (-0.3, 0.0, 0.3):
        assert speed_for_thrust(0.0, v, HQ.c_T1, HQ.c_nv_T, HQ.c_v_T) == 0.0


@pytest.mark.parametrize("p", [HL, HQ], ids=["HL", "HQ"])
@given(force=forces.filter(lambda f: abs(f) > 1e-6), v=flows)
def test_the_exact_inverse_of_the_hydrodynamic_maps_gives_the_wanted_thrust(p, force, v):
    n = speed_for_thrust(force, v, p.c_T1, p.c_nv_T, p.c_v_T)
    assert thrust(n, v, p) == pytest.approx(force, rel=1e-6, abs=1e-9)
    assert n * (force + p.c_v_T * v * abs(v)) >= 0.0


@given(force=forces.filter(lambda f: abs(f) > 1e-3), v=flows)
def test_the_printed_inverse_is_exact_for_hl_and_for_hq_only_where_the_signs_agree(force, v):
    hl = speed_for_thrust_as_printed(force, v, HL.c_T1, HL.c_nv_T, 0.0)
    assert hl == pytest.approx(speed_for_thrust(force, v, HL.c_T1, HL.c_nv_T, 0.0), rel=1e-12)
    needed = force + HQ.c_v_T * v * abs(v)
    if abs(needed) < 1e-3:
        return
    printed = speed_for_thrust_as_printed(force, v, HQ.c_T1, HQ.c_nv_T, HQ.c_v_T)
    exact = speed_for_thrust(force, v, HQ.c_T1, HQ.c_nv_T, HQ.c_v_T)
    assert (printed == pytest.approx(exact)) == (np.sign(needed) == np.sign(force))


@given(n=speeds, v=flows)
def test_hydrodynamic_thrust_and_torque_are_odd(n, v):
    assert thrust(-n, -v, HQ) == pytest.approx(-thrust(n, v, HQ))
    assert torque(-n, -v, HQ) == pytest.approx(-torque(n, v, HQ))


@given(n=speeds)
def test_the_rotor_loses_energy_without_drive(n):
    for p in (SIMPLIFIED, HL, HQ):
        assert n * rotor_acceleration(n, torque(n, 0.0, p), 0.0, p) <= -p.k_n * n * n + 1e-9


def test_arrays_broadcast_and_agree_with_scalars():
    n, v = np.linspace(-200, 200, 7)[:, None], np.linspace(-0.5, 0.5, 5)
    batch = thrust(n, v, HQ)
    assert batch.shape == (7, 5)
    assert batch == pytest.approx(np.array([[thrust(a, b, HQ) for b in v] for a in n[:, 0]]))


def test_the_throttle_ramps_no_faster_than_its_limit_and_stops_at_the_command():
    assert ramp_limited(0.0, 3.0, 100.0, 0.01) == pytest.approx(1.0)
    assert ramp_limited(2.9, 3.0, 100.0, 0.01) == pytest.approx(3.0)
    assert ramp_limited(3.0, -3.0, 100.0, 0.02) == pytest.approx(1.0)
