"""Runs as vehicle logs: topics of any rate on one grid, with whatever sensors there are."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.log_check import lattice_step
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.lone_readings import lone_readings
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.oddities import Oddity, cleaned
from gap_diagnosis.vehicle.rules import LONE_EVERY, PERIOD
from gap_diagnosis.vehicle.turns import Stated, attitudes_with, read_with
from rov_sim.vehicle.innovations import LATE, PARTS
from run_bag import MissingTopicError, Run, RunError, read_run
from run_bag.importers.vectors import attitude_moves
from thruster_model.identification.preparation import noise_level
from thruster_model.identification.speed_sign import on_lines

__all__ = ["log_of", "read_logs", "suited_period"]

Array = NDArray[np.float64]
_VEHICLE = ("rov/odometry", "rov/imu", "rov/velocity", "rov/depth", "rov/battery")
_BATTERY = ("rov/battery.voltage", "rov/battery.current")
_IMU, _ODOMETRY = "rov/imu.", "rov/odometry."
_MOST = 32
_INSTANTS_A_READING = 100
"""A log has at most so many instants for each reading of throttles and motion: a pause of a year is no recording."""
_WORTH_A_WORD = 1.0
"""[s] By which throttles may go on after the last reading of the motion without a word."""
_LARGEST = 1e6
"""[V, rad/s, m/s^2, m, m/s, A] No vehicle gives a reading beyond it."""

_SAME_PERIOD = 1e-5
"""Share by which a period is the usual one: commands stay within a millisecond of its instants in a hundred s."""


class _Odd(NamedTuple):
    """What logs of sensors show to be wrong by themselves, and how many readings of which topic stand alone."""

    oddities: list[Oddity]
    alone: list[str]


def read_logs(paths: Sequence[Path], model: Model, period: float | None = None) -> tuple[list[VehicleLog], Model]:
    """Return the runs in these folders as logs, and the model for a filter of their period.

    `period`: of the filter [s], None: one that suits their commands.

    Raises:
        RunError: one cannot be read, or holds no throttles or nothing that tells the vehicle's motion.
    """
    runs = [_read(path) for path in paths]
    period = suited_period(runs, model.thrusters) if period is None else period
    return [log_of(run, model.thrusters, period, stated=model.mounted) for run in runs], replace(model, period=period)


def _read(path: Path) -> Run:
    wanted = [*_VEHICLE, *(f"thruster_{i}/{name}" for i in range(_MOST) for name in ("throttle", "state"))]
    try:
        return read_run(path, wanted)
    except MissingTopicError as error:
        there = set(error.found) if isinstance(error.found, list) else set()
        return read_run(path, [topic for topic in wanted if topic in there])


def suited_period(runs: Sequence[Run], thrusters: int) -> float:
    """Return the period [s] near the usual one at which commands change at its instants only, where they are regular.

    One that changes within a part of a period acts from the nearer edge of that part on.
    """
    spacings = []
    for time in (each[0] for run in runs for i in range(thrusters) if (each := _throttle(run, i)) is not None):
        apart = np.diff(time)
        usual = float(np.median(apart)) if apart.size else 0.0
        if usual > 0.0 and float(np.mean(np.abs(apart / usual - 1.0) > 0.1)) < 0.1:
            even = apart[np.abs(apart / usual - 1.0) < 0.5]
            spacings.append(float(np.mean(even)))
    if not spacings or max(spacings) > 1.1 * min(spacings):
        return PERIOD
    spacing = float(np.median(spacings))
    period = spacing / round(spacing / PERIOD) if spacing > PERIOD else spacing * round(PERIOD / spacing)
    near = abs(period / PERIOD - 1.0) < _SAME_PERIOD
    return PERIOD if near or not 0.5 < period / PERIOD < 1.5 else period


def log_of(
    run: Run, thrusters: int, period: float = PERIOD, grid: Array | None = None, *, stated: Stated | None = None
) -> VehicleLog:  # fmt: skip
    """Return a run as a log of a vehicle with so many thrusters; `grid`: its instants [s], else from the first reading.

    Without a grid the run is a whole recording: what its log shows to be wrong is taken out of the way, see `oddities`.
    stated: how IMU and velocity log are mounted; None: as the body. What they tell is read in the body's axes. An
    odometry's attitude and rates are those already.

    Raises:
        RunError: no throttles, nothing that tells the motion, readings that no vehicle gives, or far more time than
            readings.
    """
    if not 0.0 < period < np.inf:
        raise RunError(f"period of the filter [s]: expected a number above 0; found {period:g}")
    notes: list[str] = []
    imu, log = (stated or Stated()).mountings
    throttles = [_throttle(run, i) for i in range(thrusters)]
    if all(each is None for each in throttles):
        raise RunError(f"{run.name}: expected thruster_<i>/throttle; found {', '.join(run)}")
    extra = [i for i in range(thrusters, _MOST) if _throttle(run, i) is not None]
    if extra:
        raise RunError(f"{run.name}: expected {thrusters} thrusters; found throttles of thruster {extra[0]} too")
    odd = _Odd([], []) if grid is None else None
    took: list[tuple[str, str]] = []
    attitude, rates = _attitude(run, took, odd, imu), _rates(run, notes, odd, imu)
    if rates is None and attitude is None:
        raise RunError(f"{run.name}: expected rov/imu or rov/odometry with attitude or rates; found {', '.join(run)}")
    force = _in_body(_sensor(run, "imu", [f"{_IMU}linear_acceleration.{a}" for a in "xyz"], odd), imu)
    velocity = _in_body(_sensor(run, "velocity", [f"rov/velocity.twist.twist.linear.{a}" for a in "xyz"], odd), log)
    depth = _sensor(run, "depth", ["rov/depth.depth"], odd)
    gauges = {j: name for j, name in enumerate(_BATTERY) if name in run}
    battery = _sensor(run, "battery", list(gauges.values()), odd)
    given = [each for each in throttles if each is not None]
    start = min(float(t[0]) for t, _ in given)
    moving = rates if rates is not None else attitude
    assert moving is not None
    first = max(start, float(moving[0][0]))
    start += period * np.ceil((first - start) / period - 1e-6)
    last = max(float(t[-1]) for t, _ in given)
    end = min(float(moving[0][-1]), last + 5.0)
    if grid is None:
        if last > end + _WORTH_A_WORD:
            motion = "rates" if rates is not None else "an attitude"
            after = f"{last - end:.0f} s after the last reading of {motion}"
            notes.append(f"throttles go on for {after}: they are left out")
        count = max(int((end - start) / period), 1)
        _refuse_pause(run.name, count, period, [t for t, _ in (*given, moving)])
        grid = start + period * np.arange(count)
    K = grid.size
    hold = run.hold("throttle")
    commands = [np.zeros((K, PARTS)) if each is None else _commanded(*each, grid, period, hold) for each in throttles]
    told, noise = np.full((K, 13), np.nan), np.full(13, np.nan)
    lateness = np.zeros((K, len(LATE) + thrusters))
    for at, channel, sensor in ((3, rates, "imu"), (6, force, "imu"), (9, depth, "depth"), (10, velocity, "velocity")):
        if channel is not None:
            columns = slice(at, at + channel[1].shape[1])
            told[:, columns], noise[columns], late = _at_instants(*channel, grid, period)
            lateness[:, LATE.index(sensor)] = late
    quaternions = np.full((K, 4), np.nan)
    if attitude is not None:
        quaternions, noise[:3], lateness[:, LATE.index("attitude")] = _attitudes(*attitude, grid, period)
    speeds, speed_noise, signed = _speeds(run, thrusters, grid, period, notes, odd, lateness[:, len(LATE) :])
    power, power_noise = np.full((K, 2), np.nan), np.full(2, np.nan)
    if battery is not None:
        power[:, list(gauges)], power_noise[list(gauges)], late = _at_instants(*battery, grid, period)
        lateness[:, LATE.index("battery")] = late
        power[:, 1] = -power[:, 1]
    alone = f"readings that stand alone, far off, are left out: {', '.join(odd.alone)}" if odd and odd.alone else ""
    return VehicleLog(
        name=run.name, period=period, commands=np.stack(commands, axis=2), attitude=quaternions, told=told,
        speeds=speeds, battery=power, lateness=lateness, noise=noise, speed_noise=speed_noise,
        battery_noise=power_noise, signed=signed, start=run.start, notes=tuple(notes), took=tuple(took), left_out=alone,
        oddities=tuple(odd.oddities if odd else ()),
        unrecorded=tuple(i for i, each in enumerate(throttles) if each is None),
    )  # fmt: skip


def _refuse_pause(name: str, count: int, period: float, times: Sequence[Array]) -> None:
    readings = sum(t.size for t in times)
    most = _INSTANTS_A_READING * readings
    if count > most:
        together = np.sort(np.concatenate(times))
        k = int(np.argmax(np.diff(together)))
        pause = together[k + 1] - together[k]
        raise RunError(
            f"{name}: expected at most {most} instants of {period:g} s for {readings} readings of throttles and "
            f"motion; found {count}; for {pause:.0f} s from {together[k]:.1f} s on nothing was recorded"
        )


def _readings(run: Run, name: str) -> Array:
    """Return the values of a channel, those that are infinite as not measured.

    Raises:
        RunError: one is larger than any reading of a vehicle.
    """
    values = np.where(np.isfinite(run[name].values), run[name].values, np.nan)
    wrong = np.abs(values) > _LARGEST
    if wrong.any():
        k = int(np.argmax(wrong))
        at = f"at {run.time(name)[k]:.3f} s"
        raise RunError(f"{run.name}: {name}: expected readings up to {_LARGEST:g}; found {values[k]:g} {at}")
    return values


def _throttle(run: Run, i: int) -> tuple[Array, Array] | None:
    name = f"thruster_{i}/throttle.commanded"
    if name not in run:
        return None
    values = _readings(run, name)
    sent = f"thruster_{i}/throttle.sent"
    if sent in run:
        told = _readings(run, sent)
        values = np.where(np.isfinite(told), told, values)
    keep = np.isfinite(values)
    return (run.time(name)[keep], values[keep]) if keep.any() else None


def _columns(run: Run, names: Sequence[str], *, whole: bool = False) -> tuple[Array, Array] | None:
    """Return when any of these channels (`whole`: all) told something, and what; None where hardly anything was."""
    if not names or not all(name in run for name in names):
        return None
    time, values = run.time(names[0]), np.column_stack([_readings(run, name) for name in names])
    there = np.isfinite(values)
    keep = there.all(axis=1) if whole else there.any(axis=1)
    repeated = np.concatenate(([False], np.all(values[1:] == values[:-1], axis=1)))
    if 2 * np.count_nonzero(repeated & keep) > keep.sum() and np.count_nonzero(keep & ~repeated) > 10:
        keep &= ~repeated  # a value that is told again and again is one reading of a slower sensor
    return (time[keep], values[keep]) if keep.sum() > 2 else None


def _sensor(
    run: Run, sensor: str, names: Sequence[str], odd: _Odd | None, *,
    whole: bool = False, thruster: int | None = None, fastest: float = 0.0,
) -> tuple[Array, Array] | None:  # fmt: skip
    """Return what these channels of a sensor told, see `_columns`; what its log shows to be wrong is added to `odd`."""
    channel = _columns(run, names, whole=whole)
    if channel is None or odd is None:
        return channel
    if not whole:  # a quaternion may change its sign from one reading to the next
        channel = _without_lone(*channel, names[0].rpartition(".")[0], thruster, odd.alone)
    time, values, found = cleaned(*channel, sensor, thruster, fastest)
    odd.oddities.extend(found)
    return time, values


def _without_lone(
    time: Array, values: Array, topic: str, thruster: int | None, found: list[str]
) -> tuple[Array, Array]:  # fmt: skip
    """Return readings without outliers; how many there are is added to what was found."""
    rotor_may_stop = thruster is not None and float(np.median(np.diff(time))) > LONE_EVERY
    if topic == "rov/battery" or rotor_may_stop:  # what is drawn starts and stops with the commands
        return time, values
    alone = lone_readings(values, scatter(values))
    if alone.any():
        found.append(f"{np.count_nonzero(alone)} of {time.size} of {topic}")
    return time[~alone], values[~alone]


def _in_body(channel: tuple[Array, Array] | None, R: Array) -> tuple[Array, Array] | None:
    """Return when a sensor that is mounted by R told something, and what, in the body's axes."""
    return None if channel is None else (channel[0], read_with(channel[1], R))


