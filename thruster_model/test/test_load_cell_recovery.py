"""Thrust out of a ringing load cell, against truth from another implementation, integrated by scipy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import multivariate_normal

from thruster_model.errors import UnfitDataError
from thruster_model.load_cell.preparation import Recording, jumps, stretch_of, thesis_windows
from thruster_model.load_cell.ringdown import Segment, fit_segment, ring_down
from thruster_model.load_cell.smoothing import LinearModel, log_likelihood, smooth
from thruster_model.load_cell.study import recover_recordings

ARM, LEAK = 0.24, 0.2
TIMES = (1.0, 6.0, 11.0)


def true_thrust(t, scale):
    """A start, a reversal with an overshoot, and a stop; each throttle jump is answered within 30 ms."""
    rise = [np.clip((t - s) / 0.03, 0.0, 1.0) for s in TIMES]
    over = 25.0 * np.exp(-(((t - 6.05) / 0.04) ** 2))
    return scale * (-12.0 * rise[0] + (23.0 * rise[1] + over * rise[1]) - 11.0 * rise[2])


def record(name, rng, scale=1.0, f_1=15.0, softening=0.8, damping=0.035, reaction=0.0):
    """A mode whose frequency follows its own momentary amplitude, shaft and blade lines, sensor noise; 1 kHz.

    `reaction` [N] is a push at each jump that is no thrust.
    """
    time = np.arange(0.0, 13.0, 0.001)

    def rates(t, x):
        q, r = x
        T = true_thrust(t, scale)
        w = 2 * np.pi * (f_1 - softening * np.log10(max(0.3, np.hypot(q - T, r / 90.0))))
        kick = sum(reaction * np.exp(-(((t - s - 0.03) / 0.02) ** 2)) for s in TIMES)
        return [r, w**2 * (T + kick - q) - 2 * damping * w * r]

    solution = solve_ivp(rates, (0.0, 13.0), [0.0, 0.0], t_eval=time, max_step=0.005, rtol=1e-6, atol=1e-6)
    q, T = solution.y[0], true_thrust(time, scale)
    running = (time > TIMES[0]) & (time < TIMES[2])
    shaft = 2 * np.pi * 17.0 * time + rng.uniform(0, 6)
    wrench = np.zeros((time.size, 6))
    wrench[:, 0] = q + running * (0.4 * np.sin(shaft) + 0.7 * np.sin(3 * shaft)) + 0.1 * rng.normal(size=time.size)
    ring = T + LEAK * (q - T) + running * 3.0 * np.sin(2 * shaft)
    wrench[:, 4] = ARM * (ring + 0.3 * rng.normal(size=time.size))
    throttle = np.select([time < TIMES[0], time < TIMES[1], time < TIMES[2]], [0.0, -3.0, 3.0], 0.0)
    return Recording(
        name=name, time=time, wrench=wrench, legs=None, speed=100.0 * running, throttle=throttle, setpoint=None,
        turned=False,
    ), T  # fmt: skip


@pytest.fixture(scope="module")
def study():
    rng = np.random.default_rng(3)
    made = [record(f"run_{i}", rng, scale, f_1) for i, (scale, f_1) in enumerate([(1, 15.0), (0.9, 15.3), (0.7, 14.8)])]
    truth = {r.name: (r.time, T) for r, T in made}
    return recover_recordings([r for r, _ in made]), truth


def errors(study):
    """Return error [N], stated deviation [N], reading's error [N] of all cells within 1.2 s after a jump."""
    found, truth = study
    rows = []
    for name, r in found.recovered.items():
        time, T = truth[name]
        means = np.array([T[(time >= c - 0.02) & (time < c + 0.02)].mean() for c in r.cell_time])
        for start in TIMES:
            k = (r.cell_time > start - 0.04) & (r.cell_time < start + 1.2)
            rows.append([(r.cell_thrust - means)[k], r.cell_deviation[k], (r.cell_reading - means)[k]])
    return [np.concatenate(column) for column in zip(*rows, strict=True)]


def test_the_mode_is_found_within_its_deviations(study):
    resonance = study[0].resonance
    assert resonance.mode.frequency == pytest.approx(15.0, abs=3 * resonance.deviation["frequency"])
    assert resonance.deviation["frequency"] < 1.0
    assert resonance.mode.damping == pytest.approx(0.035, abs=0.015)
    assert resonance.mode.leak == pytest.approx(LEAK, abs=0.03)
    assert resonance.mode.arm_gain == pytest.approx(1.0, abs=0.05)
    assert study[0].arm == pytest.approx(ARM, rel=0.03)


def test_errors_of_the_recovered_thrust_are_within_what_is_stated(study):
    error, deviation, _ = errors(study)
    assert np.mean(np.abs(error) < 2 * deviation) > 0.85
    assert np.mean(np.abs(error) < deviation) > 0.5


def test_the_recovered_thrust_is_several_times_closer_to_the_truth_than_the_reading(study):
    error, _, reading = errors(study)
    assert np.sqrt(np.mean(error**2)) < np.sqrt(np.mean(reading**2)) / 3


