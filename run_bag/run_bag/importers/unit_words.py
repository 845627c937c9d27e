"""Units that words of a column's name are: motor_rpm, thrust_kN, rev_per_s."""

from __future__ import annotations

import re

from .conversions import is_unit, spelled, written_so

__all__ = ["named_units", "words_of"]

_WORDS = {
    "hz": "Hz", "rads": "rad/s", "radps": "rad/s", "degs": "deg/s", "usec": "us", "microseconds": "us", "pwm": "us",
    "msec": "ms", "percent": "%", "pct": "%", "kg": "kgf", "g": "gf", "grams": "gf", "gram": "gf", "lb": "lbf",
    "lbs": "lbf", "newton": "N", "newtons": "N", "nm": "N m", "mnm": "mN m", "ncm": "N cm", "mps": "m/s",
    "cms": "cm/s", "mms": "mm/s", "volt": "V", "volts": "V", "amp": "A", "amps": "A", "ampere": "A", "sec": "s",
    "seconds": "s", "celsius": "degC",
}  # fmt: skip
"""Words of names that are units, beside the units themselves."""
_PAIRS = {("rad", "s"): "rad/s", ("deg", "s"): "deg/s", ("rev", "min"): "rpm", ("r", "min"): "rpm", ("u", "min"): "rpm",
          ("rev", "s"): "rps", ("m", "s"): "m/s", ("cm", "s"): "cm/s", ("mm", "s"): "mm/s", ("n", "m"): "N m",
          ("lbf", "in"): "lbf in", ("lbf", "ft"): "lbf ft",
          ("mn", "m"): "mN m", ("n", "cm"): "N cm", ("kgf", "cm"): "kgf cm", ("deg", "c"): "degC",
          ("mps", "2"): "m/s^2", ("ms", "2"): "m/s^2"}  # fmt: skip
_PER = ("per", "pro")
_RAW = "counts"
"""Of a device: as a unit raw and adc are counts; in a name they say whose value it is, as in servo1_raw."""


def words_of(name: str) -> list[str]:
    """Return the words of a name as they are written: motorRPM_1 is motor, RPM, 1; thrust_mN is thrust, mN."""
    words: list[str] = []
    for piece in re.findall(r"[^\W\d_]+|\d+|%", name):
        whole = written_so(piece) or piece.lower() in _WORDS
        words += [piece] if whole else re.split(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", piece)
    return words


def named_units(name: str) -> list[str]:
    """Return the units that words of a name are, the last and likeliest one last; a name of one letter is no unit.

    `kn` may be kN as well, in a name in small letters; rev_per_s is a unit as a whole.
    """
    every = words_of(name)
    words = [word for word in every if word.lower() not in _PER]
    found: list[str] = []
    for k, word in enumerate(words):
        pair = _PAIRS.get((words[k - 1].lower(), word.lower())) if k else None
        if pair and (k > 1 or len(words) < len(every)):
            found.append(pair)
        elif word.isalpha() and (len(word) > 1 or k > 0):
            own = written_so(word) or ([spelled(word)] if is_unit(word) and spelled(word) != _RAW else [])
            found += [*own, *filter(None, [_WORDS.get(word.lower())])]
    return found
