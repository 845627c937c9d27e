"""The entries of a map, found in recordings -> topics, on a clock that starts at 1 s."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import NotThereError, RecordingError
from ..topic import Topic
from .axes import PARTS, REP103, attitude_of, in_our_axes
from .bag_source import BagSource
from .csv_source import MAX_SPAN_S, CsvSource
from .decisions import Decisions
from .recording_map import Constant, Mapped, RecordingMap
from .sign_source import SIGN_UNKNOWN, magnitudes, of_noise, sign_source
from .sources import Array, Series, Source
from .stated_units import against_stated, time_against_stated

START_S = 1.0
SECOND = 1_000_000_000
MOST_FILES = 8
"""Whose times a sentence lists."""
MOST_TILT = np.radians(400.0)
"""[rad] Of a roll or a pitch, which may be counted from 0 to 360 degrees."""
STATE = "thruster_msgs/msg/ThrusterState"


@dataclass(frozen=True)
class _Part:
    entry: Mapped
    stamps: NDArray[np.int64]
    values: Array


def mapped_topics(sources: Sequence[Source], told: RecordingMap, log: Decisions) -> tuple[list[Topic], list[str]]:
    """Return the topics, and warnings; channels of one topic with different times are merged, NaN in the gaps.

    Raises:
        RecordingError: columns are missing or in two files, a cell is no number, rows are out of order, or a file
            lasts while no other one does.
    """
    places = _places(sources, told)
    for source in sources:
        if isinstance(source, CsvSource):
            source.prepare([e for e, at in places if at is source])
    read = [(e, at, _later(at.series(e), e.time_offset)) for e, at in places]
    _refuse_apart([(at, series) for _, at, series in read])
    start = min(_first(series) for _, _, series in read)
    parts: dict[str, list[_Part]] = {}
    for e, at, series in read:
        lag = series.origin - start
        if (int(series.stamps[-1]) + lag) / SECOND > MAX_SPAN_S:
            row = int(series.rows[np.flatnonzero((series.stamps.astype(float) + lag) / SECOND > MAX_SPAN_S)[0]])
            raise at.refusal(e, row, f"a time at most {MAX_SPAN_S:g} s after the first one, its time is")
        stamps = series.stamps + (lag + int(START_S * SECOND))
        parts.setdefault(e.topic, []).append(_Part(e, stamps, _values(e, at, series)))
        where = e.place if e.is_field else f"{e.place} at {e.time_column!r}"
        if isinstance(at, BagSource):
            where += " at its headers' stamps" if at.stamped(e.topic_of_field) else " at the recorder's times"
        where += f" and {e.time_offset:+} s" if e.time_offset else ""
        within = f" of {at.path.name}" if len(sources) > 1 else ""
        log.add(e.channel, e.column, e.unit, f"{where}{within}; {e.how}")
    shift = START_S - start / SECOND
    how = f"{shift!r} s was added to all times, so that the clock starts at {START_S:g} s, as that of bench recordings"
    log.add("shift of the clock", shift, "s", how, digits=17)
    made: list[Topic] = []
    unsigned: list[str] = []
    doubts: list[str] = []
    warnings = [sentence for e, at in places for sentence in against_stated(e, at)]
    warnings += dict.fromkeys(sentence for e, at in places for sentence in time_against_stated(e, at))
    warnings += [sentence for own in parts.values() for part in own for sentence in _beyond_a_turn(part)]
    for name, own in parts.items():
        stamps, fields = _merge(own)
        for c in told.entries:
            if isinstance(c, Constant) and c.topic == name:
                fields[c.path] = np.full(len(stamps), c.value)
                log.add(c.channel, c.value, c.unit, "the same in all messages, as the map says")
        if name.startswith("rov/"):
            fields = in_our_axes(fields, rep103=name in told.rep103)
            _refuse_parted(name, fields)
            if name in told.rep103:
                log.add(f"axes of {name}", REP103, "", "brought to north, east, down and forward, starboard, down")
        kind = own[0].entry.type
        if kind == STATE and "n" in fields and "sign_source" not in fields:
            sign = sign_source(name, fields, log)
            fields["sign_source"] = np.full(len(stamps), sign)
            unsigned += [name] if sign == SIGN_UNKNOWN else []
            doubts += of_noise(name, fields["n"])
        made.append(Topic(name=name, type=kind, stamps=stamps, fields=fields))
    return made, warnings + magnitudes(unsigned) + doubts


def _beyond_a_turn(part: _Part) -> list[str]:
    """Return what is wrong with a roll or pitch that no attitude has."""
    name, path = part.entry.channel, part.entry.path
    largest = float(np.nanmax(np.abs(part.values), initial=0.0))
    if not attitude_of(path) or path.endswith("yaw") or largest <= MOST_TILT:
        return []
    return [
        f"{name}: up to {np.degrees(largest):.4g} degrees: expected -180 to 180; is `unit` that of the recording? "
        f"It says {part.entry.given_unit}"
    ]


def _refuse_apart(read: Sequence[tuple[Source, Series]]) -> None:
    """Refuse a file of which all samples lie before or after those of the others: its clock is another one."""
    spans: dict[Path, tuple[int, int]] = {}
    for source, series in read:
        if series.stamps.size:
            own = series.origin + int(series.stamps[0]), series.origin + int(series.stamps[-1])
            first, last = spans.get(source.path, own)
            spans[source.path] = min(first, own[0]), max(last, own[1])
    apart = {
        path: span
        for path, span in spans.items()
        if len(spans) > 1 and all(_disjoint(span, other) for at, other in spans.items() if at != path)
    }
    if not apart:
        return
    path, (first, last) = next(iter(apart.items()))
    others = [(f" of {at.name}" if len(spans) > 2 else "", span) for at, span in spans.items() if at != path]
    expected = ", ".join(f"{_seconds(span)}{whose}" for whose, span in others[:MOST_FILES])
    text = f"{path}: expected times on the clock of the other files, {expected}; found {_seconds((first, last))}"
    text += "; `time_offset` of its entries brings its times to theirs"
    if len(apart) > 1 and len(spans) > 2:
        text += f"; apart from all others are {', '.join(each.name for each in apart)}"
    begin, end = min(span[0] for _, span in others), max(span[1] for _, span in others)
    raise RecordingError(text, path=path, expected=[begin, end], found=[first, last])


def _disjoint(one: tuple[int, int], other: tuple[int, int]) -> bool:
    return one[1] < other[0] or other[1] < one[0]


def _seconds(span: tuple[int, int]) -> str:
    return f"{span[0] / SECOND:.3f} to {span[1] / SECOND:.3f} s"


def _refuse_parted(topic: str, fields: Mapping[str, Array]) -> None:
    """Refuse an attitude whose parts never stand in one row or message."""
    for head in [path.removesuffix(".w") for path in fields if path.endswith("orientation.w")]:
        if not np.isfinite(np.stack([fields[f"{head}.{part}"] for part in PARTS])).all(axis=0).any():
            text = f"{topic}.{head}: expected all its parts measured at one time; found no row or message with all"
            raise RecordingError(text, found=head)


def _timed(entry: Mapped, at: Source, told: RecordingMap) -> Mapped:
    """Return an entry of a table with a time: its own, or the first of the map's that the table has."""
    if entry.is_field:
        return entry
    column, scale = entry.time_column, told.times[0][1] if len(told.times) == 1 else 1.0
    if column is None:
        column, scale = next((each for each in told.times if at.has(replace(entry, column=each[0]))), told.times[0])
    return replace(entry, time_column=column, time_scale=entry.time_scale or scale)


