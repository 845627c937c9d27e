"""The framed protocol for 100 Hz: bytes in, frames out, no port and no clock.

Little endian, 115200 baud, the same layout in both directions:

    offset  0   1   2       3     4         6           10       10+length
            A5  5A  length  type  sequence  time [µs]   payload  CRC-32
            u8  u8  u8      u8    u16       u32                  u32

The sequence counts the frames of the sender modulo 2^16, the time is the sender's clock modulo 2^32 µs (71.6 minutes).
The CRC is that of Ethernet and zlib, over everything between the sync bytes and itself.

Why 32 bits. A frame is false when damaged bytes pass the check, with probability 2^-b for b bits and damage beyond the
code's guaranteed distance. At 100 frames/s of which one in a hundred is damaged, that is one false frame in 18 hours
with 16 bits and in 136 years with 32. Two more bytes in 53 are a fair price where a frame moves a thruster. Random
bytes, 11,520 a second, pass the sync (2^-16), a known type with a length it can have (2^-10) and the CRC less than once
in a hundred thousand years.

Errors that are counted, never guessed at: bytes before a sync, headers with a type or length that does not exist, wrong
checksums, missing sequence numbers, repeated ones. After a wrong checksum the search goes on one byte behind the sync
that failed, so that a frame inside a damaged one is found. The memory is one frame at most.
"""

import zlib
from collections import Counter
from collections.abc import Mapping, Set
from dataclasses import dataclass
from struct import Struct

from bench_driver.errors import OutOfRange

__all__ = ["BAUD", "LONGEST_FRAME", "LONGEST_PAYLOAD", "OVERHEAD", "RATE", "SYNC", "Frame", "FrameDecoder", "encode"]

BAUD = 115200
"""Speed of the serial line [bit/s]."""
RATE = 100
"""Frames of measurements a second."""
SYNC = b"\xa5\x5a"
OVERHEAD = 14
"""Bytes of a frame besides its payload."""
LONGEST_PAYLOAD = 69
"""That of the state of eight thrusters [bytes]."""
LONGEST_FRAME = OVERHEAD + LONGEST_PAYLOAD
SEQUENCES = 1 << 16
CLOCK_WRAP = 1 << 32
"""The clock starts again after this many microseconds."""

_HEAD = Struct("<2sBBHI")
_CHECK = Struct("<I")


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame whose checksum was right.

    Attributes:
        type: what the payload is, 0 to 255.
        sequence: number of the frame modulo 2^16.
        time: clock of the sender modulo 2^32 [µs].
        payload: at most `LONGEST_PAYLOAD` bytes.

    Raises:
        OutOfRange: a number that its field cannot carry.
    """

    type: int
    sequence: int
    time: int
    payload: bytes = b""

    def __post_init__(self) -> None:
        for what, value, end in (
            ("type of the frame", self.type, 256),
            ("sequence number", self.sequence, SEQUENCES),
            ("time stamp [us]", self.time, CLOCK_WRAP),
            ("length of the payload", len(self.payload), LONGEST_PAYLOAD + 1),
        ):
            if not 0 <= value < end:
                raise OutOfRange(what, f"0 to {end - 1}", value)


def encode(frame: Frame) -> bytes:
    """Return the bytes of a frame."""
    head = _HEAD.pack(SYNC, len(frame.payload), frame.type, frame.sequence, frame.time)
    body = head + frame.payload
    return body + _CHECK.pack(zlib.crc32(body[len(SYNC) :]))


class FrameDecoder:
    """Bytes in, frames out; how the bytes are cut into pieces makes no difference.

    Args:
        lengths: the payload lengths that each type can have; every other header is rejected at once.

    Attributes:
        rejected: "garbage" and "bad header" count bytes skipped, "wrong checksum" counts frames.
        jumps: number of times that the sequence did not go on by one.
        lost: frames missing in these jumps; none is counted where the sequence went back.
        repeated: frames with the sequence number of the frame before; they are returned all the same.
    """

    def __init__(self, lengths: Mapping[int, Set[int]]) -> None:
        self.rejected: Counter[str] = Counter()
        self.jumps = 0
        self.lost = 0
        self.repeated = 0
        self._lengths = {kind: frozenset(allowed) for kind, allowed in lengths.items()}
        self._bytes = bytearray()
        self._sequence: int | None = None

    @property
    def waiting(self) -> int:
        """Return the number of bytes kept for a frame that is not whole yet, less than `LONGEST_FRAME`."""
        return len(self._bytes)

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames that end in these bytes, oldest first."""
        frames = []
        pending = self._bytes
        pending += data
        at = 0  # bytes before it are done with
        while True:
            at = self._next_sync(at)
            if len(pending) - at < _HEAD.size:
                break
            _, length, kind, sequence, time = _HEAD.unpack_from(pending, at)
            if length not in self._lengths.get(kind, ()):
                self.rejected["bad header"] += 1
                at += 1
                continue
            end = at + _HEAD.size + length
            if len(pending) < end + _CHECK.size:
                break
            if zlib.crc32(pending[at + len(SYNC) : end]) != _CHECK.unpack_from(pending, end)[0]:
                self.rejected["wrong checksum"] += 1
                at += 1
                continue
            frames.append(Frame(kind, sequence, time, bytes(pending[at + _HEAD.size : end])))
            self._follow(sequence)
            at = end + _CHECK.size
        del pending[:at]
        return frames

    def _next_sync(self, at: int) -> int:
        """Return where the next sync begins or may begin, and count what is skipped."""
        found = self._bytes.find(SYNC, at)
        if found < 0:
            found = len(self._bytes) - self._bytes.endswith(SYNC[:1], at)
        self.rejected["garbage"] += found - at
        return found

    def _follow(self, sequence: int) -> None:
        if self._sequence is not None:
            step = (sequence - self._sequence) % SEQUENCES
            self.repeated += step == 0
            self.jumps += step > 1
            self.lost += step - 1 if 1 < step < SEQUENCES // 2 else 0
        self._sequence = sequence
