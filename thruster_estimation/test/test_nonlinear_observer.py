"""NLO and KFNLO: where they converge from everywhere, where they do not, and the conditions on their gains."""

from math import sqrt

import numpy as np
import pytest
from thruster_truth import DT, HL, Array, rate, rate_416, truth

from thruster_estimation.belief import initial_belief
from thruster_estimation.gain_conditions import check_gains, saturated_gains
from thruster_estimation.observers import observer_step
from thruster_estimation.offline import observe
from thruster_estimation.settings import bench_settings, checked

REVERSALS = np.repeat([3.0, -3.0, 3.0, -3.0], 75)
SIGNED = {observer: checked(bench_settings(observer)._replace(unsigned=0)) for observer in ("nlo", "kfnlo")}


def start(n: float, v: float, U: float):  # type: ignore[no-untyped-def]
    return initial_belief(n, v, U, deviation_n=1.0, deviation_v=0.1, deviation_U=0.1)


@pytest.mark.parametrize("observer", ["nlo", "kfnlo"])
@pytest.mark.parametrize(("v", "U"), [(0.5, -0.5), (-0.5, 0.5), (1.0, 1.0), (-1.0, -0.2)])
def test_on_its_own_plant_the_estimate_converges_from_everywhere(observer: str, v: float, U: float) -> None:
    x = truth(REVERSALS, (0.0, 0.0, 0.0), HL, law=rate_416)
    h = observe(x[:, 0], x[:, 2], REVERSALS, DT, start(0.0, v, U), SIGNED[observer], HL)
    error = np.hypot(h.v - x[:, 1], h.U - x[:, 2])
    # what is left comes of the throttle's jumps, which a speed measured at 25 Hz shows one sample late
    assert error[0] > 0.1 and np.max(error[75:]) < 0.02 and np.mean(error[75:]) < 2e-3


def test_on_its_own_plant_an_exact_estimate_stays_exact_through_reversals() -> None:
    x = truth(REVERSALS, (0.0, 0.0, 0.0), HL, law=rate_416)
    h = observe(x[:, 0], x[:, 2], REVERSALS, DT, start(0.0, 0.0, 0.0), SIGNED["nlo"], HL)
    assert np.max(abs(h.v - x[:, 1])) < 7e-4 and np.max(abs(h.U - x[:, 2])) < 1e-4


def test_on_the_plant_of_4_4_the_exact_estimate_is_left_at_each_reversal_and_only_there() -> None:
    x = truth(REVERSALS, (0.0, 0.0, 0.0), HL)
    h = observe(x[:, 0], x[:, 2], REVERSALS, DT, start(0.0, 0.0, 0.0), SIGNED["nlo"], HL)
    error = abs(h.v - x[:, 1])
    assert np.max(error[:75]) < 5e-3
    for begin in (75, 150, 225):
        assert np.max(error[begin : begin + 60]) > 0.045
        assert np.count_nonzero(error[begin : begin + 75] > 0.02) * DT > 0.4
    as_run = checked(SIGNED["nlo"]._replace(printed=0))
    better = observe(x[:, 0], x[:, 2], REVERSALS, DT, start(0.0, 0.0, 0.0), as_run, HL)
    assert np.max(abs(better.v - x[:, 1])) < 5e-3


def test_the_error_on_its_own_plant_decays_as_the_equations_say() -> None:
    # (4.16), (4.17) integrated by Euler at 0.1 ms, n and y taken from the truth
    throttles = np.full(50, 2.0)
    x = truth(throttles, (60.0, 0.05, 0.03), HL, law=rate_416)
    s, fine = SIGNED["nlo"], np.array([60.0, 0.05, 0.03])
    v, U, expected = 0.2, -0.1, []
    for k in range(50):
        for _ in range(400):
            n, y = fine[0], fine[2]
            own = rate_416(np.array([n, v, y]), throttles[k], HL)
            v_rate = own[1] + (s.k_11 + abs(n) * s.k_12) * (y - U)
            T = HL.c_T1 * n * abs(n) - HL.c_nv_T * abs(n) * v
            U_rate = -HL.k_U * U - HL.k_UU * U * abs(U) + HL.k_TU * T + (s.k_21 + abs(n) * s.k_22) * (y - U)
            fine = fine + 1e-4 * rate_416(fine, throttles[k], HL)
            v, U = v + 1e-4 * v_rate, U + 1e-4 * U_rate
        expected.append((v, U))
    h = observe(x[:, 0], x[:, 2], throttles, DT, start(60.0, 0.2, -0.1), SIGNED["nlo"], HL)
    found = np.transpose([h.v, h.U])
    assert np.max(abs(found - np.array(expected))) < 0.012
    np.testing.assert_allclose(found[25:], np.array(expected)[25:], atol=1e-3)


