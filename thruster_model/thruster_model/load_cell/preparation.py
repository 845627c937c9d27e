"""From samples of a recording to what `structure` and `ringdown` work on: tare, 5 ms means, jumps, envelope."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import butter, hilbert, sosfiltfilt

from thruster_model.errors import UnfitDataError
from thruster_model.load_cell.ringdown import Segment, fit_segment
from thruster_model.load_cell.structure import Stretch

__all__ = ["Recording", "around_jumps", "jumps", "lever_arm", "plateau", "segments", "stretch_of", "thesis_windows"]

Array = NDArray[np.float64]
PERIOD = 0.005  # [s]
HOLD = 0.15  # [s] for which a jump of the throttle counts
LEAST_JUMP = 0.05  # [V]
LARGE_JUMP = 0.5  # [V] that sets the load cell ringing
FULL_SPEED = 100.0  # [rad/s]
MODE_BAND = (9.0, 20.0)  # [Hz]


@dataclass(frozen=True, kw_only=True)
class Recording:
    """Load cell, rotor and throttle of one run, on the load cell's samples.

    Attributes:
        name: of the run.
        time: [s] (N,).
        wrench: force [N] and torque [N m] in the thruster's frame (N, 6).
        legs: gauge forces [N] (N, 6), None where not recorded.
        speed: |n| [rad/s] (N,), None where not recorded.
        throttle: [V] (N,), None where not recorded.
        setpoint: instants [s] and set points [N] of the thrust, None where there is none.
        turned: whether the importer turned force and torque by half a turn about z.
    """

    name: str
    time: Array
    wrench: Array
    legs: Array | None
    speed: Array | None
    throttle: Array | None
    setpoint: tuple[Array, Array] | None
    turned: bool


def _rest(recording: Recording) -> slice:
    """Return the first 0.2 s, or less where the throttle moves before."""
    end = recording.time[0] + 0.2
    if recording.throttle is not None and np.any(recording.throttle):
        end = min(end, float(recording.time[np.flatnonzero(recording.throttle)[0]]))
    return slice(0, max(10, int(np.searchsorted(recording.time, end))))


def _means(time: Array, values: Array) -> Array:
    width = max(1, round(PERIOD / float(np.median(np.diff(time)))))
    count = len(values) // width
    return np.asarray(values[: count * width].reshape(count, width, *values.shape[1:]).mean(axis=1))


def stretch_of(recording: Recording, arm: float) -> Stretch:
    """Return a recording as 5 ms means: force along the thruster, and torque about y over its `arm` [m].

    Raises:
        UnfitDataError: no rotor speed or no throttle, or shorter than a second.
    """
    if recording.speed is None or recording.throttle is None:
        missing = [n for n, v in (("rotor speed", recording.speed), ("throttle", recording.throttle)) if v is None]
        raise UnfitDataError([f"{recording.name}: expected {' and '.join(missing)} beside the load cell; found none"])
    tared = recording.wrench - np.median(recording.wrench[_rest(recording)], axis=0)
    time = _means(recording.time, recording.time)
    if time.size < 200:
        raise UnfitDataError(
            [f"{recording.name}: expected at least 1 s of load cell; found {time.size * PERIOD:.2f} s"]
        )
    reading = _means(recording.time, np.stack([tared[:, 0], tared[:, 4] / arm], axis=1))
    speed = median_filter(_means(recording.time, np.abs(recording.speed)), 11, mode="nearest")
    filled = np.nan_to_num(reading[:, 0])
    ring = sosfiltfilt(butter(2, MODE_BAND, "bandpass", fs=1.0 / PERIOD, output="sos"), filled)
    return Stretch(
        name=recording.name,
        time=time,
        reading=reading,
        amplitude=np.abs(hilbert(ring)),
        level=(speed / FULL_SPEED) ** 2,
        jump=_held_jumps(recording, time),
    )


def _held_jumps(recording: Recording, time: Array) -> Array:
    """Return by how much [V] the throttle changed within the last 0.15 s (and the next 20 ms: clocks differ)."""
    assert recording.throttle is not None
    index = np.clip(np.searchsorted(recording.time, time), 0, recording.time.size - 1)
    throttle = recording.throttle[index]
    change = np.abs(np.diff(throttle, prepend=throttle[0]))
    held = np.zeros(time.size)
    for k in np.flatnonzero(change >= LEAST_JUMP):
        near = slice(max(0, k - round(0.02 / PERIOD)), k + round(HOLD / PERIOD))
        held[near] = np.maximum(held[near], change[k])
    return held


def jumps(stretch: Stretch) -> list[float]:
    """Return the instants [s] of jumps of the throttle by 0.5 V or more, at least a second apart."""
    large = stretch.jump >= LARGE_JUMP
    starts = stretch.time[large & ~np.concatenate([[False], large[:-1]])] + 0.02
    found: list[float] = []
    for start in starts:
        if not found or start > found[-1] + 1.0:
            found.append(float(start))
    return found


def around_jumps(stretch: Stretch, before: float = 0.4, after: float = 1.3) -> list[Stretch]:
    """Return the parts around jumps that hold at least half a second."""
    parts = [stretch.part(start - before, start + after) for start in jumps(stretch)]
    return [part for part in parts if part.time.size > 100]


def segments(stretch: Stretch, length: float = 0.25, after: float = 1.0) -> list[Segment]:
    """Return fitted segments of ringing after jumps, where the throttle has been still for 0.15 s."""
    found = []
    for start in jumps(stretch):
        at = start + HOLD
        while at + length <= min(start + after, float(stretch.time[-1])):
            part = stretch.part(at, at + length)
            if np.all(part.jump < 0.15) and np.all(np.isfinite(part.reading[:, 0])):
                found.append(fit_segment(stretch.name, part.time, part.reading[:, 0]))
                at += length
            else:
                at += 0.05
    return found


def plateau(recording: Recording) -> Array:
    """Return means (M, 6) of the tared wrench over half-second blocks of steady rotation."""
    if recording.speed is None:
        return np.empty((0, 6))
    width = round(0.5 / float(np.median(np.diff(recording.time))))
    count = recording.time.size // width
    tared = recording.wrench - np.median(recording.wrench[_rest(recording)], axis=0)
    means = tared[: count * width].reshape(count, width, 6).mean(axis=1)
    speed = np.median(np.abs(recording.speed)[: count * width].reshape(count, width), axis=1)
    if count < 3:
        return np.empty((0, 6))
    steady = (speed > 0.4 * FULL_SPEED) & (np.abs(np.gradient(speed)) < 5.0)
    return np.asarray(means[steady])


def lever_arm(plateaus: Array) -> float:
    """Return torque about y over thrust [m] from steady means (M, 6).

    Raises:
        UnfitDataError: no steady thrust, or a torque that does not follow it.
    """
    thrust, torque = plateaus[:, 0], plateaus[:, 4]
    if thrust.size < 3 or float(np.sum(thrust**2)) < 1.0:
        raise UnfitDataError(["load cell: expected steady thrust for the moment's lever arm; found too little"])
    arm = float(torque @ thrust / (thrust @ thrust))
    if abs(arm) < 0.02:
        raise UnfitDataError([f"load cell: expected a torque about y that follows the thrust; found {arm:.3f} N m/N"])
    return arm


def thesis_windows(time: Array, setpoint: Array) -> list[tuple[float, float]]:
    """Return the windows (start, end) [s] that the thesis' scores leave out as ringing, for its step and its ramp."""
    start = float(time[0])
    change = np.diff(setpoint)
    if np.any(np.abs(change) >= 5.0):
        return [(start, start + 1.2), (start + 5.0, start + 6.2)]
    straight = np.mean(np.abs(np.diff(setpoint, 2)) < 1e-6)
    if straight > 0.9 and np.ptp(setpoint) > 15.0:
        return [(start, start + 0.6), (start + 4.8, start + 6.0)]
    return []
