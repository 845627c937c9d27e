"""Readings that arrive late are taken in where they belong."""

import numpy as np
from navigation_truth import STEP, sailed

from thruster_estimation.navigation_belief import Heard, NavigationSettings, checked_navigation
from thruster_estimation.navigation_online import NAVIGATION_START, LateReading, NavigationTrack, navigation_advance
from thruster_estimation.navigation_output import compiled_output, navigate

SETTINGS = checked_navigation(NavigationSettings())
TICK = round(1e9 * STEP)


def tracked(heard: np.ndarray, delays: dict[str, int], count: int, shift: int = 0) -> list[NavigationTrack]:
    """Return the tracks over `count` instants; each sensor's readings arrive its delay [ticks] later."""
    fields = {"velocity": slice(10, 13), "depth": slice(13, 14)}
    track, tracks = NAVIGATION_START, []
    for k in range(count):
        others = []
        for name, columns in fields.items():
            j = k - delays.get(name, 0)
            if j >= 0 and np.isfinite(heard[j, columns]).all():
                values = dict(zip(Heard._fields[columns], heard[j, columns].tolist(), strict=True))
                others.append(LateReading(j * TICK - shift, values))
        imu = Heard(*heard[k, :10].tolist())
        track = navigation_advance(track, k * TICK, imu, others, SETTINGS)
        tracks.append(track)
    return tracks


def test_reading_by_reading_it_is_the_run_over_arrays() -> None:
    truth = sailed(0, seconds=1.0)
    found = navigate(truth.heard, truth.dt, SETTINGS)
    last = tracked(truth.heard, {}, 101)[-1]
    assert last.belief is not None
    np.testing.assert_allclose(last.belief.P, found.last.P, rtol=1e-9)
    np.testing.assert_allclose(compiled_output(last.belief, SETTINGS).velocity, found.velocity[-1], rtol=1e-9)


def test_late_readings_leave_no_trace_once_they_have_come() -> None:
    truth = sailed(1, seconds=1.0)
    truth.heard[0, 10:] = np.nan  # the beginning takes what is there, and cannot go back
    on_time = tracked(truth.heard, {}, 101)
    late = tracked(truth.heard, {"velocity": 7, "depth": 3}, 101)
    assert late[40].belief != on_time[40].belief
    for k in (38, 59, 78):  # nothing of theirs is still on its way
        np.testing.assert_array_equal(late[k].belief.P, on_time[k].belief.P)  # type: ignore[union-attr]
        assert late[k].belief.velocity == on_time[k].belief.velocity  # type: ignore[union-attr]
    assert late[-1].dropped == 0


def test_what_is_measured_between_two_instants_counts_at_the_next() -> None:
    truth = sailed(2, seconds=0.5)
    between, at = tracked(truth.heard, {}, 51, shift=TICK // 3)[-1], tracked(truth.heard, {}, 51)[-1]
    assert between.belief is not None and at.belief is not None
    assert between.belief.velocity == at.belief.velocity


def test_the_memory_is_bounded_and_what_lies_beyond_it_is_counted() -> None:
    truth = sailed(3, seconds=3.0)
    tracks = tracked(truth.heard, {"velocity": 150}, 301)
    assert max(len(track.steps) for track in tracks) <= 102
    assert tracks[-1].dropped == 8


def test_an_instant_that_is_not_later_starts_anew() -> None:
    truth = sailed(4, seconds=0.2)
    track = tracked(truth.heard, {}, 21)[-1]
    again = navigation_advance(track, 0, Heard(*truth.heard[1].tolist()), (), SETTINGS)
    assert len(again.steps) == 1 and again.belief is not None
    assert again.belief.P[3, 3] > 0.1
