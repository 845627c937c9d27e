"""A plain csv with a map of its columns -> topics.

The map is YAML, one entry per channel:

    thruster_0/state.n: {column: rpm, time_column: t, unit: rad/s, scale: 0.10471975512}

`column` and `time_column` are names of the header line or 1-based numbers. value = scale * cell + offset, in
`unit`; `time_scale` (default 1) brings the time column to seconds; cells equal to one of `nan` (and empty
ones) are not measured.
"""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ..definitions import definitions
from ..errors import RecordingError
from ..topic import Topic
from ..units import unit_of

Array = NDArray[np.float64]
KNOWN = {
    "thrust_setpoint": "thruster_msgs/msg/ThrustSetpoint",
    "speed_setpoint": "thruster_msgs/msg/SpeedSetpoint",
    "throttle": "thruster_msgs/msg/Throttle",
    "state": "thruster_msgs/msg/ThrusterState",
    "flow": "thruster_msgs/msg/FlowVelocity",
    "adv_raw": "thruster_msgs/msg/AdvSample",
    "load": "geometry_msgs/msg/WrenchStamped",
    "gauges": "thruster_msgs/msg/LoadCellGauges",
    "estimate": "thruster_msgs/msg/ThrusterEstimate",
    "truth": "thruster_msgs/msg/ThrusterTruth",
}
"""Last part of `thruster_<i>/...` -> type."""
KNOWN_VEHICLE = {
    "rov/truth": "nav_msgs/msg/Odometry",
    "rov/setpoint": "thruster_msgs/msg/VehicleSetpoint",
    "rov/odometry": "nav_msgs/msg/Odometry",
    "rov/imu": "sensor_msgs/msg/Imu",
    "rov/velocity": "geometry_msgs/msg/TwistWithCovarianceStamped",
    "rov/depth": "thruster_msgs/msg/Depth",
    "rov/battery": "sensor_msgs/msg/BatteryState",
    "rov/operator": "geometry_msgs/msg/TwistStamped",
    "rov/wrench": "geometry_msgs/msg/WrenchStamped",
}
KEYS = {"column", "time_column", "unit", "scale", "offset", "nan", "time_scale"}
START_S = 1.0
MAX_MAP_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Column:
    """One entry of the map."""

    channel: str
    topic: str
    type: str
    path: str
    column: str | int
    time_column: str | int
    unit: str
    scale: float = 1.0
    offset: float = 0.0
    time_scale: float = 1.0
    nan: frozenset[str] = field(default_factory=frozenset)


def topic_type(topic: str) -> str | None:
    """Return the message type of a known topic, None for others."""
    parts = topic.strip("/").split("/")
    if len(parts) == 2 and parts[0].startswith("thruster_") and parts[0][9:].isdigit():
        return KNOWN.get(parts[1])
    return KNOWN_VEHICLE.get(topic.strip("/"))


def read_map(path: Path) -> list[Column]:
    """Read and check a map.

    Raises:
        RecordingError: all that is wrong with it.
    """
    try:
        if path.stat().st_size > MAX_MAP_BYTES:
            raise RecordingError(f"{path}: expected a map of at most {MAX_MAP_BYTES} bytes", path=path)
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RecordingError(f"{path}: cannot be read as YAML: {error}", path=path) from error
    if not isinstance(content, dict) or not content:
        kind = type(content).__name__
        text = f"{path}: expected entries `channel: {{column, time_column, unit}}`, found {kind}"
        raise RecordingError(text, path=path, expected="entries", found=kind)
    problems: list[str] = []
    columns = [c for name, entry in content.items() if (c := _column(str(name), entry, problems)) is not None]
    if problems:
        raise RecordingError(f"{path}: " + "; ".join(problems), path=path, found=problems)
    return columns


def _column(name: str, entry: Any, problems: list[str]) -> Column | None:
    before = len(problems)
    topic, dot, path = name.strip("/").partition(".")
    kind = topic_type(topic)
    if kind is None:
        known = ", ".join([*(f"thruster_<i>/{k}" for k in KNOWN), *KNOWN_VEHICLE])
        problems.append(f"{name}: unknown topic {topic!r}; known are {known}")
        return None
    if not isinstance(entry, Mapping):
        problems.append(f"{name}: expected a mapping with column, time_column and unit, found {entry!r}")
        return None
    unknown, missing = sorted(set(entry) - KEYS), sorted({"column", "time_column", "unit"} - set(entry))
    problems += [f"{name}: unknown key {k!r}; known are {', '.join(sorted(KEYS))}" for k in map(str, unknown)]
    problems += [f"{name}: key {k!r} is missing" for k in missing]
    for key in ("scale", "offset", "time_scale"):
        value = entry.get(key, 1.0)
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            problems.append(f"{name}: {key}: expected a number, found {value!r}")
    for key in ("column", "time_column"):
        value = entry.get(key, 1)
        if isinstance(value, bool) or not isinstance(value, int | str) or (isinstance(value, int) and value < 1):
            problems.append(f"{name}: {key}: expected a name or a number from 1, found {value!r}")
    definitions().require(kind)
    expected = unit_of(kind, path)
    if not dot or not expected:
        problems.append(f"{name}: {kind} has no numeric field {path!r}")
    elif "unit" in entry and entry["unit"] != expected:
        problems.append(f"{name}: expected unit {expected!r}, found {entry['unit']!r}; convert with scale")
    if len(problems) > before:
        return None
    given = entry.get("nan", [])
    marks = given if isinstance(given, list) else [given]
    return Column(
        channel=name, topic=topic, type=kind, path=path, unit=expected,
        column=entry["column"], time_column=entry["time_column"],
        scale=float(entry.get("scale", 1.0)), offset=float(entry.get("offset", 0.0)),
        time_scale=float(entry.get("time_scale", 1.0)), nan=frozenset(str(m) for m in marks),
    )  # fmt: skip


