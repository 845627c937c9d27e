"""A bag as a source: rosbag2 of any storage, MCAP, ROS 1; a field is called topic.field."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..definitions import full_name, parse_schema
from ..errors import EmptyRunError, RecordingError
from ..reader import read_recording, read_run
from ..run import Channel
from ..stamps import has_header
from .csv_source import indices
from .recording_map import Mapped
from .sources import Array, Series


def without_marks(values: Array, nan: Iterable[str]) -> Array:
    """Return values with NaN where they equal one of the numbers that mean "not measured"."""
    for mark in nan:
        try:
            values = np.where(values == float(mark), np.nan, values)
        except ValueError:
            continue  # a text is no mark among numbers
    return values


class BagSource:
    """A bag in memory.

    Args:
        path: rosbag2 directory, .mcap, .db3 or .bag.
        topics: those to be decoded; None: all.

    Raises:
        RunError: as `read_run`.
    """

    def __init__(self, path: Path, topics: set[str] | None = None) -> None:
        self.path = path
        self.channels: dict[str, Channel] = {}
        raws = [raw for scan in read_recording(path, set()).scans for raw in scan.topics.values()]
        self.types = {raw.topic.strip("/"): full_name(raw.schema.name) for raw in raws if raw.schema}
        self._schemas = {raw.topic.strip("/"): raw.schema for raw in raws}
        present = {raw.topic.strip("/") for raw in raws}
        self.listed = sorted(present)
        wanted = None if topics is None else topics & present
        self.warnings: tuple[str, ...] = ()
        if wanted is None or wanted:
            try:
                run = read_run(path, wanted)
            except EmptyRunError:
                if wanted is None:
                    raise
            else:
                self.channels, self.warnings = dict(run.channels), run.warnings

    def stamped(self, topic: str) -> bool:
        """Tell whether messages of a topic say when they were made; else the recorder's times are theirs."""
        schema = self._schemas[topic]
        if schema is None:
            return False
        return has_header(parse_schema(schema.name, schema.encoding, schema.data), full_name(schema.name))

    def names(self) -> list[str]:
        """Return the channels, and the topics that were not decoded."""
        decoded = {name.partition(".")[0] for name in self.channels}
        return [*self.channels, *(topic for topic in self.listed if topic not in decoded)]

    def unit(self, name: str) -> str:
        """Return the unit of a channel of a type that is known, else ""."""
        return self.channels[name].unit if name in self.channels else ""

    def has(self, entry: Mapped) -> bool:
        """Tell whether the bag has the entry's field, measured at least once."""
        return entry.is_field and str(entry.column).lstrip("/") in self.channels

    def series(self, entry: Mapped) -> Series:
        """Return a channel's samples."""
        channel = self.channels[str(entry.column).lstrip("/")]
        origin = int(channel.stamps[0])
        values = without_marks(channel.values, entry.nan)
        return Series(origin=origin, stamps=channel.stamps - origin, values=values, rows=indices(values))

    def refusal(self, entry: Mapped, row: int, expected: str) -> RecordingError:
        """Return the error about one message."""
        found = self.channels[str(entry.column).lstrip("/")].values[row]
        text = f"{self.path}: {entry.column}, message {row}: expected {expected}, found {found:g}"
        return RecordingError(text, path=self.path, position=row, expected=expected, found=float(found))