def _places(sources: Sequence[Source], told: RecordingMap) -> list[tuple[Mapped, Source]]:
    """Return the entries, those of tables with a time, and where each is.

    Raises:
        RecordingError: entries are in no recording, or in two: a line for each, the last one with what there is.
    """
    places, refused = [], []
    for e in told.mapped:
        try:
            at = _place(sources, e)
        except NotThereError as error:
            refused.append(error)
        else:
            places.append((_timed(e, at, told), at))
    if refused and len(sources) > 1 and all(s.has(e) for s in sources for e in told.mapped):
        files = ", ".join(s.path.name for s in sources)
        text = f"{files}: expected all files of one recording, found all that the map names in each: import each alone"
        raise RecordingError(text, path=sources[0].path, found=files)
    if len(refused) > 1:
        lines: dict[object, list[str]] = {}
        for each in refused:
            lines.setdefault(each.found, []).append(each.asked)
        text = "\n".join("\n".join(asked) + f", found {there}" for there, asked in lines.items())
        raise RecordingError(text, path=refused[0].path, found=[str(each) for each in refused])
    if refused:
        raise refused[0]
    return places


def _place(sources: Sequence[Source], entry: Mapped) -> Source:
    """Return the one recording that an entry is in."""
    named = [s for s in sources if not entry.file or s.path.name == entry.file]
    found = [s for s in named if s.has(entry)]
    if len(found) > 1:  # a whole name goes before one whose unit in brackets is left out
        found = [s for s in found if entry.column in s.names()] or found
    if len(found) == 1:
        return found[0]
    what = entry.place
    if found:
        files = ", ".join(s.path.name for s in found)
        raise NotThereError(entry.channel, f"{what} in one file (say which by `file: NAME`)", f"it in {files}")
    if not named:
        raise NotThereError(entry.channel, f"file {entry.file!r}", ", ".join(s.path.name for s in sources))
    source = max(named, key=lambda s: sum(s.has(each) for each in _columns(entry)))
    if entry.is_field == isinstance(source, CsvSource):
        other = "column" if isinstance(source, CsvSource) else "field"
        kind = "a table, whose entries have a `column`" if other == "column" else "a bag or log, whose have a `field`"
        raise NotThereError(entry.channel, other, f"{what}; it is {kind}", path=source.path)
    if isinstance(source, CsvSource):
        source.refuse_missing(entry)  # says what there is
    names = source.names()
    listed = ", ".join(names[:40]) + (f" and {len(names) - 40} more" if len(names) > 40 else "")
    raise NotThereError(entry.channel, what, listed, path=source.path)


