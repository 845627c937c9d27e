"""Read a run: a rosbag2 directory (of one or several MCAP files) or a single MCAP file, whole or cut off."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import run_metadata
from .bag_folder import bag_files, losses
from .budget import Budget
from .decode import Columns, decode
from .definitions import FieldsOf, full_name, parse_schema
from .errors import EmptyRunError, MissingTopicError, RunError, SchemaError, StampOrderError
from .mcap_content import RawTopic, Scan, Schema
from .mcap_scan import scan
from .one_clock import APART, of_one_clock
from .other_bags import scan_others, unpack_messages
from .rosbag2 import BAG_RECORD
from .run import NANOSECONDS, Channel, Run
from .units import unit_of

_SHARED = ("diagnostic_msgs/msg/DiagnosticArray", "tf2_msgs/msg/TFMessage", "rcl_interfaces/msg/Log")
"""Types of topics that all nodes publish on: their stamps need not follow each other."""

_OVERTAKEN = 500_000_000
"""[ns] By which messages may overtake each other on their way, over a network or through threads."""
_FIRST_TRANSFORM = "transforms[0].header.stamp"

_UNASKED = (
    "rcl_interfaces/msg/Log",
    "rcl_interfaces/msg/ParameterEvent",
    "nav_msgs/msg/Path",
    "visualization_msgs/msg/MarkerArray",
    "visualization_msgs/msg/Marker",
)
"""Types that are read only if they are asked for: what nodes say of themselves, on their own clocks, and what draws for
viewers what other topics measure, each message repeating what was before in ever more fields."""


@dataclass(frozen=True)
class Recording:
    """The raw content of a run: files scanned, messages not decoded. What a recovery starts from.

    Attributes:
        path: as given.
        name: name of the run.
        scans: one per file, in order.
        metadata: the recorded `run` object; other MCAP metadata under "mcap".
        warnings: damage and loss, one sentence each.
        budget: what is left of it.
    """

    path: Path
    name: str
    scans: tuple[Scan, ...]
    metadata: Mapping[str, Any]
    warnings: tuple[str, ...]
    budget: Budget


def read_run(path: Path | str, topics: Iterable[str] | None = None) -> Run:
    """Read a run into arrays.

    Messages are decoded by the definitions inside the file. A channel's stamps are the header stamps where
    the type has a header (log times if none of them was ever filled in, or on topics that all nodes share, as
    /diagnostics), else the log times. Channels in
    which nothing was measured (all NaN) are left out; so are strings, and what nodes log or draw for viewers (paths,
    markers) unless it is asked for.

    Args:
        path: rosbag2 directory or .mcap file.
        topics: with or without leading slash; None: all. Asked for explicitly, a topic must be decodable;
            otherwise one that is not decodable is left out with a warning.

    Returns:
        The run; what was lost or left out is in `warnings`.

    Raises:
        NotARunError: nothing there, no MCAP file, or not MCAP.
        MissingTopicError: a requested topic is not there.
        SchemaError: a requested topic cannot be decoded.
        StampOrderError: header stamps run backwards within a topic, further than messages overtake each other.
        EmptyRunError: no message, or no measured value.
        TooLargeError: a size in the file exceeds the caps, or the content the budget.
        ClockError: topics of two clocks.
    """
    wanted = None if topics is None else {t.strip("/") for t in topics}
    recording = read_recording(path, wanted)
    warnings = list(recording.warnings)
    budget = recording.budget
    parsed: dict[Schema, FieldsOf] = {}
    by_topic: dict[str, list[RawTopic]] = {}
    for one in recording.scans:
        for raw in one.topics.values():
            by_topic.setdefault(raw.topic.strip("/"), []).append(raw)
    if not any(s.message_count for s in recording.scans):
        text = "; ".join([f"{recording.path}: the run has no message", *warnings])
        raise EmptyRunError(text, path=recording.path, found=0)
    missing = sorted((wanted or set()) - set(by_topic))
    if missing:
        listed = ", ".join(sorted(by_topic)) or "no topic at all"
        text = f"{recording.path}: no topic {', '.join(missing)}; it has: {listed}"
        raise MissingTopicError(text, path=recording.path, topic=missing[0], expected=missing, found=sorted(by_topic))
    channels: dict[str, Channel] = {}
    for topic, parts in by_topic.items():
        if (wanted is not None and topic not in wanted) or not any(p.payloads for p in parts):
            continue
        if wanted is None and all(p.schema is not None and full_name(p.schema.name) in _UNASKED for p in parts):
            continue
        try:
            channels.update(_channels(recording.path, topic, parts, warnings, budget, parsed))
        except SchemaError as error:
            if wanted is not None:
                raise
            warnings.append(f"{error}; the topic was left out")
    channels = of_one_clock(recording.path, channels, warnings, asked=wanted is not None)
    if not channels:
        text = "; ".join([f"{recording.path}: no channel with a measured value", *warnings])
        raise EmptyRunError(text, path=recording.path, found=0)
    return Run(name=recording.name, channels=channels, metadata=recording.metadata, warnings=tuple(warnings))


def read_recording(path: Path | str, wanted: set[str] | None = None) -> Recording:
    """Scan the files of a run without decoding; `wanted` names topics without leading slash, None: all.

    Raises:
        NotARunError, TooLargeError: as read_run.
    """
    path = Path(path)
    files, description, unclear = bag_files(path, others=True)
    budget = Budget(sum(f.stat().st_size for f in files))

    def kept(topic: str) -> bool:
        return wanted is None or topic.strip("/") in wanted

    if description.get("others"):
        scans = tuple(scan_others(files, kept, budget, scan))
    else:
        scans = tuple(scan(f, kept, budget=budget) for f in files)
    if str(description.get("compression_mode") or "").lower() == "message":
        for one in scans:
            unpack_messages(one, budget)
    metadata, unread = run_metadata.found_metadata(scans, description, BAG_RECORD)
    warnings = unclear + [f"{s.path.name}: {problem}" for s in scans for problem in s.problems] + unread
    warnings += losses(description, scans)
    name = path.stem if path.is_file() else path.resolve().name
    return Recording(path, name, scans, metadata, tuple(warnings), budget)


def _channels(
    path: Path,
    topic: str,
    parts: list[RawTopic],
    warnings: list[str],
    budget: Budget,
    known: dict[Schema, FieldsOf],
) -> dict[str, Channel]:
    """Decode one topic; its channel in each file may carry another schema, but of one type."""
    result: dict[str, Channel] = {}
    types = sorted({full_name(p.schema.name) if p.schema else "" for p in parts if p.payloads})
    if len(types) != 1 or not types[0]:
        found = ", ".join(types) or "none"
        text = f"{path}: topic {topic}: expected one message type with a schema, found {found}"
        raise SchemaError(text, path=path, topic=topic, found=types)
    log_times: list[int] = []
    payloads: list[bytes] = []
    fields = None
    for part in parts:
        if not part.payloads or part.schema is None:
            continue
        if part.encoding != "cdr":
            text = f"{path}: topic {topic}: expected encoding cdr, found {part.encoding!r}"
            raise SchemaError(text, path=path, topic=topic, expected="cdr", found=part.encoding)
        try:
            if part.schema not in known:
                budget.take("definitions", len(part.schema.data), path)
                known[part.schema] = parse_schema(part.schema.name, part.schema.encoding, part.schema.data)
            parsed = known[part.schema]
        except SchemaError as error:
            raise SchemaError(f"{path}: topic {topic}: {error}", path=path, topic=topic) from error
        if fields is not None and parsed != fields:
            text = f"{path}: topic {topic}: two different definitions of {types[0]} in one run"
            raise SchemaError(text, path=path, topic=topic, found=types[0])
        fields = parsed
        log_times += part.log_times
        payloads += part.payloads
    assert fields is not None
    if max(log_times) >= 1 << 63:
        text = f"{path}: topic {topic}: expected log times below 2^63 ns, found {max(log_times)}"
        raise SchemaError(text, path=path, topic=topic, expected=1 << 63, found=max(log_times))
    logged = np.array(log_times, dtype=np.uint64).astype(np.int64)
    if np.any(logged[1:] < logged[:-1]):
        order = np.argsort(logged, kind="stable")
        logged, payloads = logged[order], [payloads[i] for i in order]
    try:
        columns = decode(fields, types[0], payloads, budget)
    except RunError as error:
        text = f"{path}: topic {topic} ({types[0]}): {error}"
        raise type(error)(
            text, path=path, topic=topic, position=error.position, expected=error.expected, found=error.found
        ) from error
    if types[0] in _SHARED:
        stamps = _of_many(columns, logged)
    else:
        stamps = _stamps(path, topic, columns, logged, warnings)
    if len(columns.frames) > 1:
        warnings.append(f"topic {topic}: several frame ids ({', '.join(sorted(columns.frames))}); none is kept")
    frame = next(iter(columns.frames)) if len(columns.frames) == 1 else ""
    if columns.left_out:
        warnings.append(f"topic {topic}: too long for channels, left out: {', '.join(sorted(columns.left_out))}")
    for field_path, values in columns.values.items():
        if not np.isnan(values).all():
            name = f"{topic}.{field_path}"
            unit = unit_of(types[0], field_path, topic)
            result[name] = Channel(name=name, stamps=stamps, values=values, unit=unit, frame=frame)
    return result


def _of_many(columns: Columns, logged: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the stamps of a topic of many nodes: log times, or, where those are of another clock, its own in order."""
    own = columns.header_stamps
    if own is None and _FIRST_TRANSFORM + ".sec" in columns.values:
        seconds, rest = (np.nan_to_num(columns.values[_FIRST_TRANSFORM + part]) for part in (".sec", ".nanosec"))
        own = seconds.astype(np.int64) * NANOSECONDS + rest.astype(np.int64)
    if own is None or not own.any() or abs(int(own[0]) - int(logged[0])) < APART:
        return logged
    return _in_order(columns, own)


