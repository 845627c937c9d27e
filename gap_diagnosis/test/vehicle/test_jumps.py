"""Sensors that jump in mid-dive, in the world of the sealed cases: found, told with their size, and what is no jump."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.blind import watch_hours_io
from gap_diagnosis.vehicle.blind.watch_hours_io import Watched, watched_draw
from gap_diagnosis.vehicle.branch import Steered
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.running import outputs
from gap_diagnosis.vehicle.watching import Alarm, Watch

BEGUN = 20.5
"""[s] Half a second into a piece."""


class Dive:
    """A healthy dive of a drawn vehicle, whose thrusters step and reverse, and what its watch has learned."""

    def __init__(self, seed: int) -> None:
        draw = watched_draw(seed)
        watched = Watched(draw, load_model(draw.vehicle))
        self.watch: Any = lambda: Watch(watched.model, watched._healthy)
        self.log = watched._log(watched._truth, 7, "steps", 100.0)

    def watched(self, log: VehicleLog, seconds: int = 40) -> tuple[Watch, list[list[Alarm]]]:
        """Return the watch, and what it told after each second."""
        watch, piece = self.watch(), round(1.0 / log.period)
        return watch, [watch.step(log.part(k * piece, (k + 1) * piece)) for k in range(seconds)]


@pytest.fixture(scope="module", params=[1, 5], ids=["bluerov2_heavy", "ngs"])
def dive(request: pytest.FixtureRequest) -> Iterator[Dive]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(watch_hours_io, "_MINUTE", 20.0)
        yield Dive(request.param)


def at(log: VehicleLog, begin: float, end: float = np.inf) -> NDArray[np.intp]:
    """Return the instants between two times [s]."""
    times = log.period * np.arange(log.count)
    return np.flatnonzero((times >= begin) & (times < end))


def deeper(log: VehicleLog, rows: Sequence[int] | NDArray[np.intp], size: float | NDArray[np.float64]) -> VehicleLog:
    """Return the log with a depth [m] added in these rows."""
    told = log.told.copy()
    told[rows, 9] += size
    return replace(log, told=told)


def turned(log: VehicleLog, rows: Sequence[int] | NDArray[np.intp], size: float) -> VehicleLog:
    """Return the log with an angle [rad] added to the heading in these rows."""
    attitude = log.attitude.copy()
    told = Rotation.from_euler("z", size) * Rotation.from_quat(np.roll(attitude[rows], -1, axis=1))
    attitude[rows] = np.roll(told.as_quat(), 1, axis=1)
    return replace(log, attitude=attitude)


def sudden(watch: Watch) -> dict[str, float]:
    """Return the log ratios of jumps."""
    return {h.effect: ratio for (h, _), ratio in zip(watch.followed, watch.ratios, strict=True) if h.sudden}


@pytest.mark.parametrize("size", [0.2, -0.5, 2.0])
@pytest.mark.parametrize(("spoil", "effect"), [(deeper, "depth_bias"), (turned, "heading_bias")])
def test_a_jump_in_mid_piece_is_the_first_that_is_told_and_with_its_size(
    dive: Dive, spoil: Any, effect: str, size: float
) -> None:
    size = min(size, 1.5) if effect == "heading_bias" else size
    _, told = dive.watched(spoil(dive.log, at(dive.log, BEGUN), size))
    first = next(k for k, alarms in enumerate(told) if alarms)
    (alarm,) = told[first]
    assert alarm.failure.effect == effect and first + 1 - BEGUN < 5.0
    assert alarm.size == pytest.approx(size, rel=0.1) and alarm.size == pytest.approx(size, abs=4.0 * alarm.deviation)
    assert alarm.since == pytest.approx(BEGUN, abs=0.2)
    assert all(len(alarms) == 1 for alarms in told[first:])


def test_a_healthy_dive_with_reversals_has_no_jumps(dive: Dive) -> None:
    watch = dive.watch()
    piece = round(1.0 / dive.log.period)
    for k in range(99):
        assert not watch.step(dive.log.part(k * piece, (k + 1) * piece))
        assert sudden(watch) == {"depth_bias": 0.0, "heading_bias": 0.0}


def test_lone_outliers_are_no_jumps(dive: Dive) -> None:
    log, depths = dive.log, np.flatnonzero(np.isfinite(dive.log.told[:, 9]))
    for begin, size in ((10.5, 0.4), (15.3, -1.0), (20.0, 5.0), (25.9, 0.6)):
        log = deeper(log, [depths[depths >= at(log, begin)[0]][0]], size)
        log = turned(log, [int(at(log, begin + 2.0)[0])], 0.4 * size)
    _, told = dive.watched(log)
    assert not any(told)


def test_a_jump_is_told_for_a_minute_and_a_later_one_adds_to_it(dive: Dive) -> None:
    log = deeper(deeper(dive.log, at(dive.log, BEGUN), 0.5), at(dive.log, 30.5), 0.3)
    watch, told = dive.watched(log, 99)
    assert told[28][0].size == pytest.approx(0.5, abs=0.05) and told[38][0].size == pytest.approx(0.8, abs=0.05)
    assert told[80] and not any(told[97:])
    assert sudden(watch)["depth_bias"] == 0.0


@pytest.mark.parametrize("lasts", [3.0, 12.0])
def test_a_jump_back_ends_it(dive: Dive, lasts: float) -> None:
    _, told = dive.watched(deeper(dive.log, at(dive.log, BEGUN, BEGUN + lasts), -0.7))
    end = int(BEGUN + lasts) + 1
    assert told[end - 2] or lasts < 5.0
    assert not any(told[end:])


def test_of_both_sensors_that_jump_at_once_both_are_told(dive: Dive) -> None:
    rows = at(dive.log, BEGUN)
    _, told = dive.watched(turned(deeper(dive.log, rows, 0.6), rows, -0.5))
    sizes = [{alarm.failure.effect: alarm.size for alarm in alarms} for alarms in told[25:]]
    for each in sizes:
        assert each == {"depth_bias": pytest.approx(0.6, abs=0.06), "heading_bias": pytest.approx(-0.5, abs=0.05)}


def test_a_watch_that_begins_anew_takes_what_is_told_then_for_right(dive: Dive) -> None:
    log = deeper(dive.log, at(dive.log, BEGUN), 0.5)
    watch, told = dive.watched(log, 30)
    assert told[-1]
    watch.begin()
    piece = round(1.0 / log.period)
    assert not any(watch.step(log.part(k * piece, (k + 1) * piece)) for k in range(30, 45))


def test_a_depth_that_drifts_away_is_no_jump(dive: Dive) -> None:
    rows = at(dive.log, BEGUN)
    watch, _ = dive.watched(deeper(dive.log, rows, 0.2 * dive.log.period * np.arange(len(rows))))
    assert sudden(watch)["depth_bias"] == 0.0


def test_a_filter_that_a_velocity_led_astray_takes_no_depth_for_a_jump(dive: Dive) -> None:
    told = dive.log.told.copy()
    told[[k for k in np.flatnonzero(np.isfinite(told[:, 12])) if 500 <= k < 900][::15], 12] += 5.0
    watch, piece = dive.watch(), round(1.0 / dive.log.period)
    for k in range(40):
        watch.step(replace(dive.log, told=told).part(k * piece, (k + 1) * piece))
        assert sudden(watch)["depth_bias"] == 0.0


def test_a_filter_that_goes_through_a_piece_in_two_parts_comes_out_the_same(dive: Dive) -> None:
    watch, log, rng = dive.watch(), dive.log.part(100, 140), np.random.default_rng(1)
    one, other = (watch._dive.branch(log) for _ in range(2))
    K, N = log.count, log.thrusters
    gains, speed_gains = 0.02 * rng.uniform(size=(K, 16, 13)), 0.1 * rng.uniform(size=(K, N))
    by = Steered(log, gains, speed_gains, np.tile(np.eye(13), (K, 1, 1)), np.ones((K, N)), 0.9 ** np.arange(K + 1))
    whole, halves = outputs(K, N), [outputs(17, N), outputs(K - 17, N)]
    assert one.step(by, tuple(whole))
    assert other.step(by.part(0, 17), tuple(halves[0])) and other.step(by.part(17, K), tuple(halves[1]))
    for k, each in enumerate(whole):
        both = np.concatenate([half[k] for half in halves])
        if k == 3:  # the states hold what a wrench is beside that at the beginning
            both, each = np.delete(both, np.s_[13:19], axis=1), np.delete(each, np.s_[13:19], axis=1)
        np.testing.assert_allclose(both, each, rtol=1e-9, atol=1e-9)
