"""Instants of a recording: moved, where commands act later or an IMU has read earlier than it says, and counted."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.unknowns import Key
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.innovations import CHANNELS, LATE, PARTS

__all__ = ["CLOCKS", "as_read", "counted", "first_instant", "instant_at", "read_later", "shifted"]

Array = NDArray[np.float64]
_LOGS = 64
"""Moved recordings that are kept: a fit asks for the same ones ever again."""
CLOCKS = {
    **{name: slice(LATE.index(name), LATE.index(name) + 1) for name in ("attitude", "velocity")},
    "tachometer": slice(len(LATE), None),
}
"""Sensors beside the IMU whose stamps may be late by themselves, with their columns of `VehicleLog.lateness`."""


def shifted(
    log: VehicleLog, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect] = ()
) -> VehicleLog:  # fmt: skip
    """Return a log whose commands act, and whose sensors read, as late as values and effects of the log say."""
    own = tuple(values.get(("late", sensor), 0.0) for sensor in CLOCKS)
    log = _older(log, own) if any(own) else log
    late, rate = values.get(("late", "commands"), 0.0), 0.0
    for effect in effects:
        if effect.id == "log_alignment":
            late -= effect.sizes["throttle"]
        elif effect.id == "clock_drift":
            rate += effect.sizes["rate"]
    return _acting(log, late, rate) if late or rate else log


@lru_cache(maxsize=_LOGS)
def _older(log: VehicleLog, late: tuple[float, ...]) -> VehicleLog:
    """Return a log whose sensors have read so long [s] before their stamps, those of `CLOCKS`."""
    lateness = log.lateness.copy()
    for of, time in zip(CLOCKS.values(), late, strict=True):
        lateness[:, of] += time / log.period
    return replace(log, lateness=lateness)


@lru_cache(maxsize=_LOGS)
def _acting(log: VehicleLog, late: float, rate: float) -> VehicleLog:
    """Return a log whose commands act later, by more and more."""
    total = (late + rate * log.period * np.arange(log.cut, log.cut + log.count)) / log.period
    log = _instants_earlier(log, np.ceil(PARTS * total - 0.5).astype(int))
    return replace(log, lateness=log.lateness + total[:, None])


def _instants_earlier(log: VehicleLog, parts: NDArray[np.intp]) -> VehicleLog:
    """Return a log whose instants lie so many parts of a period earlier, (K,), than the stamps of its rows.

    Commands move by whole parts: a mean of two commands would be another drive, across a dead zone.
    """
    part = np.clip(np.arange(PARTS * log.count).reshape(-1, PARTS) - parts[:, None], 0, PARTS * log.count - 1)
    commands = log.commands.reshape(-1, log.thrusters)[part]
    return replace(log, commands=commands, lateness=log.lateness - parts[:, None] / PARTS)


def _rows_late(parts: int) -> int:
    """Return by how many rows readings stand earlier of an IMU that is so many parts of a period late."""
    return (parts + PARTS // 2) // PARTS


@lru_cache(maxsize=_LOGS)
def as_read(log: VehicleLog, parts: int) -> VehicleLog:
    """Return a log with an instant wherever an IMU that is so many parts of a period late has read.

    A filter is at its best where a reading tells of the instant that it corrects, and most of what is known comes from
    an IMU. So its readings keep their instants, and commands and other sensors lie between them.
    """
    rows = _rows_late(parts)
    return read_later(_instants_earlier(log, np.full(log.count, parts - PARTS * rows)), rows)


@lru_cache(maxsize=_LOGS)
def read_later(log: VehicleLog, rows: int) -> VehicleLog:
    """Return a log in which the IMU's readings stand so many rows earlier, those that are then outside aside."""

    def moved(values: Array) -> Array:
        none = np.full((min(abs(rows), len(values)), values.shape[1]), np.nan)
        return np.concatenate((values[rows:], none) if rows >= 0 else (none, values[:rows]))

    told, lateness = log.told.copy(), log.lateness.copy()
    told[:, 3:9] = moved(told[:, 3:9])
    lateness[:, :2] = np.nan_to_num(moved(lateness[:, :2])) - rows
    return replace(log, attitude=moved(log.attitude), told=told, lateness=lateness)


def instant_at(log: VehicleLog, start: float) -> int:
    """Return the instant of a time [s], within the first half."""
    return min(round(start / log.period), log.count // 2)


def first_instant(log: VehicleLog) -> int:
    """Return the first instant that counts: later where no sensor tells the velocity at the start."""
    return instant_at(log, rules.START if log.there["velocity"] else rules.START_UNTOLD)


def counted(log: VehicleLog, late: int) -> NDArray[np.intp]:
    """Return the instant from which on each of the 13 channels counts: the same readings of an IMU that is so many
    parts of a period late."""
    first = np.full(CHANNELS, first_instant(log))
    first[:9] = np.maximum(first[:9] - _rows_late(late), 0)
    return first
