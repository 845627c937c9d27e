"""The columns of a csv -> topics, on a clock that starts at 1 s."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from ..topic import Topic
from .column_map import Column, Constant
from .csv_table import Array, Table
from .decisions import Decisions

START_S = 1.0
MAX_SPAN_S = float((1 << 31) - 2)
SIGN_UNKNOWN, SIGN_MEASURED = 0, 1
STATE = "thruster_msgs/msg/ThrusterState"
Part = tuple[Column, NDArray[np.int64], Array]


def topics(table: Table, entries: Sequence[Column | Constant], log: Decisions) -> tuple[list[Topic], list[str]]:
    """Return the topics, and warnings; channels of one topic with different times are merged, NaN in the gaps.

    Raises:
        RecordingError: a column is missing, a cell is no number, or rows are out of order (`position`: line).
    """
    columns = [e for e in entries if isinstance(e, Column)]
    read = [(c, *_read(table, c)) for c in columns]
    start = min(float(time[0]) for _, time, _, _ in read)
    by_topic: dict[str, list[Part]] = {}
    for column, time, values, rows in read:
        if time[-1] - start > MAX_SPAN_S:
            row = int(rows[np.flatnonzero(time - start > MAX_SPAN_S)[0]])
            at = table.index(column.time_column, column.channel)
            expected = f"a time at most {MAX_SPAN_S:g} s after the first one"
            raise table.refusal(row, at, expected, table.rows[row][1][at])
        stamps = np.round((time - start + START_S) * 1e9).astype(np.int64)
        by_topic.setdefault(column.topic, []).append((column, stamps, values))
        how = f"column {column.column!r} at {column.time_column!r}; value = {column.scale:g} * cell + {column.offset:g}"
        log.add(column.channel, column.column, column.unit, how)
    shift = START_S - start
    how = f"{shift!r} s was added to all times, so that the clock starts at {START_S:g} s, as that of bench recordings"
    log.add("shift of the clock", shift, "s", how)
    made: list[Topic] = []
    warnings: list[str] = []
    for name, parts in by_topic.items():
        stamps, fields = _merge(parts)
        for e in entries:
            if isinstance(e, Constant) and e.topic == name:
                fields[e.path] = np.full(len(stamps), e.value)
                log.add(e.channel, e.value, e.unit, "the same in all messages, as the map says")
        kind = parts[0][0].type
        if kind == STATE and "n" in fields and "sign_source" not in fields:
            fields["sign_source"] = np.full(len(stamps), _sign_source(name, fields, log, warnings))
        made.append(Topic(name=name, type=kind, stamps=stamps, fields=fields))
    return made, warnings


def _read(table: Table, column: Column) -> tuple[Array, Array, NDArray[np.intp]]:
    """Return time [s] and values of the rows in which this column has a time, and which these are."""
    at, index = table.index(column.time_column, column.channel), table.index(column.column, column.channel)
    time = table.numbers(at, column.nan, column.time_scale)
    values = table.numbers(index, column.nan, column.scale, column.offset)
    timeless = np.flatnonzero(np.isnan(time) & ~np.isnan(values))
    there = np.flatnonzero(~np.isnan(time))
    if not there.size:
        text = f"{table.path}: {column.channel}: time column {column.time_column!r} has no number"
        raise RecordingError(text, path=table.path, found=column.time_column)
    if timeless.size:
        row = int(timeless[0])
        raise table.refusal(row, at, f"the time of the value in column {index + 1}", table.rows[row][1][at])
    time, values = time[there], values[there]
    falls = np.flatnonzero(np.diff(time) < 0)
    if falls.size:
        i = int(falls[0]) + 1
        line = table.line(int(there[i]))
        text = f"{table.path}, line {line}: rows out of order: {time[i]:g} s after {time[i - 1]:g} s"
        raise RecordingError(text, path=table.path, position=line, expected=float(time[i - 1]), found=float(time[i]))
    return time, values, there


def _merge(parts: list[Part]) -> tuple[NDArray[np.int64], dict[str, Any]]:
    if all(np.array_equal(stamps, parts[0][1]) for _, stamps, _ in parts):
        return parts[0][1], {column.path: values for column, _, values in parts}
    stamps = np.unique(np.concatenate([s for _, s, _ in parts]))
    fields: dict[str, Any] = {}
    for column, own, values in parts:
        merged = np.full(len(stamps), np.nan)
        merged[np.searchsorted(stamps, own)] = values
        fields[column.path] = merged
    return stamps, fields


def _sign_source(topic: str, fields: Mapping[str, Any], log: Decisions, warnings: list[str]) -> int:
    """Decide where the sign of n comes from: only a sensor that tells the direction gives negative speeds."""
    channel = f"{topic}.sign_source"
    if np.any(fields["n"] < 0):
        log.add(channel, SIGN_MEASURED, "1", "SIGN_MEASURED: not in the map, and n is negative at times")
        return SIGN_MEASURED
    log.add(channel, SIGN_UNKNOWN, "1", "SIGN_UNKNOWN: not in the map, and n is never negative")
    warnings.append(
        f"{channel} is not in the map and n is never negative: SIGN_UNKNOWN is written, n counts as a magnitude; "
        f"where the sensor tells the direction, add `{channel}: {{value: {SIGN_MEASURED}}}`"
    )
    return SIGN_UNKNOWN
