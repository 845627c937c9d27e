"""Attitudes and axes of others in ours: roll, pitch and yaw become a quaternion, REP 103's axes NED and FRD.

Ours are north, east, down and forward, starboard, down; the quaternion turns body into earth axes. REP 103 has east,
north, up and forward, port, up. With r = (0, 1, 1, 0) / sqrt(2) from ENU to NED and s = (0, 1, 0, 0) from FRD to FLU,
q_ours = r q s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..units import unit_of

__all__ = ["ANGLES", "PARTS", "REP103", "attitude_of", "down_in_body", "in_our_axes", "quaternion", "unit_in_map"]

Array = NDArray[np.float64]
ANGLES, PARTS = ("roll", "pitch", "yaw"), ("w", "x", "y", "z")
REP103 = "rep103"
_BODY = ("angular_velocity", "linear_acceleration", "twist.twist.linear", "twist.twist.angular")
_PLACE = "pose.pose.position"


def attitude_of(path: str) -> str:
    """Return the field of which `path` is an angle ("orientation" for "orientation.roll"), "" where it is none."""
    head, _, last = path.rpartition(".")
    return head if last in ANGLES and head.rsplit(".", 1)[-1] == "orientation" else ""


def unit_in_map(message_type: str, path: str, topic: str) -> str:
    """Return the unit of a channel of a map, "" where it has none; an angle is one of an attitude's."""
    head = attitude_of(path)
    return "rad" if head and unit_of(message_type, f"{head}.w", topic) else unit_of(message_type, path, topic)


def quaternion(roll: Array, pitch: Array, yaw: Array) -> tuple[Array, Array, Array, Array]:
    """Return (w, x, y, z) of the turns yaw, pitch, roll [rad], in that order, from body to earth."""
    half = 0.5 * np.stack((roll, pitch, yaw))
    (c1, c2, c3), (s1, s2, s3) = np.cos(half), np.sin(half)
    return (
        c1 * c2 * c3 + s1 * s2 * s3,
        s1 * c2 * c3 - c1 * s2 * s3,
        c1 * s2 * c3 + s1 * c2 * s3,
        c1 * c2 * s3 - s1 * s2 * c3,
    )


def down_in_body(attitude: Array) -> Array:
    """Return the earth's down in body axes (N, 3) of attitudes w, x, y, z (N, 4) of any length but zero."""
    w, x, y, z = (attitude / np.linalg.norm(attitude, axis=1, keepdims=True)).T
    return np.column_stack((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)))


def in_our_axes(fields: Mapping[str, Array], *, rep103: bool) -> dict[str, Array]:
    """Return the fields of a topic of a vehicle with quaternions for angles, and from REP 103's axes in ours."""
    out = dict(fields)
    for head in dict.fromkeys(filter(None, map(attitude_of, fields))):
        _put(out, head, quaternion(*(out.pop(f"{head}.{angle}") for angle in ANGLES)))
    if not rep103:
        return out
    for head in [path.removesuffix(".w") for path in out if path.endswith("orientation.w")]:
        w, x, y, z = (out[f"{head}.{part}"] for part in PARTS)
        _put(out, head, [np.sqrt(0.5) * part for part in (w + z, x + y, x - y, w - z)])
    for path in out:
        if path.rpartition(".")[0] in _BODY and path[-1] in "yz":
            out[path] = -out[path]
    east, north = out.pop(f"{_PLACE}.x", None), out.pop(f"{_PLACE}.y", None)
    out |= {f"{_PLACE}.{to}": place for to, place in (("x", north), ("y", east)) if place is not None}
    if f"{_PLACE}.z" in out:
        out[f"{_PLACE}.z"] = -out[f"{_PLACE}.z"]
    return out


def _put(fields: dict[str, Array], head: str, parts: Sequence[Array]) -> None:
    fields.update({f"{head}.{name}": part for name, part in zip(PARTS, parts, strict=True)})
