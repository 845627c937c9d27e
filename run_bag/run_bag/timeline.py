"""A run as it is played: its messages in order of time, those of one instant together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .definitions import definitions, full_name, parse_schema
from .errors import EmptyRunError, InvalidRunError, SchemaError
from .mcap_content import RawTopic
from .reader import read_recording
from .rosbag2 import offers, type_hash
from .run_metadata import TOPIC, run_text
from .selection import Selection
from .stamps import has_header, header_stamp

NANOSECONDS = 1_000_000_000
CLOCK = "/clock"
Order = Literal["stamp", "log"]


class PlayedTopic(NamedTuple):
    """A topic that is played: name, message type, and the QoS profiles of those who published it."""

    name: str
    type: str
    offers: tuple[Mapping[str, Any], ...]


class Instant(NamedTuple):
    """All messages of one time [ns]: (index of the topic, payload), in order of topic, then of the file."""

    time: int
    messages: list[tuple[int, bytes]]


@dataclass(frozen=True, kw_only=True, eq=False)
class Timeline:
    """What is played.

    Attributes:
        topics: sorted by name.
        times: [ns], int64, non-decreasing, shape (N,).
        owners: index of each message's topic, shape (N,).
        payloads: N serialised messages.
        left_out: why a topic is not played, one sentence each.
        told: what was run, as `run_metadata.TOPIC` says it; "" where nothing does.
    """

    topics: tuple[PlayedTopic, ...]
    times: NDArray[np.int64]
    owners: NDArray[np.int64]
    payloads: list[bytes]
    left_out: tuple[str, ...]
    told: str = ""

    def instants(self) -> Iterator[Instant]:
        """Yield what happens, instant by instant."""
        edges = np.flatnonzero(np.diff(self.times)) + 1
        for first, last in zip([0, *edges.tolist()], [*edges.tolist(), len(self.times)], strict=True):
            owners = self.owners[first:last].tolist()
            yield Instant(int(self.times[first]), list(zip(owners, self.payloads[first:last], strict=True)))


def read_timeline(
    path: Path,
    wanted: Selection,
    *,
    order: Order = "log",
    start: float = 0.0,
    end: float | None = None,
) -> Timeline:
    """Read what is to be played; a recorded /clock is not, since a player has its own.

    Args:
        path: rosbag2 directory or .mcap file.
        wanted: topics.
        order: "log": by the time of recording; "stamp": by the stamp in the message, where it has a header that
            was filled in.
        start: first time that is played, from the first message on [s].
        end: last one [s]; None: all.

    Raises:
        NotARunError, TooLargeError: as read_run.
        InvalidRunError: `end` before `start`.
        EmptyRunError: nothing is left to be played.
    """
    if end is not None and end < start:
        raise InvalidRunError("play", [f"expected an end behind the start at {start:g} s, found {end:g} s"])
    recording = read_recording(path)
    left_out: list[str] = [*recording.warnings]
    topics: dict[str, PlayedTopic] = {}
    every: list[tuple[int, str, bytes]] = []
    for raw in [raw for one in recording.scans for raw in one.topics.values()]:
        if raw.topic == CLOCK or raw.topic not in wanted:
            continue
        try:
            topic, stamped = _topic(raw)
        except SchemaError as error:
            left_out.append(f"{raw.topic} is not played: {error}")
            continue
        times = raw.log_times
        if order == "stamp" and stamped:
            pairs = zip(raw.payloads, raw.log_times, strict=True)
            times = [header_stamp(payload) or logged for payload, logged in pairs]
        if topics.setdefault(raw.topic, topic).type != topic.type:
            left_out.append(f"{raw.topic}: its messages of type {topic.type} are not played, others before are")
            continue
        every += [(time, raw.topic, payload) for time, payload in zip(times, raw.payloads, strict=True)]
    if not every:
        text = "; ".join([f"{path}: nothing to play", *left_out])
        raise EmptyRunError(text, path=path, found=0)
    every.sort(key=lambda e: e[:2])  # stable: messages of one topic and time stay in the order of the file
    index = {name: i for i, name in enumerate(sorted(topics))}
    stamps = np.array([e[0] for e in every], dtype=np.int64)
    first = stamps[0] + round(start * NANOSECONDS)
    last = stamps[-1] if end is None else stamps[0] + round(end * NANOSECONDS)
    begin, stop = np.searchsorted(stamps, first), np.searchsorted(stamps, last, side="right")
    if begin >= stop:
        length = (stamps[-1] - stamps[0]) / NANOSECONDS
        raise EmptyRunError(f"{path}: nothing to play from {start:g} s on; it has {length:.3f} s", path=path, found=0)
    return Timeline(
        topics=tuple(topics[name] for name in index),
        times=stamps[begin:stop],
        owners=np.array([index[e[1]] for e in every[begin:stop]], dtype=np.int64),
        payloads=[e[2] for e in every[begin:stop]],
        left_out=tuple(left_out),
        told=run_text(recording.metadata) if recording.metadata and TOPIC in wanted else "",
    )


def _topic(raw: RawTopic) -> tuple[PlayedTopic, bool]:
    """Return a topic of the file, and whether its messages begin with a header.

    Raises:
        SchemaError: its type is unknown here or was another when the run was recorded.
    """
    if raw.schema is None or raw.encoding != "cdr":
        raise SchemaError(f"expected messages in cdr with a definition, found encoding {raw.encoding!r}")
    name = full_name(raw.schema.name)
    recorded, here = type_hash(raw.extra), definitions().type_hash(name)
    if recorded and recorded != here:
        text = f"{name} is defined otherwise here than where it was recorded ({here}, {recorded})"
        raise SchemaError(text, expected=here, found=recorded)
    fields = parse_schema(name, raw.schema.encoding, raw.schema.data)
    return PlayedTopic(raw.topic, name, offers(raw.extra)), has_header(fields, name)
