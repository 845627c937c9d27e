"""What a log shows by itself: repeats, spikes, lattices, holes, scattered stamps; and what is none of these."""

import numpy as np
import pytest

from gap_diagnosis.log_check import (
    edge_deviation,
    hole_around_zero,
    lattice_step,
    lone_samples,
    regular_stamps,
    repeated_samples,
    spikes,
)
from gap_diagnosis.scatter import scattered_before_sorting
from thruster_model.identification.preparation import noise_level

RNG = np.random.default_rng(1)
WAVE = 60.0 * np.sin(np.arange(800) / 40.0)
NOISY = WAVE + 1.2 * RNG.standard_normal(800)


def test_noisy_readings_show_nothing():
    assert lattice_step(NOISY) == 0.0
    assert not repeated_samples(NOISY).any()
    assert hole_around_zero(NOISY) == 0.0


@pytest.mark.parametrize("step", [0.37, 5.3, 12.6])
def test_the_step_of_a_coarse_converter_is_found(step):
    assert lattice_step(step * np.round(NOISY / step)) == pytest.approx(step, rel=1e-9)


@pytest.mark.parametrize("decimal", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("step", [0.8, 1.0])
def test_the_step_of_a_converter_is_found_in_readings_of_another_unit_with_few_decimals(step, decimal):
    speed = 40.0 * np.sin(np.arange(4000) / 100.0) + 0.35 * RNG.standard_normal(4000)
    rpm = np.round(np.round(speed / step) * step * 30.0 / np.pi / decimal) * decimal
    assert lattice_step(rpm * np.pi / 30.0) == pytest.approx(step, rel=3e-3)
    assert not repeated_samples(rpm * np.pi / 30.0).any()


def test_readings_of_a_coarse_converter_are_no_repeats():
    assert not repeated_samples(5.0 * np.round(NOISY / 5.0)).any()


@pytest.mark.parametrize("decimals", [3, 4])
def test_readings_of_a_fine_converter_written_with_few_decimals_are_no_repeats(decimals):
    speed = 40.0 * np.sin(np.arange(4000) / 100.0) + 0.8 * RNG.standard_normal(4000)
    readings = np.round(np.round(speed / (np.pi / 60.0)) * (np.pi / 60.0), decimals)
    assert np.mean(readings[1:] == readings[:-1]) > 0.01
    assert not repeated_samples(readings).any()


@pytest.mark.parametrize(("noise", "swing"), [(3.0, 800.0), (6.0, 800.0), (11.5, 800.0), (20.0, 3000.0)])
def test_whole_rpm_of_a_noisy_tachometer_are_no_repeats(noise, swing):
    for seed in range(60):
        rng, time = np.random.default_rng(seed), np.arange(900) / 20.0
        speed = swing * np.sin(0.9 * time) * np.sin(0.31 * time) + noise * rng.standard_normal(time.size)
        readings = np.round(speed) * (np.pi / 30.0)
        assert not repeated_samples(readings).any()
        kept = rng.random(time.size) >= 0.06
        kept[0] = True
        lost = readings[np.maximum.accumulate(np.where(kept, np.arange(time.size), 0))]
        found = repeated_samples(lost)
        assert np.mean(found[~kept]) > 0.9


@pytest.mark.parametrize("apart", [0.0003, 0.0006, 0.011])
def test_readings_on_a_lattice_for_either_way_are_no_repeats(apart):
    for seed in range(20):
        rng = np.random.default_rng(seed)
        speed = 150.0 * np.sin(np.arange(4000) / 100.0) + rng.standard_normal(4000)
        readings = 0.05 * np.round(speed / 0.05) - apart * np.sign(speed)
        assert np.mean(readings[1:] == readings[:-1]) > 0.005
        assert not repeated_samples(readings).any()
        kept = rng.random(4000) >= 0.05
        kept[0] = True
        lost = readings[np.maximum.accumulate(np.where(kept, np.arange(4000), 0))]
        assert np.mean(repeated_samples(lost)[~kept]) > 0.9


def test_repeated_samples_are_marked_one_by_one():
    kept = RNG.random(800) >= 0.2
    kept[0] = True
    index = np.maximum.accumulate(np.where(kept, np.arange(800), 0))
    assert np.array_equal(repeated_samples(NOISY[index]), ~kept)


def test_a_sensor_that_stands_still_for_long_does_not_repeat():
    still = NOISY.copy()
    still[100:200] = still[100]
    assert not repeated_samples(still).any()


def test_spikes_stand_out_of_a_slow_signal():
    slow = 0.2 * np.sin(np.arange(800) / 200.0) + 0.006 * RNG.standard_normal(800)
    hit = RNG.random(800) < 0.1
    assert np.mean(spikes(slow + np.where(hit, 0.3, 0.0), 0.006)[hit]) > 0.95
    assert np.mean(spikes(slow, 0.006)) < 0.005


def test_the_first_step_of_coarse_readings_is_no_hole_however_many_outliers_lie_off_their_lattice():
    coarse = np.round(60.0 * np.sin(np.arange(8000) / 40.0) + RNG.standard_normal(8000))
    coarse[np.flatnonzero(np.abs(coarse) > 20.0)[::500]] += 0.37
    assert np.count_nonzero(coarse == 0.0) > 5
    assert hole_around_zero(coarse) == 0.0


def test_a_few_readings_beyond_noise_about_zero_are_no_edge_of_a_hole():
    values = 0.1 * np.random.default_rng(8).standard_normal(15000)
    values[1000:12000:1000] = 5.0
    assert hole_around_zero(values) == 0.0


def test_a_hole_around_zero_is_as_wide_as_the_smallest_reading():
    cut = np.where(np.abs(NOISY) < 14.0, 0.0, NOISY)
    assert 14.0 <= hole_around_zero(cut) < 16.0


@pytest.mark.parametrize("seed", range(4))
def test_the_edge_of_a_hole_is_as_unsure_as_the_noise_of_the_readings_beyond_it(seed):
    rng = np.random.default_rng(seed)
    speed = slowing(rng, lambda down: down)
    seen = np.where(np.abs(speed) < 18.0, 0.0, speed + rng.standard_normal(speed.size))
    edge = hole_around_zero(seen)
    deviation = edge_deviation([seen], edge)
    assert abs(edge - 18.0) < 2.5 * deviation < 4.0


def slowing(rng, stops):
    """Return speeds of a rotor at 100 Hz that is driven up and coasts down again and again; `stops`: when it slows."""
    up = 90.0 * (1.0 - np.exp(-np.arange(100) / 8.0))
    down = 90.0 * np.exp(-np.arange(150) / 8.0)
    return np.concatenate([np.concatenate((up, stops(down))) for _ in range(12)]) + 0.5 * rng.standard_normal(3000)


def test_a_hole_is_seen_where_zeros_have_noise_and_the_edge_differs_between_rise_and_fall():
    rng = np.random.default_rng(7)
    noise = 0.5 * rng.standard_normal(3000)
    speed = slowing(rng, lambda down: down)
    blind = np.where(np.diff(speed, prepend=0.0) > 0.0, speed < 16.0, speed < 12.0)
    assert 11.0 < hole_around_zero(np.where(blind, 0.0, speed) + noise) < 13.5


def test_a_rotor_that_coasts_down_or_that_friction_stops_has_no_hole():
    rng = np.random.default_rng(8)
    assert hole_around_zero(slowing(rng, lambda down: down)) == 0.0
    assert hole_around_zero(slowing(rng, lambda down: np.maximum(down - 3.0 * (down < 30.0), 0.0))) == 0.0


def test_scatter_of_stamps_is_measured_about_a_line_and_undone_of_sorting():
    regular = 0.04 * np.arange(3000) + 1.0
    scattered = np.sort(regular + 0.02 * RNG.standard_normal(3000))
    line, scatter = regular_stamps(scattered)
    assert np.max(np.abs(line - regular)) < 2e-3
    assert scatter < 0.02
    assert scattered_before_sorting(scatter, 0.04) == pytest.approx(0.02, rel=0.06)


@pytest.mark.parametrize("deviation", [0.002, 0.03, 0.1])
def test_stamps_that_scatter_by_more_than_a_period_scatter_still(deviation):
    rng = np.random.default_rng(3)
    scattered = np.sort(0.02 * np.arange(1500) + deviation * rng.standard_normal(1500))
    assert regular_stamps(scattered)[1] > 0.3 * min(deviation, 0.02)


@pytest.mark.parametrize("wander", ["jump", "pause", "swing"])
def test_stamps_that_jump_pause_or_wander_do_not_scatter(wander):
    """An eighth of a second each, beside a scatter of a millisecond."""
    time = 0.04 * np.arange(750)
    late = {
        "jump": 0.125 * (time > 15.0),
        "pause": 0.125 * (time > 7.0) + 0.125 * (time > 20.0),
        "swing": 0.125 * np.sin(time / 3.0),
    }[wander]
    stamps = time + late + 1e-3 * np.random.default_rng(0).standard_normal(time.size)
    as_they_are, scatter = regular_stamps(stamps)
    assert scatter == 0.0
    np.testing.assert_array_equal(as_they_are, stamps)


def test_regular_stamps_do_not_scatter():
    assert regular_stamps(0.04 * np.arange(100))[1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("at", [0, 1, -1])
def test_a_spike_at_the_end_of_a_flow_is_one(at):
    flow = 0.006 * np.random.default_rng(3).standard_normal(500)
    flow[at] = 0.4
    assert np.flatnonzero(spikes(flow, 0.006)).tolist() == [at % 500]


def test_a_flow_that_climbs_and_falls_all_the_time_has_no_spikes():
    steep = 0.3 * np.sin(np.arange(750) / 18.0) + 0.006 * np.random.default_rng(7).standard_normal(750)
    assert np.sum(spikes(steep, 0.006)) <= 2


def flow_read_at(rate):
    time = np.arange(0.0, 120.0, 1.0 / rate)
    noise = 0.006 * np.random.default_rng(8).standard_normal(time.size)
    return 0.08 * np.sin(4.1 * time) + 0.06 * np.sin(1.7 * time) + noise


@pytest.mark.parametrize("rate", [6.0, 10.0, 25.0])
def test_the_peaks_of_a_flow_that_is_read_slowly_are_no_spikes(rate):
    flow = flow_read_at(rate)
    assert np.mean(spikes(flow, noise_level(flow))) < 0.005


@pytest.mark.parametrize("rate", [10.0, 25.0])
def test_spikes_are_found_beside_such_peaks(rate):
    flow = flow_read_at(rate)
    hit = np.random.default_rng(9).random(flow.size) < 0.05
    flow[hit] += 0.4
    found = spikes(flow, noise_level(flow))
    assert np.mean(found[hit]) > 0.9 and np.mean(found[~hit]) < 0.005


def test_what_most_samples_do_is_no_spike():
    fast = 0.1 * np.sin(2.0 * np.arange(500))
    assert not spikes(fast + 0.006 * np.random.default_rng(8).standard_normal(500), 0.006).any()


def test_stamps_that_do_not_advance_have_no_line_through_them():
    stamps, scatter = regular_stamps(np.full(100, 3.0))
    assert np.all(stamps == 3.0) and scatter == 0.0


def test_a_single_reading_far_from_all_its_neighbours_is_marked_and_nothing_else():
    values = NOISY.copy()
    values[[100, 431]] += [30.0, -25.0]
    assert np.flatnonzero(lone_samples(values, 1.2)).tolist() == [100, 431] and not lone_samples(NOISY, 1.2).any()


def test_more_lone_readings_than_any_logger_has_are_left():
    values, many = NOISY.copy(), [100, 200, 300, 431, 500]  # of 800
    values[many] += 30.0
    assert not lone_samples(values, 1.2).any()
    values[500] = NOISY[500]
    assert np.flatnonzero(lone_samples(values, 1.2)).tolist() == many[:4]


@pytest.mark.parametrize(
    "event",
    [
        np.where(np.arange(800) < 400, 0.0, 60.0),  # a step
        60.0 * np.exp(-np.maximum(np.arange(800) - 400, 0) / 2.0) * (np.arange(800) >= 400),  # and one that fades
        np.where(np.abs(np.arange(800) - 400) < 1.5, 60.0, 0.0),  # three samples
    ],
)
def test_what_lasts_longer_than_a_sample_is_not_lone(event):
    assert not lone_samples(NOISY + event, 1.2).any()
