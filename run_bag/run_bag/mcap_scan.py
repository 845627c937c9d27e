"""Read the records of an MCAP file in one pass, whole or cut off anywhere.

The file is walked from its start and needs neither footer nor index, so a recording that was killed is read
the same way as a finished one: up to the last whole message, also inside a compressed chunk as far as it can
be decompressed. A record that is whole but makes no sense is left out, and the next one is read. Only the
channels of a chunk that was left out are looked up in the summary behind the data, which repeats them. Sizes
in the file are never trusted beyond the caps below.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import zstandard

from .budget import OVERHEAD, Budget
from .errors import NotARunError, TooLargeError
from .mcap_content import RawMessage, RawTopic, Scan, Schema
from .mcap_fields import decompress, mapping, prefixed, string
from .run_metadata import TOPIC, TYPES

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 1, 2, 3, 4, 5, 6
METADATA, DATA_END, LAST_OPCODE, FIRST_PRIVATE = 12, 15, 15, 0x80
MAX_CHUNK_BYTES = 256 << 20
MAX_RECORD_BYTES = 64 << 20
MAX_CHANNELS = 10_000
MAX_PROBLEMS = 20

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<QQQI")
_FOOTER = struct.Struct("<QQI")


class _Cut(Exception):
    """The bytes end before the record does, or make no sense from here on."""


class _End(_Cut):
    """The file ends inside a record of its own: what was never written is missing, and nothing else."""


def scan(
    path: Path,
    wanted: Callable[[str], bool] = lambda topic: True,
    receive: Callable[[RawMessage, RawTopic], None] | None = None,
    budget: Budget | None = None,
) -> Scan:
    """Scan one MCAP file.

    Args:
        path: the file.
        wanted: says of each topic (as in the file) whether its payloads are kept.
        receive: takes each wanted message, with its topic, in place of keeping it: memory stays small.
        budget: what the whole recording may cost; None: this file is all of it.

    Returns:
        What was found; a cut or damaged file is described in `problems`, not raised.

    Raises:
        NotARunError: the file cannot be opened or is no MCAP file.
        TooLargeError: a record or chunk beyond the caps, or more than the budget.
    """
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(0)
            head = file.read(len(MAGIC))
            if head != MAGIC:
                found = head.hex(" ") if head else "an empty file"
                text = f"{path}: expected an MCAP file, which starts with {MAGIC.hex(' ')}, found {found}"
                text += "; a table, another bag or a log is imported first: thruster import"
                raise NotARunError(text, path=path, position=0, expected=MAGIC, found=head)
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                return _Scanner(Scan(path, size), data, wanted, receive, budget or Budget(size)).run()
    except OSError as error:
        raise NotARunError(f"{path}: cannot be read: {error.strerror or error}", path=path) from error


class _Scanner:
    def __init__(
        self,
        result: Scan,
        data: mmap.mmap,
        wanted: Callable[[str], bool],
        receive: Callable[[RawMessage, RawTopic], None] | None,
        budget: Budget,
    ) -> None:
        self.result, self.data, self.wanted, self.receive = result, data, wanted, receive
        self.budget = budget
        self.wanted_ids: set[int] = set()
        self.telling: set[int] = set()  # channels on which a message says what was run
        self.schemas: dict[int, Schema] = {}
        self.asked_summary = False
        self.left_out = 0
        self.orphans: list[int] = []  # log times of messages whose channel is unknown

    def run(self) -> Scan:
        try:
            self.result.end = len(MAGIC)
            self.records(self.data, len(MAGIC), top=True)
            if not self.result.complete:
                self.result.problems.append(f"no end mark: cut off at byte {self.result.size}, behind a whole record")
        except _Cut as cut:
            self.result.damaged |= not isinstance(cut, _End)
            lost = self.result.size - self.result.end
            self.result.problems.append(f"{cut}; the last {lost} of {self.result.size} bytes could not be read")
        if self.left_out > MAX_PROBLEMS:
            self.result.problems.append(f"{self.left_out - MAX_PROBLEMS} more damaged records were left out")
        if self.orphans:
            self.result.damaged = True
            text = f"{len(self.orphans)} messages of channels that the file does not describe were left out"
            self.result.problems.append(text)
            self.result.holes.append((min(self.orphans), max(self.orphans)))
        return self.result

    def leave_out(self, data: mmap.mmap | bytes, end: int, problem: str) -> None:
        """Note damage and go on behind the record, if what follows at `end` looks like one; else stop."""
        if not _in_step(data, end):
            raise _Cut(problem)
        self.left_out += 1
        self.result.damaged = True
        if self.left_out <= MAX_PROBLEMS:
            self.result.problems.append(f"{problem}; left out")

    def records(self, data: mmap.mmap | bytes, position: int, *, top: bool) -> None:
        """Walk records; `top` is the file itself, else the inside of a chunk."""
        size, unpack, unpack_message = len(data), _RECORD.unpack_from, _MESSAGE.unpack_from
        topics, wanted, result = self.result.topics, self.wanted_ids, self.result
        messages, memory = self.budget.left("messages"), self.budget.left("memory")
        counted, kept = 0, 0
        earliest = 1 << 64
        latest = -1 if result.last_log_time is None else result.last_log_time
        try:
            while position < size:
                if position + 9 > size:
                    raise (_End if top else _Cut)(f"cut off at byte {position} inside the head of a record")
                opcode, length = unpack(data, position)
                begin, end = position + 9, position + 9 + length
                if end > size:
                    self.refuse_nonsense(opcode, length, position)
                    if top and opcode == CHUNK:
                        self.chunk(data[begin:size], position, cut=True)
                    raise (_End if top else _Cut)(f"cut off inside the record at byte {position}")
                if opcode == MESSAGE:
                    if length < 22:
                        self.leave_out(data, end, f"damaged: a message of {length} bytes at byte {position}")
                        position = end
                        continue
                    _, _, channel, sequence, log_time, publish_time = unpack_message(data, position)
                    counted += 1
                    if counted > messages or kept > memory:
                        break
                    if channel in self.telling:
                        kept += length
                        result.told.append(data[begin + 22 : end])
                        position = end
                        if top:
                            result.end = end
                        continue
                    if channel not in topics:
                        self.summary()
                    if channel in topics:
                        topic = topics[channel]
                        topic.count += 1
                        if log_time < earliest:
                            earliest = log_time
                        if log_time > latest:
                            latest = log_time
                        if channel not in wanted:
                            pass
                        elif self.receive is not None:
                            payload = data[begin + 22 : end]
                            self.receive(RawMessage(channel, sequence, log_time, publish_time, payload), topic)
                        else:
                            kept += length + OVERHEAD
                            topic.log_times.append(log_time)
                            topic.payloads.append(data[begin + 22 : end])
                    elif _in_step(data, end):
                        self.orphans.append(log_time)
                    else:
                        raise _Cut(f"damaged: message of unknown channel {channel} at byte {position}")
                elif opcode == DATA_END and top:
                    result.complete, result.end = True, end
                    return
                else:
                    self.refuse_nonsense(opcode, length, position)
                    if opcode in (SCHEMA, CHANNEL, METADATA, CHUNK):
                        try:
                            self.other(opcode, data[begin:end], position, top=top)
                        except _Cut as damage:
                            self.leave_out(data, end, str(damage))
                        if opcode == CHUNK:
                            messages, memory = self.budget.left("messages"), self.budget.left("memory")
                position = end
                if top:
                    result.end = end
        finally:
            if latest >= 0:
                result.last_log_time = max(latest, result.last_log_time or 0)
            if earliest < 1 << 64:
                before = result.first_log_time
                result.first_log_time = earliest if before is None else min(earliest, before)
            self.budget.take("messages", counted, result.path)
            self.budget.take("memory", kept, result.path)

    def refuse_nonsense(self, opcode: int, length: int, position: int) -> None:
        if opcode == 0:
            raise _Cut(f"damaged: a record of kind 0 at byte {position}")
        cap = MAX_CHUNK_BYTES if opcode == CHUNK else MAX_RECORD_BYTES
        if length > cap and opcode <= LAST_OPCODE and length <= self.result.size:
            text = f"{self.result.path}: a record of {length} bytes at byte {position}, at most {cap} are read"
            raise TooLargeError(text, path=self.result.path, position=position, expected=cap, found=length)

    def other(self, opcode: int, body: bytes, position: int, *, top: bool) -> None:
        if opcode == CHUNK:
            if not top:
                raise _Cut(f"damaged: a chunk inside a chunk at byte {position}")
            self.chunk(body, position, cut=False)
            return
        self.budget.take("records", 1, self.result.path)
        self.budget.take("memory", len(body), self.result.path)
        try:
            if opcode == SCHEMA:
                name, rest = string(body[2:])
                encoding, rest = string(rest)
                self.schemas[int.from_bytes(body[:2], "little")] = Schema(name, encoding, prefixed(rest)[0])
            elif opcode == CHANNEL:
                self.channel(body, position)
            elif opcode == METADATA:
                name, rest = string(body)
                self.result.metadata[name] = mapping(rest)
        except (UnicodeDecodeError, ValueError) as error:
            raise _Cut(f"damaged: the record of kind {opcode} at byte {position}: {error}") from error

    def channel(self, body: bytes, position: int) -> None:
        number, schema = int.from_bytes(body[:2], "little"), int.from_bytes(body[2:4], "little")
        topic, rest = string(body[4:])
        encoding, rest = string(rest)
        if number in self.result.topics:
            return
        if schema and schema not in self.schemas:
            self.summary()
        if len(self.result.topics) >= MAX_CHANNELS:
            text = f"{self.result.path}: more than {MAX_CHANNELS} channels at byte {position}"
            raise TooLargeError(text, path=self.result.path, position=position, expected=MAX_CHANNELS)
        definition = self.schemas.get(schema)
        if topic == TOPIC and definition is not None and definition.name in TYPES:
            self.telling.add(number)
            return
        self.result.topics[number] = RawTopic(topic, encoding, definition, mapping(rest))
        if self.wanted(topic):
            self.wanted_ids.add(number)

    def summary(self) -> None:
        """Take the schemas and channels that the summary behind the data repeats, once; a cut file has none."""
        data, size = self.data, self.result.size
        footer = size - len(MAGIC) - _FOOTER.size - _RECORD.size
        if self.asked_summary or footer < len(MAGIC) or data[size - len(MAGIC) : size] != MAGIC:
            return
        self.asked_summary = True
        position = int(_FOOTER.unpack_from(data, footer + _RECORD.size)[0])
        while len(MAGIC) <= position < footer:
            opcode, length = _RECORD.unpack_from(data, position)
            begin, end = position + _RECORD.size, position + _RECORD.size + length
            if end > footer:
                return
            if opcode in (SCHEMA, CHANNEL):
                try:
                    self.other(opcode, data[begin:end], position, top=True)
                except _Cut:
                    return
            position = end

    def chunk(self, body: bytes, position: int, *, cut: bool) -> None:
        if len(body) < _CHUNK.size + 4:
            raise _Cut(f"cut off inside the chunk at byte {position}")
        first, last, size, crc = _CHUNK.unpack_from(body)
        if size > MAX_CHUNK_BYTES:
            where = f"{self.result.path}: a chunk of {size} bytes at byte {position}"
            text = f"{where}, at most {MAX_CHUNK_BYTES} are read"
            raise TooLargeError(text, path=self.result.path, position=position, expected=MAX_CHUNK_BYTES, found=size)
        self.budget.content(size, self.result.path)
        where = f"the chunk at byte {position} (log times {first / 1e9:.3f} s to {last / 1e9:.3f} s)"
        try:
            compression, rest = string(body[_CHUNK.size :])
            data = decompress(compression, rest[8:], size)
            if not cut and len(data) != size:
                raise ValueError(f"expected {size} bytes, found {len(data)}")
            if not cut and crc and zlib.crc32(data) != crc:
                raise ValueError("its checksum is wrong")
        except (UnicodeDecodeError, ValueError, RuntimeError, zstandard.ZstdError) as error:
            if not cut:
                self.result.holes.append((first, last))
            raise _Cut(f"{where} is damaged: {error}") from error
        try:
            self.records(data, 0, top=False)
        except _Cut as inner:
            if not cut:
                self.result.holes.append((max(first, self.result.last_log_time or 0), last))
            raise _Cut(f"inside {where}: {inner}") from inner


def _in_step(data: mmap.mmap | bytes, position: int) -> bool:
    """Say whether a record that fits, or nothing, begins here."""
    if position == len(data):
        return True
    if position + _RECORD.size > len(data):
        return False
    opcode, length = _RECORD.unpack_from(data, position)
    return (0 < opcode <= LAST_OPCODE or opcode >= FIRST_PRIVATE) and position + _RECORD.size + length <= len(data)
