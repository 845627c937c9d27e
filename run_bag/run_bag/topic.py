"""One topic to be written: columns in, serialised messages out."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .definitions import Definitions, definitions, full_name
from .errors import InvalidRunError
from .known_topics import KNOWN
from .layout import Layout, dtype_of, layout

NANOSECONDS = 1_000_000_000
ENCAPSULATION = b"\0\1\0\0"
_INDEXED = re.compile(r"(.+)\[(\d+)\]$")


@dataclass(frozen=True, kw_only=True, eq=False)
class Topic:
    """Messages of one topic as columns.

    Attributes:
        name: topic; a leading slash is added in the file if it is missing.
        type: message type, "package/msg/Type" or "package/Type".
        stamps: instants of measurement [ns], int64 >= 0, non-decreasing, (N,); log time, publish time and,
            where the type has a header, its stamp.
        fields: field path -> numbers of shape (N,); (N, k) for arrays and sequences, or "path[i]" -> (N,) for
        one
            element of an array of fixed size; a str or N strings for string fields. What is missing is NaN in
            floating-point fields, 0 in integers and booleans, "" in strings, and sequences are empty.
        frame: frame id for the header.
    """

    name: str
    type: str
    stamps: ArrayLike
    fields: Mapping[str, Any] = field(default_factory=dict)
    frame: str = ""

    @classmethod
    def of_thruster(cls, index: int, name: str, time: ArrayLike, fields: Mapping[str, Any]) -> Topic:
        """Return a topic of a thruster whose clock begins at one second: zero means "no stamp" to some tools.

        Args:
            index: of the thruster.
            name: below the thruster's own, one of `KNOWN`.
            time: of the messages from the beginning [s], (N,).
            fields: as of any topic.
        """
        stamps = NANOSECONDS + np.round(np.asarray(time, dtype=np.float64) * 1e9).astype(np.int64)
        own = f"thruster_{index}"
        return cls(name=f"{own}/{name}", type=KNOWN[name], stamps=stamps, fields=dict(fields), frame=own)


@dataclass(frozen=True)
class Columns:
    """A checked topic: what the serialiser works from."""

    name: str
    type: str
    stamps: NDArray[np.int64]
    numbers: dict[str, NDArray[Any]]
    strings: dict[str, list[str] | str]
    template: Layout

    def __len__(self) -> int:
        return len(self.stamps)

    def payloads(self, first: int, last: int) -> Iterator[bytes]:
        """Yield the serialised messages first..last-1."""
        if any(isinstance(s, list) for s in self.strings.values()):
            shapes: dict[tuple[tuple[str, str], ...], Layout] = {}
            for i in range(first, last):
                strings = {k: s[i] if isinstance(s, list) else s for k, s in self.strings.items()}
                key = tuple(strings.items())
                if key not in shapes:
                    shapes[key] = _layout(definitions(), self.type, strings, self.numbers)
                yield self._bulk(shapes[key], i, i + 1)
            return
        size, data = self.template.size, self._bulk(self.template, first, last)
        for offset in range(0, len(data), size):
            yield data[offset : offset + size]

    def _bulk(self, shape: Layout, first: int, last: int) -> bytes:
        raw = np.zeros((last - first, shape.size), dtype=np.uint8)
        raw[:, : len(ENCAPSULATION)] = np.frombuffer(ENCAPSULATION, dtype=np.uint8)
        for offset, count in shape.counts:
            raw[:, offset : offset + 4] = np.frombuffer(count.to_bytes(4, "little"), dtype=np.uint8)
        for text in shape.texts:
            begin = text.offset + 4
            raw[:, begin : begin + len(text.data)] = np.frombuffer(text.data, dtype=np.uint8)
        records = raw.view(dtype_of(shape))[:, 0]
        for f in shape.fields:
            if f.count == 0:
                continue
            if f.path in self.numbers:
                records[f.path] = self.numbers[f.path][first:last]
            elif f.code[0] == "f":
                records[f.path] = np.nan
        return raw.tobytes()


class _GivenLengths:
    def __init__(self, strings: Mapping[str, str], numbers: Mapping[str, NDArray[Any]]) -> None:
        self.strings, self.numbers = strings, numbers

    def string(self, path: str, offset: int) -> bytes:
        return self.strings.get(path, "").encode()

    def length(self, path: str, offset: int) -> int:
        column = self.numbers.get(path)
        return 0 if column is None or column.ndim != 2 else column.shape[1]


def _layout(
    known: Definitions, type_name: str, strings: Mapping[str, str], numbers: Mapping[str, NDArray[Any]]
) -> Layout:
    return layout(known.fields(type_name), type_name, _GivenLengths(strings, numbers))


def check_topic(topic: Topic) -> Columns:
    """Check a topic against the definition of its type.

    Raises:
        SchemaError: the type is unknown.
        InvalidRunError: all that is wrong with stamps and fields.
    """
    known, type_name = definitions(), full_name(topic.type)
    problems = []
    if not re.fullmatch(r"/?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", topic.name):
        problems.append(f"expected a topic name of letters, digits, _ and /, found {topic.name!r}")
    stamps = np.asarray(topic.stamps)
    if stamps.ndim != 1 or not stamps.size or stamps.dtype.kind not in "iu":
        text = f"expected integer stamps in nanoseconds, at least one, found {stamps.dtype} {stamps.shape}"
        raise InvalidRunError(f"topic {topic.name!r}", [*problems, text])
    stamps = stamps.astype(np.int64)
    if stamps.min() < 0 or stamps.max() >= NANOSECONDS << 31:
        problems.append(f"expected stamps from 0 s to below 2^31 s, found {stamps.min()} to {stamps.max()} ns")
    if (falls := np.flatnonzero(np.diff(stamps) < 0)).size:
        i = int(falls[0])
        problems.append(f"stamps run backwards at message {i + 1}: {stamps[i]} ns, then {stamps[i + 1]} ns")

    strings: dict[str, list[str] | str] = {}
    numbers: dict[str, NDArray[Any]] = {}
    elements: dict[str, dict[int, NDArray[Any]]] = {}
    for path, value in topic.fields.items():
        if isinstance(value, str):
            strings[path] = value
            continue
        if isinstance(value, Sequence) and value and all(isinstance(s, str) for s in value):
            strings[path] = [str(s) for s in value]
            continue
        column = np.asarray(value)
        match = _INDEXED.match(path)
        if match and column.ndim == 1:
            elements.setdefault(match[1], {})[int(match[2])] = column
        else:
            numbers[path] = column
    sample = {k: s if isinstance(s, str) else s[0] for k, s in strings.items()}
    shape = _layout(known, type_name, sample, numbers)
    by_path = {f.path: f for f in shape.fields}
    if "header.stamp.sec" in by_path:
        strings.setdefault("header.frame_id", topic.frame)
        for path in ("header.stamp.sec", "header.stamp.nanosec"):
            if path in numbers:
                problems.append(f"field {path!r} comes from the stamps and cannot be given")
        numbers["header.stamp.sec"], numbers["header.stamp.nanosec"] = np.divmod(stamps, NANOSECONDS)
    elif topic.frame:
        problems.append(f"{type_name} has no header for the frame {topic.frame!r}")
    for base, columns in elements.items():
        target = by_path.get(base)
        if target is None or not target.count or max(columns) >= target.count:
            problems.append(f"{type_name} has no field {base + str([max(columns)])!r}")
            continue
        merged = np.full((len(stamps), target.count), np.nan if target.code[0] == "f" else 0)
        for i, column in columns.items():
            if column.shape != stamps.shape:
                problems.append(f"field '{base}[{i}]': expected {len(stamps)} values, found {column.shape}")
            else:
                merged[:, i] = column
        numbers[base] = merged

    for path, column in numbers.items():
        target = by_path.get(path)
        if target is None:
            problems.append(f"{type_name} has no numeric field {path!r}")
            continue
        wanted = (len(stamps),) if target.count is None else (len(stamps), target.count)
        if column.shape != wanted:
            problems.append(f"field {path!r}: expected shape {wanted}, found {column.shape}")
        elif column.dtype.kind not in "fiub":
            problems.append(f"field {path!r}: expected numbers, found {column.dtype}")
        elif target.code[0] != "f":
            info = np.iinfo(target.code)
            whole = np.isfinite(column).all() and (column == np.floor(column)).all()
            if not whole or column.min() < info.min or column.max() > info.max:
                problems.append(f"field {path!r}: expected whole numbers from {info.min} to {info.max}")
    texts = {t.path for t in shape.texts}
    for path, string in strings.items():
        if path not in texts:
            problems.append(f"{type_name} has no string field {path!r}")
        elif isinstance(string, list) and len(string) != len(stamps):
            problems.append(f"field {path!r}: expected {len(stamps)} strings, found {len(string)}")
        elif any("\0" in s for s in ([string] if isinstance(string, str) else string)):
            problems.append(f"field {path!r}: a string holds a NUL character")
    if problems:
        raise InvalidRunError(f"topic {topic.name!r} ({type_name})", problems)
    sample = {k: s if isinstance(s, str) else s[0] for k, s in strings.items()}
    name = topic.name if topic.name.startswith("/") else "/" + topic.name
    return Columns(name, type_name, stamps, numbers, strings, _layout(known, type_name, sample, numbers))
