"""Which topics of a vehicle are in REP 103's axes, each by evidence of its own: gravity, or how the depth changes.

With q the attitude, d = (d_x, d_y, d_z) the earth's down in body axes and (u, v, w) what a topic tells of velocity,

    depth(t + 1 s) - depth(t) - int d_x u dt  =  s int (d_y v + d_z w) dt        s: 1 in our axes, -1 in REP 103's
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.integrate import cumulative_trapezoid

from ..errors import RunError
from ..topic import Topic
from .axes import PARTS, REP103, down_in_body
from .decisions import Decisions
from .mapped_topics import mapped_topics
from .recording_map import parse_map
from .sources import Array, Source
from .vectors import vector_of

__all__ = ["axes_lines"]

_UP = 0.5
"""Share of the specific force along z, upwards, from which on z points up."""
_WINDOW, _FEWEST = 1.0, 20
"""[s] Over which a depth changes by more than its noise; windows below which nothing is said."""
_MOVED = 0.02
"""[m] Root mean square of the changes below which they are noise."""
_ALIKE = 0.7
"""Correlation of both sides from which on it tells s: noise reaches it in a thousandth of twenty windows."""
_MOVING = ("rov/velocity", "rov/odometry")
_READ = (*_MOVING, "rov/depth", "rov/imu.orientation")


def axes_lines(
    topics: Collection[str], force: Mapping[str, Array | None], sources: Sequence[Source], lines: Sequence[str]
) -> list[str]:
    """Return the lines of a proposed map about axes: those of topics that tell it, a question about the others.

    Args:
        topics: with vectors, of which nobody has said in which axes they are.
        force: what the accelerometer tells by axis, in any unit.
        sources: the recordings; lines: those of the proposal about their times and channels.
    """
    ways = {"rov/imu": _upright(force)} if "rov/imu" in topics else {}
    moving = [topic for topic in _MOVING if topic in topics]
    if moving:
        read = _read(sources, lines, turned=ways.get("rov/imu", 0) < 0)
        ways |= {topic: _falling(read, topic) for topic in moving}
    told = [topic for topic, way in sorted(ways.items()) if way < 0]
    asked = [topic for topic, way in sorted(ways.items()) if way == 0]
    why = {"rov/imu": "at rest the IMU's z axis points up"}
    reasons = "; ".join(why.get(topic, f"{topic}.z is positive while the depth shrinks") for topic in told)
    lines_told = [f"{_axes(told)}   # {reasons}"] if told else []
    question = f"if x is forward, y port, z up in {', '.join(asked)}: nothing says so"
    return [*lines_told, *([f"# {_axes([*told, *asked])}   # {question}"] if asked else [])]


def _axes(topics: Sequence[str]) -> str:
    return f"axes: {{{', '.join(f'{topic}: {REP103}' for topic in sorted(topics))}}}"


def _upright(force: Mapping[str, Array | None]) -> int:
    """Return 1 where the specific force says that z points down, -1 where up, 0 where it says neither."""
    means = {axis: float(np.nanmean(values)) for axis, values in force.items() if values is not None}
    size = float(np.linalg.norm(list(means.values())))
    if set(means) != set("xyz") or abs(means["z"]) <= _UP * size:
        return 0
    return -1 if means["z"] > 0.0 else 1


def _read(sources: Sequence[Source], lines: Sequence[str], *, turned: bool) -> dict[str, Topic]:
    """Return velocities, depth and attitude as the proposal has them; nothing where they cannot be read so.

    turned: whether the IMU is in REP 103's axes.
    """
    used = [line for line in lines if line.startswith(("time:", *_READ)) and "unit: '?'" not in line]
    attitude = any(line.startswith("rov/imu.orientation") for line in used)
    axes = [f"axes: {{rov/imu: {REP103}}}"] if turned and attitude else []
    try:
        return {t.name: t for t in mapped_topics(sources, parse_map("\n".join([*used, *axes])), Decisions())[0]}
    except RunError:
        return {}


def _falling(read: Mapping[str, Topic], topic: str) -> int:
    """Return s, 0 where the depth does not tell it."""
    velocity = vector_of(read.get(topic), "twist.twist.linear", "xyz")
    depth = vector_of(read.get("rov/depth"), "depth", ("",))
    if velocity is None or depth is None or np.median(depth[1]) < 0.0:  # positive up: no depth
        return 0
    time, (u, v, w) = velocity[0], velocity[1].T
    down = _down(vector_of(read.get("rov/imu"), "orientation", PARTS), time)
    edges = np.arange(max(time[0], depth[0][0]), min(time[-1], depth[0][-1]), _WINDOW)
    if edges.size <= _FEWEST:
        return 0
    fallen, along, across = (
        np.diff(np.interp(edges, *each))
        for each in ((depth[0], depth[1][:, 0]), _summed(time, down[0] * u), _summed(time, down[1] * v + down[2] * w))
    )
    left = fallen - along
    size = float(np.linalg.norm(left) * np.linalg.norm(across))
    alike = float(left @ across) / size if size > 0.0 else 0.0
    moved = float(np.sqrt(np.mean(left**2))) > _MOVED
    return int(np.sign(alike)) if moved and abs(alike) > _ALIKE else 0


def _down(attitude: tuple[Array, Array] | None, time: Array) -> Array:
    """Return the earth's down in body axes (3, N) at these times; that of a level vehicle without an attitude."""
    if attitude is None:
        return np.tile([[0.0], [0.0], [1.0]], time.size)
    return np.stack([np.interp(time, attitude[0], row) for row in down_in_body(attitude[1]).T])


def _summed(time: Array, rate: Array) -> tuple[Array, Array]:
    """Return times and the integral of a rate up to each."""
    return time, np.asarray(cumulative_trapezoid(rate, time, initial=0.0))
