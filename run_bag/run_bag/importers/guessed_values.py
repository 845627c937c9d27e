"""What a column or field of a recording holds, for a proposal of a map: read once for whatever is asked of it."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..errors import RunError
from .csv_source import CsvSource
from .log_source import LogSource
from .recording_map import Entry, Mapped
from .sources import Array, Source

__all__ = ["Span", "is_0", "is_of_quaternion", "is_unknown", "moves", "span_of", "values_of"]

_NORMED = 0.02
"""By which the squares of a quaternion's rounded elements may add up to more or less than 1."""
_UNKNOWN = (-1.0, 32767.0, 65535.0)
"""What MAVLink's messages have where nothing is known, as of a cell that a battery has not."""


class Span(NamedTuple):
    """How many numbers a column or field has, and the least and the largest of them."""

    numbers: int
    low: float
    high: float


def values_of(source: Source, name: str) -> Array | None:
    """Return the values of a column or field, None where they are no numbers."""
    try:
        if isinstance(source, CsvSource):
            index = source.names().index(name)
            values = source.numbers(index, source.marks(index))
        else:
            own = Entry(channel=name, topic="", type="", path="", unit="")
            entry = Mapped(**vars(own), column=name, is_field=True)
            if not source.has(entry):
                return None
            values = source.series(entry).values
    except RunError:
        return None
    return values if np.isfinite(values).any() else None


@lru_cache(maxsize=4096)  # more fields than the largest logs have
def span_of(source: Source, name: str) -> Span | None:
    """Return the span of a column or field, None where it has no numbers."""
    values = values_of(source, name)
    return None if values is None else Span(int(np.isfinite(values).sum()), np.nanmin(values), np.nanmax(values))


def is_0(source: Source, name: str) -> bool:
    """Tell whether a column or field is never anything but 0."""
    span = span_of(source, name)
    return span is not None and span.low == span.high == 0.0


def is_unknown(source: Source, name: str) -> bool:
    """Tell whether a field of a vehicle's log is never anything but one mark that nothing is known."""
    span = span_of(source, name) if isinstance(source, LogSource) else None
    return span is not None and span.low == span.high and span.low in _UNKNOWN


def is_of_quaternion(source: Source, name: str) -> bool:
    """Tell whether a column or field is one of four elements, q[0] to q[3], whose squares always add up to 1."""
    stem = name.rpartition("[")[0]
    parts = [values_of(source, f"{stem}[{k}]") if f"{stem}[{k}]" in source.names() else None for k in range(4)]
    told = [values for values in parts if values is not None]
    sizes = np.sum(np.square(told), axis=0) if len(told) == 4 and len({each.size for each in told}) == 1 else np.nan
    known = np.atleast_1d(sizes)[np.isfinite(np.atleast_1d(sizes))]
    return bool(known.size and np.all(np.abs(known - 1.0) < _NORMED))


def moves(source: Source, name: str) -> bool:
    """Tell whether a column or field ever changes."""
    span = span_of(source, name)
    return span is not None and span.low < span.high
