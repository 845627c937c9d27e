"""A recording under way: an MCAP file without chunks, so that a process killed at any moment loses next to nothing.

Each message is a record of its own and reaches the operating system at the next `flush`, from where a killed
process cannot take it back. The file has its final name from the start, and the reader takes it as it is;
`finishing.finish` turns it into a bag that stock rosbag2 reads.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from mcap.writer import Writer

from .errors import CannotWriteError, RunExistsError
from .rosbag2 import LIBRARY, TopicRecord, TopicRegistry, write_run_record

BUFFER_BYTES = 1 << 20
SEQUENCES = 1 << 32
"""Sequence numbers in the file have 32 bits."""
FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}


def open_buffered(path: Path) -> BinaryIO:
    """Open a new file for writing."""
    return path.open("xb", buffering=BUFFER_BYTES)


def free_bytes(path: Path) -> int:
    """Return the space left on the disk that holds a path, which need not exist yet."""
    there = next(p for p in (path.absolute(), *path.absolute().parents) if p.exists())
    return shutil.disk_usage(there).free


class Journal:
    """The file of a recording under way."""

    def __init__(
        self, directory: Path, metadata: Mapping[str, Any], open_file: Callable[[Path], BinaryIO] = open_buffered
    ) -> None:
        """Make the directory, which must not exist, and begin the file in it.

        Args:
            directory: the run to be.
            metadata: what is run; JSON without NaN.
            open_file: opens the file.

        Raises:
            RunExistsError: there is something at the directory's place; nothing is overwritten.
            CannotWriteError: the file system refuses.
        """
        self.directory = directory
        self.path = directory / f"{directory.resolve().name}_0.mcap"
        self.messages = 0
        self.failed = False
        self._clean = True
        with self._named():
            try:
                directory.mkdir(parents=True)
            except FileExistsError as error:
                raise RunExistsError(f"{directory} exists; nothing is overwritten", path=directory) from error
            self._file = open_file(self.path)
            self._writer = Writer(self._file, use_chunking=False)
            self._writer.start(profile="ros2", library=LIBRARY)
            self._registry = TopicRegistry(self._writer)
        self.describe(metadata)

    @property
    def size(self) -> int:
        """Bytes recorded, those not yet flushed included."""
        return self._file.tell() if not self._file.closed else self.path.stat().st_size

    def describe(self, metadata: Mapping[str, Any]) -> None:
        """Store what is run, in place of what was stored before, and flush it."""
        with self._named():
            write_run_record(self._writer, metadata)
        self._clean = False
        self.flush()

    def add_topic(self, topic: TopicRecord) -> int:
        """Begin a topic and return the number of its channel.

        Raises:
            SchemaError: its type is unknown here.
            CannotWriteError: the file system refuses.
        """
        with self._named():
            return self._registry.add(topic)

    def add(self, channel: int, payload: bytes, *, log_time: int, publish_time: int, sequence: int = 0) -> None:
        """Record a message; times in ns.

        Raises:
            CannotWriteError: the file system refuses.
        """
        try:
            self._writer.add_message(channel, log_time, payload, publish_time, sequence % SEQUENCES)
        except OSError as error:
            raise self._failure(error) from error
        self.messages += 1
        self._clean = False

    def flush(self) -> None:
        """Hand everything to the operating system; to be called every 0.1 s or more often.

        Raises:
            CannotWriteError: the file system refuses.
        """
        if not self._clean:
            with self._named():
                self._file.flush()
            self._clean = True

    def close(self) -> None:
        """End the file; after a failure, leave it as far as it got.

        Raises:
            CannotWriteError: the file system refuses.
        """
        if self._file.closed:
            return
        if self.failed:
            with contextlib.suppress(OSError):  # was reported; closing tries to write the rest again
                self._file.close()
            return
        with self._named():
            self._writer.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()

    @contextlib.contextmanager
    def _named(self) -> Iterator[None]:
        """Turn a refusal of the file system into one of ours."""
        try:
            yield
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> CannotWriteError:
        self.failed = True
        why = "no space is left" if error.errno in FULL else error.strerror or str(error)
        kept = f"the run is readable up to there ({self.messages} messages taken, the last ones not written)"
        return CannotWriteError(f"{self.path}: recording stopped: {why}; {kept}", path=self.path, found=error.errno)