def _attitude(
    run: Run, took: list[tuple[str, str]], odd: _Odd | None, imu: Array
) -> tuple[Array, Array] | None:  # fmt: skip
    """Return the IMU's attitude, else that of the odometry; of two it is told which one was taken."""
    own = _sensor(run, "imu", [f"{_IMU}orientation.{a}" for a in "wxyz"], odd, whole=True)
    names = [f"{_ODOMETRY}pose.pose.orientation.{a}" for a in "wxyz"]
    other = _columns(run, names, whole=True)
    if own is not None and _measured(own[1], odd):
        if other is not None and _measured(other[1], odd):
            took.append(("attitude", "that of rov/imu; rov/odometry has another one, which is not read"))
        return own[0], attitudes_with(own[1], imu)
    if other is None or not _measured(other[1], odd):
        return None
    why = "has none" if own is None else "has one that is not measured or never changes"
    took.append(("attitude", f"that of rov/odometry, as rov/imu {why}"))
    return _sensor(run, "odometry", names, odd, whole=True)


def _rates(run: Run, notes: list[str], odd: _Odd | None, imu: Array) -> tuple[Array, Array] | None:
    rates = _sensor(run, "imu", [f"{_IMU}angular_velocity.{a}" for a in "xyz"], odd)
    if rates is not None:
        return _in_body(rates, imu)
    other = _sensor(run, "odometry", [f"{_ODOMETRY}twist.twist.angular.{a}" for a in "xyz"], odd)
    if other is not None:
        notes.append("gyro: the rates of rov/odometry, as rov/imu has none")
    return other


