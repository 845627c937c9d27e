"""Arrays of ROS 1 topics of a small vehicle in a pool -> topics.

One npz per recording, one array per topic, '/' written '__', bag times [s] in `<topic>__t`:

    rovio__thrusters         PWM [µs] of thrusters 1 to 6, 1500 = stop       -> thruster_0 .. thruster_5/throttle
    sensor_fusion__states    phi theta psi [rad], p q r [rad/s], three more, depth [m] -> rov/odometry, rov/depth
    rovio__imu__data         time [ms], gyro [rad/s], acceleration [m/s^2]   -> rov/imu

Commands are logged on change in some recordings. Their last message then is none of a stop, though the vehicle comes to
rest: after `STOPS` seconds without a message the thrusters count as stopped, unless told to hold.

Throttle [V] = (PWM - 1500 µs) / (80 µs/V): full command is 5 V. Body axes are forward, starboard, down. What has no
topic of ours (magnetometer, pressure beside the depth made of it, biases of the filter, reference) is left out, and
said so.
"""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..budget import Budget
from ..errors import RecordingError, RunError
from ..topic import Topic
from .axes import PARTS, quaternion
from .decisions import Decisions

__all__ = ["read_arrays", "topics"]

Array = NDArray[np.float64]
STOP_US, US_PER_VOLT = 1500.0, 80.0
STOPS = 0.25
"""[s] after the last message; in the recordings one comes every 0.2 s."""
LATEST = 9e9
"""[s] What fits into a stamp."""
STATES, THRUSTERS, IMU = "sensor_fusion__states", "rovio__thrusters", "rovio__imu__data"
_WIDTHS = {STATES: 10, THRUSTERS: 6, IMU: 7}
_EARTH, _BODY = "map_ned", "base_link_frd"


def read_arrays(path: Path) -> dict[str, tuple[Array, Array]]:
    """Return (times [s], values) of each topic of a recording that is used here.

    Raises:
        RecordingError: all that is wrong with it.
        TooLargeError: it unpacks to more than its size lets expect.
    """
    wanted = [*_WIDTHS, *(f"{name}__t" for name in _WIDTHS)]
    try:
        budget = Budget(path.stat().st_size)
        with zipfile.ZipFile(path) as packed:  # what is unpacked is at most what is said here
            budget.content(sum(each.file_size for each in packed.infolist()), path)
        with np.load(path, allow_pickle=False) as file:
            held = {name: np.asarray(file[name], dtype=np.float64) for name in file.files if name in wanted}
    except RunError:
        raise
    except Exception as error:  # the library raises all kinds on broken files
        why = " ".join(str(error).split())[:200] or type(error).__name__
        raise RecordingError(f"{path}: cannot be read as npz: {why}", path=path) from error
    problems, found = [], {}
    for name, width in _WIDTHS.items():
        values, times = held.get(name), held.get(f"{name}__t")
        if values is None and times is None and name != STATES:
            continue
        if values is None or times is None:
            problems.append(f"expected the arrays {name} and {name}__t; found {', '.join(sorted(held)) or 'none'}")
        elif times.ndim != 1 or times.size == 0 or values.shape != (times.size, width):
            problems.append(f"{name}: expected shape (N, {width}) beside N times; found {values.shape}, {times.shape}")
        elif not (np.all(np.diff(times) >= 0.0) and 0.0 <= times[0] <= times[-1] < LATEST):
            problems.append(f"{name}__t: expected times from 0 to {LATEST:g} s that never fall")
        elif not np.all(np.isfinite(values)):
            problems.append(f"{name}: expected finite numbers; found {np.count_nonzero(~np.isfinite(values))} others")
        else:
            found[name] = (times, values)
    if problems:
        raise RecordingError(f"{path}: " + "; ".join(problems), path=path, found=problems)
    return found


def topics(arrays: Mapping[str, tuple[Array, Array]], log: Decisions, *, hold_last: bool = False) -> list[Topic]:
    """Return the topics of one recording; `hold_last`: the last command holds until the recording ends."""
    times, states = arrays[STATES]
    at = _stamps(times)
    orientation = dict(zip(PARTS, quaternion(*states[:, :3].T), strict=True))
    fields: dict[str, Any] = {f"pose.pose.orientation.{name}": value for name, value in orientation.items()}
    fields |= {f"twist.twist.angular.{axis}": states[:, 3 + k] for k, axis in enumerate("xyz")}
    fields["child_frame_id"] = _BODY
    made = [
        Topic(name="rov/odometry", type="nav_msgs/msg/Odometry", stamps=at, fields=fields, frame=_EARTH),
        Topic(
            name="rov/depth", type="thruster_msgs/msg/Depth", stamps=at, fields={"depth": states[:, 9]}, frame=_EARTH
        ),
    ]
    log.add("linear velocity and position", None, "m/s, m", "not measured: NaN")
    log.add("attitude and rates", "as logged", "rad, rad/s", "the vehicle's own filter; angles became quaternions")
    if IMU in arrays:
        made.append(_imu(*arrays[IMU]))
        log.add("clock of the imu", "the bag's", "s", "its own, in ms, is left out")
    made += _throttles(*arrays.get(THRUSTERS, (np.empty(0), np.empty((0, 6)))), times, hold_last, log)
    log.add("left out", "magnetometer, pressure, biases of the filter, reference", "", "no topic of ours holds them")
    return made


def _stamps(times: Array) -> NDArray[np.int64]:
    return np.round(times * 1e9).astype(np.int64)


def _imu(times: Array, values: Array) -> Topic:
    fields: dict[str, Any] = {f"angular_velocity.{axis}": values[:, 1 + k] for k, axis in enumerate("xyz")}
    fields |= {f"linear_acceleration.{axis}": values[:, 4 + k] for k, axis in enumerate("xyz")}
    fields["orientation_covariance[0]"] = np.full(times.size, -1.0)  # as the message says: no orientation in here
    return Topic(name="rov/imu", type="sensor_msgs/msg/Imu", stamps=_stamps(times), fields=fields, frame=_BODY)


def _throttles(times: Array, pulses: Array, during: Array, hold_last: bool, log: Decisions) -> list[Topic]:
    """Return a throttle for each thruster; before its first message each one was at its stop, and after its last."""
    stop = np.full((1, _WIDTHS[THRUSTERS]), STOP_US)
    if times.size == 0:
        log.add("throttles", 0.0, "V", "no command was logged: a run without thrust")
        times, pulses = during[:1], stop
    elif times[0] > during[0]:
        log.add("throttles before the first message", 0.0, "V", "one message at the recording's start, added")
        times, pulses = np.concatenate((during[:1], times)), np.concatenate((stop, pulses))
    log.add("throttle", f"(PWM - {STOP_US:g} µs) / {US_PER_VOLT:g} µs/V", "V", "full command of 400 µs is 5 V")
    left = float(during[-1] - times[-1])
    if times.size > 1 and left > STOPS:
        how = (
            "the last value is held, as told" if hold_last else f"one message of 0 V, {STOPS:g} s after the last, added"
        )
        log.add("recording after the last command", left, "s", how)
        if not hold_last:
            times, pulses = np.append(times, times[-1] + STOPS), np.concatenate((pulses, stop))
    return [
        Topic(
            name=f"thruster_{k}/throttle",
            type="thruster_msgs/msg/Throttle",
            stamps=_stamps(times),
            fields={"commanded": (pulses[:, k] - STOP_US) / US_PER_VOLT},
            frame=f"thruster_{k}",
        )
        for k in range(pulses.shape[1])
    ]
