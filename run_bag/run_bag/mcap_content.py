"""What a scan of an MCAP file finds: topics with their raw messages, metadata, damage."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple


@dataclass(frozen=True)
class Schema:
    """A message definition in the file."""

    name: str
    encoding: str
    data: bytes


class RawMessage(NamedTuple):
    """A message as it lies in the file; times in ns."""

    channel: int
    sequence: int
    log_time: int
    publish_time: int
    payload: bytes


@dataclass
class RawTopic:
    """A channel of the file with its messages, in the order of the file."""

    topic: str
    encoding: str
    schema: Schema | None
    extra: dict[str, str]
    log_times: list[int] = field(default_factory=list)
    payloads: list[bytes] = field(default_factory=list)
    count: int = 0


@dataclass
class Scan:
    """Everything found in one file.

    Attributes:
        path: the file.
        size: its size in bytes.
        topics: channel id -> channel; payloads only of the wanted topics, `count` of all.
        metadata: MCAP metadata records by name.
        complete: the end mark of the data was reached.
        end: offset behind the last byte that could be read.
        last_log_time: latest log time of any message [ns], None without messages; first_log_time likewise.
        damaged: something in the file makes no sense; false where its end alone is missing.
        holes: first and last log time [ns] of what was left out between messages that were read.
        problems: damage, one sentence each.
        told: messages that say what was run (`run_metadata.TOPIC`); they are among no topic's.
    """

    path: Path
    size: int
    topics: dict[int, RawTopic] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    complete: bool = False
    end: int = 0
    last_log_time: int | None = None
    first_log_time: int | None = None
    damaged: bool = False
    holes: list[tuple[int, int]] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    told: list[bytes] = field(default_factory=list)

    @property
    def message_count(self) -> int:
        """Messages found, those of unwanted topics included."""
        return sum(t.count for t in self.topics.values())
