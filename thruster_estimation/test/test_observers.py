"""All observers in their proper form: convergence, consistency, and what they do with bad input."""

import numpy as np
import pytest
from thruster_truth import DT, HL, HQ, Array, rate, truth

from thruster_estimation.belief import Belief, Level, Status, initial_belief, level, reason
from thruster_estimation.observers import observer_step
from thruster_estimation.offline import COLUMNS, History, compiled_step, observe
from thruster_estimation.settings import OBSERVERS, EkfSettings, bench_settings, checked

NOISE_N, NOISE_U = 2.0, 0.02
START = initial_belief(deviation_n=5.0, deviation_v=0.1, deviation_U=0.1)
EKF = checked(EkfSettings(q_n=100.0, q_v=5e-5, q_U=5e-5, r_n=NOISE_N**2, r_U=NOISE_U**2, gate=16.0))
SINE = 2.5 * np.sin(0.05 * np.arange(400))


def tuned(observer: str):  # type: ignore[no-untyped-def]
    settings = bench_settings(observer)
    known = {"r_n": NOISE_N**2, "r_U": NOISE_U**2, "q_n": 100.0, "q_v": 5e-5, "q_U": 5e-5}
    return checked(settings._replace(**{k: x for k, x in known.items() if k in settings._fields}))


def measured(x: Array, seed: int) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return abs(x[:, 0] + rng.normal(0, NOISE_N, len(x))), x[:, 2] + rng.normal(0, NOISE_U, len(x))


@pytest.fixture(scope="module")
def sine() -> tuple[Array, Array, Array]:
    x = truth(SINE, (0.0, 0.0, 0.0), HL)
    return (x, *measured(x, 3))


@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_loop_in_python_gives_what_the_compiled_loop_gives(observer: str, sine: tuple[Array, Array, Array]) -> None:
    _, y_n, y_U = sine
    y_n, y_U = y_n[:60].copy(), y_U[:60].copy()
    y_n[[5, 20]], y_U[[7, 30]] = [np.nan, 900.0], [np.nan, 5.0]
    settings = tuned(observer)._replace(gate=16.0)
    h, belief = observe(y_n, y_U, SINE[:60], DT, START, settings, HL), START
    for k in range(60):
        belief, i = observer_step(belief, y_n[k], y_U[k], DT, SINE[k], settings, HL)
        expected = np.array([*belief[:10], *i])
        np.testing.assert_allclose(h.table[:, k], expected, rtol=1e-9, atol=1e-12, equal_nan=True)
    assert len(COLUMNS) == expected.size and h.last.unseen_n == pytest.approx(belief.unseen_n)


@pytest.mark.parametrize(
    ("observer", "largest"), [("ekf", (3.0, 0.03, 0.02)), ("nlo", (3.0, 0.05, 0.03)), ("kfnlo", (3.0, 0.05, 0.03))]
)
def test_the_estimate_follows_the_truth_from_a_wrong_start(
    observer: str, largest: tuple[float, float, float], sine: tuple[Array, Array, Array]
) -> None:
    x, y_n, y_U = sine
    h = observe(y_n, y_U, SINE, DT, START._replace(v=0.1, U=-0.2), tuned(observer), HL)
    found = np.transpose([h.n, h.v, h.U])
    assert np.all(np.sqrt(np.mean((found - x)[100:] ** 2, axis=0)) < largest)


def test_the_ekf_is_consistent_where_its_noise_is_the_truth() -> None:
    rng = np.random.default_rng(5)
    x, states = np.array([60.0, 0.08, 0.07]), []
    settings = checked(EKF._replace(gate=np.inf, unsigned=0, q_v=2e-5, q_U=2e-5))
    throttles = 2.0 + 0.5 * np.sin(0.1 * np.arange(500))
    for u in throttles:
        for _ in range(4):
            x = x + rng.normal(size=3) * np.sqrt(np.array([100.0, 2e-5, 2e-5]) * DT / 4)
            h = DT / 4 / 10
            for _ in range(10):
                k_1 = rate(x, u, HL)
                x = x + h * rate(x + 0.5 * h * k_1, u, HL)
        states.append(x)
    truth_x = np.array(states)
    y_n = truth_x[:, 0] + rng.normal(0, NOISE_N, 500)
    y_U = truth_x[:, 2] + rng.normal(0, NOISE_U, 500)
    start = initial_belief(60.0, 0.08, 0.07, deviation_n=1.0, deviation_v=0.01, deviation_U=0.01)
    found = observe(y_n, y_U, throttles, DT, start, settings, HL)
    # chi-square with two degrees: standard error of the mean 2 / sqrt(500)
    assert abs(np.mean(found.nis) - 2.0) < 4 * 2 / np.sqrt(500)
    assert 0.8 < np.mean((found.n - truth_x[:, 0]) ** 2 / found.P_nn) < 1.25
    assert 0.5 < np.mean((found.v - truth_x[:, 1]) ** 2 / found.P_vv) < 2.0


