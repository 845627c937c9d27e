"""The arrays of numbers of a MATLAB file, versions 5 to 7; scipy's reader of them crashes on files that are damaged.

After a header of 128 bytes come elements: kind and size, uint32 each, then the data, padded to 8 bytes. Up to four
bytes of data lie in the tag itself, with the size in its upper half. An array (kind 14) holds elements of its own:
flags with its class, dimensions, name, the real part. A compressed element (15) holds one other under zlib.
(MATLAB, MAT-File Format, chapter 1.)
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..budget import Budget

_HEADER = 128
_ARRAY, _COMPRESSED = 14, 15
_CODES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_OTHERS = {1: "cells", 2: "a structure", 3: "an object", 4: "text", 5: "a sparse matrix"}
_NUMBERS = range(6, 16)
_COMPLEX = 0x0800
_LARGEST = 2**31 - 1
"""Of a dimension, as MATLAB writes it."""


def read_numbers(path: Path) -> dict[str, NDArray[Any] | str]:
    """Return each variable by its name: an array of numbers, or in words what else it is.

    Raises:
        OSError: it cannot be read.
        ValueError: another version, or damaged.
        TooLargeError: it unpacks to more than its size lets expect.
    """
    data = path.read_bytes()
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128])
    if order is None:
        raise ValueError("expected version 5 to 7 (in MATLAB: save -v7)")
    budget, found = Budget(len(data)), {}
    for kind, content in _elements(data, _HEADER, order):
        if kind == _COMPRESSED:
            kind, content = next(_elements(_unpacked(content, budget, path), 0, order), (0, b""))
        if kind == _ARRAY:
            name, value = _variable(content, order)
            found[name] = value
    return found


def _unpacked(packed: bytes, budget: Budget, path: Path) -> bytes:
    unpack, blocks = zlib.decompressobj(), []
    while packed and not unpack.eof:
        blocks.append(unpack.decompress(packed, 1 << 20))
        budget.content(len(blocks[-1]), path)
        packed = unpack.unconsumed_tail
    return b"".join(blocks)


def _elements(data: bytes, at: int, order: str) -> Iterator[tuple[int, bytes]]:
    while at + 8 <= len(data):
        kind, size = (int(word) for word in np.frombuffer(data, f"{order}u4", 2, at))
        if kind >> 16:
            kind, size, begin, after = kind & 0xFFFF, kind >> 16, at + 4, at + 8
            if size > 4:
                raise ValueError(f"byte {at}: expected up to four bytes in a tag, found {size}")
        else:
            begin = at + 8
            after = begin + size + (0 if kind == _COMPRESSED else -size % 8)
        if begin + size > len(data):
            raise ValueError(f"byte {at}: expected {size} bytes, found {len(data) - begin}")
        yield kind, data[begin : begin + size]
        at = after


def _variable(data: bytes, order: str) -> tuple[str, NDArray[Any] | str]:
    parts = _elements(data, 0, order)
    flags, shape, name = (_array(*next(parts, (0, b"")), order) for _ in range(3))
    whole = all(each.dtype.kind in "iu" for each in (flags, shape, name))
    if not whole or flags.size < 1 or shape.size < 2 or (shape < 0).any() or (shape > _LARGEST).any():
        raise ValueError("expected an array with class and dimensions, found none")
    named = name.astype(np.uint8).tobytes().decode("latin-1")
    kind = int(flags[0]) & 0xFF
    if kind not in _NUMBERS or int(flags[0]) & _COMPLEX:
        return named, _OTHERS.get(kind, "complex numbers" if kind in _NUMBERS else f"class {kind}")
    values = _array(*next(parts, (0, b"")), order)
    wanted = 1
    for each in shape.tolist():
        wanted *= int(each)
    if values.size != wanted:
        raise ValueError(f"{named}: expected {wanted} numbers, found {values.size}")
    return named, values.reshape(shape.tolist(), order="F")


def _array(kind: int, data: bytes, order: str) -> NDArray[Any]:
    if kind not in _CODES:
        raise ValueError(f"expected a kind of numbers, found {kind}")
    code = np.dtype(order + _CODES[kind])
    if len(data) % code.itemsize:
        raise ValueError(f"expected whole numbers of {code.itemsize} bytes, found {len(data)} bytes")
    return np.frombuffer(data, code)
