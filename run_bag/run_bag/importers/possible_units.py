"""Which of a channel's units its values can be in: those in which the largest one is a reading that exists.

A unit is told by values only where one alone is left. 8000 of a tachometer may be rpm or deg/s, 800 of a gyro deg/s or
mrad/s; 21 of a battery are V, as 0.02 V and 0.2 V drive nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .axes import down_in_body, quaternion
from .conversions import CONVERSIONS, G, conversion
from .mapped_topics import MOST_TILT
from .sources import Array

__all__ = ["by_gravity", "exists", "known_quantity", "possible", "possible_angles", "taken_for_granted", "units_of"]

_LARGEST: dict[str, tuple[float, float]] = {
    "rad/s": (5.0, 2000.0), "N": (0.01, 5000.0), "N m": (1e-4, 500.0), "m/s": (0.05, 5.0), "V": (3.0, 400.0),
    "A": (0.5, 500.0), "m": (1.0, 1000.0),
}  # fmt: skip
"""Least and most, in our unit, that the largest reading of a thruster, a battery, a velocity log or a depth is."""
_INERTIAL = {"rad/s": (0.005, 20.0), "m/s^2": (0.02, 50.0)}
"""The same of a vehicle's gyro and accelerometer."""
_PARTS = {"m/s": ("cm/s", "mm/s"), "m": ("cm", "mm")}
"""Of quantities that are in our unit where nothing is said, unless a value may as well be in such a part of it."""
_TURNS, _ANGLE, _OVER = 20.0 * 2.0 * np.pi, 0.2, 1.0
"""[rad] More than a yaw that counts its turns; the largest angle of a dive at least; more than any tilts as a rule."""
_GRAVITY = {"g": 1.0, "m/s^2": G, "mg": 1000.0, "cm/s^2": 100.0 * G, "mm/s^2": 1000.0 * G}
_WITHIN = 0.15
"""By which share a vehicle that moves gently is off gravity."""
_NEAR, _FAR = 0.005, 0.015
"""Shares of gravity that tell mg from cm/s^2, which differ by 0.02: a good accelerometer's error, and beyond it."""
_MOVING, _TWICE = 0.03, 2.0
"""Accelerations of a vehicle over gravity, and the ratio of two tilts from which on they are not one."""


def units_of(ours: str) -> dict[str, float]:
    """Return units of a channel, each size once, with the factor that brings them to ours."""
    found = {ours: 1.0}
    for unit, into in CONVERSIONS.get(ours, {}).items():
        if into.offset == 0.0 and not np.isclose(into.factor, list(found.values()), rtol=1e-9).any():
            found[unit] = into.factor
    return found


def possible(ours: str, largest: float, *, inertial: bool = False) -> tuple[str, ...]:
    """Return the units in which `largest` exists, ours alone where it is taken for granted; all of them if none is.

    inertial: of a vehicle's gyro or accelerometer.
    """
    units = units_of(ours)
    least, most = (_INERTIAL if inertial else _LARGEST).get(ours, (0.0, np.inf))
    left = tuple(unit for unit, factor in units.items() if least <= factor * largest <= most)
    if largest <= most and ours in _PARTS and not set(_PARTS[ours]) & set(left):
        return (ours,)
    return left or tuple(units)


def exists(unit: str, ours: str, largest: float) -> bool:
    """Tell whether a thruster, a battery or a log reads as much in a unit; so it does where nothing was read."""
    into = conversion(unit, ours)
    return into is None or not into.factor * largest > _LARGEST.get(ours, (0.0, np.inf))[1]


def known_quantity(ours: str) -> bool:
    """Tell whether anything is known of how large a quantity is."""
    return ours in _LARGEST or ours in _INERTIAL or ours == "rad"


def taken_for_granted(ours: str) -> bool:
    """Tell whether a quantity is in our unit where nothing is said."""
    return ours in _PARTS


def by_gravity(size: Array) -> tuple[str, ...]:
    """Return the units in which a specific force is about gravity half of the time; none where it is so in none."""
    usual, (low, high) = float(np.median(size)), np.quantile(size, (0.25, 0.75))
    off = {
        unit: abs(usual / gravity - 1.0)
        for unit, gravity in _GRAVITY.items()
        if (1.0 - _WITHIN) * gravity < low and high < (1.0 + _WITHIN) * gravity
    }
    near = [unit for unit, share in off.items() if share < _NEAR]
    told = len(near) == 1 and all(share > _FAR for unit, share in off.items() if unit not in near)
    return tuple(near) if told else tuple(off)


def possible_angles(angles: Mapping[str, Array], force: Sequence[Array]) -> tuple[str, ...]:
    """Return the units in which roll, pitch and yaw exist, and tilt about as far as the accelerometer does.

    force: readings of its three axes in any unit, at times that need not be those of the angles; none where unknown.
    """
    largest = {name: float(np.nanmax(np.abs(values))) for name, values in angles.items()}
    units = units_of("rad")
    left = [
        unit
        for unit, factor in units.items()
        if factor * max(largest.values()) >= _ANGLE
        and all(factor * each <= (_TURNS if name == "yaw" else MOST_TILT) for name, each in largest.items())
    ]
    if set(angles) != {"roll", "pitch", "yaw"}:
        return tuple(left or units)
    read = {unit: _tilt(_down(angles["roll"], angles["pitch"], units[unit])) for unit in left}
    told = [unit for unit, tilt in read.items() if tilt < _OVER]
    if len(force) == 3 and _steady(np.linalg.norm(np.stack(force), axis=0)):
        felt = _tilt(np.stack(force, axis=1))
        told = [unit for unit in told if 0.5 * (felt - _MOVING) < read[unit] < _TWICE * felt + 0.1]
    return tuple(told or units)


def _steady(size: Array) -> bool:
    """Tell whether a specific force is of one size half of the time, as gravity is in any unit."""
    usual, (low, high) = float(np.median(size)), np.quantile(size, (0.25, 0.75))
    return bool((1.0 - _WITHIN) * usual < low and high < (1.0 + _WITHIN) * usual)


def _down(roll: Array, pitch: Array, factor: float) -> Array:
    there = np.isfinite(roll) & np.isfinite(pitch)
    roll, pitch = factor * roll[there], factor * pitch[there]
    return down_in_body(np.stack(quaternion(roll, pitch, np.zeros(roll.size)), axis=1))


def _tilt(vectors: Array) -> float:
    """Return by how much directions are off their mean as a rule [rad], however the sensor is mounted."""
    there = np.isfinite(vectors).all(axis=1) & (np.linalg.norm(vectors, axis=1) > 0.0)
    unit = vectors[there] / np.linalg.norm(vectors[there], axis=1, keepdims=True)
    if not unit.size:
        return 0.0
    middle = unit.mean(axis=0)
    along = unit @ middle / max(float(np.linalg.norm(middle)), 1e-9)
    return float(np.median(np.arccos(np.clip(along, -1.0, 1.0))))
