"""The unit of a gyro by the attitude beside it: both turn as fast."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ..errors import RunError
from .axes import PARTS
from .checked_map import parse_map
from .decisions import Decisions
from .mapped_topics import mapped_topics
from .possible_units import units_of
from .sources import Source
from .turning import turning_ratio
from .vectors import vector_of

__all__ = ["gyro_by_attitude"]

_GYRO, _ASKED = "rov/imu.angular_velocity", "unit: '?'"
_ATTITUDES = (("rov/imu", "orientation"), ("rov/odometry", "pose.pose.orientation"))
_WITHIN = 1.5
"""Ratio by which a gyro's unit may be off: units are further apart."""


def gyro_by_attitude(sources: Sequence[Source], times: Sequence[str], entries: Sequence[str]) -> list[str]:
    """Return the entries of a proposed map, a gyro's with the unit that an attitude tells where they ask for it.

    times: the proposal's lines about time.
    """
    gyro = [line for line in entries if line.startswith(_GYRO) and _ASKED in line]
    for topic, head in _ATTITUDES:
        attitude = [line for line in entries if line.startswith(f"{topic}.{head}") and _ASKED not in line]
        if len(gyro) == 3 and attitude and (unit := _unit(sources, [*times, *attitude], gyro, topic, head)):
            told = rf"unit: {unit}\1unit by its values: as {unit} it turns as the attitude does"
            return [re.sub(r"unit: '\?'(.*?)write the unit: .*", told, e) if e in gyro else e for e in entries]
    return list(entries)


def _unit(sources: Sequence[Source], lines: Sequence[str], gyro: Sequence[str], topic: str, head: str) -> str:
    """Return the unit in which the gyro turns as this attitude does, "" where none does or nothing turns."""
    text = "\n".join([*lines, *(line.replace(_ASKED, "unit: rad/s") for line in gyro)])
    try:
        read = {each.name: each for each in mapped_topics(sources, parse_map(text), Decisions())[0]}
    except RunError:
        return ""
    rates = vector_of(read.get("rov/imu"), "angular_velocity", "xyz")
    attitude = vector_of(read.get(topic), head, PARTS)
    ratio = turning_ratio(rates, attitude) if rates and attitude else None
    if ratio is None:
        return ""
    return next((u for u, factor in units_of("rad/s").items() if abs(np.log(factor * ratio)) < np.log(_WITHIN)), "")
