"""Recorded messages of one topic -> columns of numbers, all messages of one layout at once."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .budget import Budget
from .definitions import FieldsOf
from .errors import SchemaError, TooLargeError
from .layout import Layout, dtype_of, payload_layout

FRAME_ID = "header.frame_id"
SEC, NANOSEC = "header.stamp.sec", "header.stamp.nanosec"
NANOSECONDS = 1_000_000_000
MAX_ELEMENTS = 64
"""Longer arrays (images, clouds) do not become channels."""
_MASKED_GROUPS = 32
"""From so many layouts on, messages are decoded one by one instead of searching for others of their kind."""


@dataclass
class Columns:
    """Numbers of one topic.

    Attributes:
        values: path -> float64 (N,); NaN where a message lacks the field (shorter sequence).
        header_stamps: int64 ns (N,), or None if the type has no header.
        frames: the frame ids that occur.
        left_out: paths of arrays too long for channels.
        budget: what decoding may still cost.
        layouts: how many different ones there were.
    """

    values: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    header_stamps: NDArray[np.int64] | None = None
    frames: set[str] = field(default_factory=set)
    left_out: set[str] = field(default_factory=set)
    budget: Budget = field(default_factory=lambda: Budget(0))
    layouts: int = 0


def decode(fields_of: FieldsOf, name: str, payloads: list[bytes], budget: Budget | None = None) -> Columns:
    """Decode all messages of a topic; `budget`: of the whole recording.

    Raises:
        SchemaError: `position` is the index of the first message that does not fit the definition.
        TooLargeError: likewise, a message with too many items, or more than the budget.
    """
    result = Columns(budget=budget or Budget(sum(map(len, payloads))))
    lengths = np.fromiter(map(len, payloads), dtype=np.int64, count=len(payloads))
    for length in np.unique(lengths):
        rows = np.flatnonzero(lengths == length)
        whole = len(rows) == len(payloads)
        joined = b"".join(payloads if whole else [payloads[i] for i in rows])
        block = np.frombuffer(joined, dtype=np.uint8).reshape(len(rows), int(length))
        _decode_block(fields_of, name, block, rows, len(payloads), result)
    return result


def _decode_block(
    fields_of: FieldsOf,
    name: str,
    block: NDArray[np.uint8],
    rows: NDArray[np.int64],
    total: int,
    result: Columns,
) -> None:
    groups = 0
    while len(rows):
        sample = block[0].tobytes()
        try:
            shape = payload_layout(fields_of, name, sample)
        except (SchemaError, TooLargeError) as error:
            text = f"message {rows[0]}: {error}"
            raise type(error)(text, position=int(rows[0]), expected=error.expected, found=error.found) from error
        result.layouts += 1
        if result.layouts > 1:  # one for each topic is free
            result.budget.take("steps", len(shape.fields) + len(shape.texts), "its messages")
        groups += 1
        if groups >= _MASKED_GROUPS:
            _store(shape, block[:1], rows[:1], total, result)
            block, rows = block[1:], rows[1:]
            continue
        same = _same_layout(block, shape)
        if same.all():
            _store(shape, block, rows, total, result)
            return
        _store(shape, block[same], rows[same], total, result)
        block, rows = block[~same], rows[~same]


def _same_layout(block: NDArray[np.uint8], shape: Layout) -> NDArray[np.bool_]:
    """Return which messages have the byte order, lengths and frame id that this layout was made from."""
    same = block[:, 1] == block[0, 1]
    spans = [(offset, offset + 4) for offset, _ in shape.counts]
    spans += [(t.offset + 4, t.offset + 4 + len(t.data)) for t in shape.texts if t.path == FRAME_ID]
    for first, last in spans:
        same &= (block[:, first:last] == block[0, first:last]).all(axis=1)
    return same


def _store(shape: Layout, block: NDArray[np.uint8], rows: NDArray[np.int64], total: int, result: Columns) -> None:
    records = np.ascontiguousarray(block).view(dtype_of(shape, block.shape[1]))[:, 0]
    whole = len(rows) == total
    names = {f.path for f in shape.fields}
    if SEC in names and NANOSEC in names:
        result.frames.add(shape.text(FRAME_ID))
        stamps = records[SEC].astype(np.int64) * NANOSECONDS + records[NANOSEC].astype(np.int64)
        if result.header_stamps is None:
            result.header_stamps = np.zeros(total, dtype=np.int64)
        result.header_stamps[rows] = stamps
    for f in shape.fields:
        if f.path in (SEC, NANOSEC) or f.count == 0 or f.path.endswith("structure_needs_at_least_one_member"):
            continue
        if f.count is not None and f.count > MAX_ELEMENTS:
            result.left_out.add(f.path)
            continue
        if whole or f.path not in result.values:
            result.budget.take("numbers", total * (f.count or 1), "its messages")
        column = records[f.path].astype(np.float64)
        parts = {f.path: column} if f.count is None else {f"{f.path}[{i}]": column[:, i] for i in range(f.count)}
        for path, values in parts.items():
            if whole:
                result.values[path] = values
                continue
            if path not in result.values:
                result.values[path] = np.full(total, np.nan)
            result.values[path][rows] = values
