"""Scores: by hand."""

import math

import numpy as np
import pytest

from thruster_control.references import REFERENCES, Reference, Window
from thruster_control.scores import chatter, normalised, overshoot, reversals, settling_time, tracking_scores

TIME = np.arange(0.0, 10.0, 0.5)
FLAT = Reference(lambda t: np.full(np.shape(t), 5.0), (Window(0.0, 2.0),))


def test_the_scores_of_a_constant_error_are_that_error() -> None:
    scores = tracking_scores(TIME, FLAT.thrust(TIME) + 0.5, np.zeros(20), FLAT)
    assert scores == pytest.approx((0.5, 0.1, 0.5, 0.0, 16))


def test_what_happens_in_a_window_that_is_left_out_or_is_unknown_does_not_count() -> None:
    T = np.where(TIME < 2.0, 100.0, 5.0)
    T[-1] = np.nan
    scores = tracking_scores(TIME, T, np.zeros(20), FLAT)
    assert (scores.rmse, scores.largest, scores.samples) == (0.0, 0.0, 15)
    assert math.isnan(tracking_scores(TIME, np.full(20, np.nan), np.zeros(20), FLAT).rmse)


def test_the_rmse_is_over_the_root_mean_square_of_the_set_point() -> None:
    sine = REFERENCES["sine"]
    time = np.arange(0.0, 10.0, 0.001)
    none = tracking_scores(time, np.zeros(time.size), np.zeros(time.size), sine)
    assert none.of_reference == pytest.approx(1.0)
    assert none.rmse == pytest.approx(math.sqrt(25.0 + 12.5), rel=0.05)


def test_shapes_that_differ_are_refused() -> None:
    with pytest.raises(ValueError, match="one shape"):
        tracking_scores(TIME, np.zeros(3), np.zeros(20), FLAT)


def test_normalised_is_the_share_of_the_lookup_table_s_error() -> None:
    assert normalised(0.3, 0.6) == 0.5
    assert math.isnan(normalised(0.3, 0.0))


def test_chatter_is_the_way_that_the_throttle_travels() -> None:
    assert chatter([0.0, 2.0, -1.0, np.nan, -1.0, 0.0]) == 6.0


def test_reversals_are_changes_of_sign_also_across_zero() -> None:
    assert reversals([1.0, -1.0, 0.0, 0.0, 1.0, 2.0, np.nan, -2.0]) == 3
    assert reversals([0.0, 0.0]) == 0


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_overshoot_is_a_share_of_the_step_in_its_direction(sign: float) -> None:
    T = sign * np.array([-10.0, 0.0, 12.0, 9.0, 10.0])
    assert overshoot(T, -10.0 * sign, 10.0 * sign) == pytest.approx(0.1)
    assert overshoot(np.minimum(sign * T, 10.0), -10.0, 10.0) == 0.0
    assert math.isnan(overshoot(T, 10.0, 10.0))


def test_the_settling_time_ends_when_the_band_is_left_for_the_last_time() -> None:
    time = np.arange(5.0, 10.0)
    assert settling_time(time, [0.0, 9.8, 8.0, 9.8, 10.1], 0.0, 10.0) == 3.0
    assert settling_time(time, np.full(5, 10.0), 0.0, 10.0) == 0.0
    assert settling_time(time, [0.0, 9.8, 10.0, 10.0, 8.0], 0.0, 10.0) == math.inf
    assert settling_time(time, [0.0, 10.0, np.nan, 10.0, 10.0], 0.0, 10.0) == 3.0
