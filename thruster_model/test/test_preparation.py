"""What is done to raw samples before a fit: rest, tare, masks, cell means, noise; values known by hand."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from thruster_model.identification.preparation import (
    cell_means,
    glitch_mask,
    noise_level,
    rest_window,
    ringing_mask,
    tare,
    tare_unsigned_speed,
)

GLITCH = {"half_width": 50, "peak": 25.0, "foot": 4.0}


def test_rest_ends_a_margin_before_the_first_throttle():
    time = 0.01 * np.arange(500)
    throttle = np.where(time >= 2.0, -1.5, 0.0)
    assert rest_window(time, throttle) == pytest.approx((0.0, 1.75))
    assert rest_window(time, throttle, margin=0.5) == pytest.approx((0.0, 1.5))


def test_a_recording_that_starts_with_a_throttle_has_no_rest():
    time = 3.0 + 0.01 * np.arange(100)
    assert rest_window(time, np.ones(100)) == (3.0, 3.0)


def test_a_recording_without_throttle_rests_throughout():
    time = 0.01 * np.arange(101)
    assert rest_window(time, np.zeros(101)) == pytest.approx((0.0, 0.75))


def test_tare_takes_the_median_of_the_rest_off_deaf_to_spikes_and_gaps():
    time = 0.01 * np.arange(400)
    values = np.where(time < 2.0, 0.7, 5.0)
    values[[10, 20, 30]] = 90.0
    values[40:60] = np.nan
    tared, offset, _ = tare(time, values, (0.0, 1.75))
    assert offset == pytest.approx(0.7)
    assert tared[-1] == pytest.approx(4.3)
    assert np.isnan(tared[40:60]).all()


def test_tare_leaves_values_alone_where_the_rest_is_too_short():
    time = 0.01 * np.arange(400)
    values = np.full(400, 0.7)
    values[25:200] = np.nan
    tared, offset, _ = tare(time, values, (0.0, 0.18))
    assert offset == 0.0
    np.testing.assert_array_equal(tared, values)


def test_the_rest_value_of_an_unsigned_speed_comes_off_its_magnitude_in_both_directions():
    time = 0.01 * np.arange(600)
    true = np.where(time < 2.0, 0.0, np.where(time < 4.0, 80.0, -80.0))
    read = np.where(true < 0.0, -1.0, 1.0) * (np.abs(true) + 1.15)
    speed, offset, _ = tare_unsigned_speed(time, read, (0.0, 1.75))
    assert offset == pytest.approx(1.15)
    np.testing.assert_allclose(speed, true, atol=1e-12)
    # What a signed tare would leave: reverse off by twice the rest value.
    assert tare(time, read, (0.0, 1.75))[0][-1] == pytest.approx(-82.3)


def test_a_glitch_is_found_whole_with_its_tail_and_nothing_else():
    time = 0.005 * np.arange(2000)
    clean = 60.0 + 10.0 * np.sin(time)
    glitch = 200.0 * np.exp(-np.arange(40) / 8.0)
    values = clean.copy()
    values[700:740] += glitch
    mask = glitch_mask(values, **GLITCH)
    above = 700 + np.flatnonzero(glitch > 6.0)  # the foot, and what the glitch itself moves the median by
    assert mask[above].all()
    assert mask.sum() <= above.size + 2


def test_a_small_bump_without_a_peak_is_no_glitch():
    values = np.full(1000, 60.0)
    values[500:520] += 20.0
    assert not glitch_mask(values, **GLITCH).any()
    values[510] += 10.0
    assert np.flatnonzero(glitch_mask(values, **GLITCH)).tolist() == list(range(500, 520))


@pytest.mark.parametrize("rise", [0, 1, 5, 30, 200])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_monotonic_transients_through_zero_pass_however_steep(rise, direction):
    k = np.arange(2000)
    values = direction * 110.0 * np.clip((k - 1000.5) / max(rise, 1e-9), -1.0, 1.0)
    assert not glitch_mask(values, **GLITCH).any()


def test_exponential_reversals_of_a_rotor_pass():
    time = 0.005 * np.arange(2000)
    values = np.where(time < 5.0, 110.0, -110.0 + 220.0 * np.exp(-13.66 * (time - 5.0)))
    values += 0.5 * np.random.default_rng(2).standard_normal(time.size)
    assert not glitch_mask(values, **GLITCH).any()


def test_nan_is_no_glitch_and_hides_none():
    values = np.full(1000, 60.0)
    values[300:320] = np.nan
    values[600] = 200.0
    assert np.flatnonzero(glitch_mask(values, **GLITCH)).tolist() == [600]
    assert not glitch_mask(np.full(50, np.nan), **GLITCH).any()


def test_a_load_cell_rings_from_each_jump_on_for_the_hold_and_no_longer():
    fine = 0.002 * np.arange(5000)
    throttle = np.where(fine < 2.0, 0.0, np.where(fine < 6.0, 1.0, 0.7))
    time = 0.01 * np.arange(1000)
    mask = ringing_mask(time, fine, throttle, jump=0.5, span=0.02, hold=1.2)
    # Over `span`, 0.02 s, after the jump the throttle still differs from before.
    np.testing.assert_array_equal(mask[time < 1.99], False)
    assert mask[(time > 2.001) & (time < 3.199)].all()
    assert not mask[time > 3.221].any()


def test_every_jump_sets_the_load_cell_ringing_anew():
    fine = 0.002 * np.arange(5000)
    throttle = np.where(fine < 2.0, 0.0, np.where(fine < 6.0, 1.0, 2.0))
    mask = ringing_mask(fine, fine, throttle, jump=0.5, span=0.02, hold=1.2)
    ringing = ((fine > 2.001) & (fine < 3.199)) | ((fine > 6.001) & (fine < 7.199))
    assert mask[ringing].all()
    assert not mask[(fine > 3.221) & (fine < 5.999)].any()
    assert not mask[fine > 7.221].any()


def test_slow_ramps_ring_nothing():
    fine = 0.002 * np.arange(5000)
    mask = ringing_mask(fine, fine, 0.6 * fine, jump=0.5, span=0.02, hold=1.2)
    assert not mask.any()


def test_a_change_through_zero_counts_at_its_whole_size():
    fine = 0.002 * np.arange(5000)
    throttle = np.where(fine < 2.0, 0.3, -0.3)
    assert ringing_mask(fine, fine, throttle, jump=0.5, span=0.02, hold=0.1).any()
    assert not ringing_mask(fine, fine, np.abs(throttle), jump=0.5, span=0.02, hold=0.1).any()


@settings(max_examples=60, deadline=None)
@given(
    slope=st.floats(-50.0, 50.0),
    level=st.floats(-100.0, 100.0),
    begin=st.floats(-5.0, 5.0),
    per_cell=st.integers(1, 80),
)
def test_the_cells_of_a_ramp_hold_its_value_at_their_centres(slope, level, begin, per_cell):
    """Samples at 1 kHz stand for the period around them: cells begin half a period before the first one."""
    period, cells = 0.001, 20
    time = begin + period * np.arange(cells * per_cell)
    centres, means = cell_means(
        time, level + slope * time, start=begin - 0.5 * period, width=period * per_cell, cells=cells
    )
    np.testing.assert_allclose(means, level + slope * centres, atol=1e-9)
    assert centres[0] == pytest.approx(begin + 0.5 * period * (per_cell - 1), abs=1e-12)


def test_without_the_half_period_a_ramp_would_come_out_half_a_period_late():
    time = 0.001 * np.arange(4000)
    centres, means = cell_means(time, time, start=0.0, width=0.04, cells=100)
    np.testing.assert_allclose(means - centres, -0.0005, atol=1e-12)


def test_empty_and_mostly_masked_cells_are_nan():
    time = 0.001 * np.arange(400)
    values = np.ones(400)
    values[40:80] = np.nan
    values[80:101] = np.nan
    values[120:139] = np.nan
    _, means = cell_means(time, values, start=-0.0005, width=0.04, cells=12)
    assert np.flatnonzero(np.isnan(means)).tolist() == [1, 2, 10, 11]
    np.testing.assert_array_equal(means[np.isfinite(means)], 1.0)


def test_a_burst_of_late_samples_in_one_cell_takes_nothing_from_the_others():
    time = 0.04 * np.arange(200) + 0.01
    time[:5] = time[5] - 0.001 * np.arange(5, 0, -1)
    _, means = cell_means(time, np.sin(time), start=0.0, width=0.04, cells=200)
    assert np.sum(np.isfinite(means)) == 195


@pytest.mark.parametrize("sigma", [0.01, 0.3, 5.0])
def test_white_noise_on_a_curve_with_steps_and_spikes_is_recovered_within_ten_percent(sigma):
    rng = np.random.default_rng(4)
    k = np.arange(4000)
    curve = 100.0 * sigma * np.sin(k / 150.0) + np.where(k > 1500, 400.0 * sigma, 0.0)
    spikes = np.where(rng.random(k.size) < 0.01, 50.0 * sigma * rng.standard_normal(k.size), 0.0)
    values = curve + spikes + sigma * rng.standard_normal(k.size)
    assert noise_level(values) == pytest.approx(sigma, rel=0.1)


def test_readings_that_do_not_move_tell_nothing_of_the_noise():
    rng = np.random.default_rng(5)
    speed = 80.0 * np.sin(np.arange(3000) / 40.0) + 0.3 * rng.standard_normal(3000)
    blind = np.where(np.abs(speed) < 60.0, 0.0, speed)
    assert np.mean(blind == 0.0) > 0.5
    assert noise_level(blind) == pytest.approx(0.3, rel=0.5)  # where it sets in, it jumps
    assert noise_level(np.repeat([0.0, 1.0], 50)) == pytest.approx(1e-6)  # less than a step tells nothing


def test_the_noise_of_too_few_samples_is_not_known():
    assert np.isnan(noise_level(np.arange(12.0)))
    assert noise_level(np.arange(13.0)) == pytest.approx(12e-6)  # not zero: it would weigh infinitely
    gaps = np.random.default_rng(1).standard_normal(300)
    gaps[::3] = np.nan
    assert np.isnan(noise_level(gaps))
