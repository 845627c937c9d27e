"""The extended Kalman filter of the rotor speed; truth comes from scipy, the linear oracle from filterpy."""

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.stats import chi2, norm

from thruster_estimation.belief import Belief, Status, initial_belief
from thruster_estimation.consistency import nis_interval
from thruster_estimation.correction import speed_measured, wrong_sign
from thruster_estimation.drift import rotor_rate, rotor_slope
from thruster_estimation.observers import observer_step
from thruster_estimation.offline import History, observe
from thruster_estimation.settings import SpeedEkfSettings, checked
from thruster_model.equations.thruster import ThrusterCoefficients, input_map

ZEROS = dict.fromkeys(ThrusterCoefficients._fields, 0.0) | {"drive_gain": 1.0}
# Table 3.1 of the thesis.
TABLE = ThrusterCoefficients(**(ZEROS | {
    "c_u1": 793.6, "c_u2": 709.0, "delta_u1": -0.8475, "delta_u2": 0.9254, "k_n": 11.3, "k_Q": 67.66,
    "u_dot_max": 100.0, "c_Q1": 1.577e-5, "c_Q2": 3.255e-5, "delta_Q1": -0.0215, "delta_Q2": 0.0192,
}))  # fmt: skip
LINEAR = TABLE._replace(k_Q=0.0)
DT, Q_DENSITY, R = 0.02, 400.0, 4.0
SETTINGS = checked(SpeedEkfSettings(q_n=Q_DENSITY, r_n=R, unsigned=0, largest_step=1e-3))
UNSIGNED = SETTINGS._replace(unsigned=1)
Array = NDArray[np.float64]


def start(n: float, deviation: float) -> Belief:
    return initial_belief(n, deviation_n=deviation, deviation_v=0.0, deviation_U=0.0)


def rate(_: float, n: Array, u: float, w: float) -> Array:
    """Table 3.1 written out again, so that the plant is not the filter's own code."""
    drive = 793.6 * min(u + 0.8475, 0.0) + 709.0 * max(u - 0.9254, 0.0)
    s = n * np.abs(n)
    load = 1.577e-5 * np.minimum(s + 0.0215, 0.0) + 3.255e-5 * np.maximum(s - 0.0192, 0.0)
    return np.asarray(-11.3 * n - 67.66 * load + drive + w)


def truth(throttles: Array, n_0: float, seed: int) -> tuple[Array, np.random.Generator]:
    """Integrate with white noise of density q, held over quarter periods."""
    rng = np.random.default_rng(seed)
    n, out, h = n_0, [], DT / 4
    for u in throttles:
        for _ in range(4):
            w = rng.normal() * np.sqrt(Q_DENSITY / h)
            n = float(solve_ivp(rate, (0.0, h), [n], args=(u, w), rtol=1e-8, atol=1e-8).y[0, -1])
        out.append(n)
    return np.array(out), rng


def run(measured: Array, throttles: Array, settings: SpeedEkfSettings, belief: Belief) -> History:
    return observe(measured, np.nan, throttles, DT, belief, settings, TABLE)


def test_a_single_update_gives_the_values_computed_by_hand() -> None:
    # P = 9, r = 16: S = 25, K = 0.36; y = 110 - 100 = 10; n = 103.6; P = 0.64 * 9 = 5.76.
    after, innovation = observer_step(start(100.0, 3.0), 110.0, np.nan, 0.0, 0.0, SETTINGS._replace(r_n=16.0), TABLE)
    assert (innovation.y_n, innovation.S_nn, innovation.nis, innovation.dof) == (10.0, 25.0, 4.0, 1)
    assert after.n == pytest.approx(103.6, abs=1e-12) and after.P_nn == pytest.approx(5.76, abs=1e-12)
    assert after.status == Status.USED_N | Status.NO_COVARIANCE


def test_an_unsigned_update_in_reverse_is_the_mirror_image_of_the_one_forward() -> None:
    after, _ = observer_step(start(-100.0, 3.0), 110.0, np.nan, 0.0, 0.0, UNSIGNED._replace(r_n=16.0), TABLE)
    assert after.n == pytest.approx(-103.6, abs=1e-12)