def _columns(entry: Mapped) -> list[Mapped]:
    """Return an entry for each column that an entry reads."""
    return [replace(entry, column=column, where=()) for column in (entry.column, *(told for told, _ in entry.where))]


def _later(series: Series, offset: float) -> Series:
    """Return samples with an offset [s] added to their times."""
    whole = math.floor(offset)  # a float has no ns of times since 1970
    return replace(series, origin=series.origin + whole * SECOND + round((offset - whole) * SECOND))


def _first(series: Series) -> int:
    return series.origin + int(series.stamps[0])


def _values(entry: Mapped, source: Source, series: Series) -> Array:
    with np.errstate(over="ignore"):
        scaled = (
            series.values if (entry.scale, entry.offset) == (1.0, 0.0) else entry.scale * series.values + entry.offset
        )
        values = entry.convert(scaled)
    wrong = np.flatnonzero(np.isinf(values))
    if wrong.size:
        raise source.refusal(entry, int(series.rows[wrong[0]]), f"a finite number of {entry.unit}")
    return values


def _merge(parts: list[_Part]) -> tuple[NDArray[np.int64], dict[str, Any]]:
    if all(np.array_equal(p.stamps, parts[0].stamps) for p in parts):
        return parts[0].stamps, {p.entry.path: p.values for p in parts}
    stamps = np.unique(np.concatenate([p.stamps for p in parts]))
    fields: dict[str, Any] = {}
    for p in parts:
        merged = np.full(len(stamps), np.nan)
        merged[np.searchsorted(stamps, p.stamps)] = p.values
        fields[p.entry.path] = merged
    return stamps, fields
