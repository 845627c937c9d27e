"""Read the records of an MCAP file in one pass, whole or cut off anywhere.

The file is walked from its start and needs neither footer nor index, so a recording that was killed is read
the same way as a finished one: up to the last whole message, also inside a compressed chunk as far as it can
be decompressed. Sizes in the file are never trusted beyond the caps below.
"""

from __future__ import annotations

import mmap
import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import lz4.frame
import zstandard

from .errors import NotARunError, TooLargeError

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK = 1, 2, 3, 4, 5, 6
METADATA, DATA_END, LAST_OPCODE = 12, 15, 15
MAX_CHUNK_BYTES = 256 << 20
MAX_RECORD_BYTES = 64 << 20
MAX_CHANNELS = 10_000

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<BQHIQQ")
_CHUNK = struct.Struct("<QQQI")


@dataclass(frozen=True)
class Schema:
    """A message definition in the file."""

    name: str
    encoding: str
    data: bytes


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
        last_log_time: latest log time of any message [ns], None without messages.
        problems: damage, one sentence each.
    """

    path: Path
    size: int
    topics: dict[int, RawTopic] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    complete: bool = False
    end: int = 0
    last_log_time: int | None = None
    problems: list[str] = field(default_factory=list)

    @property
    def message_count(self) -> int:
        """Messages found, those of unwanted topics included."""
        return sum(t.count for t in self.topics.values())


class _Cut(Exception):
    """The bytes end before the record does, or make no sense from here on."""


def scan(path: Path, wanted: Callable[[str], bool] = lambda topic: True) -> Scan:
    """Scan one MCAP file.

    Args:
        path: the file.
        wanted: says of each topic (as in the file) whether its payloads are kept.

    Returns:
        What was found; a cut or damaged file is described in `problems`, not raised.

    Raises:
        NotARunError: the file cannot be opened or is no MCAP file.
        TooLargeError: a record or chunk beyond the caps.
    """
    try:
        with path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(0)
            head = file.read(len(MAGIC))
            if head != MAGIC:
                found = head.hex(" ") if head else "an empty file"
                text = f"{path}: expected an MCAP file, which starts with {MAGIC.hex(' ')}, found {found}"
                raise NotARunError(text, path=path, position=0, expected=MAGIC, found=head)
            with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
                return _Scanner(Scan(path, size), data, wanted).run()
    except OSError as error:
        raise NotARunError(f"{path}: cannot be read: {error.strerror or error}", path=path) from error


class _Scanner:
    def __init__(self, result: Scan, data: mmap.mmap, wanted: Callable[[str], bool]) -> None:
        self.result, self.data, self.wanted = result, data, wanted
        self.schemas: dict[int, Schema] = {}

    def run(self) -> Scan:
        try:
            self.result.end = len(MAGIC)
            self.records(self.data, len(MAGIC), top=True)
            if not self.result.complete:
                self.result.problems.append(f"no end mark: cut off at byte {self.result.size}, behind a whole record")
        except _Cut as cut:
            lost = self.result.size - self.result.end
            self.result.problems.append(f"{cut}; the last {lost} of {self.result.size} bytes could not be read")
        return self.result

    def records(self, data: mmap.mmap | bytes, position: int, *, top: bool) -> None:
        """Walk records; `top` is the file itself, else the inside of a chunk."""
        size, unpack, unpack_message = len(data), _RECORD.unpack_from, _MESSAGE.unpack_from
        topics, wanted, result = self.result.topics, self.wanted_ids(), self.result
        latest = -1 if result.last_log_time is None else result.last_log_time
        try:
            while position < size:
                if position + 9 > size:
                    raise _Cut(f"cut off at byte {position} inside the head of a record")
                opcode, length = unpack(data, position)
                begin, end = position + 9, position + 9 + length
                if end > size:
                    self.refuse_nonsense(opcode, length, position)
                    if top and opcode == CHUNK:
                        self.chunk(data[begin:size], position, cut=True)
                    raise _Cut(f"cut off inside the record at byte {position}")
                if opcode == MESSAGE:
                    if length < 22:
                        raise _Cut(f"damaged: a message of {length} bytes at byte {position}")
                    _, _, channel, _, log_time, _ = unpack_message(data, position)
                    if channel not in topics:
                        raise _Cut(f"damaged: message of unknown channel {channel} at byte {position}")
                    topic = topics[channel]
                    topic.count += 1
                    if log_time > latest:
                        latest = log_time
                    if channel in wanted:
                        topic.log_times.append(log_time)
                        topic.payloads.append(data[begin + 22 : end])
                elif opcode == DATA_END and top:
                    result.complete, result.end = True, end
                    return
                else:
                    self.refuse_nonsense(opcode, length, position)
                    if opcode in (SCHEMA, CHANNEL, METADATA, CHUNK):
                        self.other(opcode, data[begin:end], position, top=top)
                        wanted = self.wanted_ids()
                position = end
                if top:
                    result.end = end
        finally:
            if latest >= 0:
                result.last_log_time = max(latest, result.last_log_time or 0)

    def wanted_ids(self) -> set[int]:
        return {i for i, t in self.result.topics.items() if self.wanted(t.topic)}

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
        try:
            if opcode == SCHEMA:
                name, rest = _string(body[2:])
                encoding, rest = _string(rest)
                self.schemas[int.from_bytes(body[:2], "little")] = Schema(name, encoding, _prefixed(rest)[0])
            elif opcode == CHANNEL:
                self.channel(body, position)
            elif opcode == METADATA:
                name, rest = _string(body)
                self.result.metadata[name] = _map(rest)
        except (UnicodeDecodeError, ValueError) as error:
            raise _Cut(f"damaged: the record of kind {opcode} at byte {position}: {error}") from error

    def channel(self, body: bytes, position: int) -> None:
        number, schema = int.from_bytes(body[:2], "little"), int.from_bytes(body[2:4], "little")
        topic, rest = _string(body[4:])
        encoding, rest = _string(rest)
        if number in self.result.topics:
            return
        if len(self.result.topics) >= MAX_CHANNELS:
            text = f"{self.result.path}: more than {MAX_CHANNELS} channels at byte {position}"
            raise TooLargeError(text, path=self.result.path, position=position, expected=MAX_CHANNELS)
        self.result.topics[number] = RawTopic(topic, encoding, self.schemas.get(schema), _map(rest))

    def chunk(self, body: bytes, position: int, *, cut: bool) -> None:
        if len(body) < _CHUNK.size + 4:
            raise _Cut(f"cut off inside the chunk at byte {position}")
        _, _, size, crc = _CHUNK.unpack_from(body)
        if size > MAX_CHUNK_BYTES:
            where = f"{self.result.path}: a chunk of {size} bytes at byte {position}"
            text = f"{where}, at most {MAX_CHUNK_BYTES} are read"
            raise TooLargeError(text, path=self.result.path, position=position, expected=MAX_CHUNK_BYTES, found=size)
        try:
            compression, rest = _string(body[_CHUNK.size :])
            data = _decompress(compression, rest[8:], size)
        except (UnicodeDecodeError, ValueError, RuntimeError, zstandard.ZstdError) as error:
            raise _Cut(f"the chunk at byte {position} cannot be decompressed: {error}") from error
        whole = len(data) == size and (crc == 0 or zlib.crc32(data) == crc)
        if not whole and not cut:
            self.result.problems.append(
                f"the chunk at byte {position} is damaged (length or checksum is wrong) and was left out"
            )
            return
        try:
            self.records(data, 0, top=False)
        except _Cut as inner:
            raise _Cut(f"inside the chunk at byte {position}: {inner}") from inner


def _prefixed(data: bytes) -> tuple[bytes, bytes]:
    length = int.from_bytes(data[:4], "little")
    if len(data) < 4 + length or len(data) < 4:
        raise ValueError(f"a length of {length} beyond the record")
    return data[4 : 4 + length], data[4 + length :]


def _string(data: bytes) -> tuple[str, bytes]:
    text, rest = _prefixed(data)
    return text.decode("utf-8"), rest


def _map(data: bytes) -> dict[str, str]:
    rest, _ = _prefixed(data)
    result = {}
    while rest:
        key, rest = _string(rest)
        result[key], rest = _string(rest)
    return result


def _decompress(compression: str, data: bytes, size: int) -> bytes:
    """Decompress at most `size` bytes (+ 1, to notice more); of cut data what can be had."""
    if compression == "":
        return data[: size + 1]
    if compression == "zstd":
        with zstandard.ZstdDecompressor().stream_reader(data) as reader:
            return reader.read(size + 1)
    if compression == "lz4":
        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1))
    raise ValueError(f"compression {compression!r}; known are zstd, lz4 and none")