def test_from_rest_inside_the_dead_zone_the_estimate_stays_and_the_sign_follows_the_throttle() -> None:
    throttles = np.concatenate([np.zeros(25), np.full(25, 0.5), np.full(50, -2.5)])
    x = truth(throttles, (0.0, 0.0, 0.0), HQ)
    y_n, y_U = measured(x, 9)
    h = observe(y_n, y_U, throttles, DT, START, EKF, HQ)
    assert np.max(abs(h.n[10:50])) < 3.0 and np.all(h.n[60:] < -20.0)
    assert np.all(np.isfinite(h.table[:9]))


def test_an_unsigned_tachometer_is_followed_through_reversals() -> None:
    throttles = np.repeat([3.0, 0.0, -3.0, 0.0, 3.0, -3.0], 25)
    x = truth(throttles, (0.0, 0.0, 0.0), HL)
    y_n, y_U = measured(x, 8)
    h = observe(y_n, y_U, throttles, DT, START, checked(EKF._replace(gate=np.inf)), HL)
    assert np.all(np.sign(h.n) == np.sign(x[:, 0]), where=abs(x[:, 0]) > 10)
    assert np.any(h.status.astype(int) & Status.AMBIGUOUS)


@pytest.mark.parametrize("observer", ["ekf", "kfnlo"])
def test_spikes_are_refused_and_leave_the_estimate_alone(observer: str, sine: tuple[Array, Array, Array]) -> None:
    y_n, y_U = sine[1].copy(), sine[2].copy()
    y_n[[120, 121, 300]] += 80.0
    y_U[[150, 151, 152, 310]] = [0.6, -0.6, 0.6, -0.6]
    settings = checked(tuned(observer)._replace(gate=16.0))
    h = observe(y_n, y_U, SINE, DT, START, settings, HL)
    plain = observe(*sine[1:], SINE, DT, START, settings, HL)
    assert np.all(h.gated_n[[120, 121, 300]] == 1) and np.all(h.gated_U[[150, 151, 152, 310]] == 1)
    assert np.mean(h.gated_n) < 0.02 and np.mean(h.gated_U) < 0.02
    assert np.max(abs(h.v - plain.v)) < 0.02 and np.max(abs(h.U - plain.U)[160:300]) < 0.01


def test_a_gap_is_no_refusal_so_a_spike_after_it_stays_refused() -> None:
    y_U = np.full(40, 0.05)
    y_U[5:30], y_U[30] = np.nan, 3.0
    h = observe(50.0 * np.ones(40), y_U, 1.9, DT, START, EKF, HL)
    assert h.gated_U[30] == 1 and h.used_U[31] == 1


def test_a_compiled_step_from_python_is_the_same_step() -> None:
    expected, innovation = observer_step(START, 50.0, 0.1, DT, 2.0, EKF, HL)
    after, found = compiled_step(START, 50.0, 0.1, DT, 2.0, EKF, HL)
    np.testing.assert_allclose(after, expected, rtol=1e-12)
    np.testing.assert_allclose(found, innovation, rtol=1e-12)


def test_a_gate_that_stayed_shut_reopens_after_its_patience_and_the_estimate_recovers() -> None:
    throttles = np.full(200, 2.0)
    x = truth(throttles, (0.0, 0.0, 0.0), HL)
    y_n, y_U = measured(x, 1)
    y_U[100:] += 0.4  # a current sets in: nothing in the model makes U jump
    settings = checked(EKF._replace(q_U=0.002))
    h = observe(y_n, y_U, throttles, DT, START, settings, HL)
    shut = np.flatnonzero(h.gated_U[100:]) + 100
    reopened = np.flatnonzero(h.status.astype(int) & Status.REOPENED)
    assert len(reopened) and 0.5 <= (reopened[0] - 100) * DT < 0.6
    assert np.all(h.gated_U[100 : reopened[0]] == 1) and np.mean(h.used_U[reopened[0] + 20 :]) > 0.9
    assert abs(h.U[-1] - y_U[-20:].mean()) < 0.06 and shut.size < 40
    never = observe(y_n, y_U, throttles, DT, START, checked(settings._replace(patience=np.inf)), HL)
    assert np.all(never.gated_U[110:] == 1)


@pytest.mark.parametrize("observer", OBSERVERS)
def test_missing_and_unusable_measurements_leave_the_prediction(observer: str) -> None:
    settings, start = tuned(observer), START._replace(n=40.0, v=0.05, U=0.04)
    nothing, _ = observer_step(start, np.nan, np.nan, DT, 2.0, settings, HL)
    for bad in (np.inf, -np.inf, -3.0):
        after, innovation = observer_step(start, bad, np.nan, DT, 2.0, settings, HL)
        assert after == nothing and np.isnan(innovation.y_n) and innovation.used_n == 0
    assert nothing.unseen_n == DT and level(nothing.status) == Level.DEGRADED
    assert "no usable speed" in reason(nothing.status)


