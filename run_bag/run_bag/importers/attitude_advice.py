"""What contradicts an attitude: gravity in the accelerometer, and the gyro, each at times of its own."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np

from ..topic import Topic
from .axes import PARTS, down_in_body
from .possible_units import units_of
from .sources import Array
from .turning import heading_ratio, turning_ratio
from .vectors import attitude_moves, vector_of

__all__ = ["advice_on_attitude", "tilts_as_felt"]

GRAVITY = 9.81
"""[m/s^2]"""
_GRAVITY_WITHIN = (0.7, 1.4)
"""The mean specific force of a vehicle that moves gently, over gravity."""
_TILTED = np.deg2rad(30.0)
"""[rad] What attitude and accelerometer may differ by; an IMU that is mounted askew does not reach it."""
_APART = 0.5
"""[s] From a reading of one sensor to the next one of the other, beyond which the two are not compared."""
_WINDOW, _FEWEST = 0.5, 20
"""[s] Whose means are compared, as a vehicle's own accelerations are short; windows below which nothing is said."""
_MOVED, _TURNED = 0.05, 0.1
"""Share of gravity that has to come and go along an axis, to tell a sign and to tell a size."""
_ALIKE, _OPPOSITE, _TWICE = 0.8, -0.7, 2.0
"""Correlations, and the ratio of two movements from which on one of them is in another unit."""
_STILL = 0.02
"""[rad/s] Deviation of a gyro's axis from which on the vehicle turns: noise and vibration are less."""
_NAMED = 1.15
"""Ratio by which two units' may differ from what is found, to be named."""
_USUAL = ("rad/s", "rpm", "rps", "deg/s", "mrad/s")


def advice_on_attitude(imu: Topic | None, odometry: Topic | None) -> list[str]:
    """Return a sentence for each thing in which accelerometer, gyro and attitude contradict each other."""
    told = {"rov/imu": _told(imu, "orientation"), "rov/odometry": _told(odometry, "pose.pose.orientation")}
    attitudes = {whose: each for whose, each in told.items() if each is not None}
    moving = {whose: each for whose, each in attitudes.items() if attitude_moves(each[1])}
    whose, attitude = next(iter(moving.items()), ("", None))
    rates, gyro = vector_of(imu, "angular_velocity", "xyz"), "rov/imu.angular_velocity"
    if rates is None:
        rates, gyro = vector_of(odometry, "twist.twist.angular", "xyz"), "rov/odometry.twist.twist.angular"
    still = [_still(each) for each in attitudes if each not in moving] if rates and _turns(rates[1]) else []
    force = vector_of(imu, "linear_acceleration", "xyz")
    by_gravity = _against_gravity(force, attitude, whose) if force is not None else []
    if by_gravity or attitude is None or rates is None:
        return [*still, *by_gravity]
    return [*still, *_against_gyro(gyro, rates, attitude, whose)]


def _told(topic: Topic | None, head: str) -> tuple[Array, Array] | None:
    """Return an attitude where one of length 1 was told; a driver that measures none may write zeros."""
    attitude = vector_of(topic, head, PARTS)
    if attitude is None:
        return None
    there = np.abs(np.linalg.norm(attitude[1], axis=1) - 1.0) < 0.1
    return (attitude[0][there], attitude[1][there]) if there.sum() > 1 else None


def _turns(rates: Array) -> bool:
    """Tell whether a gyro [rad/s] shows more than noise about its mean."""
    return bool(np.std(rates, axis=0).max() > _STILL)


def _still(whose: str) -> str:
    head = "orientation" if whose == "rov/imu" else "pose.pose.orientation"
    return (
        f"{whose}.{head}: never changes while the gyro turns: nobody measured it, and no diagnosis takes it; expected "
        "an attitude, or no entry for it in the map"
    )


def _against_gravity(force: tuple[Array, Array], attitude: tuple[Array, Array] | None, whose: str) -> list[str]:
    values = force[1]
    size = float(np.median(np.linalg.norm(values, axis=1)))
    if not _GRAVITY_WITHIN[0] * GRAVITY < size < _GRAVITY_WITHIN[1] * GRAVITY:
        return [
            f"rov/imu.linear_acceleration: {size:.3g} m/s^2 as a rule: expected the specific force, about "
            f"{GRAVITY:g} m/s^2 at rest; is `unit` that of the recording, is gravity taken away?"
        ]
    up = float(np.median(values[:, 2])) / size > 0.5
    if attitude is None:
        return [_UPSIDE_DOWN] if up else []
    time, felt, down = _downs(force, attitude)
    if not time.size:
        return []
    angle = _apart(felt, down)
    if angle < _TILTED:
        return _tilts(whose, time, felt, down)
    if up and whose == "rov/imu":
        return [_UPSIDE_DOWN]
    return [
        f"{whose}: attitude and specific force disagree about where down is, by {np.degrees(angle):.0f} degrees as a "
        "rule: expected angles in their own `unit` and sign, or a quaternion w, x, y, z, that turn body axes (forward, "
        "starboard, down) into north, east, down; of an IMU that is mounted turned the sensors' file states the "
        "`rotation`, and this is as it should be"
    ]