def _measured(q: Array, odd: _Odd | None) -> bool:
    """Tell whether an attitude is one; in a piece of a recording it may stay as it is."""
    return attitude_moves(q) or (odd is None and bool(np.abs(np.linalg.norm(q, axis=1) - 1.0).max() < 0.1))


def _commanded(time: Array, values: Array, grid: Array, period: float, hold: str | None = None) -> Array:
    """Return what acts in each part of each period (K, PARTS) of a value that is held from its instant on, or, where
    the hold is "linear", on straight lines.

    It is that of the part's middle: a mean of two commands would be another drive, across a dead zone. Of faster
    commands it is their mean. Zero before the first one.
    """
    part = period / PARTS
    begin: Array = (grid[:, None] + part * np.arange(PARTS)).ravel()
    if hold == "linear":
        return on_lines(time, values, begin + 0.5 * part).reshape(-1, PARTS)
    if time.size > 1 and float(np.median(np.diff(time))) < 0.9 * part:
        return _held_mean(time, values, begin, part).reshape(-1, PARTS)
    k = np.searchsorted(time, begin + 0.5 * part, side="right") - 1
    return np.where(k >= 0, values[np.maximum(k, 0)], 0.0).reshape(-1, PARTS)


def _held_mean(time: Array, values: Array, grid: Array, period: float) -> Array:
    """Return the mean over each period of a value that is held from its instant on; zero before the first one."""
    edges = np.append(grid, grid[-1] + period)
    area = np.concatenate(([0.0], np.cumsum(values[:-1] * np.diff(time))))
    k = np.searchsorted(time, edges + 1e-9, side="right") - 1
    whole = np.where(k >= 0, area[np.maximum(k, 0)] + values[np.maximum(k, 0)] * (edges - time[np.maximum(k, 0)]), 0.0)
    return np.diff(whole) / period


