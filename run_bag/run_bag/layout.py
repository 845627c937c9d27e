"""Layouts of messages for NumPy: all messages of one layout are read or written at once."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from safe_files import cdr
from safe_files.cdr import HEADER_BYTES, Layout, Source
from safe_files.errors import CdrError, CdrTooLargeError

from .definitions import FieldsOf
from .errors import SchemaError, TooLargeError

__all__ = ["HEADER_BYTES", "Layout", "dtype_of", "layout", "payload_layout"]


def dtype_of(shape: Layout, itemsize: int | None = None) -> np.dtype[np.void]:
    """Return the structured dtype of one message; field names are paths. Empty arrays are left out."""
    fields = [f for f in shape.fields if f.count != 0]
    formats = [shape.order + f.code if f.count is None else (shape.order + f.code, (f.count,)) for f in fields]
    names, offsets = [f.path for f in fields], [f.offset for f in fields]
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": itemsize or shape.size})


def layout(fields_of: FieldsOf, name: str, source: Source) -> Layout:
    """Return the layout of a message type, little-endian, with the open lengths from `source`.

    Raises:
        SchemaError: a type is unknown or of a kind that CDR in ROS 2 does not use (wstring, long double).
        TooLargeError: a message with more than 100,000 items.
    """
    with _told():
        return cdr.layout(fields_of, name, source)


def payload_layout(fields_of: FieldsOf, name: str, payload: bytes) -> Layout:
    """Return the layout of one recorded message.

    Raises:
        SchemaError: encapsulation other than plain CDR, or payload and definition do not fit together.
        TooLargeError: a message with more than 100,000 items.
    """
    with _told():
        return cdr.payload_layout(fields_of, name, payload)


@contextmanager
def _told() -> Iterator[None]:
    try:
        yield
    except CdrError as error:
        kind = TooLargeError if isinstance(error, CdrTooLargeError) else SchemaError
        raise kind(str(error), expected=error.expected, found=error.found) from error
