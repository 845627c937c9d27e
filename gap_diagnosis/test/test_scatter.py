"""What only scatters: which samples are left out, in every recording of the same sensor."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from generated import campaign
from scipy.signal import lfilter

from gap_diagnosis.jitter import jitter_of
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.scatter import found_in_logs, masks_of, scattered_before_sorting, unlike_stated
from system_identification.fitting import fit
from system_identification.noise import white_noise


def test_a_blind_tachometer_is_masked_also_where_a_recording_by_itself_does_not_show_it():
    _, recordings = campaign({"tach_dropout": {"threshold": 13.0}}, runs=4, duration=12.0, seed=4)
    assert "tach_dropout" in [found.effect for found in found_in_logs(recordings)]
    assert any(recording.log.hole["speed"] == 0.0 for recording in recordings)
    masks = masks_of(recordings)
    for index, recording in enumerate(recordings):
        values = recording.experiment.measurements["speed"].values
        assert np.all(masks[index, "speed"][values == 0.0])


def test_readings_about_the_threshold_are_left_out_by_their_neighbours_not_by_themselves():
    _, recordings = campaign({"tach_dropout": {"threshold": 13.0}}, seed=4)
    for index, recording in enumerate(recordings):
        values = recording.experiment.measurements["speed"].values
        kept = ~masks_of(recordings)[index, "speed"]
        assert np.min(np.abs(values[kept])) > 12.0
        slow = np.abs(values[kept]) < 16.0
        assert np.mean(slow) < 0.05


def test_of_readings_in_which_a_coarse_tachometer_stands_still_the_middle_one_counts():
    _, recordings = campaign({"tach_quantization": {"step": 8.0}}, runs=1, duration=12.0, seed=4)
    assert "tach_quantization" in [found.effect for found in found_in_logs(recordings)]
    values = recordings[0].experiment.measurements["speed"].values
    kept = np.flatnonzero(~masks_of(recordings)[0, "speed"])
    rows = np.split(np.arange(values.size), np.flatnonzero(np.diff(values)) + 1)
    assert max(len(row) for row in rows) > 20
    np.testing.assert_array_equal(kept, [row[(len(row) - 1) // 2] for row in rows])


def test_scatter_is_known_from_before_the_stamps_were_put_in_order_by_the_rate_at_which_they_came():
    at = 0.01 * np.arange(4000)
    stamps = np.sort(at + 0.01 * np.random.default_rng(1).standard_normal(at.size))
    log = recording_of("fast", (at, np.sin(at)), {"speed": (stamps, np.sin(at))}).log
    assert log.period["speed"] == pytest.approx(0.01, rel=1e-3)
    assert scattered_before_sorting(log.scatter["speed"], log.period["speed"]) == pytest.approx(0.01, rel=0.05)


def test_a_sound_tachometer_loses_nothing():
    _, recordings = campaign({}, seed=4)
    assert not masks_of(recordings)
    assert not found_in_logs(recordings)


@pytest.fixture(scope="module")
def sound():
    """Recordings without effect, fitted."""
    stated, recordings = campaign({}, seed=4)
    problem = Problem(recordings=tuple(recordings), parameter_set=stated, deviations=deviations_of(stated))
    return fit(problem, white_noise(problem), problem.start())


def with_residuals(fitted, residuals_of):
    """Return a fit whose residuals are `residuals_of(time, prediction, residuals)` in each series."""
    problem = fitted.problem
    residuals = fitted.residuals.copy()
    for each in problem.series:
        time = problem.recordings[each.recording].experiment.measurements[each.signal].time
        predicted = problem.measured[each.rows] - residuals[each.rows]
        residuals[each.rows] = residuals_of(time, predicted, residuals[each.rows])
    measured = problem.measured + residuals - fitted.residuals
    return SimpleNamespace(
        problem=SimpleNamespace(
            opaque=(),
            signal_rows=problem.signal_rows, series=problem.series, recordings=problem.recordings,
            measured=measured, known=problem.known,
        ),
        residuals=residuals,
    )  # fmt: skip


@pytest.mark.parametrize("scatter", [0.003, 0.01])
def test_values_read_at_other_instants_than_their_stamps_show_by_how_far_these_scatter(sound, scatter):
    rng = np.random.default_rng(5)

    def late(time, predicted, residuals):
        return residuals + np.interp(time + scatter * rng.standard_normal(time.size), time, predicted) - predicted

    size, deviation, odds = jitter_of(with_residuals(sound, late))
    assert odds > 8.0
    assert size == pytest.approx(scatter, rel=0.2)
    assert abs(size - scatter) < 4.0 * deviation


def test_outliers_are_no_scatter_of_stamps_wherever_the_signal_was_steep(sound):
    rng = np.random.default_rng(7)

    def spoiled(time, predicted, residuals):
        out = rng.choice(time.size, 6, replace=False, p=(w := np.abs(np.gradient(predicted, time)) + 1e-9) / w.sum())
        spiked = residuals.copy()
        spiked[out] += 40.0 * np.nanstd(residuals) * rng.choice([-1.0, 1.0], out.size)
        return spiked

    assert jitter_of(with_residuals(sound, spoiled))[2] < 2.0


def test_a_disturbance_that_lasts_is_no_scatter_of_stamps_though_it_grows_with_the_slope(sound):
    rng = np.random.default_rng(6)

    def lasting(time, predicted, residuals):
        path = lfilter([np.sqrt(1.0 - 0.92**2)], [1.0, -0.92], rng.standard_normal(time.size))
        steep = np.abs(np.gradient(predicted, time))
        return residuals + np.nanstd(residuals) * (0.5 + 3.0 * steep / np.nanmax(steep)) * path

    assert jitter_of(sound)[2] < 0.0 or jitter_of(sound)[0] == 0.0
    assert jitter_of(with_residuals(sound, lasting))[2] < 2.0


def test_the_first_second_of_a_thruster_that_turns_already_says_nothing() -> None:
    _, recordings = campaign({}, runs=1, duration=12.0, seed=4)
    assert masks_of(recordings) == {}
    turning = replace(recordings[0], start_std={"n": 5.0})
    masks, measured = masks_of([turning]), turning.experiment.measurements
    assert {signal for _, signal in masks} == set(measured)
    assert all(np.array_equal(mask, measured[signal].time < 1.0) for (_, signal), mask in masks.items())


@pytest.mark.parametrize(("stated", "told"), [(None, 1), (8.0, 0), (8.5, 0), (4.0, 1)])
def test_what_a_set_has_as_a_log_shows_it_is_not_told_of(stated, told):
    _, recordings = campaign({"tach_quantization": {"step": 8.0}}, runs=1, duration=12.0, seed=4)
    sizes = {} if stated is None else {"tach_quantization": {"step": stated}}
    assert len(unlike_stated(found_in_logs(recordings), sizes)) == told


@pytest.mark.parametrize("period", [0.005, 0.05])
def test_readings_that_repeat_the_last_one_are_left_out_however_fast_they_come(period: float) -> None:
    rng = np.random.default_rng(2)
    at = period * np.arange(round(40.0 / period))
    speed = 100.0 * np.sin(at)
    read, lost = speed + 0.3 * rng.standard_normal(at.size), rng.random(at.size) < 0.2
    for k in np.flatnonzero(lost[1:]) + 1:
        read[k] = read[k - 1]
    recording = recording_of("r", (at, np.sin(at)), {"speed": (at, read)})
    (found,) = found_in_logs([recording])
    assert found.effect == "dropped_samples" and found.size == pytest.approx(0.2, abs=0.02)
    told = recording.experiment.measurements["speed"]
    kept = ~masks_of([recording]).get((0, "speed"), np.zeros(told.time.size, dtype=np.bool_)) & np.isfinite(told.values)
    error = told.values[kept] - 100.0 * np.sin(told.time[kept])
    assert np.sqrt(np.mean(error**2)) < 0.35