def _in_order(columns: Columns, stamps: NDArray[np.int64]) -> NDArray[np.int64]:
    """Bring messages into the order of their stamps, and return these."""
    order = np.argsort(stamps, kind="stable")
    for path, values in columns.values.items():
        columns.values[path] = values[order]
    return stamps[order]


def _stamps(
    path: Path, topic: str, columns: Columns, logged: NDArray[np.int64], warnings: list[str]
) -> NDArray[np.int64]:
    stamps = columns.header_stamps
    if stamps is None:
        return logged
    if not stamps.any() and logged.any():
        warnings.append(f"topic {topic}: the header stamps were never filled in; log times are used")
        return logged
    late = np.maximum.accumulate(stamps) - stamps
    if 0 < late.max() <= _OVERTAKEN:
        told = f"{np.count_nonzero(late)} of {late.size} messages came up to {late.max() / 1e6:.3g} ms after later ones"
        warnings.append(f"topic {topic}: {told}: they are in the order of their stamps")
        return _in_order(columns, stamps)
    if late.any():
        i = int(np.argmax(late > 0))
        earlier, later = int(stamps[i - 1]), int(stamps[i])
        text = f"{path}: topic {topic}: stamps run backwards at message {i}: {earlier} ns, then {later} ns"
        raise StampOrderError(text, path=path, topic=topic, position=i, expected=earlier, found=later)
    return stamps