def scatter(values: Array) -> Array:
    """Return the standard deviation of white noise on columns (K, m) of slow signals; readings on a lattice are off by
    its step, evenly."""
    return np.array([np.hypot(noise_level(column), lattice_step(column) / np.sqrt(12.0)) for column in values.T])


def _at_instants(time: Array, values: Array, grid: Array, period: float) -> tuple[Array, Array, Array]:
    """Return readings at the instants (K, m), the noise of one of them (m,), by how many periods each is older (K,).

    Fast sensors: a parabola through five readings, whose middle does not lag behind what bends, as a mean would; a
    mean over 40 ms of a vehicle's rate errs by three times a gyro's noise where a thruster starts. Slow ones: each
    reading at the instant at or after it; a rotor that starts is 20 rad/s faster half a period later.
    """
    spacing = float(np.median(np.diff(time))) if time.size > 1 else np.inf
    noise = scatter(values)
    out, late = np.full((grid.size, values.shape[1]), np.nan), np.zeros(grid.size)
    if spacing > 0.9 * period:
        place = np.ceil((time - grid[0]) / period - 1e-6).astype(int)
        keep = (place >= 0) & (place < grid.size)
        out[place[keep]] = values[keep]
        late[place[keep]] = np.maximum(place[keep] - (time[keep] - grid[0]) / period, 0.0)
        return out, noise, late
    smooth = values
    if spacing < 0.4 * period and time.size > 5:
        weights = np.array([-3.0, 12.0, 17.0, 12.0, -3.0]) / 35.0
        smooth = values.copy()
        smooth[2:-2] = sum(w * values[j : len(values) - 4 + j] for j, w in enumerate(weights))
        noise = noise * np.sqrt(17.0 / 35.0)
    after = np.clip(np.searchsorted(time, grid), 1, time.size - 1)
    near = time[after] - time[after - 1] < 3.0 * spacing
    near &= (grid >= time[0] - 1e-9) & (grid <= time[-1] + 1e-9)
    for j in range(values.shape[1]):
        out[near, j] = np.interp(grid[near], time, smooth[:, j])
    return out, noise, late