def tilts_as_felt(imu: Topic | None, odometry: Topic | None) -> bool:
    """Tell whether an attitude has down where the accelerometer feels it, while the vehicle rolls and pitches.

    Whoever turns one of them over turns one of both tilts the other way, however it is turned about z.
    """
    force = vector_of(imu, "linear_acceleration", "xyz")
    attitudes = [_told(imu, "orientation"), _told(odometry, "pose.pose.orientation")]
    attitude = next((each for each in attitudes if each is not None), None)
    if force is None or attitude is None:
        return False
    time, felt, down = _downs(force, attitude)
    if not time.size or _apart(felt, down) >= _TILTED:
        return False
    both = _both_tilts(time, felt, down).values()
    return len(both) == 2 and all(alike > _ALIKE for alike, _ in both)


def _downs(force: tuple[Array, Array], attitude: tuple[Array, Array]) -> tuple[Array, Array, Array]:
    """Return times at which both are told, and where down is by the accelerometer and by the attitude, as (N, 3)."""
    time, values = force
    length = np.linalg.norm(values, axis=1)
    time, felt = time[length > 0.0], -values[length > 0.0] / length[length > 0.0, None]
    down, near = _at(time, attitude[0], down_in_body(attitude[1]))
    return time[near], felt[near], down[near]


def _apart(felt: Array, down: Array) -> float:
    """Return by which angle both downs differ as a rule [rad]."""
    return float(np.median(np.arccos(np.clip(np.sum(felt * down, axis=1), -1.0, 1.0))))


def _at(time: Array, at: Array, vectors: Array) -> tuple[Array, Array]:
    """Return unit vectors at other times, and where these are close to theirs."""
    found = np.column_stack([np.interp(time, at, column) for column in vectors.T])
    after = np.clip(np.searchsorted(at, time), 1, at.size - 1)
    off = np.minimum(np.abs(time - at[after - 1]), np.abs(at[after] - time))
    size = np.linalg.norm(found, axis=1, keepdims=True)
    return found / np.maximum(size, 1e-9), np.asarray((off < _APART) & (size[:, 0] > 0.5))


def _both_tilts(time: Array, felt: Array, down: Array) -> dict[str, tuple[float, tuple[float, float]]]:
    """Return how alike (correlation), and how far (deviations), down moves in the attitude and in what is felt; nothing
    of an axis along which it never moves, or of a short recording."""
    windows = np.unique(np.floor((time - time[0]) / _WINDOW), return_inverse=True)[1]
    count = np.bincount(windows)
    found = {}
    for axis, name in ((1, "roll"), (0, "pitch")) if count.size >= _FEWEST else ():
        read, true = (np.bincount(windows, each[:, axis]) / count for each in (down, felt))
        sizes = float(np.std(read)), float(np.std(true))
        if min(sizes) > 0.0:
            alike = float(np.mean((read - read.mean()) * (true - true.mean()))) / (sizes[0] * sizes[1])
            found[name] = alike, sizes
    return found


def _tilts(whose: str, time: Array, felt: Array, down: Array) -> list[str]:
    """Return what is wrong with how an attitude tilts that is level when the vehicle is."""
    told = []
    for name, (alike, sizes) in _both_tilts(time, felt, down).items():
        where = f"{whose}: {name} and specific force"
        if alike < _OPPOSITE and min(sizes) > _MOVED:
            told.append(f"{where} tilt opposite ways (correlation {alike:.2f}): expected one way; is its `sign` right?")
        elif alike > _ALIKE and max(sizes) > _TURNED and not 1.0 / _TWICE < sizes[0] / sizes[1] < _TWICE:
            told.append(
                f"{where} disagree about how far the vehicle tilts: {name} moves {sizes[0] / sizes[1]:.3g} times as "
                "far: expected 1; is `unit` that of the recording?"
            )
    return told


def _against_gyro(gyro: str, rates: tuple[Array, Array], attitude: tuple[Array, Array], whose: str) -> list[str]:
    ratio = turning_ratio(rates, attitude)
    if ratio is None or 1.0 / _TWICE < ratio < _TWICE:
        return _of_heading(rates, attitude, whose)
    named = _taken(ratio, {unit: factor for unit, factor in units_of("rad/s").items() if unit in _USUAL})
    return [
        f"{gyro}: turns {ratio:.3g} times as fast as the attitude of {whose} does{named}: expected 1; is the `unit` of "
        "both that of the recording?"
    ]


def _of_heading(rates: tuple[Array, Array], attitude: tuple[Array, Array], whose: str) -> list[str]:
    """Return what is wrong with a yaw whose roll and pitch need not be."""
    units = units_of("rad")
    factors = sorted({taken / true for true, taken in itertools.permutations(units.values(), 2)})
    ratio = heading_ratio(rates, attitude, [-1.0, *factors])
    if ratio is None:
        return []
    if ratio < 0.0:
        return [f"{whose}: yaw turns the other way than the gyro: expected one way; is its `sign` right?"]
    return [
        f"{whose}: yaw turns {ratio:.3g} times as fast as the gyro does{_taken(ratio, units)}: expected 1; is its "
        "`unit` that of the recording?"
    ]


def _taken(ratio: float, units: Mapping[str, float]) -> str:
    """Return which unit read as which other one makes readings so many times as large, "" where none does."""
    off = {
        f", as {true} read as {taken} would": abs(np.log(units[taken] / units[true] / ratio))
        for true, taken in itertools.permutations(units, 2)
    }
    named = min(off, key=lambda each: off[each])
    return named if off[named] < np.log(_NAMED) else ""


_UPSIDE_DOWN = (
    "rov/imu: its z axis points up: expected axes forward, starboard, down; say `axes: {rov/imu: rep103}` where they "
    "are forward, port, up; of an IMU that is mounted upside down the sensors' file states the `rotation`, and this is "
    "as it should be"
)
