"""Which topics of a vehicle are in REP 103's axes, each by evidence of its own: gravity beside an attitude, how the
depth changes, or names."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ..errors import RunError
from ..topic import Topic
from .attitude_advice import tilts_as_felt
from .axes import REP103
from .checked_map import parse_map
from .decisions import Decisions
from .falling import falling
from .mapped_topics import mapped_topics
from .sources import Array, Source

__all__ = ["axes_lines"]

_UP = 0.5
"""Share of the specific force along z, upwards, from which on z points up."""
_IMU, _MOVING = "rov/imu", ("rov/velocity", "rov/odometry")
_POINTS_UP = "at rest the IMU's z axis points up"
_WHICH_WAY = f"{_POINTS_UP}: is y to port, or is it mounted upside down? the sensors' file then states `rotation`"
"""Asked where both explain the same."""


def axes_lines(
    topics: Collection[str], force: Mapping[str, Array | None], sources: Sequence[Source], lines: Sequence[str],
    *, named: Mapping[str, int],
) -> list[str]:  # fmt: skip
    """Return the lines of a proposed map about axes: those of topics that tell it, a question about the others.

    Args:
        topics: with vectors, of which nobody has said in which axes they are.
        force: what the accelerometer tells by axis, in any unit.
        sources: the recordings; lines: those of the proposal about their times and channels.
        named: topics whose names or types say their axes: 1 ours, -1 REP 103's.
    """
    upright = _upright(force) if _IMU in topics else 0
    ways, why = {}, {}
    if _IMU in topics:
        ways[_IMU] = upright if upright >= 0 else _turned(sources, lines) or min(named.get(_IMU, 0), 0)
        why[_IMU] = _POINTS_UP
    moving = [topic for topic in _MOVING if topic in topics]
    if moving:
        unknown = upright < 0 and ways[_IMU] == 0  # as if level: its attitude is in axes that nobody knows
        read = _read(sources, [e for e in lines if not (unknown and e.startswith(_IMU))], turned=ways.get(_IMU, 0) < 0)
        for topic in moving:
            fallen = falling(read, topic)
            ways[topic] = fallen or named.get(topic, 0)
            why[topic] = f"{topic}.z is positive while the depth shrinks" if fallen else f"{topic}: as its names say"
    told = [topic for topic, way in sorted(ways.items()) if way < 0]
    asked = [topic for topic, way in sorted(ways.items()) if way == 0 and named.get(topic, 0) <= 0]
    found = [f"{_axes(told)}   # {'; '.join(why[topic] for topic in told)}"] if told else []
    plain = [topic for topic in asked if topic != _IMU or upright == 0]
    questions = [_WHICH_WAY] if plain != asked else []
    questions += [f"if x is forward, y port, z up in {', '.join(plain)}: nothing says so"] if plain else []
    return [*found, *([f"# {_axes([*told, *asked])}   # {'; '.join(questions).replace('?;', '?')}"] if asked else [])]


def _axes(topics: Sequence[str]) -> str:
    return f"axes: {{{', '.join(f'{topic}: {REP103}' for topic in sorted(topics))}}}"


def _upright(force: Mapping[str, Array | None]) -> int:
    """Return 1 where the specific force says that z points down, -1 where up, 0 where it says neither."""
    means = {axis: float(np.nanmean(values)) for axis, values in force.items() if values is not None}
    size = float(np.linalg.norm(list(means.values())))
    if set(means) != set("xyz") or abs(means["z"]) <= _UP * size:
        return 0
    return -1 if means["z"] > 0.0 else 1


def _turned(sources: Sequence[Source], lines: Sequence[str]) -> int:
    """Return -1 where the attitude fits an IMU in REP 103's axes, 1 where it fits one in ours upside down, else 0."""
    for way in (1, -1):
        read = _read(sources, lines, turned=way < 0)
        if tilts_as_felt(read.get(_IMU), read.get("rov/odometry")):
            return way
    return 0


def _read(sources: Sequence[Source], lines: Sequence[str], *, turned: bool) -> dict[str, Topic]:
    """Return velocities, depth, specific force and attitude as the proposal has them; nothing where they cannot be
    read so.

    turned: whether the IMU is in REP 103's axes.
    """
    heads = ("time:", *_MOVING, "rov/depth", f"{_IMU}.orientation", f"{_IMU}.linear_acceleration")
    used = [line for line in lines if line.startswith(heads) and "unit: '?'" not in line]
    imu = any(line.startswith(_IMU) for line in used)
    axes = [f"axes: {{{_IMU}: {REP103}}}"] if turned and imu else []
    try:
        return {t.name: t for t in mapped_topics(sources, parse_map("\n".join([*used, *axes])), Decisions())[0]}
    except RunError:
        return {}