def _attitudes(time: Array, q: Array, grid: Array, period: float) -> tuple[Array, Array, Array]:
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    flip = np.cumprod(np.concatenate(([1.0], np.where((q[1:] * q[:-1]).sum(axis=1) < 0.0, -1.0, 1.0))))
    q = q * flip[:, None]
    mean, noise, late = _at_instants(time, q, grid, period)
    mean /= np.linalg.norm(mean, axis=1, keepdims=True)
    return mean, np.full(3, 2.0 * float(np.sqrt(np.mean(noise**2)))), late


def _speeds(
    run: Run, thrusters: int, grid: Array, period: float, notes: list[str], odd: _Odd | None, lateness: Array
) -> tuple[Array, Array, bool]:
    speeds, noise, signed = np.full((grid.size, thrusters), np.nan), np.full(thrusters, np.nan), True
    told = [f"thruster_{i}/state.n" for i in range(thrusters)]
    fastest = max((float(np.nan_to_num(np.abs(run[c].values)).max(initial=0.0)) for c in told if c in run), default=0.0)
    for i in range(thrusters):
        channel = _sensor(run, "tachometer", [told[i]], odd, thruster=i, fastest=fastest)
        if channel is not None:
            out, scattered, lateness[:, i] = _at_instants(*channel, grid, period)
            speeds[:, i], noise[i] = out[:, 0], scattered[0]
            source = f"thruster_{i}/state.sign_source"
            signed = signed and (source not in run or bool(np.median(run[source].values) > 0.5))
    if not signed:
        notes.append("rotor speeds without sign")
    return speeds, noise, signed