class Table:
    """A csv in memory: rows of text, and the names of its columns if the first line has some."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open(encoding="utf-8-sig", newline="") as file:
                rows = [(i, row) for i, row in enumerate(csv.reader(file), 1) if any(cell.strip() for cell in row)]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise RecordingError(f"{path}: cannot be read as csv: {error}", path=path) from error
        named = bool(rows) and any(_number(cell) is None for cell in rows[0][1])
        self.names = [cell.strip() for cell in rows[0][1]] if named else []
        self.rows = rows[1:] if named else rows
        if not self.rows:
            raise RecordingError(f"{path}: expected rows of numbers, found none", path=path, found=0)

    def index(self, column: str | int, channel: str) -> int:
        """Return the 0-based index of a column."""
        if isinstance(column, int):
            if column <= len(self.rows[0][1]):
                return column - 1
            found = f"{len(self.rows[0][1])} columns"
        elif self.names.count(column) == 1:
            return self.names.index(column)
        else:
            found = ", ".join(self.names) or "no header line"
            found += f" ({column!r} more than once)" if column in self.names else ""
        text = f"{self.path}: {channel}: expected column {column!r}, found {found}"
        raise RecordingError(text, path=self.path, expected=column, found=found)

    def numbers(self, index: int, nan: frozenset[str]) -> Array:
        """Return a column; empty cells and those in `nan` are NaN."""
        result = np.full(len(self.rows), np.nan)
        for i, (line, row) in enumerate(self.rows):
            cell = row[index].strip() if index < len(row) else ""
            if not cell or cell in nan:
                continue
            value = _number(cell)
            if value is None:
                text = f"{self.path}, line {line}, column {index + 1}: expected a number, found {cell!r}"
                raise RecordingError(text, path=self.path, position=line, expected="a number", found=cell)
            result[i] = value
        return result


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None


def topics(table: Table, columns: list[Column]) -> list[Topic]:
    """Return the topics; channels of one topic with different time columns are merged, NaN in the gaps.

    Raises:
        RecordingError: a column is missing, a cell is no number, or rows are out of order (`position`: line).
    """
    starts, prepared = [], []
    for column in columns:
        time = table.numbers(table.index(column.time_column, column.channel), column.nan) * column.time_scale
        values = table.numbers(table.index(column.column, column.channel), column.nan) * column.scale + column.offset
        there = np.flatnonzero(np.isfinite(time))
        if not there.size:
            text = f"{table.path}: {column.channel}: time column {column.time_column!r} has no number"
            raise RecordingError(text, path=table.path, found=column.time_column)
        time, values = time[there], values[there]
        falls = np.flatnonzero(np.diff(time) < 0)
        if falls.size:
            i = int(falls[0]) + 1
            line = table.rows[int(there[i])][0]
            text = f"{table.path}, line {line}: rows out of order: {time[i]:g} s after {time[i - 1]:g} s"
            raise RecordingError(
                text, path=table.path, position=line, expected=float(time[i - 1]), found=float(time[i])
            )
        starts.append(float(time[0]))
        prepared.append((column, time, values))
    shift = START_S - min(starts) if min(starts) < 0 else 0.0
    by_topic: dict[str, list[tuple[Column, NDArray[np.int64], Array]]] = {}
    for column, time, values in prepared:
        stamps = np.round((time + shift) * 1e9).astype(np.int64)
        by_topic.setdefault(column.topic, []).append((column, stamps, values))
    return [_merge(name, parts) for name, parts in by_topic.items()]


def _merge(name: str, parts: list[tuple[Column, NDArray[np.int64], Array]]) -> Topic:
    if all(np.array_equal(stamps, parts[0][1]) for _, stamps, _ in parts):
        stamps = parts[0][1]
        fields = {column.path: values for column, _, values in parts}
    else:
        stamps = np.unique(np.concatenate([s for _, s, _ in parts]))
        fields = {}
        for column, own, values in parts:
            merged = np.full(len(stamps), np.nan)
            merged[np.searchsorted(stamps, own)] = values
            fields[column.path] = merged
    return Topic(name=name, type=parts[0][0].type, stamps=stamps, fields=fields)
