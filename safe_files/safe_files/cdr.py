"""Where each field of a CDR message lies: one walk over the definition, for writing and for reading.

CDR (XCDR1, as ROS 2 writes it): four bytes of encapsulation (0, 1 = little endian, 0, 0), then the fields in
order, each primitive aligned to its own size, counted from behind the encapsulation. A string is a uint32
length that includes the final NUL, then the bytes; a sequence is a uint32 count, then its elements (whose
alignment gap exists only if there is an element). Messages whose strings and sequences have equal lengths
thus have one layout: columns of a whole recording and the single records of a running node are read and written by it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from .errors import CdrError, CdrTooLargeError

__all__ = [
    "ARRAY", "BASE", "HEADER_BYTES", "NAME", "PRIMITIVES", "SEQUENCE", "Field", "FieldsOf", "Layout", "PayloadSource",
    "Source", "Text", "layout", "payload_layout",
]  # fmt: skip

FieldsOf = Mapping[str, Sequence[tuple[str, Any]]]
"""The fields of each message type by its full name: (name, description). A description is (BASE, (primitive, bound)),
(NAME, full name), (ARRAY, (description, count)) or (SEQUENCE, (description, bound)), as rosbags parses definitions."""
BASE, NAME, ARRAY, SEQUENCE = 1, 2, 3, 4

PRIMITIVES = {
    "bool": "u1", "byte": "u1", "char": "u1", "uint8": "u1", "int8": "i1", "uint16": "u2", "int16": "i2",
    "uint32": "u4", "int32": "i4", "uint64": "u8", "int64": "i8", "float32": "f4", "float64": "f8",
}  # fmt: skip
HEADER_BYTES = 4
MAX_ITEMS = 100_000
MAX_DEPTH = 32


@dataclass(frozen=True)
class Field:
    """Primitives of one kind in a row: path, byte offset in the message, how many (None: a scalar)."""

    path: str
    kind: str
    offset: int
    count: int | None

    @property
    def code(self) -> str:
        """The primitive as NumPy writes it, without its byte order."""
        return PRIMITIVES[self.kind]


@dataclass(frozen=True)
class Text:
    """A string: path, byte offset of its length word, encoded bytes without the final NUL."""

    path: str
    offset: int
    data: bytes


@dataclass(frozen=True)
class Layout:
    """Positions in messages of one type whose strings and sequences have these lengths.

    Attributes:
        size: bytes of the message, encapsulation included.
        order: "<" or ">".
        fields: all primitives.
        texts: all strings.
        counts: (byte offset, value) of every uint32 that holds the length of a string or sequence.
    """

    size: int
    order: str
    fields: tuple[Field, ...]
    texts: tuple[Text, ...]
    counts: tuple[tuple[int, int], ...]

    def text(self, path: str) -> str:
        """Return the string at a path, "" if the type has none there."""
        return next((t.data.decode("utf-8", "replace") for t in self.texts if t.path == path), "")


class Source(Protocol):
    """Tells the walk the lengths that the definition leaves open."""

    def string(self, path: str, offset: int) -> bytes:
        """Return the string whose length word lies at this offset."""

    def length(self, path: str, offset: int) -> int:
        """Return the number of elements of the sequence whose count lies at this offset."""


class _Walk:
    def __init__(self, fields_of: FieldsOf, source: Source, order: str) -> None:
        self.fields_of, self.source, self.order = fields_of, source, order
        self.position = HEADER_BYTES
        self.items = 0
        self.fields: list[Field] = []
        self.texts: list[Text] = []
        self.counts: list[tuple[int, int]] = []

    def align(self, size: int) -> None:
        self.position += -(self.position - HEADER_BYTES) % size

    def primitive(self, kind: str, path: str, count: int | None) -> None:
        if kind not in PRIMITIVES:
            raise CdrError(f"field {path!r}: type {kind!r} is not supported", found=kind)
        size = int(PRIMITIVES[kind][1])
        if count != 0:
            self.align(size)
        self.fields.append(Field(path, kind, self.position, count))
        self.position += size * (1 if count is None else count)

    def string(self, path: str) -> None:
        self.align(4)
        data = self.source.string(path, self.position)
        self.counts.append((self.position, len(data) + 1))
        self.texts.append(Text(path, self.position, data))
        self.position += 4 + len(data) + 1

    def struct(self, name: str, path: str, depth: int) -> None:
        if depth > MAX_DEPTH or name not in self.fields_of:
            raise CdrError(f"field {path!r}: type {name!r} is unknown or nested too deeply", found=name)
        fields = self.fields_of[name] or [("structure_needs_at_least_one_member", (BASE, ("uint8", 0)))]
        for field, description in fields:
            self.field(description, f"{path}.{field}" if path else field, depth)

    def field(self, description: Any, path: str, depth: int) -> None:
        self.items += 1
        if self.items > MAX_ITEMS:
            raise CdrTooLargeError(f"field {path!r}: more than {MAX_ITEMS} items in one message", expected=MAX_ITEMS)
        if description[0] == NAME:
            self.struct(str(description[1]), path, depth + 1)
        elif description[0] == BASE:
            if description[1][0] == "string":
                self.string(path)
            else:
                self.primitive(description[1][0], path, None)
        else:
            element, count = description[1]
            if description[0] == SEQUENCE:
                self.align(4)
                count = self.source.length(path, self.position)
                self.counts.append((self.position, count))
                self.position += 4
            if element[0] == BASE and element[1][0] != "string":
                self.primitive(element[1][0], path, int(count))
            else:
                for i in range(int(count)):
                    self.field(element, f"{path}[{i}]", depth)


def layout(fields_of: FieldsOf, name: str, source: Source, order: str = "<") -> Layout:
    """Return the layout of a message type, with the open lengths from `source`.

    Raises:
        CdrError: a type is unknown or of a kind that CDR in ROS 2 does not use (wstring, long double).
        CdrTooLargeError: a message with more than 100,000 items.
    """
    walk = _Walk(fields_of, source, order)
    walk.struct(name, "", 0)
    return Layout(walk.position, order, tuple(walk.fields), tuple(walk.texts), tuple(walk.counts))


class PayloadSource:
    """Reads the open lengths out of one message."""

    def __init__(self, payload: bytes, order: str) -> None:
        self.payload, self.order = payload, "little" if order == "<" else "big"

    def length(self, path: str, offset: int) -> int:
        """Return the count at the offset, if that many bytes can follow."""
        word = self.payload[offset : offset + 4]
        count = int.from_bytes(word, self.order)  # type: ignore[arg-type]
        if len(word) < 4 or count > len(self.payload) - offset - 4:
            raise CdrError(f"field {path!r} at byte {offset}: a length beyond the end of the message")
        return count

    def string(self, path: str, offset: int) -> bytes:
        """Return the bytes of the string without its NUL."""
        length = self.length(path, offset)
        data = self.payload[offset + 4 : offset + 4 + length]
        if length and data[-1:] != b"\0":
            raise CdrError(f"field {path!r} at byte {offset}: a string that does not end in NUL")
        if not length:
            raise CdrError(f"field {path!r} at byte {offset}: a string of length 0, not even NUL")
        return data[:-1]


def payload_layout(fields_of: FieldsOf, name: str, payload: bytes) -> Layout:
    """Return the layout of one recorded message.

    Raises:
        CdrError: encapsulation other than plain CDR, or payload and definition do not fit together.
    """
    if len(payload) < HEADER_BYTES or payload[0] != 0 or payload[1] not in (0, 1):
        found = payload[:2].hex(" ") or "nothing"
        raise CdrError(f"expected the encapsulation of plain CDR (00 00 or 00 01), found {found}", found=found)
    order = "<" if payload[1] else ">"
    result = layout(fields_of, name, PayloadSource(payload, order), order)
    if not result.size <= len(payload) < result.size + 4:
        text = f"expected {result.size} bytes by the definition of {name}, found {len(payload)}"
        raise CdrError(text, expected=result.size, found=len(payload))
    return result
