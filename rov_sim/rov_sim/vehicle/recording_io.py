"""A recorded run of a vehicle: what was wanted, what it did, what its thrusters did; read from the run's topics."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from run_bag import MissingTopicError, Run, RunError, read_run

__all__ = ["Motion", "SetPoints", "VehicleRecording", "read_vehicle", "signal"]

Array = NDArray[np.float64]

_VEHICLE = ("truth", "odometry", "setpoint", "wrench", "depth", "battery", "thruster_failure")
_THRUSTER = ("throttle", "state", "estimate", "truth", "thrust_setpoint")
_MOST_THRUSTERS = 32
_POSE = "rov/{}.pose.pose."
_TWIST = "rov/{}.twist.twist."


@dataclass(frozen=True, kw_only=True, eq=False)
class Motion:
    """Where a vehicle was, K instants.

    Attributes:
        time: since the run's start [s], (K,).
        position: north, east, down [m], (K, 3).
        attitude: (w, x, y, z), body to earth, (K, 4).
        velocity: nu in body axes [m/s, rad/s], (K, 6).
    """

    time: Array
    position: Array
    attitude: Array
    velocity: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class SetPoints:
    """What was wanted, M instants: Euler angles [rad] and their rates [rad/s], linear velocity [m/s], (M, 3) each."""

    time: Array
    angles: Array
    rates: Array
    velocity: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class VehicleRecording:
    """A run and its vehicle.

    Attributes:
        run: the recording.
        truth: a simulator's, None for a real vehicle.
        odometry: None where none was recorded.
        set_points: None where none was recorded.
        thrusters: indices of those of which anything was recorded.
    """

    run: Run
    truth: Motion | None
    odometry: Motion | None
    set_points: SetPoints | None
    thrusters: tuple[int, ...]

    @property
    def motion(self) -> Motion:
        """The truth where it is known, else the odometry."""
        found = self.truth if self.truth is not None else self.odometry
        if found is None:
            raise AssertionError("a vehicle's recording has either")
        return found

    @property
    def judged_by(self) -> str:
        """What the scores are made from."""
        return "rov/truth" if self.truth is not None else "rov/odometry"


def read_vehicle(path: Path) -> VehicleRecording:
    """Read a run of a vehicle.

    Raises:
        RunError: it cannot be read, or has neither rov/truth nor rov/odometry.
    """
    wanted = [f"rov/{name}" for name in _VEHICLE]
    wanted += [f"thruster_{i}/{name}" for i in range(_MOST_THRUSTERS) for name in _THRUSTER]
    try:
        run = read_run(path, wanted)
    except MissingTopicError as error:  # says which there are
        there = set(error.found) if isinstance(error.found, list) else set()
        kept = [topic for topic in wanted if topic in there]
        if not {"rov/truth", "rov/odometry"} & set(kept):
            listed = ", ".join(sorted(there)) or "no topic at all"
            text = f"{path}: expected a vehicle's run, with rov/truth or rov/odometry; it has: {listed}"
            raise RunError(text, path=path) from error
        run = read_run(path, kept)
    own = tuple(i for i in range(_MOST_THRUSTERS) if any(name.startswith(f"thruster_{i}/") for name in run))
    truth, odometry = _motion(run, "truth"), _motion(run, "odometry")
    if truth is None and odometry is None:
        raise RunError(f"{path}: expected poses in rov/truth or rov/odometry, found none", path=path)
    return VehicleRecording(run=run, truth=truth, odometry=odometry, set_points=_set_points(run), thrusters=own)


def signal(run: Run, channel: str) -> tuple[Array, Array] | None:
    """Return instants [s] and values of a channel, (N,) each, or None where nothing of it was recorded."""
    return (run.time(channel), np.asarray(run[channel].values)) if channel in run else None


def _columns(run: Run, channels: list[str]) -> tuple[Array, Array] | None:
    """Return instants (N,) and values (N, k) of channels of one topic; NaN where one was never measured."""
    there = [name for name in channels if name in run]
    if not there:
        return None
    time = run.time(there[0])
    none = np.full(time.size, np.nan)
    return time, np.column_stack([run[name].values if name in run else none for name in channels])


def _motion(run: Run, name: str) -> Motion | None:
    pose, twist = _POSE.format(name), _TWIST.format(name)
    position = _columns(run, [f"{pose}position.{axis}" for axis in "xyz"])
    attitude = _columns(run, [f"{pose}orientation.{axis}" for axis in "wxyz"])
    velocity = _columns(run, [f"{twist}{kind}.{axis}" for kind in ("linear", "angular") for axis in "xyz"])
    if position is None or attitude is None or velocity is None:
        return None
    return Motion(time=position[0], position=position[1], attitude=attitude[1], velocity=velocity[1])


def _set_points(run: Run) -> SetPoints | None:
    parts = {
        part: _columns(run, [f"rov/setpoint.{part}[{k}]" for k in range(3)])
        for part in ("attitude", "attitude_rate", "velocity")
    }
    first = next((part for part in parts.values() if part is not None), None)
    if first is None:
        return None
    none = np.full((first[0].size, 3), np.nan)
    angles, rates, velocity = (none if part is None else part[1] for part in parts.values())
    return SetPoints(time=first[0], angles=angles, rates=rates, velocity=velocity)
