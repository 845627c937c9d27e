import math

import numpy as np
import pytest

from thruster_estimation.belief import Status
from thruster_estimation.offline import observe
from thruster_estimation.online import (
    START,
    Measured,
    advance,
    covariance_matrix,
    first_belief,
    mean_throttle,
    states,
)
from thruster_estimation.settings import BENCH, PROPER, bench_settings
from thruster_model.parameter_set_io import load_parameter_set

P = load_parameter_set("hl").coefficients
PERIOD = 40_000_000  # ns
RNG = np.random.default_rng(5)
N = 40
U_IN = 2.0 * np.sin(0.2 * np.arange(N))
Y_N, Y_U = abs(60.0 * np.sin(0.2 * np.arange(N) - 0.3)) + RNG.normal(size=N), 0.1 + 0.02 * RNG.normal(size=N)
Y_N[7], Y_U[[3, 9]] = math.nan, math.nan


def tracked(observer: str, form: int) -> list[tuple[float, ...]]:
    settings, track, found = bench_settings(observer, form=form), START, []
    for k in range(N):
        measured = Measured(k * PERIOD, Y_N[k], Y_U[k], True)
        track = advance(track, measured, U_IN[k - 1] if k else math.nan, settings, P)
        assert track.belief is not None
        found.append(track.belief[:9])
    return found


@pytest.mark.parametrize("observer", ["ekf", "nlo", "kfnlo", "speed-ekf"])
def test_instant_by_instant_the_estimates_are_those_over_the_whole_recording(observer: str) -> None:
    start = first_belief(Y_N[0], Y_U[0], math.nan, True, PROPER)
    before = np.concatenate([[math.nan], U_IN[:-1]])
    dt = np.concatenate([[0.0], np.full(N - 1, 0.04)])
    whole = observe(Y_N, Y_U, before, dt, start, bench_settings(observer), P)
    np.testing.assert_allclose(tracked(observer, PROPER), whole.table[:9].T, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("observer", ["ekf", "nlo", "kfnlo"])
def test_in_the_benchs_form_the_estimate_of_an_instant_knows_the_measurements_before_it(observer: str) -> None:
    start = first_belief(Y_N[0], Y_U[0], math.nan, True, BENCH)
    whole = observe(Y_N, Y_U, U_IN, 0.04, start, bench_settings(observer, form=BENCH), P)
    found = tracked(observer, BENCH)
    assert found[0] == start[:9]
    np.testing.assert_allclose(found[1:], whole.table[:9, :-1].T, rtol=1e-12, atol=1e-12)


def test_an_instant_that_does_not_lie_after_the_former_one_begins_anew() -> None:
    settings = bench_settings("ekf")
    first = advance(START, Measured(0, 50.0, 0.1, True), math.nan, settings, P)
    later = advance(first, Measured(PERIOD, 80.0, 0.1, True), 2.0, settings, P)
    again = advance(later, Measured(0, 50.0, 0.1, True), math.nan, settings, P)
    assert again == first != later


def test_a_signed_speed_below_zero_is_used_and_as_a_magnitude_it_is_not() -> None:
    settings = bench_settings("ekf")
    signed, unsigned = (
        advance(START, Measured(0, -50.0, 0.1, is_unsigned), 0.0, settings, P).belief for is_unsigned in (False, True)
    )
    assert signed is not None and unsigned is not None
    assert signed.n == pytest.approx(-50.0) and signed.status & Status.USED_N
    assert not unsigned.status & Status.USED_N


def test_an_unsigned_first_speed_gets_the_throttles_sign() -> None:
    assert [first_belief(50.0, 0.1, u, True, PROPER).n for u in (-1.0, math.nan, 1.0)] == [-50.0, 50.0, 50.0]
    assert first_belief(-50.0, 0.1, 1.0, False, PROPER).n == -50.0
    nothing = first_belief(math.nan, math.nan, 1.0, True, PROPER)
    assert nothing[:3] == (0.0, 0.0, 0.0)


def test_the_throttle_that_acted_is_the_mean_of_the_held_one() -> None:
    history = [(0, 1.0), (40, 2.0), (60, 4.0), (80, 9.0)]
    assert mean_throttle(history, 40, 80, 100) == (2.0 * 20 + 4.0 * 20) / 40
    assert mean_throttle(history, 30, 50, 100) == 1.5
    assert mean_throttle(history, 0, 40, 100) == 1.0
    assert mean_throttle(history, None, 70, 100) == 4.0
    assert mean_throttle(history, None, 60, 100) == 2.0, "what is commanded now has not acted yet"


def test_a_throttle_that_has_not_come_or_is_too_old_is_not_known() -> None:
    assert math.isnan(mean_throttle([], 0, 40, 100))
    assert math.isnan(mean_throttle([(20, 1.0)], 0, 40, 100))
    assert mean_throttle([(0, 1.0)], 100, 140, 100) == 1.0
    assert math.isnan(mean_throttle([(0, 1.0)], 101, 140, 100))


def test_what_an_observer_does_not_estimate_is_nan() -> None:
    belief = first_belief(50.0, 0.1, 1.0, True, PROPER)
    assert states(belief, bench_settings("ekf")) == (50.0, 0.0, 0.1)
    one = states(belief, bench_settings("speed-ekf"))
    assert one[0] == 50.0 and np.isnan(one[1:]).all()
    settings = bench_settings("nlo")
    track = advance(START, Measured(0, 50.0, 0.1, True), 1.0, settings, P)
    assert track.belief is not None
    matrix = covariance_matrix(track.belief)
    assert np.isfinite(matrix[0, 0]) and np.isnan(matrix).sum() == 8
    ekf = advance(START, Measured(0, 50.0, 0.1, True), 1.0, bench_settings("ekf"), P)
    assert ekf.belief is not None
    whole = covariance_matrix(ekf.belief)
    assert np.isfinite(whole).all() and (whole == whole.T).all()
