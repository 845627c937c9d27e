"""The unit of a column or field whose recording states none: from its name, from its values, or asked about.

What neither the name nor the values decide is "?", with the units in question: an import refuses it until a person has
written the unit. A speed without a unit is the usual case: 300 may be rad/s or rpm.
"""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from .advice import LARGE
from .conversions import COMMANDS, CONVERSIONS, conversion, is_unit, spelled
from .recording_map import ASKED
from .sources import Array


class Guessed(NamedTuple):
    """A unit, and what a person should know about it ("" where it was stated)."""

    unit: str
    why: str = ""


class _Range(NamedTuple):
    """The units in question for values of a magnitude up to `most`; where it is one, the values decide."""

    most: float
    units: tuple[str, ...]


_BY_SIZE: dict[str, tuple[_Range, ...]] = {
    "rad/s": (_Range(LARGE["n"], ("rad/s", "rpm", "rps")), _Range(np.inf, ("rpm",))),
    "N": (_Range(100.0, ("N", "kgf", "lbf")), _Range(np.inf, ("N", "gf", "mN"))),
    "N m": (_Range(50.0, ("N m", "N cm", "kgf cm")), _Range(np.inf, ("mN m", "N cm"))),
    "m/s": (_Range(10.0, ("m/s",)), _Range(np.inf, ("m/s", "cm/s", "mm/s"))),
    "V": (_Range(100.0, ("V",)), _Range(2000.0, ("V", "cV")), _Range(np.inf, ("mV",))),
    "A": (_Range(100.0, ("A",)), _Range(500.0, ("A", "mA")), _Range(np.inf, ("mA",))),
}
_OF_VEHICLE: dict[str, tuple[_Range, ...]] = {
    "rad/s": (_Range(6.0, ("rad/s", "deg/s")), _Range(np.inf, ("deg/s",))),
    "rad": (_Range(6.3, ("rad", "deg")), _Range(np.inf, ("deg",))),
    "m/s^2": (_Range(4.0, ("g", "m/s^2")), _Range(100.0, ("m/s^2",)), _Range(np.inf, ("mg",))),
}
"""Of its gyro, attitude and accelerometer, whose largest component at rest is gravity."""
_GRAVITY, _OFF = {"g": 1.0, "m/s^2": 9.81, "mg": 1000.0}, 0.15
"""What an accelerometer at rest reads in each unit, and by which share a vehicle that moves gently is off it."""
_TIME_STEPS = (
    _Range(0.5, ("s",)), _Range(2.0, ("s", "ms")), _Range(300.0, ("ms",)), _Range(3e3, ("ms", "us")),
    _Range(3e5, ("us",)), _Range(3e6, ("us", "ns")), _Range(np.inf, ("ns",)),
)  # fmt: skip
"""Steps between two samples: a recording has 3 to 2000 of them in a second."""
_EPOCH = ((1e9, "s"), (1e12, "ms"), (1e15, "us"), (1e18, "ns"))
"""What times since 1970 are from 2001 to 2286, in each unit: the least one, ten times as many at most."""
_WORDS = {
    "rpm": "rpm", "rps": "rps", "hz": "Hz", "rads": "rad/s", "radps": "rad/s", "dps": "dps", "degs": "deg/s",
    "krpm": "krpm", "us": "us", "usec": "us", "microseconds": "us", "pwm": "us", "ms": "ms", "msec": "ms",
    "ns": "ns", "percent": "%", "pct": "%", "kgf": "kgf", "kg": "kgf", "gf": "gf", "g": "gf", "grams": "gf",
    "gram": "gf", "lbf": "lbf", "lb": "lbf", "lbs": "lbf", "n": "N", "newton": "N", "newtons": "N", "mn": "mN",
    "kn": "kN", "nm": "N m", "mnm": "mN m", "ncm": "N cm", "mps": "m/s", "cms": "cm/s", "mms": "mm/s", "mv": "mV",
    "cv": "cV", "v": "V", "volt": "V", "volts": "V", "ma": "mA", "ca": "cA", "a": "A", "amp": "A", "amps": "A",
    "s": "s", "sec": "s", "seconds": "s", "degc": "degC", "celsius": "degC", "degf": "degF", "mah": "mAh",
}  # fmt: skip
"""Words of names that are units."""
_PAIRS = {("rad", "s"): "rad/s", ("deg", "s"): "deg/s", ("rev", "min"): "rpm", ("r", "min"): "rpm", ("u", "min"): "rpm",
          ("rev", "s"): "rps", ("m", "s"): "m/s", ("cm", "s"): "cm/s", ("mm", "s"): "mm/s", ("n", "m"): "N m",
          ("mn", "m"): "mN m", ("n", "cm"): "N cm", ("kgf", "cm"): "kgf cm", ("deg", "c"): "degC"}  # fmt: skip


