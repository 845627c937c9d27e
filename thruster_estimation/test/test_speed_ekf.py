"""The extended Kalman filter of the rotor speed; truth comes from scipy, the linear oracle from filterpy."""

import re
from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.stats import chi2, norm

from thruster_estimation.speed_ekf import (
    Innovation,
    Settings,
    SpeedBelief,
    Status,
    Step,
    acceleration,
    correct,
    gated,
    innovation_of,
    jacobian,
    nis_interval,
    predict,
    step,
    validity,
)
from thruster_model.equations.thruster import ThrusterCoefficients

ZEROS = dict.fromkeys(ThrusterCoefficients._fields, 0.0) | {"drive_gain": 1.0}
# Table 3.1 of the thesis.
TABLE = ThrusterCoefficients(**(ZEROS | {
    "c_u1": 793.6, "c_u2": 709.0, "delta_u1": -0.8475, "delta_u2": 0.9254, "k_n": 11.3, "k_Q": 67.66,
    "u_dot_max": 100.0, "c_Q1": 1.577e-5, "c_Q2": 3.255e-5, "delta_Q1": -0.0215, "delta_Q2": 0.0192,
}))  # fmt: skip
LINEAR = TABLE._replace(k_Q=0.0)
DT, Q_DENSITY, R = 0.02, 400.0, 4.0
SETTINGS = Settings(coefficients=TABLE, q=Q_DENSITY, r=R)
Array = NDArray[np.float64]


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


def run(measured: Array, throttles: Array, settings: Settings, start: SpeedBelief) -> list[Step]:
    steps, belief = [], start
    for z, u in zip(measured, throttles, strict=True):
        steps.append(step(belief, z, DT, u=u, settings=settings))
        belief = steps[-1].belief
    return steps


def values(steps: list[Step]) -> tuple[Array, Array]:
    return np.array([s.belief.n for s in steps]), np.array([s.belief.deviation for s in steps])


def test_a_single_update_gives_the_values_computed_by_hand() -> None:
    # P = 9, r = 16: S = 25, K = 0.36; y = 110 - 100 = 10; n = 103.6; P = 0.64 * 9 = 5.76.
    belief = SpeedBelief(n=100.0, deviation=3.0)
    innovation = innovation_of(belief, 110.0, replace(SETTINGS, r=16.0))
    assert (innovation.y, innovation.S, innovation.nis) == (10.0, 25.0, 4.0)
    after = correct(belief, innovation)
    assert after.n == pytest.approx(103.6, abs=1e-12)
    assert after.deviation == pytest.approx(2.4, abs=1e-12)
    assert after.status is Status.UPDATED


def test_an_unsigned_update_in_reverse_is_the_mirror_image_of_the_one_forward() -> None:
    settings = replace(SETTINGS, r=16.0, unsigned=True)
    belief = SpeedBelief(n=-100.0, deviation=3.0)
    after = correct(belief, innovation_of(belief, 110.0, settings))
    assert after.n == pytest.approx(-103.6, abs=1e-12)


@pytest.mark.parametrize("n", [-150.0, -3.0, -0.05, 0.05, 3.0, 150.0])
@pytest.mark.parametrize("v", [0.0, 0.7, -0.7])
def test_the_jacobian_is_the_slope_of_the_acceleration(n: float, v: float) -> None:
    p = TABLE._replace(c_nv_Q=1e-3, c_v_Q=0.1, k_2=0.01)
    h = 1e-4 * max(abs(n), 1.0) if abs(n) > 1 else 1e-5
    slope = (acceleration(n + h, 2.0, v, p) - acceleration(n - h, 2.0, v, p)) / (2 * h)
    assert jacobian(n, v, p) == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("u", [0.0, 3.0, -4.0])
def test_the_prediction_agrees_with_scipy(u: float) -> None:
    def both(t: float, x: Array) -> list[float]:
        slope = (rate(t, x[0] + 1e-3, u, 0.0) - rate(t, x[0] - 1e-3, u, 0.0)) / 2e-3
        return [float(rate(t, x[0], u, 0.0)), float(2 * slope * x[1] + Q_DENSITY)]

    expected = solve_ivp(both, (0.0, 0.1), [80.0, 25.0], rtol=1e-9, atol=1e-9, max_step=1e-3).y[:, -1]
    after = predict(SpeedBelief(n=80.0, deviation=5.0), 0.1, u, SETTINGS)
    assert after.n == pytest.approx(expected[0], abs=2e-3)
    assert after.deviation**2 == pytest.approx(expected[1], rel=1e-3)


