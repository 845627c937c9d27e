"""The binary stream of a Nortek Vectrino velocimeter: bytes in, records out, no port and no clock.

Packets begin with A5 and an identifier, and end with a checksum u16 = B58C + the sum of all 16-bit words before it,
modulo 2^16, little endian throughout. Velocity packets (51) are 22 bytes long:

    A5 51 status u8, count u8, velocity 4 x i16, amplitude 4 x u8, correlation 4 x u8, checksum

All others (05 hardware, 04 head, 00 user configuration, 07 probe check, 50 velocity header, 0F file information) state
their size in 16-bit words after the identifier. Status bit 5 tells the unit of the velocity: 1 mm/s or 0.1 mm/s. Of the
packets other than velocity only the velocity header is read: noise amplitudes, from which

    SNR = 20 log10(amplitude/noise) dB,

as the instrument's own ASCII export has it to within its rounding, temperature [0.01 °C] and speed of sound [0.1 m/s].
The checksum adds words, so words that swap their places and pairs of opposite errors pass it.
"""

import math
from collections import Counter
from dataclasses import dataclass
from struct import Struct

__all__ = ["LONGEST_PACKET", "Packet", "VectrinoDecoder", "Velocity", "VelocityHeader", "checksum"]

LONGEST_PACKET = 4096
"""A packet said to be longer is taken for garbage [bytes]; the longest known one, the probe check, has 2064."""

_VELOCITY = 0x51
_HEADER = 0x50
_RECORD = Struct("<BBBB4h4B4BH")
_HEADER_FIELDS = Struct("<2xHHHHH4B4BhH")
_HEADER_LENGTH = 42
_IDENTIFIERS = frozenset({0x05, 0x04, 0x00, 0x07, _HEADER, 0x0F, _VELOCITY})
_FINE = 0x20  # status: velocity in 0.1 mm/s
_KNOWN_STATUS = frozenset({0x03, 0x23})
_COUNTS = 256

Beams = tuple[float, float, float, float]
Counts = tuple[int, int, int, int]


@dataclass(frozen=True, kw_only=True, slots=True)
class Velocity:
    """One velocity record.

    Attributes:
        count: number of the record modulo 256.
        status: as sent; `known_status` is False for one whose meaning, but for the unit, is not known here.
        velocity: X, Y, Z, second Z [m/s] in the instrument's configured coordinates.
        amplitude: of each beam [counts].
        snr: signal to noise of each beam [dB]; NaN before the first velocity header or without an echo.
        correlation: of each beam [%].
    """

    count: int
    status: int
    velocity: Beams
    amplitude: Counts
    snr: Beams
    correlation: Counts

    @property
    def known_status(self) -> bool:
        """Return whether the status is one of those documented."""
        return self.status in _KNOWN_STATUS


@dataclass(frozen=True, kw_only=True, slots=True)
class VelocityHeader:
    """What the instrument found before it started to measure.

    Attributes:
        noise_amplitude, noise_correlation: of each beam [counts], [%].
        temperature: of the water [°C].
        sound_speed: [m/s].
    """

    noise_amplitude: Counts
    noise_correlation: Counts
    temperature: float
    sound_speed: float


@dataclass(frozen=True, slots=True)
class Packet:
    """Any other packet, whole and with its checksum, not interpreted."""

    identifier: int
    content: bytes


def checksum(data: bytes) -> int:
    """Return the checksum of an even number of bytes."""
    # Sum of little-endian words: even bytes count once, odd ones 256 times.
    return (0xB58C + sum(data[::2]) + (sum(data[1::2]) << 8)) & 0xFFFF


class VectrinoDecoder:
    """Bytes in, records out; how the bytes are cut into pieces makes no difference. Memory is bounded.

    Attributes:
        rejected: "garbage" and "bad header" count bytes skipped, "wrong checksum" counts packets.
        jumps: number of times that the count of velocity records did not go on by one.
        lost: records missing in these jumps, modulo 256 each.
        header: the last velocity header, None before the first.
    """

    def __init__(self) -> None:
        self.rejected: Counter[str] = Counter()
        self.jumps = 0
        self.lost = 0
        self.header: VelocityHeader | None = None
        self._bytes = bytearray()
        self._count: int | None = None

    @property
    def waiting(self) -> int:
        """Return the number of bytes kept for a packet that is not whole yet, less than `LONGEST_PACKET`."""
        return len(self._bytes)

    def feed(self, data: bytes) -> list[Velocity | VelocityHeader | Packet]:
        """Return what ends in these bytes, oldest first."""
        found: list[Velocity | VelocityHeader | Packet] = []
        pending = self._bytes
        pending += data
        at = 0
        while True:
            start = pending.find(0xA5, at)
            if start < 0:
                start = len(pending)
            self.rejected["garbage"] += start - at
            at = start
            if len(pending) - at < 4:
                break
            identifier = pending[at + 1]
            length = _RECORD.size if identifier == _VELOCITY else 2 * (pending[at + 2] | pending[at + 3] << 8)
            if identifier not in _IDENTIFIERS or not _possible(identifier, length):
                self.rejected["bad header"] += 1
                at += 1
                continue
            if len(pending) - at < length:
                break
            packet = bytes(pending[at : at + length])
            if checksum(packet[:-2]) != packet[-2] | packet[-1] << 8:
                self.rejected["wrong checksum"] += 1
                at += 1
                continue
            found.append(self._read(identifier, packet))
            at += length
        del pending[:at]
        return found

    def _read(self, identifier: int, packet: bytes) -> Velocity | VelocityHeader | Packet:
        if identifier == _VELOCITY:
            return self._velocity(packet)
        if identifier == _HEADER:
            self.header = _header(packet)
            return self.header
        return Packet(identifier, packet)

    def _velocity(self, packet: bytes) -> Velocity:
        _, _, status, count, *values, _ = _RECORD.unpack(packet)
        if self._count is not None:
            step = (count - self._count) % _COUNTS
            self.jumps += step != 1
            self.lost += (step - 1) % _COUNTS
        self._count = count
        unit = 1e-4 if status & _FINE else 1e-3  # m/s
        v1, v2, v3, v4, a1, a2, a3, a4, c1, c2, c3, c4 = values
        noise = self.header.noise_amplitude if self.header else (0, 0, 0, 0)
        s1, s2, s3, s4 = (_snr(a, n) for a, n in zip((a1, a2, a3, a4), noise, strict=True))
        return Velocity(
            count=count, status=status, velocity=(v1 * unit, v2 * unit, v3 * unit, v4 * unit),
            amplitude=(a1, a2, a3, a4), snr=(s1, s2, s3, s4), correlation=(c1, c2, c3, c4),
        )  # fmt: skip


def _possible(identifier: int, length: int) -> bool:
    if identifier == _VELOCITY:
        return True
    return length == _HEADER_LENGTH if identifier == _HEADER else 6 <= length <= LONGEST_PACKET


def _header(packet: bytes) -> VelocityHeader:
    _, _, _, _, _, n1, n2, n3, n4, k1, k2, k3, k4, temperature, sound_speed = _HEADER_FIELDS.unpack_from(packet)
    return VelocityHeader(
        noise_amplitude=(n1, n2, n3, n4), noise_correlation=(k1, k2, k3, k4),
        temperature=temperature / 100, sound_speed=sound_speed / 10,
    )  # fmt: skip


def _snr(amplitude: int, noise: int) -> float:
    return 20 * math.log10(amplitude / noise) if amplitude and noise else math.nan
