"""What is odd in a vehicle's own sensors: axes, units and signs that gravity, water and batteries do not allow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..topic import Topic
from .attitude_advice import advice_on_attitude
from .axes import REP103
from .falling import falling

__all__ = ["SHALLOWEST", "advice_on_vehicle"]

Array = NDArray[np.float64]
_FASTEST, _SPEED, SHALLOWEST, _VOLTS = 20.0, 5.0, -0.5, 200.0
"""[rad/s, m/s, m, V] Beyond these a vehicle's reading is of another unit or sign: thrusters drive none at 10 knots."""
_BACKWARD = 0.1
"""Share of the largest current of a battery up to which it may be an offset on the other side of 0."""
_WINDOW = 1.0
"""[s] Whose median depths are compared: within it noise changes a depth faster than any vehicle."""


def advice_on_vehicle(topics: Sequence[Topic]) -> list[str]:
    """Return a sentence for each thing that a diagnosis of the vehicle would stumble over."""
    found = {topic.name.strip("/"): topic for topic in topics}
    told = advice_on_attitude(found.get("rov/imu"), found.get("rov/odometry"))
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
    told += [
        f"{topic}: its z is positive while the depth shrinks: expected axes forward, starboard, down; say `axes: "
        f"{{{topic}: {REP103}}}` if y points to port and z up"
        for topic in ("rov/velocity", "rov/odometry")
        if topic in found and falling(found, topic) < 0
    ]
    for topic, advice_of in (("rov/depth", _of_depth), ("rov/battery", _of_battery)):
        told += advice_of(found[topic]) if topic in found else []
    return told


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
    if usual < SHALLOWEST:
        told.append(f"rov/depth.depth: {usual:.3g} m as a rule: expected depths, positive down; say `sign: -1`")
    fastest = _fastest(np.asarray(topic.stamps)[there] * 1e-9, depth[there])
    if fastest > _SPEED:
        told.append(
            f"rov/depth.depth: changes by up to {fastest:.4g} m/s: no vehicle's; is `unit` that of the recording?"
        )
    return told


def _of_battery(topic: Topic) -> list[str]:
    current = _measured(topic, "current")
    if current is None or not is_charging(current):
        return []
    return [
        f"rov/battery.current: positive throughout, {np.median(current):.3g} A as a rule: expected negative while it "
        "is drawn; say `sign: -1`"
    ]


def is_charging(current: Array) -> bool:
    """Tell whether a battery's currents are positive throughout, as if nothing were drawn, but for an offset; (N,)."""
    return bool(np.median(current) > 0.0 and np.min(current) >= -_BACKWARD * np.max(current))


def _fastest(time: Array, values: Array) -> float:
    """Return how fast a signal changes at most [1/s], from the median of a window to that of the next."""
    windows = np.floor((time - time[0]) / _WINDOW)
    starts = np.flatnonzero(np.diff(windows, prepend=-1.0))
    medians = [(np.median(time[part]), np.median(values[part])) for part in np.split(np.arange(time.size), starts[1:])]
    steps = np.diff(np.array(medians), axis=0)
    return float(np.max(np.abs(steps[:, 1] / steps[:, 0]), initial=0.0))