def test_without_load_torque_the_filter_is_filterpys_kalman_filter() -> None:
    rng = np.random.default_rng(3)
    decay = np.exp(-11.3 * DT)
    oracle = KalmanFilter(dim_x=1, dim_z=1, dim_u=1)
    oracle.x, oracle.P = np.array([[20.0]]), np.array([[100.0]])
    oracle.F, oracle.B, oracle.H = np.array([[decay]]), np.array([[(1 - decay) / 11.3]]), np.array([[1.0]])
    oracle.Q, oracle.R = np.array([[Q_DENSITY * (1 - decay**2) / 22.6]]), np.array([[R]])
    belief, settings = SpeedBelief(n=20.0, deviation=10.0), replace(SETTINGS, coefficients=LINEAR)
    for u, z in zip(rng.uniform(-4, 4, 200), rng.normal(0, 100, 200), strict=True):
        oracle.predict(u=np.array([[793.6 * min(u + 0.8475, 0.0) + 709.0 * max(u - 0.9254, 0.0)]]))
        oracle.update(np.array([[z]]))
        belief = step(belief, z, DT, u=u, settings=settings).belief
        assert belief.n == pytest.approx(oracle.x.item(), abs=1e-9)
        assert belief.deviation**2 == pytest.approx(oracle.P.item(), abs=1e-9)


def test_on_a_known_plant_the_mean_nis_lies_in_its_chi_square_interval_and_errors_are_as_large_as_stated() -> None:
    throttles = 3.0 + 1.5 * np.sin(np.arange(600) * DT * 2.0)
    n, rng = truth(throttles, 0.0, seed=11)
    steps = run(n + rng.normal(0, np.sqrt(R), n.size), throttles, SETTINGS, SpeedBelief(n=0.0, deviation=1.0))
    low, high = nis_interval(n.size, 0.99)
    assert low < np.mean([s.innovation.nis for s in steps if s.innovation]) < high
    estimate, deviation = values(steps)
    assert 0.8 < np.mean(((estimate - n) / deviation) ** 2) < 1.2


def test_a_noise_assumed_too_small_shows_in_the_mean_nis() -> None:
    throttles = np.full(200, 3.0)
    n, rng = truth(throttles, 0.0, seed=12)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    steps = run(measured, throttles, replace(SETTINGS, r=R / 9, q=Q_DENSITY / 9), SpeedBelief(n=0.0, deviation=1.0))
    assert np.mean([s.innovation.nis for s in steps if s.innovation]) > nis_interval(n.size, 0.9999)[1]


def test_the_nis_interval_is_the_chi_square_distributions_to_one_percent() -> None:
    for count in (10, 100, 1000):
        assert nis_interval(count) == pytest.approx(tuple(chi2.ppf([0.025, 0.975], count) / count), rel=1e-2)


def test_a_wrong_start_is_forgotten() -> None:
    throttles = np.full(50, 3.0)
    n, rng = truth(throttles, 100.0, seed=5)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    estimate, deviation = values(run(measured, throttles, SETTINGS, SpeedBelief(n=-200.0, deviation=300.0)))
    assert np.all(np.abs(estimate - n)[2:] < 4 * deviation[2:])


def test_an_unsigned_tachometer_is_followed_through_reversals() -> None:
    throttles = np.repeat([3.0, -3.0, 3.0, -3.0], 50)
    n, rng = truth(throttles, 0.0, seed=8)
    measured = np.abs(n + rng.normal(0, np.sqrt(R), n.size))
    steps = run(measured, throttles, replace(SETTINGS, unsigned=True), SpeedBelief(n=0.0, deviation=5.0))
    estimate, deviation = values(steps)
    assert np.min(n) < -50 < 50 < np.max(n)
    assert np.all(np.sign(estimate) == np.sign(n), where=np.abs(n) > 10)
    assert np.max(np.abs(estimate - n)) < 5 * np.max(deviation)


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_near_zero_an_unsigned_measurement_has_the_raised_noise_of_a_wrong_sign(share: float) -> None:
    sigma = 6.0
    belief = SpeedBelief(n=-share * sigma, deviation=sigma)
    innovation = innovation_of(belief, 4.0, replace(SETTINGS, unsigned=True))
    added = 4 * quad(lambda x: x * x * norm.pdf(x, share * sigma, sigma), -60, 0)[0]
    assert innovation.r == pytest.approx(R + added, rel=1e-6)
    after = correct(belief, innovation)
    assert after.status is Status.AMBIGUOUS and "raised r" in after.reason


