"""Jacobians, matrix functions and prediction, against finite differences, scipy and filterpy."""

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from thruster_truth import BENCH_HL, DT, HL, HQ, Array, rate

from thruster_estimation.belief import Belief, initial_belief
from thruster_estimation.correction import innovation_of
from thruster_estimation.drift import jacobian, rates
from thruster_estimation.matrices import Covariance, Matrix, congruent, exponential
from thruster_estimation.observers import observer_step
from thruster_estimation.settings import bench_settings, checked
from thruster_model.equations.thruster import ThrusterCoefficients, input_map
from thruster_model.parameter_set_io import load_parameter_set

UPPER = np.triu_indices(3)
EKF = bench_settings("ekf")
SIMPLIFIED = load_parameter_set("simplified").coefficients


def full(P: tuple[float, ...]) -> Array:
    M = np.zeros((3, 3))
    M[UPPER] = P
    return M + np.triu(M, 1).T


@pytest.mark.parametrize("p", [HL, HQ, SIMPLIFIED], ids=["hl", "hq", "simplified"])
@pytest.mark.parametrize("x", [(90.0, 0.12, 0.05), (-60.0, 0.04, -0.1), (30.0, -0.08, 0.1), (-110.0, -0.15, -0.13)])
def test_the_jacobian_is_the_slope_of_the_rates(p: ThrusterCoefficients, x: tuple[float, float, float]) -> None:
    F = np.array(jacobian(*x, p)).reshape(3, 3)
    for j, h in enumerate((1e-3, 1e-6, 1e-6)):
        ahead, behind = np.array(x), np.array(x)
        ahead[j] += h
        behind[j] -= h
        slope = np.array(rates(*ahead, 100.0, 0.0, 0, p)) - np.array(rates(*behind, 100.0, 0.0, 0, p))
        np.testing.assert_allclose(F[:, j], slope / (2 * h), rtol=1e-6, atol=1e-7)


def test_the_rates_are_those_of_the_thesis() -> None:
    for x in ((90.0, 0.12, 0.05), (-60.0, 0.04, -0.1)):
        np.testing.assert_allclose(rates(*x, input_map(2.0, HQ), 0.0, 0, HQ), rate(np.array(x), 2.0, HQ), rtol=1e-12)
        # (4.16) with y = 0.07 m/s
        n, v, U = x
        T = HQ.c_T1 * n * abs(n) - HQ.c_nv_T * abs(n) * v - HQ.c_v_T * v * abs(v)
        expected = -HQ.k_v * v - HQ.k_Uv * v * (abs(v) - HQ.k_w * np.sign(n) * 0.07) + HQ.k_Tv * T
        assert rates(n, v, U, 0.0, 0.07, 1, HQ)[1] == pytest.approx(expected, rel=1e-12)


def test_the_exponential_and_the_congruence_are_scipys_and_numpys() -> None:
    rng = np.random.default_rng(0)
    A, M = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    P = M @ M.T
    # fourth order: the first term left out is (0.05 |A|)^5 / 120
    np.testing.assert_allclose(np.reshape(exponential(Matrix(*A.ravel()), 0.05), (3, 3)), expm(0.05 * A), atol=1e-7)
    found = full(congruent(Matrix(*A.ravel()), Covariance(*P[UPPER])))
    np.testing.assert_allclose(found, A @ P @ A.T, rtol=1e-12)


@pytest.mark.parametrize("u", [0.0, 3.0, -2.0])
@pytest.mark.parametrize("p", [HL, HQ], ids=["hl", "hq"])
def test_the_prediction_of_states_and_covariance_agrees_with_scipy(u: float, p: ThrusterCoefficients) -> None:
    def both(t: float, z: Array) -> Array:
        F, P = np.array(jacobian(*z[:3], p)).reshape(3, 3), z[3:].reshape(3, 3)
        return np.concatenate([rate(z[:3], u, p), (F @ P + P @ F.T + np.diag([300.0, 0.002, 0.002])).ravel()])

    start = Belief(80.0, 0.09, 0.07, 25.0, 0.01, 0.002, 0.001, 0.0004, 0.0008)
    z = np.concatenate([start[:3], full(start[3:9]).ravel()])
    expected = solve_ivp(both, (0.0, DT), z, rtol=1e-10, atol=1e-12).y[:, -1]
    after, _ = observer_step(start, np.nan, np.nan, DT, u, EKF, p)
    # RK4 in steps of 10 ms, at up to 2300 rad/s^2
    assert np.all(abs(np.array(after[:3]) - expected[:3]) < [3e-4, 3e-6, 3e-6])
    np.testing.assert_allclose(full(after[3:9]).ravel(), expected[3:], rtol=3e-3, atol=2e-6)


