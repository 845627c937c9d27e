"""The text of a map, read and checked: all that is wrong with it is told at once."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from safe_files.yaml_io import yaml_mapping

from ..errors import RecordingError
from .axes import ANGLES, PARTS, REP103
from .checked_entry import TIMES, TOP, check_column, entry_of, seconds_of
from .recording_map import Constant, Mapped, RecordingMap

TIME_KEYS = {"column", "unit"}
MOST_NAMED = 4
"""Entries that a sentence names before it says what is wrong with them."""
CSV_KEYS = {"separator", "decimal"}


def read_map(path: Path) -> RecordingMap:
    """Read and check a map.

    Raises:
        RecordingError: all that is wrong with it.
    """
    return _checked(yaml_mapping(path, _refused), str(path))


def parse_map(text: str) -> RecordingMap:
    """Read and check the text of a map; see `read_map`."""
    return _checked(yaml_mapping(text, _refused, "map"), "map")


def _checked(content: Mapping[Any, Any], origin: str) -> RecordingMap:
    if not set(content) - TOP:
        raise _refused(origin, ["expected entries `channel: {column or field, unit}`, found none"])
    problems: list[str] = []
    told = content.get("time")
    times = tuple(filter(None, (_time(each, problems) for each in (told if isinstance(told, list) else [told]))))
    text = _table(content.get("csv"), problems)
    made = [entry_of(str(name), entry, problems) for name, entry in content.items() if name not in TOP]
    entries = [e for e in made if e is not None]
    for e in entries:
        if isinstance(e, Mapped) and not e.is_field and e.time_column is None:
            own = set(TIMES[1:]) & set(content[e.channel])
            if not times:
                problems.append(f"{e.channel}: key 'time_column' is missing, and there is no `time: {{column, unit}}`")
            elif own and len(times) > 1:
                problems.append(f"{e.channel}: {own.pop()}: expected beside time_column, as `time` has several")
    problems += _crossing(entries)
    rep103 = _axes(content.get("axes"), entries, problems)
    if problems:
        raise _refused(origin, problems)
    return RecordingMap(entries=tuple(entries), rep103=rep103, times=times, **text)


def _refused(origin: str, problems: list[str]) -> RecordingError:
    """Return the error about a map: a line for each sentence, with the channels of which it is true."""
    channels: dict[str, list[str]] = {}
    for problem in problems:
        channel, colon, sentence = problem.partition(": ")
        channels.setdefault(colon + sentence, []).append(channel)
    lines = []
    for sentence, of in channels.items():
        whose = ", ".join(of) if len(of) <= MOST_NAMED else f"{of[0]} and {len(of) - 1} other entries"
        lines.append(f"{origin}: {whose}{sentence}")
    return RecordingError("\n".join(lines), path=origin, found=problems)


def _time(entry: Any, problems: list[str]) -> tuple[str | int, float] | None:
    if entry is None:
        return None
    if not isinstance(entry, Mapping) or "column" not in entry or set(entry) - TIME_KEYS:
        problems.append(f"time: expected {{column, unit}}, or a list of them, found {entry!r:.80}")
        return None
    check_column("time", "column", entry, problems)
    return entry["column"], seconds_of("time", entry.get("unit", "s"), problems)


def _table(entry: Any, problems: list[str]) -> dict[str, str]:
    if entry is None:
        return {}
    known = {"separator": (",", ";", "\t", " ", "|"), "decimal": (".", ",")}
    if not isinstance(entry, Mapping) or not set(entry) <= CSV_KEYS:
        problems.append(f"csv: expected {{separator, decimal}}, found {entry!r:.80}")
        return {}
    for key, value in entry.items():
        if value not in known[key]:
            problems.append(f"csv: {key}: expected one of {known[key]}, found {value!r:.80}")
    return {key: str(value) for key, value in entry.items()}


def _axes(told: Any, entries: list[Mapped | Constant], problems: list[str]) -> frozenset[str]:
    """Return the topics that are in REP 103's axes; attitudes whose parts are not all there are problems."""
    there: dict[str, dict[str, set[str]]] = {}
    for e in entries:
        if e.topic.startswith("rov/"):
            head, _, part = e.path.rpartition(".")
            there.setdefault(e.topic, {}).setdefault(head, set()).add(part)
    if told is not None and not isinstance(told, Mapping):
        problems.append(f"axes: expected {{topic: {REP103}}}, found {told!r:.80}")
        told = None
    for topic, axes in (told or {}).items():
        if axes != REP103:
            problems.append(
                f"axes: {topic}: expected {REP103} (east, north, up; forward, port, up), found {axes!r:.80}"
            )
        if topic not in there:
            problems.append(f"axes: expected topics rov/... of this map, found {topic!r:.80}")
    rep103 = frozenset(map(str, told or {}))
    for topic, heads in there.items():
        for head, parts in heads.items():
            if not head.endswith("orientation"):
                continue
            wanted = set(ANGLES) if parts & set(ANGLES) else set(PARTS)
            if parts != wanted:
                which = "all of roll, pitch, yaw, or of w, x, y, z"
                problems.append(f"{topic}.{head}: expected {which}, found {', '.join(sorted(parts))}")
    return rep103


def _crossing(entries: list[Mapped | Constant]) -> list[str]:
    """Say what is wrong between entries: a channel twice, a constant without any column, holds that differ."""
    problems: list[str] = []
    first: dict[tuple[str, str], str] = {}
    holds: dict[str, str] = {}
    for e in entries:
        key = (e.topic.strip("/"), e.path)
        if key in first:
            problems.append(f"{e.channel}: expected each channel once, found it as {first[key]} too")
        first.setdefault(key, e.channel)
        if isinstance(e, Mapped) and e.hold and holds.setdefault(e.kind, e.hold) != e.hold:
            problems.append(f"{e.channel}: hold: expected {holds[e.kind]} as for other topics {e.kind}, found {e.hold}")
    measured = {e.topic for e in entries if isinstance(e, Mapped)}
    alone = [e.channel for e in entries if e.topic not in measured]
    problems += [f"{c}: expected a column of the same topic beside the constant, found none" for c in alone]
    return problems