def guessed_unit(
    ours: str,
    name: str,
    stated: str,
    values: Array | None,
    *,
    usual: str = "",
    command: bool = False,
    vehicle: bool = False,
    size: Array | None = None,
) -> Guessed:
    """Return the unit of a column or field of a channel in `ours`.

    Args:
        ours: the channel's own unit.
        name: of the column or field.
        stated: the unit that the recording states, "" where it states none.
        values: those of the column or field, None where they are no numbers.
        usual: what the format says where the recording does not, as in a vehicle's log.
        command: it is a throttle, which need not be a voltage.
        vehicle: it is one of a vehicle's inertial sensors; values are then those of all its axes.
        size: magnitudes of an accelerometer's readings, None where they are not known.
    """
    largest = float(np.nanmax(np.abs(values))) if values is not None else np.nan
    ranges = (_OF_VEHICLE if vehicle else _BY_SIZE).get(ours, ())
    if stated:
        unit = spelled(stated)
        if fits(unit, ours, command=command):
            odd = not vehicle and ours == "rad/s" and unit == ours and largest > ranges[0].most
            return Guessed(unit, f"{largest:.4g} rad/s is no thruster's: is it rpm?" if odd else "")
        if usual:
            return Guessed(usual, f"{stated!r} is not known: taken as {usual}")
        return _asked(_candidates(ours, ranges, largest), f"{stated!r} is not known as a unit of it")
    if usual:
        return Guessed(usual)
    named = [unit for unit in named_units(name) if fits(unit, ours, command=command)]
    if named and (named[-1] != "us" or values is None or pulses(values)):
        return Guessed(named[-1], "unit by its name")
    if command:
        return _command(values, largest)
    if not ranges:
        return Guessed(ours, "unit not stated")
    if size is not None and (by_gravity := _by_gravity(size)):
        return by_gravity
    units = _candidates(ours, ranges, largest)
    return Guessed(units[0], "unit by its values") if len(units) == 1 else _asked(units, "nothing says which")


def guessed_time_unit(name: str, stated: str, values: Array | None) -> Guessed:
    """Return the unit of a table's time."""
    if stated and conversion(stated, "s") is not None:
        return Guessed(spelled(stated))
    if not stated:
        named = [unit for unit in named_units(name) if conversion(unit, "s") is not None]
        if named and (len(_tokens(name)) > 1 or _tokens(name) == ["seconds"]):
            return Guessed(named[-1], "unit by its name")
    known = values[np.isfinite(values)] if values is not None else np.empty(0)
    steps = np.diff(known)
    if not steps.size:
        return Guessed("s", "unit not stated")
    for least, unit in _EPOCH:
        if least <= known[0] < 10 * least:
            return Guessed(unit, "unit by its values")
    usual = float(np.median(steps))
    units = next(r.units for r in _TIME_STEPS if usual < r.most or r.most == np.inf)
    if len(units) > 1:
        return _asked(units, f"{usual:.4g} between two samples")
    return Guessed(units[0], "unit by its values")


def _asked(units: tuple[str, ...], why: str) -> Guessed:
    return Guessed(ASKED, f"write the unit: {', '.join(units[:-1])} or {units[-1]}? {why}")


def fits(unit: str, ours: str, *, command: bool) -> bool:
    """Tell whether a unit is one of a channel in `ours`; command: of a throttle, which need not be a voltage."""
    return conversion(unit, ours) is not None or (command and unit in COMMANDS)


def _candidates(ours: str, ranges: tuple[_Range, ...], largest: float) -> tuple[str, ...]:
    if not ranges:
        return (ours, *list(CONVERSIONS.get(ours, {}))[:2])
    return next((r.units for r in ranges if not largest > r.most), ranges[-1].units)


def _tokens(name: str) -> list[str]:
    """Return the words of a name: motorRPM_1 is motor, rpm, 1; thrust_mN is thrust, mn."""
    words: list[str] = []
    for piece in re.findall(r"[^\W\d_]+|\d+|%", name):
        apart = [piece] if piece.lower() in _WORDS else re.split(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", piece)
        words += [word.lower() for word in apart]
    return words


def named_units(name: str) -> list[str]:
    """Return the units that words of a name are, the last one last; a name of one letter is no unit."""
    words = _tokens(name)
    found = []
    for k, word in enumerate(words):
        pair = _PAIRS.get((words[k - 1], word)) if k else None
        if k > 1 and pair:
            found.append(pair)
        elif len(word) > 1 or k > 0:
            found += [word if word.isalpha() and is_unit(word) else "", _WORDS.get(word, "")]
    return [unit for unit in found if unit]


def _by_gravity(size: Array) -> Guessed | None:
    """Return the unit in which a specific force is about gravity half of the time, None where it is so in none."""
    usual, (low, high) = float(np.median(size)), np.quantile(size, (0.25, 0.75))
    for unit, gravity in _GRAVITY.items():
        if (1.0 - _OFF) * gravity < low and high < (1.0 + _OFF) * gravity:
            return Guessed(unit, f"unit by its values: |a| is {usual:.4g} as a rule, as gravity at rest")
    return None


def pulses(values: Array) -> bool:
    """Tell whether all values are widths of servo pulses [us]."""
    return bool(np.nanmin(values) > 700.0 and np.nanmax(values) < 2300.0)


def _command(values: Array | None, largest: float) -> Guessed:
    if values is None:
        return Guessed("V", "unit not stated")
    if pulses(values):
        return Guessed("us", "unit by its values")
    if largest <= 1.001:
        return Guessed("1", "unit by its values: -1 to 1")
    if largest <= 30.0:
        return Guessed("V", "unit by its values")
    return _asked(("us", "%", "counts", "V"), "nothing says which")