def test_predict_and_update_are_filterpys_on_a_linear_thruster() -> None:
    # without quadratic terms and dead zones everything is linear, except that v sees U only through |v|
    zero = dict.fromkeys(ThrusterCoefficients._fields, 0.0)
    p = ThrusterCoefficients(**(zero | {
        "c_u1": 700.0, "c_u2": 700.0, "u_dot_max": 100.0, "k_n": 13.7, "k_v": 1.1, "k_U": 0.24, "drive_gain": 1.0,
    }))  # fmt: skip
    settings = checked(EKF._replace(unsigned=0))
    belief = Belief(10.0, 0.1, 0.05, 30.0, 0.05, -0.02, 0.004, 0.003, 0.006)
    oracle = ExtendedKalmanFilter(dim_x=3, dim_z=2)
    oracle.x, oracle.P = np.array(belief[:3]), full(belief[3:9])
    slopes = np.array([13.7, 1.1, 0.24])
    decay = np.exp(-slopes * DT)
    Q = np.diag([300.0, 0.002, 0.002] * (1 - decay**2) / (2 * slopes))
    H = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    rng = np.random.default_rng(1)
    for _ in range(50):
        u, z = rng.uniform(-3, 3), rng.normal(size=2) * [100.0, 0.1]
        oracle.F, oracle.Q, oracle.R = np.diag(decay), Q, np.diag([settings.r_n, settings.r_U])
        oracle.predict()
        oracle.x[0] += 700.0 * u * (1 - decay[0]) / 13.7
        prior, P_prior = oracle.x.copy(), oracle.P.copy()
        oracle.update(z, lambda x: H, lambda x: H @ x)
        belief, innovation = observer_step(belief, z[0], z[1], DT, u, settings, p)
        S = H @ P_prior @ H.T + oracle.R
        y = z - H @ prior
        assert np.all(abs(np.array(belief[:3]) - oracle.x) < [1e-3, 1e-6, 1e-6])
        np.testing.assert_allclose(full(belief[3:9]), oracle.P, rtol=1e-5, atol=1e-8)
        assert innovation.nis == pytest.approx(y @ np.linalg.solve(S, y), rel=1e-4)
        assert innovation.dof == 2


def test_the_covariance_stays_symmetric_and_positive_over_hard_inputs() -> None:
    rng = np.random.default_rng(2)
    belief = initial_belief(deviation_n=300.0, deviation_v=0.3, deviation_U=0.5)
    for _ in range(150):
        dt, u = rng.choice([0.0, 0.001, 0.04, 0.5, 3.0]), rng.uniform(-5, 5)
        z = rng.choice([np.nan, 0.0, 1e-6, 50.0, 1e4]), rng.choice([np.nan, 0.0, -0.3, 0.4, 30.0])
        belief, _ = observer_step(belief, z[0], z[1], dt, u, EKF, HQ)
        P = full(belief[3:9])
        scale = np.diag(1 / np.sqrt(np.maximum(np.diag(P), 1e-30)))
        assert np.all(np.isfinite(belief[:9])) and np.linalg.eigvalsh(scale @ P @ scale)[0] > -1e-9


@pytest.mark.parametrize("p", [HL, BENCH_HL], ids=["published", "bench"])
def test_v_grows_uncertain_without_measurements_only_up_to_its_ceiling(p: ThrusterCoefficients) -> None:
    # T = 0, v = 0 is an equilibrium for every U, and at U = 0.14 m/s the linearisation grows there
    v = 1e-3
    assert jacobian(0.0, v, 0.14, p).vv > 6.0
    belief = initial_belief(v=v, U=0.14, deviation_n=1.0, deviation_v=0.05, deviation_U=0.05)
    for _ in range(100):
        belief, _ = observer_step(belief, 0.0, 0.14, DT, 0.0, EKF._replace(unsigned=0), p)
        assert belief.P_vv**0.5 <= EKF.largest_v * (1 + 1e-9)


def test_the_joint_nis_is_that_of_the_correlated_pair() -> None:
    S, y = np.array([[9.0, -0.4], [-0.4, 0.04]]), np.array([2.0, 0.3])
    found = innovation_of(y[0], y[1], S[0, 0], S[0, 1], S[1, 1], True, False)
    assert found.nis == pytest.approx(y @ np.linalg.solve(S, y), rel=1e-12)
    assert (found.nis_n, found.nis_U, found.gated_n, found.gated_U) == pytest.approx((4.0 / 9.0, 2.25, 0, 1))


def test_in_the_prediction_of_the_nlo_the_ambient_flow_goes_straight_to_the_sample() -> None:
    settings = bench_settings("nlo")._replace(k_11=0.0, k_12=0.0, k_21=0.0, k_22=0.0)
    x, y = (70.0, -0.2, 0.1), 0.5

    def law(t: float, z: Array) -> Array:
        water = x[2] + (y - x[2]) * t / DT
        found = rate(z, 2.0, HL)
        found[1] += HL.k_Uv * HL.k_w * (z[1] * np.sign(z[0]) * water - abs(z[1]) * z[2])
        return found

    expected = solve_ivp(law, (0.0, DT), x, rtol=1e-10, atol=1e-12).y[:, -1]
    start = initial_belief(*x, deviation_n=1.0, deviation_v=0.1, deviation_U=0.1)
    after, _ = observer_step(start, np.nan, y, DT, 2.0, settings, HL)
    assert np.all(abs(np.array(after[:3]) - expected) < [3e-4, 1e-5, 1e-5])
