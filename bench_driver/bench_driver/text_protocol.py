"""The text protocol of the thruster bench: bytes in, counts and readings out, no port and no clock.

Host to rig, 25 times a second over 9600 baud, one line `"%d\\n"` with a count of the 8-bit converter:

    count = round((5 − u)·255/10),   u throttle [V], |u| ≤ 3 V;   -99 ends the run

Rig to host, one line `"%d,%d"` with two counts of 10-bit converters, 5 V full scale:

    |n| = 49.9723·5/1024·c1          n speed [rad/s]; the tachometer has no sign
    U   = 0.3 − 0.3/2.5·5/1024·c2    U ambient flow velocity [m/s]

What the counts imply: a step of the throttle is 10/255 V = 39 mV; zero lies between two counts and is sent as 128,
which is −20 mV; count 0 is +5 V, full forward, so a zero in the text is the opposite of a stop. Whoever drives the rig
sends `ZERO_COUNT` first and enables the output only then. There is no checksum: a digit that turned into another digit
goes unnoticed, everything else is rejected and counted.

Source: settings of the rig, published with the bench's recordings.
"""

import math
import operator
import re
from collections import Counter
from dataclasses import dataclass

from bench_driver.errors import OutOfRange, ThrottleRefused

BAUD = 9600
"""Speed of the serial line [bit/s]."""
PERIOD = 0.04
"""Time between two commands [s]."""
THROTTLE_LIMIT = 3.0
"""Largest magnitude of the throttle unless a wider one is asked for [V]."""
FULL_SCALE = 5.0
"""Largest magnitude of the throttle that has a count, and full scale of the rig's inputs [V]."""
THROTTLE_STEP = 10 / 255
"""Throttle between two counts [V]."""
ZERO_COUNT = 128
"""The count that stands for zero throttle."""
END = b"-99\n"
"""What the host sends to end the run."""

_LARGEST_THROTTLE_COUNT = 255
_LARGEST_INPUT_COUNT = 1023
_SPEED_STEP = 49.9723 * 5 / 1024  # rad/s
_FLOW_AT_ZERO = 0.3  # m/s
_FLOW_STEP = 0.3 / 2.5 * 5 / 1024  # m/s

_INTEGER = rb"(0|[1-9][0-9]{0,3})"  # as "%d" prints it: no sign, no space, no leading zero
_READING = re.compile(_INTEGER + rb"," + _INTEGER)
_COMMAND = re.compile(_INTEGER)
_LONGEST_LINE = len(b"1023,1023\r")


def throttle_count(u: float, *, limit: float = THROTTLE_LIMIT) -> int:
    """Return the count nearest to a throttle; halves go up, towards reverse.

    Args:
        u: throttle [V], positive forward.
        limit: largest magnitude allowed [V], at most 5.

    Raises:
        ThrottleRefused: the throttle exceeds the limit or is not a number.
        OutOfRange: the limit itself is not within 0 to 5 V.
    """
    if not 0 <= limit <= FULL_SCALE:
        raise OutOfRange("limit of the throttle [V]", f"0 to {FULL_SCALE}", limit)
    if not abs(u) <= limit:
        raise ThrottleRefused(u, limit)
    return _nearest((5 - u) * 255 / 10)


def throttle_volts(count: int) -> float:
    """Return the throttle [V] that a count really sets."""
    return 5 - 10 / 255 * _checked("count of the throttle", count, _LARGEST_THROTTLE_COUNT)


def encode_throttle(u: float, *, limit: float = THROTTLE_LIMIT) -> bytes:
    """Return the line that sets a throttle [V]; arguments and errors as for `throttle_count`."""
    return b"%d\n" % throttle_count(u, limit=limit)


def speed_from_count(c1: int) -> float:
    """Return the magnitude of the speed |n| [rad/s] of a count of the tachometer."""
    return _SPEED_STEP * _checked("count of the tachometer", c1, _LARGEST_INPUT_COUNT)


def flow_from_count(c2: int) -> float:
    """Return the ambient flow velocity U [m/s] of a count of the flow sensor."""
    return _FLOW_AT_ZERO - _FLOW_STEP * _checked("count of the flow sensor", c2, _LARGEST_INPUT_COUNT)


def count_from_speed(n: float) -> int:
    """Return the count that an emulated tachometer gives for a speed n [rad/s]; saturates like the converter."""
    return _saturated("speed [rad/s]", n, abs(n) / _SPEED_STEP)


def count_from_flow(U: float) -> int:
    """Return the count that an emulated flow sensor gives for U [m/s]; saturates like the converter."""
    return _saturated("flow velocity [m/s]", U, (_FLOW_AT_ZERO - U) / _FLOW_STEP)


