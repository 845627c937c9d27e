"""Which topics of a vehicle are in REP 103's axes, each by evidence of its own: gravity, or how the depth changes."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from ..errors import RunError
from ..topic import Topic
from .axes import REP103
from .checked_map import parse_map
from .decisions import Decisions
from .falling import falling
from .mapped_topics import mapped_topics
from .sources import Array, Source

__all__ = ["axes_lines"]

_UP = 0.5
"""Share of the specific force along z, upwards, from which on z points up."""
_MOVING = ("rov/velocity", "rov/odometry")
_READ = (*_MOVING, "rov/depth", "rov/imu.orientation")


def axes_lines(
    topics: Collection[str], force: Mapping[str, Array | None], sources: Sequence[Source], lines: Sequence[str],
    *, ours: Collection[str] = (),
) -> list[str]:  # fmt: skip
    """Return the lines of a proposed map about axes: those of topics that tell it, a question about the others.

    Args:
        topics: with vectors, of which nobody has said in which axes they are.
        force: what the accelerometer tells by axis, in any unit.
        sources: the recordings; lines: those of the proposal about their times and channels.
        ours: topics that a name says to be in our axes: nothing is asked about them.
    """
    ways = {"rov/imu": _upright(force)} if "rov/imu" in topics else {}
    moving = [topic for topic in _MOVING if topic in topics]
    if moving:
        read = _read(sources, lines, turned=ways.get("rov/imu", 0) < 0)
        ways |= {topic: falling(read, topic) for topic in moving}
    told = [topic for topic, way in sorted(ways.items()) if way < 0]
    asked = [topic for topic, way in sorted(ways.items()) if way == 0 and topic not in ours]
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