@pytest.mark.parametrize("n", [-150.0, -3.0, -0.05, 0.05, 3.0, 150.0])
@pytest.mark.parametrize("v", [0.0, 0.7, -0.7])
def test_the_slope_is_that_of_the_acceleration(n: float, v: float) -> None:
    p = TABLE._replace(c_nv_Q=1e-3, c_v_Q=0.1, k_2=0.01)
    h = 1e-4 * max(abs(n), 1.0) if abs(n) > 1 else 1e-5
    slope = (rotor_rate(n + h, v, 99.0, p) - rotor_rate(n - h, v, 99.0, p)) / (2 * h)
    assert rotor_slope(n, v, p) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("u", [0.0, 3.0, -4.0])
def test_the_prediction_agrees_with_scipy(u: float) -> None:
    def both(t: float, x: Array) -> list[float]:
        slope = (rate(t, x[0] + 1e-3, u, 0.0) - rate(t, x[0] - 1e-3, u, 0.0)) / 2e-3
        return [float(rate(t, x[0], u, 0.0)), float(2 * slope * x[1] + Q_DENSITY)]

    expected = solve_ivp(both, (0.0, 0.1), [80.0, 25.0], rtol=1e-9, atol=1e-9, max_step=1e-3).y[:, -1]
    after, _ = observer_step(start(80.0, 5.0), np.nan, np.nan, 0.1, u, SETTINGS, TABLE)
    assert after.n == pytest.approx(expected[0], abs=2e-3)
    assert after.P_nn == pytest.approx(expected[1], rel=1e-3)


def test_without_load_torque_the_filter_is_filterpys_kalman_filter() -> None:
    rng = np.random.default_rng(3)
    decay = np.exp(-11.3 * DT)
    oracle = KalmanFilter(dim_x=1, dim_z=1, dim_u=1)
    oracle.x, oracle.P = np.array([[20.0]]), np.array([[100.0]])
    oracle.F, oracle.B, oracle.H = np.array([[decay]]), np.array([[(1 - decay) / 11.3]]), np.array([[1.0]])
    oracle.Q, oracle.R = np.array([[Q_DENSITY * (1 - decay**2) / 22.6]]), np.array([[R]])
    belief = start(20.0, 10.0)
    for u, z in zip(rng.uniform(-4, 4, 200), rng.normal(0, 100, 200), strict=True):
        oracle.predict(u=np.array([[input_map(u, TABLE)]]))
        oracle.update(np.array([[z]]))
        belief, _ = observer_step(belief, z, np.nan, DT, u, SETTINGS, LINEAR)
        assert belief.n == pytest.approx(oracle.x.item(), abs=1e-9)
        assert belief.P_nn == pytest.approx(oracle.P.item(), abs=1e-9)


def test_on_a_known_plant_the_mean_nis_lies_in_its_chi_square_interval_and_errors_are_as_large_as_stated() -> None:
    throttles = 3.0 + 1.5 * np.sin(np.arange(600) * DT * 2.0)
    n, rng = truth(throttles, 0.0, seed=11)
    h = run(n + rng.normal(0, np.sqrt(R), n.size), throttles, SETTINGS, start(0.0, 1.0))
    low, high = nis_interval(n.size, 0.99)
    assert low < np.mean(h.nis) < high
    assert 0.8 < np.mean((h.n - n) ** 2 / h.P_nn) < 1.2


def test_a_noise_assumed_too_small_shows_in_the_mean_nis() -> None:
    throttles = np.full(200, 3.0)
    n, rng = truth(throttles, 0.0, seed=12)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    h = run(measured, throttles, SETTINGS._replace(r_n=R / 9, q_n=Q_DENSITY / 9), start(0.0, 1.0))
    assert np.mean(h.nis) > nis_interval(n.size, 0.9999)[1]


