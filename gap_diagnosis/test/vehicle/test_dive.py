"""What a dive differs by from those that the watch learned from: numbers learned on line, and failures beside them."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.blind import watch_hours_io
from gap_diagnosis.vehicle.blind.watch_hours_io import Watched, watched_draw
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.dive import _freed
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.unknowns import Key
from gap_diagnosis.vehicle.watching import Watch


def test_readings_freed_of_numbers_are_as_likely_as_readings_that_have_them_by_chance() -> None:
    rng = np.random.default_rng(6)
    K, M, S = 15, 4, 3
    slopes, true = rng.normal(size=(K, M, S)), rng.normal(size=S)
    well = rng.normal(size=(K, M)) + slopes @ true
    well[rng.random((K, M)) < 0.3] = np.nan
    failed = well + rng.normal(size=(K, M))
    with_each = [well - slopes[:, :, s] for s in range(S)]
    numbers, P, out = np.zeros((2, S)), np.eye(S), np.empty((2, K, M))
    _freed(np.stack([well, failed, *with_each]), np.inf, np.ones(S), numbers, P, out)
    there = np.isfinite(well)
    C, y = slopes[there], (well[there], failed[there])
    by_chance = multivariate_normal(cov=np.eye(len(C)) + C @ C.T)
    ratio = by_chance.logpdf(y[1]) - by_chance.logpdf(y[0])
    assert 0.5 * np.nansum(out[0] ** 2 - out[1] ** 2) == pytest.approx(ratio)
    posterior = np.linalg.inv(np.eye(S) + C.T @ C)
    np.testing.assert_allclose(P, posterior)
    np.testing.assert_allclose(numbers[1], posterior @ C.T @ y[1])


def test_biases_of_which_nothing_is_told_are_forgotten_again_and_a_trim_is_not() -> None:
    numbers, P, out = np.array([[2.0, 2.0]]), np.array([[0.01, 0.005], [0.005, 0.01]]), np.empty((1, 300, 1))
    _freed(np.full((3, 300, 1), np.nan), 5.0, np.array([np.exp(-0.01), 1.0]), numbers, P, out)
    np.testing.assert_allclose(numbers, [[2.0 * np.exp(-3.0), 2.0]])
    across = 0.005 * np.exp(-3.0)
    np.testing.assert_allclose(P, [[1.0 - 0.99 * np.exp(-6.0), across], [across, 0.01]])


@pytest.fixture(scope="module")
def watched() -> Iterator[Watched]:
    """Watch over a vehicle with good sensors, to which small biases are large."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(watch_hours_io, "_MINUTE", 20.0)
        draw = replace(watched_draw(5), noise=0.35)
        yield Watched(draw, load_model(draw.vehicle))


def spoiled(log: VehicleLog, *, tilt: float = 0.0, gyro: float = 0.0, force: float = 0.0) -> VehicleLog:
    """Return a log whose attitude is turned about x [rad] and whose IMU reads more, [rad/s] and [m/s^2]."""
    q, told = log.attitude.copy(), log.told.copy()
    there = np.isfinite(q).all(axis=1)
    turned = Rotation.from_quat(np.roll(q[there], -1, axis=1)) * Rotation.from_rotvec([tilt, -tilt, 0.0])
    q[there] = np.roll(turned.as_quat(), 1, axis=1)
    told[:, 3:6] += gyro
    told[:, 6:9] += force
    return replace(log, attitude=q, told=told)


def ran(watched: Watched, log: VehicleLog) -> tuple[Watch, float]:
    """Return the watch, and the highest log ratio of all it follows."""
    watch, piece, highest = Watch(watched.model, watched._healthy), round(1.0 / log.period), 0.0
    for first in range(0, log.count - piece + 1, piece):
        watch.step(log.part(first, first + piece))
        highest = max(highest, float(watch.ratios.max()))
    return watch, highest


def learned(watched: Watched, watch: Watch) -> dict[Key, float]:
    """Return the numbers of a dive, known ones included, by key."""
    beyond = zip(watched._healthy.differing.items(), watch._dive.numbers[0], strict=True)
    return {key: watch._dive._values[key] + size * float(number) for (key, size), number in beyond}


def test_biases_of_a_start_are_learned_and_raise_no_alarm(watched: Watched) -> None:
    log = watched._log(watched._truth, 6, "hold", 60.0)
    watch, highest = ran(watched, spoiled(log, tilt=0.03, gyro=0.004, force=0.06))
    assert highest < 0.25 * watch.threshold
    plain, run = learned(watched, ran(watched, log)[0]), watched._healthy.run
    more = {key: size - plain[key] for key, size in learned(watched, watch).items()}
    assert [more["gyro", run, a] for a in range(3)] == pytest.approx([0.004] * 3, abs=0.0005)
    known = np.abs([watch._dive._values["gyro", run, a] for a in range(3)])
    assert np.all(known > 0.001)  # the filters have them, and little is left to be told beside


def test_what_becomes_known_is_what_was_learned(watched: Watched, monkeypatch: pytest.MonkeyPatch) -> None:
    log = spoiled(watched._log(watched._truth, 6, "hold", 60.0), tilt=0.01, gyro=0.002, force=0.03)
    found = learned(watched, ran(watched, log)[0])
    monkeypatch.setattr(rules, "WATCH_KNOWN", np.inf)
    watch, _ = ran(watched, log)
    plain = learned(watched, watch)
    assert not any(watch._dive._values[key] for key in plain)
    apart = [(found[key] - plain[key]) / size for key, size in watched._healthy.differing.items()]
    assert np.max(np.abs(apart)) < 0.25


@pytest.mark.parametrize(("lasts", "alarm"), [(1.5, False), (30.0, True)])
def test_what_is_wrong_for_a_moment_raises_no_alarm_however_wrong_it_is(
    watched: Watched, lasts: float, alarm: bool
) -> None:
    log = watched._log(watched._truth, 6, "hold", 60.0)
    told, begun = log.told.copy(), round(30.0 / log.period)
    told[begun : begun + round(lasts / log.period), 3] += 0.05
    watch, highest = ran(watched, replace(log, told=told))
    assert (highest >= watch.threshold) == alarm
    if alarm:
        assert watch._found[int(np.argmax(watch.ratios))] <= 34.0
