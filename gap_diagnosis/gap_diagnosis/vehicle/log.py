"""A vehicle's recording on one grid of instants: what was commanded and what each sensor told."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.oddities import Oddity
from gap_diagnosis.vehicle.rules import LEAST_EXCITATION, LEAST_TIME
from rov_sim.vehicle.innovations import PARTS

__all__ = ["CHANNELS_OF", "VehicleLog", "fewer_throttles", "held", "told_in", "wanting"]

Array = NDArray[np.float64]
CHANNELS_OF = {
    "attitude": slice(0, 3), "gyro": slice(3, 6), "accelerometer": slice(6, 9), "depth": slice(9, 10),
    "velocity": slice(10, 13),
}  # fmt: skip
"""Of the 13 channels that correct the body (`innovations`), those that each sensor tells."""


@dataclass(frozen=True, kw_only=True, eq=False)
class VehicleLog:
    """K instants of N thrusters; NaN: not measured.

    Attributes:
        name: of the recording.
        period: between instants [s].
        commands: (K, PARTS, N) [V], that act in each part of the period that begins at the instant, see `innovations`.
        attitude: (K, 4), (w, x, y, z), body to earth.
        told: (K, 13): gyro 3-5 [rad/s], specific force 6-8 [m/s^2], depth 9 [m], velocity 10-12 [m/s].
        speeds: (K, N) [rad/s]; signed: whether they tell the direction.
        battery: (K, 2) voltage, current drawn [V, A].
        lateness: (K, 5 + N), of readings before the instants, in periods, as `innovations` has them.
        noise: (13,) of the channels, each reading on the grid [rad, rad/s, m/s^2, m, m/s]; NaN: not there.
        speed_noise: (N,) [rad/s]; battery_noise: (2,) [V, A].
        start: of the recording's clock [ns]; cut: instants of it before the first one here.
        notes: what the reader decided, one sentence each; left_out: one about readings, "" where there are none.
        took: sensor and where its readings are from, of those that several topics may have.
        oddities: what the logs of the sensors show by themselves.
        unrecorded: thrusters of which it has no throttle.
    """

    name: str
    period: float
    commands: Array
    attitude: Array
    told: Array
    speeds: Array
    battery: Array
    lateness: Array
    noise: Array
    speed_noise: Array
    battery_noise: Array
    signed: bool = True
    start: int = 0
    cut: int = 0
    notes: tuple[str, ...] = ()
    left_out: str = ""
    took: tuple[tuple[str, str], ...] = ()
    oddities: tuple[Oddity, ...] = ()
    unrecorded: tuple[int, ...] = ()

    @property
    def count(self) -> int:
        """Number of instants."""
        return len(self.commands)

    @property
    def thrusters(self) -> int:
        """Number of thrusters."""
        return self.commands.shape[2]

    @cached_property
    def throttles(self) -> Array:
        """(K, N) [V], mean over the period that begins at the instant."""
        return np.asarray(self.commands.mean(axis=1))

    @property
    def duration(self) -> float:
        """[s]."""
        return self.count * self.period

    @property
    def telling(self) -> NDArray[np.bool_]:
        """Which of the 13 channels of the body tell at which instant, (K, 13)."""
        told = np.array(np.isfinite(self.told), dtype=np.bool_)
        told[:, :3] = np.isfinite(self.attitude.sum(axis=1, keepdims=True))
        return told

    @property
    def there(self) -> dict[str, bool]:
        """Which sensors told anything."""
        body: NDArray[np.bool_] = np.asarray(self.telling.any(axis=0))
        return {
            **{name: bool(body[channels].any()) for name, channels in CHANNELS_OF.items()},
            "tachometer": bool(np.isfinite(self.speeds).any()),
            "battery": bool(np.isfinite(self.battery).any()),
        }

    def part(self, first: int, last: int) -> "VehicleLog":
        """Return instants first to before last."""
        cut = ("commands", "attitude", "told", "speeds", "battery", "lateness")
        return replace(self, cut=self.cut + first, **{name: getattr(self, name)[first:last] for name in cut})  # type: ignore[arg-type]


def held(throttles: Array) -> Array:
    """Return commands (K, PARTS, N) of throttles (K, N) that are held through each period."""
    return np.repeat(throttles[:, None, :], PARTS, axis=1)


def told_in(logs: Sequence[VehicleLog]) -> dict[str, bool]:
    """Return which sensors told anything in any of these recordings."""
    return {name: any(log.there[name] for log in logs) for name in (*CHANNELS_OF, "tachometer", "battery")}


def wanting(logs: Sequence[VehicleLog]) -> str:
    """Return what recordings lack to tell anything, "" where it is nothing."""
    longest = max(log.duration for log in logs)
    if longest < LEAST_TIME:
        return f"recordings: expected one of {LEAST_TIME:g} s or more; the longest has {longest:.1f} s"
    if max(float(log.throttles.std(axis=0).max()) for log in logs) < LEAST_EXCITATION:
        return f"recordings: expected throttles that vary by {LEAST_EXCITATION:g} V; found none"
    return ""


def fewer_throttles(logs: Sequence[VehicleLog]) -> list[str]:
    """Return a question about recordings with throttles of fewer thrusters than the set has.

    A thruster may not have been used, or the recording may be of another vehicle: readings do not say which.
    """
    alike: dict[tuple[int, ...], list[str]] = {}
    for log in logs:
        if log.unrecorded:
            alike.setdefault(log.unrecorded, []).append(log.name)
    return [
        f"No throttle of thruster {', '.join(map(str, unrecorded))} in {', '.join(names)}: it counts as at rest. "
        f"Is this the set's vehicle, of {logs[0].thrusters} thrusters?"
        for unrecorded, names in alike.items()
    ]