def test_the_nis_interval_is_the_chi_square_distributions_to_one_percent() -> None:
    for count in (10, 100, 1000):
        assert nis_interval(count) == pytest.approx(tuple(chi2.ppf([0.025, 0.975], count) / count), rel=1e-2)
        both = tuple(chi2.ppf([0.025, 0.975], 2 * count) / count)
        assert nis_interval(count, degrees=2) == pytest.approx(both, rel=1e-2)
    with pytest.raises(ValueError, match="count"):
        nis_interval(3)


def test_a_wrong_start_is_forgotten() -> None:
    throttles = np.full(50, 3.0)
    n, rng = truth(throttles, 100.0, seed=5)
    h = run(n + rng.normal(0, np.sqrt(R), n.size), throttles, SETTINGS, start(-200.0, 300.0))
    assert np.all(abs(h.n - n)[2:] < 4 * np.sqrt(h.P_nn[2:]))


def test_an_unsigned_tachometer_is_followed_through_reversals() -> None:
    throttles = np.repeat([3.0, -3.0, 3.0, -3.0], 50)
    n, rng = truth(throttles, 0.0, seed=8)
    h = run(abs(n + rng.normal(0, np.sqrt(R), n.size)), throttles, UNSIGNED, start(0.0, 5.0))
    assert np.min(n) < -50 < 50 < np.max(n)
    assert np.all(np.sign(h.n) == np.sign(n), where=abs(n) > 10)
    assert np.max(abs(h.n - n)) < 5 * np.sqrt(np.max(h.P_nn))


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_near_zero_an_unsigned_measurement_has_the_raised_noise_of_a_wrong_sign(share: float) -> None:
    sigma = 6.0
    added = 4 * quad(lambda x: x * x * norm.pdf(x, share * sigma, sigma), -60, 0)[0]
    assert wrong_sign(-share * sigma, sigma**2) == pytest.approx(added, rel=1e-6)
    after, innovation = observer_step(start(-share * sigma, sigma), 4.0, np.nan, 0.0, 0.0, UNSIGNED, TABLE)
    assert innovation.S_nn == pytest.approx(sigma**2 + R + added, rel=1e-6) and after.status & Status.AMBIGUOUS


def test_beyond_its_deviation_an_unsigned_measurement_has_the_plain_noise() -> None:
    assert speed_measured(6.1, 36.0, 4.0, UNSIGNED)[1:] == (R, False)


def test_over_a_stretch_of_nan_the_deviation_grows_and_then_recovers() -> None:
    throttles = np.full(60, 3.0)
    n, rng = truth(throttles, 0.0, seed=2)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    measured[30:40] = np.nan
    h = run(measured, throttles, SETTINGS, start(0.0, 5.0))
    assert np.all(np.diff(h.P_nn[29:40]) > 0) and h.P_nn[42] == pytest.approx(h.P_nn[29], rel=0.04)
    assert np.all(h.status[30:40].astype(int) & Status.PREDICTED) and np.all(np.isnan(h.y_n[30:40]))
    assert np.all(abs(h.n - n) < 4.5 * np.sqrt(h.P_nn))


def test_spikes_are_gated_and_all_else_is_used() -> None:
    throttles = np.full(100, 3.0)
    n, rng = truth(throttles, 0.0, seed=4)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    spikes = [20, 21, 50, 77]
    measured[spikes] += [80.0, -80.0, 200.0, -60.0]
    h = run(measured, throttles, SETTINGS._replace(gate=16.0), start(0.0, 5.0))
    assert list(np.flatnonzero(h.gated_n)) == spikes
    assert np.all(abs(h.n - n) < 4.5 * np.sqrt(h.P_nn))


def test_the_gate_refuses_only_above_its_threshold() -> None:
    belief = start(100.0, 3.0)  # S = 13
    for z, used in ((100.0 + 4 * np.sqrt(13.0) - 1e-9, 1), (100.0 + 4 * np.sqrt(13.0) + 1e-9, 0)):
        _, innovation = observer_step(belief, z, np.nan, 0.0, 0.0, SETTINGS._replace(gate=16.0), TABLE)
        assert (innovation.used_n, innovation.gated_n) == (used, 1 - used)