def test_a_spike_beyond_the_largest_innovation_does_not_move_the_observer() -> None:
    limited = checked(bench_settings("nlo")._replace(largest_innovation=0.3))
    belief = start(60.0, 0.07, 0.06)
    spike, innovation = observer_step(belief, 60.0, 0.9, DT, 2.0, limited, HL)
    missing, _ = observer_step(belief, 60.0, np.nan, DT, 2.0, limited, HL)
    assert innovation.gated_U == 1 and (spike.n, spike.v, spike.U) == (missing.n, missing.v, missing.U)
    shut = belief._replace(shut_U=0.6)
    used, innovation = observer_step(shut, 60.0, 0.9, DT, 2.0, limited, HL)
    assert innovation.used_U == 1 and used.U > 0.1


@pytest.mark.parametrize(("k_11", "k_21", "holds", "told"), [
    (0.3396, 0.6, True, "hold"), (-0.3396, 0.6, True, "hold"), (2.0, 0.6, False, "4.18"), (0.0, -0.24, False, "4.19"),
])  # fmt: skip
def test_the_conditions_on_the_gains_are_checked(k_11: float, k_21: float, holds: bool, told: str) -> None:
    check = check_gains(k_11, k_21, HL.k_v, HL.k_U)
    assert check.converges is holds and told in check.reason


def test_the_form_without_beta_is_that_with_some_beta() -> None:
    rng = np.random.default_rng(0)
    betas = np.geomspace(1e-4, 1e3, 20_001)
    for k_11, k_21 in rng.uniform(-3, 3, (300, 2)):
        printed = np.any((abs(k_11) < np.sqrt(2 * HL.k_v * betas)) & (k_21 > betas / 2 - HL.k_U))
        assert check_gains(k_11, k_21, HL.k_v, HL.k_U).converges == printed


def test_saturated_gains_meet_the_conditions_and_admissible_ones_are_left_alone() -> None:
    rng = np.random.default_rng(1)
    for k_11, k_21 in rng.uniform(-5, 5, (200, 2)):
        a, b = saturated_gains(k_11, k_21, HL.k_v, HL.k_U)
        assert check_gains(a, b, HL.k_v, HL.k_U).converges and a * k_11 >= 0
    assert saturated_gains(0.3, 0.6, HL.k_v, HL.k_U) == (0.3, 0.6)


def test_kfnlo_keeps_its_gains_within_the_conditions_where_asked_to() -> None:
    # a belief in which v and U hang together so that the Kalman gain of v is far beyond (4.18)
    belief = initial_belief(0.0, 0.05, 0.05, deviation_n=1.0, deviation_v=0.3, deviation_U=0.1)._replace(P_vU=0.029)
    settings = SIGNED["kfnlo"]._replace(r_U=0.05, k_12=0.0, k_22=0.0)
    gains = {}
    for saturate in (0, 1):
        after, i = observer_step(belief, np.nan, 0.5, DT, 0.0, settings._replace(saturate=saturate), HL)
        before, _ = observer_step(belief, np.nan, np.nan, DT, 0.0, settings, HL)
        gains[saturate] = ((after.v - before.v) / i.y_U / DT, (after.U - before.U) / i.y_U / DT)
        assert after.P_vv > 0 and after.P_vv * after.P_UU > after.P_vU**2
    # the measurement enters the prediction of v too, through sgn(n) y, which is 0 at n = 0
    assert gains[0][0] > 2 * sqrt(HL.k_v * (gains[0][1] + HL.k_U)) > gains[1][0] > 0
    assert gains[1][1] == pytest.approx(gains[0][1])


def test_kfnlo_adds_the_injection_of_one_period_to_what_the_kalman_gains_leave_of_the_innovation() -> None:
    belief = initial_belief(80.0, 0.1, 0.05, deviation_n=1.0, deviation_v=0.1, deviation_U=0.1)
    settings = SIGNED["kfnlo"]
    plain, i = observer_step(belief, np.nan, 0.2, DT, 2.5, settings._replace(k_12=0.0, k_22=0.0), HL)
    after, _ = observer_step(belief, np.nan, 0.2, DT, 2.5, settings, HL)
    left, share = 0.2 - plain.U, 1.0 - np.exp(-0.1 * abs(plain.n) * DT)
    assert abs(i.y_U) > 0.1 and pytest.approx(share * left, rel=1e-5) == after.U - plain.U
    assert after.v - plain.v == pytest.approx(0.1 / 0.1 * share * left, rel=1e-5)


def test_kfnlos_covariance_knows_what_the_injection_costs() -> None:
    throttles, rng = np.full(400, 2.5), np.random.default_rng(3)
    x: Array = truth(throttles, (90.0, 0.1, 0.09), HL)
    y_U = x[:, 2] + rng.normal(0, 0.05, 400)
    noise = {"r_U": 0.05**2, "r_n": 4.0, "q_v": 1e-6, "q_U": 1e-6}
    h = observe(x[:, 0], y_U, throttles, DT, start(90.0, 0.1, 0.09), checked(SIGNED["kfnlo"]._replace(**noise)), HL)
    ratio = np.mean((h.U - x[:, 2])[100:] ** 2) / np.mean(h.P_UU[100:])
    assert 0.5 < ratio < 2.0
    assert np.isclose(rate(x[0], 2.5, HL)[0], 0.0, atol=200.0)
