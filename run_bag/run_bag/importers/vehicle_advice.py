"""What is odd in a vehicle's own sensors: axes, units and signs that gravity, water and batteries do not allow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..topic import Topic
from .axes import PARTS

__all__ = ["advice_on_vehicle"]

Array = NDArray[np.float64]
GRAVITY = 9.81
"""[m/s^2]"""
_GRAVITY_WITHIN = (0.7, 1.4)
"""The mean specific force of a vehicle that moves gently, over gravity."""
_TILTED = np.deg2rad(30.0)
"""[rad] What attitude and accelerometer may differ by; an IMU that is mounted askew does not reach it."""
_FASTEST, _SPEED, _SHALLOWEST, _VOLTS = 20.0, 5.0, -0.5, 200.0
"""[rad/s, m/s, m, V] Beyond these a vehicle's reading is of another unit or sign: thrusters drive none at 10 knots."""
_WINDOW = 1.0
"""[s] Whose median depths are compared: within it noise changes a depth faster than any vehicle."""


def advice_on_vehicle(topics: Sequence[Topic]) -> list[str]:
    """Return a sentence for each thing that a diagnosis of the vehicle would stumble over."""
    found = {topic.name.strip("/"): topic for topic in topics}
    told: list[str] = []
    if "rov/imu" in found:
        told += _of_imu(found["rov/imu"])
    same = "no vehicle's; is `unit` that of the recording?"
    speed = f"m/s: {same} Failed readings need a mark in `nan`"
    limits = (
        ("rov/imu.angular_velocity.", "xyz", _FASTEST, f"rad/s: {same}"),
        ("rov/velocity.twist.twist.linear.", "xyz", _SPEED, speed),
        ("rov/odometry.twist.twist.linear.", "xyz", _SPEED, speed),
        ("rov/battery.voltage", ("",), _VOLTS, f"V: {same}"),
    )
    for name, parts, most, sentence in limits:
        topic, _, path = name.partition(".")
        columns = [_measured(found[topic], f"{path}{part}") for part in parts] if topic in found else []
        largest = max((float(np.max(np.abs(c))) for c in columns if c is not None), default=0.0)
        if largest > most:
            told.append(f"{name.rstrip('.')}: up to {largest:.4g} {sentence}")
    return [*told, *(_of_depth(found["rov/depth"]) if "rov/depth" in found else [])]


def _measured(topic: Topic, path: str) -> Array | None:
    if path not in topic.fields:
        return None
    values = np.asarray(topic.fields[path], dtype=np.float64)
    values = values[np.isfinite(values)]
    return values if values.size else None


def _of_depth(topic: Topic) -> list[str]:
    depth = np.asarray(topic.fields.get("depth", ()), dtype=np.float64)
    there = np.isfinite(depth)
    if not there.any():
        return []
    told, usual = [], float(np.median(depth[there]))
    if usual < _SHALLOWEST:
        told.append(f"rov/depth.depth: {usual:.3g} m as a rule: expected depths, positive down; say `sign: -1`")
    fastest = _fastest(np.asarray(topic.stamps)[there] * 1e-9, depth[there])
    if fastest > _SPEED:
        told.append(
            f"rov/depth.depth: changes by up to {fastest:.4g} m/s: no vehicle's; is `unit` that of the recording?"
        )
    return told


def _fastest(time: Array, values: Array) -> float:
    """Return how fast a signal changes at most [1/s], from the median of a window to that of the next."""
    windows = np.floor((time - time[0]) / _WINDOW)
    starts = np.flatnonzero(np.diff(windows, prepend=-1.0))
    medians = [(np.median(time[part]), np.median(values[part])) for part in np.split(np.arange(time.size), starts[1:])]
    steps = np.diff(np.array(medians), axis=0)
    return float(np.max(np.abs(steps[:, 1] / steps[:, 0]), initial=0.0))


def _vector(fields: Mapping[str, object], head: str, parts: Sequence[str]) -> Array | None:
    """Return a field's parts (N, parts), None where one is missing."""
    if not all(f"{head}.{part}" in fields for part in parts):
        return None
    return np.column_stack([np.asarray(fields[f"{head}.{part}"], dtype=np.float64) for part in parts])


def _of_imu(topic: Topic) -> list[str]:
    name = topic.name.strip("/")
    force = _vector(topic.fields, "linear_acceleration", "xyz")
    if force is None or not np.isfinite(force).all(axis=1).any():
        return []
    known = np.isfinite(force).all(axis=1)
    size = float(np.median(np.linalg.norm(force[known], axis=1)))
    if not _GRAVITY_WITHIN[0] * GRAVITY < size < _GRAVITY_WITHIN[1] * GRAVITY:
        return [
            f"{name}.linear_acceleration: {size:.3g} m/s^2 as a rule: expected the specific force, about "
            f"{GRAVITY:g} m/s^2 at rest; is `unit` that of the recording, is gravity taken away?"
        ]
    q = _vector(topic.fields, "orientation", PARTS)
    if q is None:
        up = float(np.median(force[known, 2])) / size
        return [_upside_down(name)] if up > 0.5 else []
    both = known & np.isfinite(q).all(axis=1)
    if not both.any():
        return []
    w, x, y, z = (q[both] / np.linalg.norm(q[both], axis=1, keepdims=True)).T
    down = np.column_stack((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)))
    unit = force[both] / np.linalg.norm(force[both], axis=1, keepdims=True)
    angle = float(np.median(np.arccos(np.clip(-(unit * down).sum(axis=1), -1.0, 1.0))))
    if angle < _TILTED:
        return []
    if np.median(force[known, 2]) > 0.5 * size:
        return [_upside_down(name)]
    return [
        f"{name}: attitude and specific force disagree about where down is, by {np.degrees(angle):.0f} degrees as a "
        "rule: expected a quaternion w, x, y, z that turns body axes (forward, starboard, down) into north, east, down"
    ]


def _upside_down(name: str) -> str:
    return (
        f"{name}: its z axis points up: expected axes forward, starboard, down; say `axes: {{{name}: rep103}}` where "
        "they are forward, port, up"
    )