@dataclass(frozen=True, slots=True)
class Reading:
    """One line of the rig: two counts, 0 to 1023.

    Raises:
        OutOfRange: a count is not an integer of that range.
    """

    tachometer_count: int
    flow_count: int

    def __post_init__(self) -> None:
        _checked("count of the tachometer", self.tachometer_count, _LARGEST_INPUT_COUNT)
        _checked("count of the flow sensor", self.flow_count, _LARGEST_INPUT_COUNT)


def encode_reading(reading: Reading) -> bytes:
    """Return the line that an emulated rig sends."""
    return b"%d,%d\n" % (reading.tachometer_count, reading.flow_count)


class LineDecoder:
    """The host's side: bytes of the rig in, readings out; how the bytes are cut into pieces makes no difference.

    Lines end in "\\n" or "\\r\\n". Memory is bounded whatever arrives.

    Args:
        mid_line: the port was opened while the rig was sending, so what comes before the first end of line may be the
            rest of a line, `23,5` of `1023,5`, and is rejected.

    Attributes:
        rejected: number of lines rejected, by reason.
        last_rejected: the start of the line rejected last, None before the first.
    """

    def __init__(self, *, mid_line: bool = False) -> None:
        self.rejected: Counter[str] = Counter()
        self.last_rejected: bytes | None = None
        self._lines = _Lines(mid_line=mid_line)

    @property
    def waiting(self) -> int:
        """Return the number of bytes kept for a line that has not ended yet."""
        return self._lines.waiting

    def feed(self, data: bytes) -> list[Reading]:
        """Return the readings whose lines end in these bytes, oldest first."""
        readings = []
        for line, reason in self._lines.feed(data):
            match = _READING.fullmatch(line)
            if reason:
                pass
            elif match is None:
                reason = "not two integers"
            elif max(counts := [int(group) for group in match.groups()]) > _LARGEST_INPUT_COUNT:
                reason = f"count above {_LARGEST_INPUT_COUNT}"
            else:
                readings.append(Reading(*counts))
                continue
            self.rejected[reason] += 1
            self.last_rejected = line
        return readings


class CommandDecoder:
    """The rig's side, for an emulated one: bytes of the host in, counts of the throttle out.

    Attributes:
        ended: the end of the run has been received; whatever follows it is ignored.
        rejected: number of lines rejected, by reason.
        last_rejected: the start of the line rejected last, None before the first.
    """

    def __init__(self) -> None:
        self.ended = False
        self.rejected: Counter[str] = Counter()
        self.last_rejected: bytes | None = None
        self._lines = _Lines()

    def feed(self, data: bytes) -> list[int]:
        """Return the counts, 0 to 255, whose lines end in these bytes and come before the end, oldest first."""
        counts: list[int] = []
        for line, reason in [] if self.ended else self._lines.feed(data):
            if reason:
                pass
            elif line == END.rstrip():
                self.ended = True
                break
            elif not _COMMAND.fullmatch(line):
                reason = "not an integer"
            elif int(line) > _LARGEST_THROTTLE_COUNT:
                reason = f"count above {_LARGEST_THROTTLE_COUNT}"
            else:
                counts.append(int(line))
                continue
            self.rejected[reason] += 1
            self.last_rejected = line
        return counts


class _Lines:
    """Bytes in, ended lines out, each with the reason why it is not whole, or an empty one."""

    def __init__(self, *, mid_line: bool = False) -> None:
        self._start = b""
        self._reason = "start not seen" if mid_line else ""

    @property
    def waiting(self) -> int:
        return len(self._start)

    def feed(self, data: bytes) -> list[tuple[bytes, str]]:
        *ends, rest = bytes(data).split(b"\n")
        lines = []
        for end in ends:
            self._append(end)
            lines.append((self._start.removesuffix(b"\r"), self._reason))
            self._start, self._reason = b"", ""
        self._append(rest)
        return lines

    def _append(self, piece: bytes) -> None:
        room = _LONGEST_LINE - len(self._start)
        if len(piece) > room:
            self._reason = self._reason or f"longer than {_LONGEST_LINE} bytes"
        self._start += piece[:room]


def _nearest(x: float) -> int:
    return math.floor(x + 0.5)  # not round(), which takes halves to the even side


def _checked(what: str, count: int, largest: int) -> int:
    try:
        whole = operator.index(count)
    except TypeError:
        raise OutOfRange(what, f"an integer from 0 to {largest}", count) from None
    if not 0 <= whole <= largest:
        raise OutOfRange(what, f"an integer from 0 to {largest}", count)
    return whole


def _saturated(what: str, value: float, count: float) -> int:
    if math.isnan(count):
        raise OutOfRange(what, "a number", value)
    return _nearest(min(max(count, 0), _LARGEST_INPUT_COUNT))