def test_force_and_moment_say_the_same_once_the_moment_leaks_what_is_said(study):
    for r in study[0].recovered.values():
        after = (r.cell_time > TIMES[1] - 0.2) & (r.cell_time < TIMES[1] + 0.8)
        assert np.sqrt(np.mean(r.cell_difference[after] ** 2)) < 0.6


def test_the_windows_are_recovered(study):
    assert all(saved.below_one > 0.6 for saved in study[0].saved.values())


def test_frequency_and_damping_of_a_clean_ring_are_exact():
    t = np.arange(0, 0.25, 0.005)
    w, zeta = 2 * np.pi * 13.3, 0.04
    y = np.exp(-zeta * w * t) * 5 * np.cos(w * np.sqrt(1 - zeta**2) * t + 0.3) + 8 - 3 * t
    found = fit_segment("clean", t + 4.0, y)
    assert (found.frequency, found.damping) == pytest.approx((13.3, 0.04), rel=1e-5)
    assert found.usable and found.start == pytest.approx(4.0)


def test_noise_is_not_taken_for_ringing():
    rng = np.random.default_rng(5)
    t = np.arange(0, 0.25, 0.005)
    assert not any(fit_segment("noise", t, 0.3 * rng.normal(size=t.size)).usable for _ in range(20))
    with pytest.raises(UnfitDataError, match="at least 3 segments that ring"):
        ring_down([fit_segment("noise", t, 0.3 * rng.normal(size=t.size))])


def test_a_softening_law_is_found_in_segments_that_follow_one():
    rng = np.random.default_rng(2)
    segments = [
        Segment(name=f"r{i % 4}", start=0.0, amplitude=A, frequency=15 - 1.2 * np.log10(A) + 0.1 * rng.normal(),
                damping=0.04, residual=0.1)
        for i, A in enumerate(np.geomspace(1.1, 20, 24))
    ]  # fmt: skip
    found = ring_down(segments)
    for name, truth in (("frequency", 15.0), ("softening", 1.2)):
        assert abs(found.values[name] - truth) < 4 * found.deviation[name] + 0.02
    assert found.frequency_scatter < 0.2 < found.rigid_scatter


def test_filter_and_smoother_are_those_of_the_joint_gaussian():
    rng = np.random.default_rng(4)
    N, F, Q, H = 5, rng.normal(size=(5, 2, 2)) * 0.6, np.diag([0.3, 0.2]), rng.normal(size=(2, 2))
    model = LinearModel(
        F=F, Q=np.tile(Q, (N, 1, 1)), H=H, R=np.array([0.1, 0.2]), mean=np.array([1.0, -1.0]), covariance=np.eye(2)
    )
    L = np.zeros((2 * N, 2 * N))  # states as a linear map of x_0 and the process noise
    for k in range(N):
        L[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = np.eye(2)
        if k:
            L[2 * k : 2 * k + 2, : 2 * k] = F[k - 1] @ L[2 * k - 2 : 2 * k, : 2 * k]
    prior = L @ np.kron(np.diag([0, 1, 1, 1, 1]), Q) @ L.T + L[:, :2] @ L[:, :2].T
    mean, C = L[:, :2] @ model.mean, np.kron(np.eye(N), H)
    S = C @ prior @ C.T + np.kron(np.eye(N), np.diag(model.R))
    y = rng.normal(size=(N, 2))
    gain = prior @ C.T @ np.linalg.inv(S)
    assert log_likelihood(y, model) == pytest.approx(multivariate_normal(C @ mean, S).logpdf(y.ravel()))
    found = smooth(y, model)
    np.testing.assert_allclose(found.mean.ravel(), mean + gain @ (y.ravel() - C @ mean), atol=1e-10)
    posterior = prior - gain @ C @ prior
    for k in range(N):
        np.testing.assert_allclose(found.covariance[k], posterior[2 * k : 2 * k + 2, 2 * k : 2 * k + 2], atol=1e-10)


def test_the_windows_of_the_thesis_follow_from_the_set_points():
    t = np.arange(251) * 0.04 + 0.5
    step = np.where(t - 0.5 < 5.0, -10.0, 10.0)
    assert thesis_windows(t, step) == [(0.5, 1.7), (5.5, 6.7)]
    ramp = np.interp(t - 0.5, [0, 2, 3, 7, 8, 10], [0, -10, -10, 10, 10, 0])
    assert thesis_windows(t, ramp) == [(0.5, 1.1), (5.3, 6.5)]
    assert thesis_windows(t, 5 * np.cos(1.88 * t) - 5) == []


def test_what_is_missing_is_named():
    r, _ = record("quiet", np.random.default_rng(1))
    bare = Recording(**{**vars(r), "speed": None})
    with pytest.raises(UnfitDataError, match="quiet: expected rotor speed beside the load cell"):
        stretch_of(bare, ARM)
    with pytest.raises(UnfitDataError, match="expected runs with rotor speed and throttle; found none among quiet"):
        recover_recordings([bare])
    assert jumps(stretch_of(r, ARM)) == pytest.approx(TIMES, abs=0.03)
