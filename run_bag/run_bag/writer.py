"""Write a run as a rosbag2 directory: MCAP, chunked, zstd, indexed; stock `ros2 bag info|play` reads it."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import CompressionType, Writer

from safe_files.whole_files_io import new_folder

from .errors import CannotWriteError, InvalidRunError, RunError, RunExistsError
from .rosbag2 import (
    LATCHED_QOS,
    LIBRARY,
    TopicRecord,
    TopicRegistry,
    bag_metadata,
    write_bag_record,
    write_metadata_yaml,
    write_run_record,
)
from .run_metadata import TOPIC, TYPE, run_text
from .topic import Columns, Topic, check_topic

BLOCK = 20_000
"""Messages serialised at once; bounds the memory of long runs."""


def write_run(directory: Path | str, topics: Iterable[Topic], metadata: Mapping[str, Any] | None = None) -> Path:
    """Write a run.

    The messages of all topics are interleaved by stamp, which is log time, publish time and header stamp in
    one. Everything is written to a temporary directory beside the target, which then gets its name.

    Args:
        directory: the bag to make; its parent is made if missing.
        topics: what to write; one or more, with different names.
        metadata: what was run or reconstructed; JSON without NaN. It comes back as `Run.metadata`.

    Returns:
        The directory.

    Raises:
        RunExistsError: the target exists. Nothing is overwritten.
        InvalidRunError: all that is wrong with the topics or the metadata.
        SchemaError: a message type is unknown.
        CannotWriteError: the file system refuses.
    """
    target = Path(directory)
    refuse_existing(target)
    columns = _check(list(topics), metadata or {}, target)
    try:
        with new_folder(target) as folder:
            _write_bag(folder, f"{target.name}_0.mcap", columns, metadata or {})
            refuse_existing(target)
    except OSError as error:
        raise CannotWriteError(str(error), path=target) from error
    return target


def refuse_existing(target: Path) -> None:
    """Raise RunExistsError if there is anything at the target."""
    if os.path.lexists(target):
        raise RunExistsError(f"{target} exists; nothing is overwritten", path=target)


def _check(topics: list[Topic], metadata: Mapping[str, Any], target: Path) -> list[Columns]:
    problems: list[str] = []
    columns = []
    for topic in topics:
        try:
            columns.append(check_topic(topic))
        except InvalidRunError as error:
            problems.append(str(error))
    if not topics:
        problems.append("expected at least one topic, found none")
    repeated = [name for name, n in Counter(c.name for c in columns).items() if n > 1]
    problems += [f"topic {name!r} is given more than once" for name in repeated]
    try:
        json.dumps(metadata, allow_nan=False)
    except (TypeError, ValueError) as error:
        problems.append(f"metadata is no JSON: {error}")
    if problems:
        raise InvalidRunError(f"{target}: cannot be written", problems, path=target)
    return columns


def _write_bag(folder: Path, file_name: str, columns: list[Columns], metadata: Mapping[str, Any]) -> None:
    records = [TopicRecord(name=c.name, type=c.type) for c in columns]
    start = min(int(c.stamps[0]) for c in columns)
    end = max(int(c.stamps[-1]) for c in columns)
    told = run_text(metadata) if metadata else ""
    if told and TOPIC not in [c.name for c in columns]:
        message = Topic(name=TOPIC, type=TYPE, stamps=np.array([start]), fields={"data": told})
        columns = [check_topic(message), *columns]
        records = [TopicRecord(name=TOPIC, type=TYPE, qos=(LATCHED_QOS,)), *records]
    listed = [(r, len(c)) for r, c in zip(records, columns, strict=True)]
    bag = bag_metadata(file_name, start, end, listed, told)
    with (folder / file_name).open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library=LIBRARY)
        write_run_record(writer, metadata)
        registry = TopicRegistry(writer)
        channels = [registry.add(r) for r in records]
        _write_messages(writer, columns, channels)
        write_bag_record(writer, bag)
        writer.finish()
        file.flush()
        os.fsync(file.fileno())
    write_metadata_yaml(folder, bag)


def _write_messages(writer: Writer, columns: list[Columns], channels: list[int]) -> None:
    stamps = np.concatenate([c.stamps for c in columns])
    owner = np.repeat(np.arange(len(columns)), [len(c) for c in columns])
    order = np.argsort(stamps, kind="stable")
    done = [0] * len(columns)
    for begin in range(0, len(order), BLOCK):
        block = order[begin : begin + BLOCK]
        owners = owner[block]
        counts = np.bincount(owners, minlength=len(columns))
        queues = [c.payloads(d, d + int(n)) for c, d, n in zip(columns, done, counts, strict=True)]
        done = [d + int(n) for d, n in zip(done, counts, strict=True)]
        for i, stamp in zip(owners.tolist(), stamps[block].tolist(), strict=True):
            writer.add_message(channels[i], stamp, next(queues[i]), stamp)


__all__ = ["RunError", "Topic", "refuse_existing", "write_run"]
