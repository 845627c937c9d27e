"""What is unknown of a vehicle, its sensors and its recordings beside effects.

Unknowns are named by keys:
    ("vehicle", name)            added to a parameter of the vehicle set, in its unit
    ("shared", group)            share by which a group of coefficients of all thrusters is larger
    ("own", group, i)            the same of one thruster, beside
    ("own", angle or offset, i)  by which one thruster is turned about its normals [rad] or moved along them [m], see
                                 `PLACING`
    ("product", pair)            product of inertia of two axes, see `PRODUCTS` [kg m^2]
    ("gyro", run, axis)          bias of the gyro in one run [rad/s]
    ("force", run, axis)         bias of the accelerometer [m/s^2]
    ("tilt", run, axis)          turn of the attitude about an axis of the IMU in one run [rad]
    ("trim", name, run)          by which a parameter is larger in one run than in the mean of the runs before it
    ("late", what)               by which commands act later than their stamps say, or a sensor has read before them [s]
    ("sensor", id, sensor, axis) size of an effect of the library that sensors have to a degree, see `Suspected`
    ("charge", run, what)        share of the nominal voltage by which an unread battery's is higher at rest as a run
                                 begins, or the rate at which it grows, see `CHARGE`
    ("power", name)              share by which readings of the battery are larger: voltage, idle or full current
    ("nameless", place, feature) wrench on an axis, or error of a reading, in proportion to a feature of the motion
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY
from thruster_model.vehicle_parameters import definition_of

__all__ = [
    "CHARGE", "OF_RUN", "PLACING", "PRODUCTS", "Key", "acts_in", "in_brackets", "in_deviations", "in_units",
    "share_of_trim", "sum_of", "unit_of", "words_of",
]  # fmt: skip

Key = tuple[Any, ...]
OF_RUN = ("gyro", "force", "tilt", "trim", "charge")
"""First parts of keys of unknowns that tell of single runs."""

CHARGE = {"level": "1", "rate": "1/s"}
"""What is unknown of the charge of a battery whose voltage no sensor reads, with units."""

PLACING = {"first angle": "rad", "second angle": "rad", "first offset": "m", "second offset": "m"}
"""How one thruster is turned about and moved along the first and second normal of its axis (see
`thruster_misalignment`), with units; where along its axis it is changes no wrench."""
_BIASED = {"gyro": ("gyro", "rad/s"), "force": ("accelerometer", "m/s^2")}
_NAMED = {"imu": "IMU", "velocity": "velocity log"}

PRODUCTS = {"xy": "roll-pitch", "xz": "roll-yaw", "yz": "pitch-yaw"}
"""Products of inertia, with the axes whose entries of the matrix of mass they are."""


def acts_in(key: Key, run: int) -> bool:
    """Return whether an unknown changes anything in a run."""
    if key[0] == "trim":
        return bool(0 <= run <= key[2])
    return key[0] not in OF_RUN or key[1] == run


def sum_of(key: Key, run: int, free: Mapping[Key, float]) -> dict[Key, float]:
    """Return those other unknowns, with their shares, that change in a run together what this one changes there, all in
    the deviations that they are free by; none: it changes what no others do.

    What all thrusters share is what each has of its own, in all; what a run differs by is the vehicle's, in that run.
    """
    others: dict[Key, float] = {}
    if key[0] == "shared":
        others = {other: 1.0 for other in free if other[0] == "own" and other[1] == key[1]}
    elif key[0] == "trim" and acts_in(key, run):
        others = {("vehicle", key[1]): share_of_trim(key[2], run)}
    if not all(other in free for other in others):
        return {}
    return {other: share * free[key] / free[other] for other, share in others.items()}


def share_of_trim(last: int, run: int) -> float:
    """Return the share of a number by which a run differs from the mean of those before the last one, in that run."""
    return (last if run == last else -1.0) / (last + 1.0)


def in_deviations(values: Mapping[Key, float], free: Mapping[Key, float]) -> NDArray[np.float64]:
    """Return unknowns in the deviations that they are free by, (m,); what has no value is as believed."""
    return np.array([values.get(key, 0.0) / deviation for key, deviation in free.items()])


def in_units(moved: Iterable[float], free: Mapping[Key, float]) -> dict[Key, float]:
    """Return the values of unknowns that have moved by so many of their deviations; what follows them counts not."""
    return {key: float(x) * deviation for (key, deviation), x in zip(free.items(), moved, strict=False)}


def words_of(key: Key) -> str:
    """Return a number's name in words."""
    kind = key[0]
    if kind == "own":
        return f"{key[1]} of thruster {key[2]}"
    if kind == "shared":
        return f"{key[1]} of all thrusters"
    if kind == "trim":
        return f"{key[1]} of recording {key[2] + 1} against those before it"
    if kind == "charge":
        return f"{key[2]} of the battery's charge in recording {key[1] + 1}"
    if kind in _BIASED:
        return f"bias of the {_BIASED[kind][0]}'s {'xyz'[key[2]]} in recording {key[1] + 1}"
    if kind == "power":
        return f"{key[1].replace('_', ' ')} of the battery"
    if kind == "tilt":
        return f"turn of the attitude about {'xyz'[key[2]]} in recording {key[1] + 1}"
    if kind == "product":
        return f"product of inertia {key[1]}"
    if kind == "sensor":
        return VEHICLE_LIBRARY[key[1]].title + in_brackets(key[3], key[2])
    if kind == "late":
        return "commands act late" if key[1] == "commands" else f"the {_NAMED.get(key[1], key[1])} is late"
    return " ".join(map(str, key[1:]))


def in_brackets(*places: str | None) -> str:
    """Return where an effect is as words behind its title, "" where it is on all."""
    where = ", ".join(place.replace("_", " ") for place in places if place)
    return f" ({where})" if where else ""


def unit_of(key: Key) -> str:
    """Return the unit that a number moves in."""
    if key[0] == "own" and key[1] in PLACING:
        return PLACING[key[1]]
    if key[0] == "charge":
        return CHARGE[key[2]]
    if key[0] in _BIASED:
        return _BIASED[key[0]][1]
    if key[0] == "sensor":
        return VEHICLE_LIBRARY[key[1]].parameters[0].unit
    definition = definition_of(key[1]) if key[0] in ("vehicle", "trim") else None
    return (
        definition.unit
        if definition is not None
        else {"late": "s", "product": "kg m^2", "tilt": "rad"}.get(key[0], "1")
    )
