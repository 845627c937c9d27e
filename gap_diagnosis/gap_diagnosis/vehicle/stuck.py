"""Sensors of a watched vehicle that tell nothing new: silent, or stuck at one reading.

A reading scatters by its noise. A filter follows one that stands still, and what it foresees then fits. So what counts
is for how long no reading differs from the one before it, against the longest such time of the healthy vehicle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.log import CHANNELS_OF, VehicleLog

__all__ = ["Stuck", "longest_unchanged"]

Array = NDArray[np.float64]
_SENSORS = (*CHANNELS_OF, "battery")
"""Tachometers are not among them: one of a thruster at rest tells 0, and nothing new."""


def longest_unchanged(logs: Sequence[VehicleLog]) -> dict[str, float]:
    """Return the longest time without a new reading [s] of each sensor that tells anything in these recordings."""
    found: dict[str, float] = {}
    for log in logs:
        for name in _SENSORS:
            at, _, _ = _new(log, name, None)
            if at.size:
                gaps = np.diff(np.concatenate(([0], at, [log.count])))
                found[name] = max(found.get(name, 0.0), float(gaps.max()) * log.period)
    return found


class Stuck:
    """What tells nothing new, piece by piece.

    Attributes:
        since: when sensors that are stuck told something new for the last time [s].
        misleading: those of them whose last reading came again and again, which filters have followed.
    """

    def __init__(self, longest: Mapping[str, float]) -> None:
        """Begin with sensors that are well; longest: see `longest_unchanged`."""
        self.since: dict[str, float] = {}
        self.misleading: dict[str, float] = {}
        self._again = dict.fromkeys(longest, False)
        self._most = {name: max(rules.WATCH_STUCK[0], rules.WATCH_STUCK[1] * most) for name, most in longest.items()}
        self._told, self._last = dict.fromkeys(longest, 0.0), dict[str, Array]()

    def step(self, log: VehicleLog, now: float) -> VehicleLog:
        """Take a piece that begins at `now` [s]; return it without the readings of sensors that are stuck."""
        ends = now + log.count * log.period
        for name, most in self._most.items():
            at, last, again = _new(log, name, self._last.get(name))
            if at.size:
                self._told[name], self._last[name] = now + float(at[-1]) * log.period, last
            self._again[name] = again or (self._again[name] and not at.size)
            if ends - self._told[name] > most:
                if name not in self.since and self._again[name]:
                    self.misleading[name] = self._told[name]
                self.since.setdefault(name, self._told[name])
                log = _without(log, name)
            else:
                self.since.pop(name, None)
                self.misleading.pop(name, None)
        return log

    @property
    def oldest(self) -> float:
        """When something new was told for the last time by the sensor that has been still for longest [s]."""
        return min((at for name, at in self._told.items() if name not in self.since), default=inf)

    def words(self, now: float) -> dict[str, str]:
        """Return what is said at `now` [s] of each."""
        return {name: f"{name}: nothing new for {now - at:.0f} s; it is left out" for name, at in self.since.items()}


def _readings(log: VehicleLog, name: str) -> Array:
    """Return the readings of a sensor (K, ...)."""
    if name in ("attitude", "battery"):
        return np.asarray(getattr(log, name))
    return log.told[:, CHANNELS_OF[name]]


def _new(log: VehicleLog, name: str, last: Array | None) -> tuple[NDArray[np.intp], Array, bool]:
    """Return in which instants a sensor tells another reading than before, the last one, and whether it came again.

    last: before the first.

    Where readings are means of several, equal ones differ in the last digit.
    """
    rows = _readings(log, name)
    at = np.flatnonzero(np.isfinite(rows).any(axis=1))
    if not at.size:
        return at, np.empty(0), False
    before = np.vstack((np.full(rows.shape[1], np.nan) if last is None else last, rows[at[:-1]]))
    same = np.isclose(rows[at], before, rtol=1e-12, atol=0.0, equal_nan=True).all(axis=1)
    return at[~same], rows[at[-1]], bool(same[-1])


def _without(log: VehicleLog, name: str) -> VehicleLog:
    if name in ("attitude", "battery"):
        return replace(log, **{name: np.full_like(getattr(log, name), np.nan)})
    told = log.told.copy()
    told[:, CHANNELS_OF[name]] = np.nan
    return replace(log, told=told)
