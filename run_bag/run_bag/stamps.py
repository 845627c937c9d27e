"""The stamp of a serialised message, read and replaced without decoding it."""

from __future__ import annotations

import struct

from rosbags.interfaces import Nodetype

from .definitions import FieldsOf
from .layout import HEADER_BYTES

NANOSECONDS = 1_000_000_000
_HEADER = (Nodetype.NAME, "std_msgs/msg/Header")
_STAMP = {1: struct.Struct("<iI"), 0: struct.Struct(">iI")}


def has_header(fields_of: FieldsOf, name: str) -> bool:
    """Tell whether messages of a type are or begin with a std_msgs/Header: its stamp is the instant of measurement."""
    if name == _HEADER[1]:
        return True
    fields = fields_of[name]
    return bool(fields) and tuple(fields[0][1]) == _HEADER


def header_stamp(payload: bytes) -> int:
    """Return the stamp [ns] of a CDR message that begins with a header; 0 if the message is too short for one."""
    stamp = _stamp_of(payload)
    if stamp is None:
        return 0
    seconds, nanoseconds = stamp.unpack_from(payload, HEADER_BYTES)
    return int(seconds) * NANOSECONDS + int(nanoseconds)


def restamped(payload: bytes, stamp: int) -> bytes:
    """Return a CDR message that begins with a header, with another stamp [ns]; one too short for a header as it is."""
    written = _stamp_of(payload)
    if written is None:
        return payload
    changed = bytearray(payload)
    written.pack_into(changed, HEADER_BYTES, *divmod(stamp, NANOSECONDS))
    return bytes(changed)


def _stamp_of(payload: bytes) -> struct.Struct | None:
    """Return how a message's stamp is written; None where the message is too short for one."""
    return _STAMP.get(payload[1]) if len(payload) >= HEADER_BYTES + 8 else None
