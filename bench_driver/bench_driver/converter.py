"""The converter behind each throttle: a 12-bit code and the amplifier that turns it into volts.

    u = 5 − 10·code/4080

A count c of the text protocol is exactly the code 16·c, zero throttle in the framed protocol exactly the code 2040.
The amplifier is trimmed to this line (README of the firmware); codes above 4080 are never sent.
"""

import math

from bench_driver.errors import OutOfRange, ThrottleRefused

__all__ = [
    "CODE_STEP",
    "LARGEST_CODE",
    "ZERO_CODE",
    "code_from_count",
    "code_from_millivolts",
    "code_volts",
    "millivolts",
]

LARGEST_CODE = 4080
"""The code of −5 V."""
ZERO_CODE = 2040
"""The code of zero throttle."""
CODE_STEP = 10 / LARGEST_CODE
"""Throttle between two codes [V]."""
LARGEST_MILLIVOLTS = 5000
"""Largest magnitude of a throttle that has a code [mV]."""

_CODES_PER_COUNT = 16
_LARGEST_COUNT = 255


def code_volts(code: int) -> float:
    """Return the throttle [V] that a code sets."""
    if not 0 <= code <= LARGEST_CODE:
        raise OutOfRange("code of the converter", f"0 to {LARGEST_CODE}", code)
    return 5 - 10 * code / LARGEST_CODE


def code_from_count(count: int) -> int:
    """Return the code of an 8-bit count of the text protocol."""
    if not 0 <= count <= _LARGEST_COUNT:
        raise OutOfRange("count of the throttle", f"0 to {_LARGEST_COUNT}", count)
    return _CODES_PER_COUNT * count


def code_from_millivolts(u: int) -> int:
    """Return the code nearest to a throttle in whole millivolts, as the firmware rounds it: (5000 − u)·51/125."""
    if not abs(u) <= LARGEST_MILLIVOLTS:
        raise OutOfRange("throttle [mV]", f"a magnitude of at most {LARGEST_MILLIVOLTS}", u)
    return ((LARGEST_MILLIVOLTS - u) * 51 + 62) // 125


def millivolts(u: float, *, limit: float) -> int:
    """Return a throttle [V] in whole millivolts, the unit of the framed protocol.

    Raises:
        ThrottleRefused: the magnitude exceeds the limit [V] or the throttle is not a number.
        OutOfRange: the limit itself is not within 0 to 5 V.
    """
    if not 0 <= limit <= LARGEST_MILLIVOLTS / 1000:
        raise OutOfRange("limit of the throttle [V]", f"0 to {LARGEST_MILLIVOLTS / 1000}", limit)
    if not abs(u) <= limit:
        raise ThrottleRefused(u, limit)
    return math.floor(1000 * u + 0.5)