@pytest.mark.parametrize("observer", OBSERVERS)
def test_stale_measurements_show_in_the_status_and_go_with_the_next_ones(observer: str) -> None:
    n, U = np.full(40, np.nan), np.full(40, np.nan)
    n[[0, 1, 38, 39]], U[[0, 1, 38, 39]] = 40.0, 0.04
    h = observe(n, U, 1.6, DT, START._replace(n=40.0), tuned(observer), HL)
    status = h.status.astype(int)
    assert not status[10] & Status.STALE_N and status[20] & Status.STALE_N and not status[38] & Status.STALE_N
    assert level(status[20]) == Level.INVALID and "too long" in reason(status[20])
    assert bool(status[20] & Status.STALE_U) == (observer != "speed-ekf")
    assert np.all(np.isfinite(h.table[:3])) and not np.any(np.isnan(h.table[:9]))


@pytest.mark.parametrize("observer", OBSERVERS)
def test_an_unknown_throttle_holds_n_and_widens_it(observer: str) -> None:
    settings, start = tuned(observer), START._replace(n=60.0, v=0.05, U=0.04)
    after, _ = observer_step(start, np.nan, np.nan, DT, np.nan, settings, HL)
    assert after.n == pytest.approx(60.0, abs=0.2) and after.P_nn > (1000.0 * DT) ** 2
    assert after.status & Status.NO_THROTTLE and level(after.status) == Level.DEGRADED


@pytest.mark.parametrize("dt", [np.nan, np.inf, -0.04])
@pytest.mark.parametrize("observer", OBSERVERS)
def test_a_period_that_is_none_predicts_nothing_and_says_so(observer: str, dt: float) -> None:
    start = START._replace(n=60.0)
    after, _ = observer_step(start, np.nan, np.nan, dt, 2.0, tuned(observer), HL)
    assert after[:3] == start[:3] and after.status & Status.BAD_PERIOD and level(after.status) == Level.INVALID


@pytest.mark.parametrize("observer", OBSERVERS)
def test_an_estimate_that_left_the_numbers_starts_again(observer: str) -> None:
    after, _ = observer_step(START._replace(v=np.nan), 50.0, 0.1, DT, 2.0, tuned(observer), HL)
    assert after[:3] == (0.0, 0.0, 0.0) and after.status & Status.RESTARTED and level(after.status) == Level.INVALID
    assert after.P_nn == 300.0**2
    again, _ = observer_step(after, 50.0, 0.1, DT, 2.0, tuned(observer), HL)
    assert not again.status & Status.RESTARTED and abs(again.n) > 25.0


def test_observers_without_a_covariance_of_v_and_U_say_so_and_never_nan() -> None:
    for observer in ("nlo", "speed-ekf"):
        h = observe(50.0 * np.ones(9), 0.05, 2.0, DT, START, tuned(observer), HL)
        assert np.all(np.isinf(h.P_vv)) and np.all(np.isinf(h.P_UU)) and np.all(h.P_vU == 0)
        assert np.all(h.status.astype(int) & Status.NO_COVARIANCE)


def test_a_measurement_of_zero_speed_over_a_long_rest_keeps_everything_bounded() -> None:
    h = observe(np.zeros(5000), 0.1 * np.ones(5000), 0.0, DT, START, tuned("ekf"), HL)
    assert abs(h.n[-1]) < 1.0 and h.U[-1] == pytest.approx(0.1, abs=0.06)
    assert np.max(h.P_vv) <= 0.3**2 * (1 + 1e-9)


def test_wrong_settings_and_beliefs_are_refused_with_evidence() -> None:
    with pytest.raises(ValueError, match=r"q_n.*-1.*r_U: expected a number > 0, got 0.*form: expected 0 or 1, got 7"):
        checked(EKF._replace(q_n=-1.0, r_U=0.0, form=7))
    with pytest.raises(ValueError, match="expected one of ekf"):
        bench_settings("ukf")
    with pytest.raises(ValueError, match="deviations >= 0"):
        initial_belief(deviation_n=-1.0, deviation_v=1.0, deviation_U=1.0)
    with pytest.raises(ValueError, match="shape"):
        observe(np.zeros((2, 2)), 0.0, 0.0, DT, START, EKF, HL)
    with pytest.raises(AttributeError, match="no column 'w'"):
        _ = History(np.zeros((len(COLUMNS), 1)), START).w


def test_the_status_is_told_in_words() -> None:
    assert level(Status.INITIAL) == Level.INVALID and reason(Status.INITIAL) == "no step taken yet"
    assert level(Status.USED_N | Status.USED_U) == Level.OK and reason(Status.USED_N) == ""
    assert level(Status.USED_N | Status.NO_COVARIANCE) == Level.OK
    assert level(Status.USED_N | Status.GATED_U) == Level.DEGRADED and "ambient flow" in reason(
        Status.GATED_U | Status.USED_N
    )
    assert isinstance(START, Belief)