def test_beyond_its_deviation_an_unsigned_measurement_has_the_plain_noise() -> None:
    assert innovation_of(SpeedBelief(n=6.1, deviation=6.0), 4.0, replace(SETTINGS, unsigned=True)).r == R


def test_over_a_stretch_of_nan_the_deviation_grows_and_then_recovers() -> None:
    throttles = np.full(60, 3.0)
    n, rng = truth(throttles, 0.0, seed=2)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    measured[30:40] = np.nan
    steps = run(measured, throttles, SETTINGS, SpeedBelief(n=0.0, deviation=5.0))
    estimate, deviation = values(steps)
    assert np.all(np.diff(deviation[29:40]) > 0)
    assert deviation[42] == pytest.approx(deviation[29], rel=0.02)
    assert all(s.belief.status is Status.PREDICTED and s.innovation is None for s in steps[30:40])
    assert steps[39].belief.unseen == pytest.approx(10 * DT) and steps[40].belief.unseen == 0
    assert np.all(np.abs(estimate - n) < 4.5 * deviation)


def test_spikes_are_gated_and_all_else_is_used() -> None:
    throttles = np.full(100, 3.0)
    n, rng = truth(throttles, 0.0, seed=4)
    measured = n + rng.normal(0, np.sqrt(R), n.size)
    spikes = [20, 21, 50, 77]
    measured[spikes] += [80.0, -80.0, 200.0, -60.0]
    steps = run(measured, throttles, replace(SETTINGS, gate=16.0), SpeedBelief(n=0.0, deviation=5.0))
    assert [k for k, s in enumerate(steps) if s.belief.status is Status.GATED] == spikes
    assert "NIS" in steps[50].belief.reason
    estimate, deviation = values(steps)
    assert np.all(np.abs(estimate - n) < 4.5 * deviation)


def test_the_gate_refuses_only_above_its_threshold() -> None:
    assert not gated(Innovation(4.0, 4.0, 1.0), 4.0)
    assert gated(Innovation(4.01, 4.0, 1.0), 4.0)


@pytest.mark.parametrize(
    ("measured", "unsigned", "reason"),
    [(None, False, "missing"), (np.nan, False, "nan"), (np.inf, False, "inf"), (-3.0, True, "unsigned .* -3")],
)
def test_an_unusable_measurement_leaves_the_prediction_and_says_why(
    measured: float | None, unsigned: bool, reason: str
) -> None:
    start, settings = SpeedBelief(n=50.0, deviation=2.0), replace(SETTINGS, unsigned=unsigned)
    after = step(start, measured, DT, u=2.0, settings=settings).belief
    expected = predict(start, DT, 2.0, settings)
    assert (after.n, after.deviation, after.status) == (expected.n, expected.deviation, Status.PREDICTED)
    assert re.search(reason, after.reason)


def test_a_belief_too_wide_or_too_old_is_not_valid_and_says_both() -> None:
    old = SpeedBelief(n=0.0, deviation=9.0, unseen=2.0)
    assert validity(old, 10.0, 3.0).valid
    refused = validity(old, 5.0, 1.0)
    assert not refused.valid and "deviation 9 > 5" in refused.reason and "2 > 1 s" in refused.reason


def test_wrong_settings_and_inputs_are_refused_with_evidence() -> None:
    with pytest.raises(ValueError, match=r"r = 0.*q = -1"):
        Settings(coefficients=TABLE, q=-1.0, r=0.0)
    with pytest.raises(ValueError, match="deviation"):
        SpeedBelief(n=0.0, deviation=-1.0)
    with pytest.raises(ValueError, match="nan V"):
        predict(SpeedBelief(n=0.0, deviation=1.0), DT, np.nan, SETTINGS)
    with pytest.raises(ValueError, match="count"):
        nis_interval(3)
