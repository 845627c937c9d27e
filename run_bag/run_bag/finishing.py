"""Turn a journal, or a recording that was cut off, into a bag that stock rosbag2 reads: chunks, zstd, indexes,
metadata.yaml. Messages are copied as they are, one file at a time, and never held in memory."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from safe_files.whole_files_io import new_folder

from .bag_folder import bag_files, losses
from .errors import CannotWriteError, RunError
from .mcap_content import RawMessage, RawTopic, Scan
from .mcap_scan import scan
from .rosbag2 import (
    BAG_RECORD,
    LATCHED_QOS,
    LIBRARY,
    TopicRecord,
    TopicRegistry,
    bag_metadata,
    offers,
    type_hash,
    write_bag_record,
    write_metadata_yaml,
)
from .run_metadata import RUN_RECORD, TOPIC, TYPE, found_metadata, run_text
from .topic import Topic, check_topic
from .writer import refuse_existing

METADATA_FILE = "metadata.yaml"


@dataclass(frozen=True, kw_only=True)
class Finished:
    """A bag that is whole now.

    Attributes:
        directory: where it is.
        messages: how many it has.
        warnings: what could not be read, one sentence each.
        untouched: it was whole before.
    """

    directory: Path
    messages: int
    warnings: tuple[str, ...] = ()
    untouched: bool = False


def finish(directory: Path) -> Finished:
    """Finish a run in place; it keeps its name, and the old file is there until the new one is whole.

    Only a run of one file whose end alone is missing is changed in place. What is damaged in its midst, or has
    several files, is evidence: `recover` makes a new run of it.

    Raises:
        NotARunError, TooLargeError: as read_run.
        RunError: it is not to be changed in place.
        CannotWriteError: the file system refuses, for example for want of space; the old file is still there.
    """
    files, description, warnings = bag_files(directory)
    scans = tuple(scan(file, lambda topic: False) for file in files)
    warnings += [f"{s.path.name}: {problem}" for s in scans for problem in s.problems]
    warnings += losses(description, scans)
    messages = sum(s.message_count for s in scans)
    if (directory / METADATA_FILE).exists() and not warnings:
        return Finished(directory=directory, messages=messages, untouched=True)
    if not directory.is_dir() or len(files) != 1 or scans[0].damaged:
        why = "; ".join(warnings) or f"it has {len(files)} files"
        what = f"{directory}: not a recording whose end alone is missing ({why})"
        raise RunError(f"{what}; `recover --out NEW` copies what is left", path=directory)
    part = directory / f".{files[0].name}.{secrets.token_hex(8)}.part"
    try:
        bag = _copy(scans, description, part, files[0].name)
        part.replace(files[0])
        write_metadata_yaml(directory, bag)
    except OSError as error:
        text = f"{directory}: cannot be finished: {error.strerror or error}; the recording is left as it was"
        raise CannotWriteError(text, path=directory, found=error.errno) from error
    finally:
        part.unlink(missing_ok=True)  # gone already where all went well
    return Finished(directory=directory, messages=messages, warnings=tuple(warnings))


Alter = Callable[[str, bytes], bytes]


def recover(path: Path, target: Path, alter: Alter | None = None, about: Mapping[str, Any] | None = None) -> Finished:
    """Copy all that can be read of a run or .mcap file to a new run; the old one is not touched.

    Args:
        path: of the old run.
        target: the new one.
        alter: makes of each message (topic, content), in the order of the file, what is written in its place.
        about: what is added to the run's metadata.

    Raises:
        RunExistsError: the target exists. Nothing is overwritten.
        NotARunError, TooLargeError: as read_run.
        CannotWriteError: the file system refuses.
    """
    refuse_existing(target)
    files, description, warnings = bag_files(path)
    scans = tuple(scan(file, lambda topic: False) for file in files)
    warnings += [f"{s.path.name}: {problem}" for s in scans for problem in s.problems] + losses(description, scans)
    messages = sum(s.message_count for s in scans)
    try:
        with new_folder(target) as folder:
            name = f"{target.name}_0.mcap"
            bag = _copy(scans, description, folder / name, name, alter, about)
            write_metadata_yaml(folder, bag)
            refuse_existing(target)
    except OSError as error:
        raise CannotWriteError(str(error), path=target, found=error.errno) from error
    return Finished(directory=target, messages=messages, warnings=tuple(warnings))


@dataclass
class _Copy:
    """Writes the messages of one file after the other, each topic and schema once."""

    writer: Writer
    records: dict[int, TopicRecord] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    first: int | None = None
    last: int = 0
    alter: Alter | None = None
    _channels: dict[tuple[str, str, bytes], int] = field(default_factory=dict)
    _schemas: dict[tuple[str, str, bytes], int] = field(default_factory=dict)

    def topic(self, raw: RawTopic) -> int:
        """Register a topic, or find it, and return its channel."""
        name, encoding, data = ("", "", b"") if raw.schema is None else (*_parts(raw),)
        key = (raw.topic, name, data)
        if key not in self._channels:
            if name and (name, encoding, data) not in self._schemas:
                self._schemas[name, encoding, data] = self.writer.register_schema(name, encoding, data)
            schema = self._schemas.get((name, encoding, data), 0)
            record = TopicRecord(name=raw.topic, type=name, qos=offers(raw.extra), type_hash=type_hash(raw.extra))
            channel = self.writer.register_channel(raw.topic, raw.encoding, schema, dict(raw.extra))
            self._channels[key], self.records[channel], self.counts[channel] = channel, record, 0
        return self._channels[key]

    def tell(self, text: str, stamp: int) -> None:
        """Write what was run as a message, before all others."""
        message = next(check_topic(Topic(name=TOPIC, type=TYPE, stamps=[stamp], fields={"data": text})).payloads(0, 1))
        record = TopicRecord(name=TOPIC, type=TYPE, qos=(LATCHED_QOS,))
        channel = TopicRegistry(self.writer).add(record)
        self.writer.add_message(channel, stamp, message, stamp)
        self.records[channel], self.counts[channel] = record, 1
        self.first = self.last = stamp

    def file(self, one: Scan) -> None:
        """Copy the messages of a file."""
        numbers = {number: self.topic(raw) for number, raw in one.topics.items()}

        def write(message: RawMessage, raw: RawTopic) -> None:
            channel = numbers.get(message.channel)
            if channel is None:
                channel = numbers[message.channel] = self.topic(raw)
            payload = message.payload if self.alter is None else self.alter(raw.topic, message.payload)
            try:
                self.writer.add_message(channel, message.log_time, payload, message.publish_time, message.sequence)
            except OSError as error:  # of the copy, not of the file that is read
                text = f"cannot be written: {error.strerror or error}"
                raise CannotWriteError(text, found=error.errno) from error
            self.counts[channel] += 1
            self.first = message.log_time if self.first is None else min(self.first, message.log_time)
            self.last = max(self.last, message.log_time)

        scan(one.path, receive=write)


def _copy(
    scans: tuple[Scan, ...],
    description: Mapping[str, Any],
    target: Path,
    file_name: str,
    alter: Alter | None = None,
    about: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Write everything that was found to one indexed file; return its description for metadata.yaml."""
    with target.open("xb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library=LIBRARY)
        records = _metadata(scans, description, about or {})
        told = records.get(RUN_RECORD, {}).get("json", "")
        for name, content in records.items():
            writer.add_metadata(name, dict(content))
        copy = _Copy(writer, alter=alter)
        if told and any(one.message_count for one in scans):
            copy.tell(told, min((one.first_log_time for one in scans if one.first_log_time is not None), default=0))
        try:
            for one in scans:
                copy.file(one)
        except CannotWriteError as error:
            raise OSError(error.found, os.strerror(int(str(error.found)))) from error
        listed = [(record, copy.counts[channel]) for channel, record in copy.records.items()]
        bag = bag_metadata(file_name, copy.first or 0, copy.last, listed, told)
        write_bag_record(writer, bag)
        writer.finish()
        file.flush()
        os.fsync(file.fileno())
    return bag


def _metadata(
    scans: tuple[Scan, ...], description: Mapping[str, Any], about: Mapping[str, Any]
) -> dict[str, Mapping[str, str]]:
    found: dict[str, Mapping[str, str]] = {name: text for one in scans for name, text in one.metadata.items()}
    found.pop(BAG_RECORD, None)  # described the old file
    told = {**found_metadata(scans, description, BAG_RECORD)[0], **about}
    told.pop("mcap", None)
    if told:
        found[RUN_RECORD] = {"json": run_text(told)}
    return found


def _parts(raw: RawTopic) -> tuple[str, str, bytes]:
    assert raw.schema is not None
    return raw.schema.name, raw.schema.encoding, raw.schema.data
