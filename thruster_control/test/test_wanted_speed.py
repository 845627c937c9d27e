"""The rotor speed for a wanted thrust: against the thrust map, against the printed inverses, and near its jump."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from thruster_control.wanted_speed import side_for_thrust, speed_on_side
from thruster_model.equations.inflow import steady_axial_flow
from thruster_model.equations.inversion import speed_for_thrust, speed_for_thrust_map
from thruster_model.equations.thruster import thrust
from thruster_model.parameter_set_io import load_parameter_set

P = {name: load_parameter_set(name).coefficients for name in ("simplified", "hl", "hq", "kim_chung")}
FORCES = st.floats(-20.0, 20.0).filter(lambda T: abs(T) > 1e-6)
FLOWS = st.floats(-0.5, 0.5)


def wanted(T_d: float, v_0: float, k_r: float, p) -> float:  # type: ignore[no-untyped-def]
    return speed_on_side(T_d, v_0, k_r, side_for_thrust(T_d, v_0, k_r, 0.0, 0.0, p), p)


def test_hl_and_hq_by_hand() -> None:
    """c_n = 1.467e-3, c_nv = 0.4146: n_d = (0.04146 + sqrt(0.04146^2 + 4 c_n 10)) / (2 c_n) at 0.1 m/s and 10 N."""
    assert wanted(10.0, 0.1, 0.0, P["hl"]) == pytest.approx((0.04146 + np.sqrt(0.04146**2 + 0.05868)) / 2.934e-3)
    needed = 10.0 + 37.71 * 0.01
    expected = (0.03755 + np.sqrt(0.03755**2 + 4.0 * 1.467e-3 * needed)) / 2.934e-3
    assert wanted(10.0, 0.1, 0.0, P["hq"]) == pytest.approx(expected)


@given(T_d=FORCES, v=FLOWS)
@pytest.mark.parametrize("name", ["hl", "hq"])
def test_it_is_the_exact_inverse_of_the_thesis_map(name: str, T_d: float, v: float) -> None:
    p = P[name]
    n_d = wanted(T_d, v, 0.0, p)
    assert thrust(n_d, v, p) == pytest.approx(T_d, abs=1e-9)
    assert n_d == pytest.approx(float(speed_for_thrust(T_d, v, p.c_T2, p.c_nv_T, p.c_v_T)), rel=1e-9, abs=1e-9)


@given(T_d=FORCES)
def test_without_flow_it_is_3_6_in_both_directions(T_d: float) -> None:
    p = P["simplified"]._replace(delta_T1=-40.0, delta_T2=90.0)
    assert wanted(T_d, 0.0, 0.0, p) == pytest.approx(float(speed_for_thrust_map(T_d, p)), rel=1e-12)


@given(T_d=FORCES, ambient=FLOWS, c_v=st.floats(0.0, 100.0))
def test_speed_and_steady_flow_fit_each_other(T_d: float, ambient: float, c_v: float) -> None:
    """Both pieces of v|v|: flow against the propeller turns round within the range of speeds."""
    p = P["kim_chung"]._replace(c_v_T=c_v)
    n_d = wanted(T_d, steady_axial_flow(0.0, ambient, p.k_s, p.k_r, 0.0), p.k_r, p)
    v = steady_axial_flow(n_d, ambient, p.k_s, p.k_r, 0.0)
    assert thrust(n_d, v, p) == pytest.approx(T_d, abs=1e-9)


def test_flow_that_turns_round_by_the_propeller_uses_the_other_piece() -> None:
    p = P["kim_chung"]
    n_d = wanted(6.0, -0.02, p.k_r, p)
    assert -0.02 + p.k_r * n_d > 0.0
    assert thrust(n_d, -0.02 + p.k_r * n_d, p) == pytest.approx(6.0, abs=1e-9)


def test_a_propeller_in_a_stream_stays_on_its_side_within_the_hysteresis_and_still_gives_the_thrust() -> None:
    p, v = P["hl"], 0.13
    jump = p.c_nv_T * v / p.c_T2
    assert jump == pytest.approx(36.7, abs=0.1)
    assert wanted(1e-9, v, 0.0, p) - wanted(-1e-9, v, 0.0, p) == pytest.approx(jump, rel=1e-3)
    held = side_for_thrust(-0.09, v, 0.0, 1.0, 0.1, p)
    n_d = speed_on_side(-0.09, v, 0.0, held, p)
    assert held == 1.0 and n_d > 30.0
    assert thrust(n_d, v, p) == pytest.approx(-0.09, abs=1e-12)
    assert side_for_thrust(-0.11, v, 0.0, 1.0, 0.1, p) == -1.0


@pytest.mark.parametrize(("v", "hysteresis", "side"), [(-0.13, 0.1, -1.0), (0.0, 0.1, -1.0), (0.13, 0.0, -1.0)])
def test_there_is_no_hysteresis_where_nothing_jumps(v: float, hysteresis: float, side: float) -> None:
    assert side_for_thrust(-0.05, v, 0.0, 1.0, hysteresis, P["hl"]) == side
    dead = P["hl"]._replace(delta_T1=-90.0, delta_T2=90.0)
    assert side_for_thrust(-0.05, v, 0.0, 1.0, hysteresis, dead) == side


def test_noise_about_the_jump_reverses_the_propeller_often_without_hysteresis_and_not_with_it() -> None:
    p, rng = P["hl"], np.random.default_rng(3)
    reversals = {}
    for band in (0.0, 0.1):
        side, count = 1.0, 0
        for T_d in 0.03 * rng.normal(size=500):
            now = side_for_thrust(float(T_d), 0.13, 0.0, side, band, p)
            count, side = count + (now != side), now
        reversals[band] = count
    assert reversals[0.0] > 150
    assert reversals[0.1] <= 2
