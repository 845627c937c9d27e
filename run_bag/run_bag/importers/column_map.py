"""The map of the columns of a csv.

The map is YAML, one entry per channel:

    thruster_0/state.n: {column: rpm, time_column: t, unit: rad/s, scale: 0.10471975512}
    thruster_0/state.sign_source: {value: 1}

`column` and `time_column` are names of the header line or 1-based numbers. value = scale * cell + offset, in
`unit`; `time_scale` (default 1) brings the time column to seconds; cells equal to one of `nan` (and empty
ones) are not measured. `value` is one number for every message of the topic.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from ..definitions import definitions
from ..errors import RecordingError
from ..known_topics import known_topics, topic_type
from ..units import unit_of
from .unique_keys import load

NEEDED = {"column", "time_column", "unit"}
KEYS = NEEDED | {"scale", "offset", "nan", "time_scale"}
CONSTANT_KEYS = {"value", "unit"}
MAX_MAP_BYTES = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What every entry of the map says: the channel as written, and its topic, type, field and unit."""

    channel: str
    topic: str
    type: str
    path: str
    unit: str


@dataclass(frozen=True, kw_only=True)
class Column(Entry):
    """A channel out of a column."""

    column: str | int
    time_column: str | int
    scale: float = 1.0
    offset: float = 0.0
    time_scale: float = 1.0
    nan: frozenset[str] = field(default_factory=frozenset)


@dataclass(frozen=True, kw_only=True)
class Constant(Entry):
    """A channel that has one value in all messages of its topic."""

    value: float


def read_map(path: Path) -> list[Column | Constant]:
    """Read and check a map.

    Raises:
        RecordingError: all that is wrong with it.
    """
    try:
        if path.stat().st_size > MAX_MAP_BYTES:
            raise RecordingError(f"{path}: expected a map of at most {MAX_MAP_BYTES} bytes", path=path)
        content = load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
        raise RecordingError(f"{path}: cannot be read as YAML: {error}", path=path) from error
    if not isinstance(content, dict) or not content:
        kind = type(content).__name__
        text = f"{path}: expected entries `channel: {{column, time_column, unit}}`, found {kind}"
        raise RecordingError(text, path=path, expected="entries", found=kind)
    problems: list[str] = []
    entries = [e for name, entry in content.items() if (e := _entry(str(name), entry, problems)) is not None]
    problems += _crossing(entries)
    if problems:
        raise RecordingError(f"{path}: " + "; ".join(problems), path=path, found=problems)
    return entries


def _entry(name: str, entry: Any, problems: list[str]) -> Column | Constant | None:
    before = len(problems)
    topic, dot, path = name.strip("/").partition(".")
    kind = topic_type(topic)
    if kind is None:
        problems.append(f"{name}: unknown topic {topic!r}; known are {known_topics()}")
        return None
    if not isinstance(entry, Mapping):
        problems.append(f"{name}: expected a mapping with column, time_column and unit, or value, found {entry!r}")
        return None
    definitions().require(kind)
    unit = unit_of(kind, path)
    if not dot or not unit:
        problems.append(f"{name}: {kind} has no numeric field {path!r}")
    elif "unit" in entry and entry["unit"] != unit:
        problems.append(f"{name}: expected unit {unit!r}, found {entry['unit']!r}; convert with scale")
    constant = "value" in entry
    known, needed = (CONSTANT_KEYS, {"value"}) if constant else (KEYS, NEEDED)
    unknown, missing = sorted(map(str, set(entry) - known)), sorted(needed - set(entry))
    beside = " beside value" if constant else ""
    problems += [f"{name}: unknown key {k!r}{beside}; known are {', '.join(sorted(known))}" for k in unknown]
    problems += [f"{name}: key {k!r} is missing" for k in missing]
    for key in ("scale", "offset", "time_scale", "value"):
        if key in entry and not _is_number(entry[key]):
            problems.append(f"{name}: {key}: expected a number, found {entry[key]!r}")
        elif key == "time_scale" and entry.get(key, 1.0) <= 0:
            problems.append(f"{name}: {key}: expected a positive number, found {entry[key]!r}")
    for key in ("column", "time_column"):
        value = entry.get(key, 1)
        if isinstance(value, bool) or not isinstance(value, int | str) or (isinstance(value, int) and value < 1):
            problems.append(f"{name}: {key}: expected a name or a number from 1, found {value!r}")
    if len(problems) > before:
        return None
    if constant:
        return Constant(channel=name, topic=topic, type=kind, path=path, unit=unit, value=float(entry["value"]))
    given = entry.get("nan", [])
    marks = given if isinstance(given, list) else [given]
    return Column(
        channel=name, topic=topic, type=kind, path=path, unit=unit,
        column=entry["column"], time_column=entry["time_column"],
        scale=float(entry.get("scale", 1.0)), offset=float(entry.get("offset", 0.0)),
        time_scale=float(entry.get("time_scale", 1.0)), nan=frozenset(str(m) for m in marks),
    )  # fmt: skip


def _crossing(entries: list[Column | Constant]) -> list[str]:
    """Say what is wrong between entries: a channel under two names, a constant without any column."""
    problems: list[str] = []
    first: dict[tuple[str, str], str] = {}
    for e in entries:
        key = (e.topic.strip("/"), e.path)
        if key in first:
            problems.append(f"{e.channel}: expected each channel once, found it as {first[key]} too")
        first.setdefault(key, e.channel)
    measured = {e.topic for e in entries if isinstance(e, Column)}
    alone = [e.channel for e in entries if e.topic not in measured]
    problems += [f"{c}: expected a column of the same topic beside the constant, found none" for c in alone]
    return problems


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:  # an integer beyond all floats
        return False
