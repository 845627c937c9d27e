"""Stated deviations against closed forms, a double sum written out, and the scatter of many regressions."""

import numpy as np
import pytest
from scipy.signal import lfilter

from thruster_model.identification.uncertainty import autocorrelation_time, newey_west, sandwich_covariance


def remembering(rng, rho, shape):
    """First-order autoregressions of unit variance along the last axis, stationary from the start."""
    innovations = np.sqrt(1.0 - rho**2) * rng.standard_normal(shape)
    innovations[..., 0] /= np.sqrt(1.0 - rho**2)
    return lfilter([1.0], [1.0, -rho], innovations)


@pytest.mark.parametrize("rho", [0.0, 0.3, 0.6, 0.8, 0.9])
def test_the_autocorrelation_time_of_a_first_order_process_is_its_closed_form(rho):
    rng = np.random.default_rng(3)
    times = [autocorrelation_time(remembering(rng, rho, 8000)) for _ in range(8)]
    assert np.mean(times) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.12)


def test_gaps_do_not_shorten_the_memory():
    rng = np.random.default_rng(4)
    times = []
    for _ in range(8):
        series = 5.0 + remembering(rng, 0.8, 8000)
        series[rng.random(8000) < 0.3] = np.nan
        series[2000:3000] = np.nan
        times.append(autocorrelation_time(series))
    assert np.mean(times) == pytest.approx(9.0, rel=0.15)


def test_the_memory_is_never_less_than_one_sample():
    alternating = np.tile([1.0, -1.0], 500)
    assert autocorrelation_time(alternating) == 1.0
    assert autocorrelation_time(np.full(100, 3.0)) == 1.0


@pytest.mark.parametrize("lag", [0, 1, 5, 60])
def test_newey_west_is_the_weighted_double_sum_over_all_pairs(lag):
    scores = np.random.default_rng(5).standard_normal((40, 3))
    expected = np.zeros((3, 3))
    for i in range(40):
        for j in range(40):
            expected += max(0.0, 1.0 - abs(i - j) / (lag + 1.0)) * np.outer(scores[i], scores[j])
    np.testing.assert_allclose(newey_west(scores, lag), expected, rtol=1e-12, atol=1e-12)


@pytest.fixture(scope="module")
def regressions():
    """300 straight lines with slow regressors through two recordings with residuals that remember 12 samples.

    Returns the true scatter, and the stated deviations by the sandwich and by the formula for white noise.
    """
    rng = np.random.default_rng(6)
    size, replications = 600, 300
    time = np.arange(size) / size
    design = np.stack((np.ones(size), time, np.sin(9.0 * time)), axis=1)
    stacked = np.concatenate((design, design))
    hessian = stacked.T @ stacked
    estimates, sandwich, white = [], [], []
    for _ in range(replications):
        noise = remembering(rng, 0.85, (2, size)).ravel()
        estimate = np.linalg.solve(hessian, stacked.T @ noise)
        residuals = noise - stacked @ estimate
        scores = [stacked[k : k + size] * residuals[k : k + size, None] for k in (0, size)]
        covariance = sandwich_covariance(hessian, scores, np.zeros((3, 3)))
        estimates.append(estimate)
        sandwich.append(np.sqrt(np.diag(covariance)))
        white.append(np.sqrt(np.var(residuals) * np.diag(np.linalg.inv(hessian))))
    return np.std(estimates, axis=0), np.mean(sandwich, axis=0), np.mean(white, axis=0)


def test_stated_deviations_are_within_a_quarter_of_the_actual_scatter(regressions):
    scatter, sandwich, _ = regressions
    np.testing.assert_allclose(sandwich, scatter, rtol=0.25)


def test_the_formula_for_white_noise_would_be_off_by_more_than_two(regressions):
    scatter, _, white = regressions
    assert (scatter > 2.0 * white).all()


def test_with_white_residuals_the_sandwich_is_the_usual_formula():
    rng = np.random.default_rng(7)
    design = rng.standard_normal((4000, 2))
    residuals = 0.5 * rng.standard_normal(4000)
    hessian = design.T @ design
    covariance = sandwich_covariance(hessian, [design * residuals[:, None]], np.zeros((2, 2)))
    expected = 0.25 * np.linalg.inv(hessian)
    np.testing.assert_allclose(np.diag(covariance), np.diag(expected), rtol=0.15)


def test_a_parameter_that_the_data_do_not_touch_keeps_its_prior():
    rng = np.random.default_rng(8)
    scores = np.stack((rng.standard_normal(1000), np.zeros(1000)), axis=1)
    covariance = sandwich_covariance(np.diag([1000.0, 0.0]), [scores], np.eye(2))
    assert covariance[1, 1] == pytest.approx(1.0, rel=0.01)
    assert covariance[0, 0] == pytest.approx(1e-3, rel=0.2)


def test_recordings_are_not_correlated_across_their_borders():
    """Two halves given as one recording share a long-run covariance; given as two they do not."""
    first = remembering(np.random.default_rng(9), 0.9, (1, 400)).T
    hessian = np.array([[400.0]])
    apart = sandwich_covariance(hessian, [first, -first[::-1]], np.zeros((1, 1)))
    joined = sandwich_covariance(hessian, [np.concatenate((first, -first[::-1]))], np.zeros((1, 1)))
    assert apart[0, 0] != pytest.approx(joined[0, 0], rel=1e-6)
