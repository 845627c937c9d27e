"""Units in which others record, exactly: the factor that brings each to ours.

A unit is written as people do: `rpm`, `1/min`, `us`, `µs`, `kgf`, `N m`, `N·m`, `m/s²`, `m/s2`, `m s^-2`, `°C`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..unit_spelling import factors_of, plain

G = 9.80665
POUND = 4.4482216152605
OUNCE = POUND / 16
FOOT = 0.3048
WATER = 1000.0
"""Density of fresh water [kg/m^3], by which a pressure is a depth."""


class Conversion(NamedTuple):
    """value in ours = factor * (value + offset)."""

    factor: float
    offset: float = 0.0

    def __call__(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return values in our unit."""
        if self == (1.0, 0.0):
            return values
        return self.factor * (values + self.offset)


def _linear(**factors: float) -> dict[str, Conversion]:
    return {name: Conversion(factor) for name, factor in factors.items()}


_TURN = 2.0 * math.pi
_DEGREE = math.pi / 180.0
CONVERSIONS: dict[str, dict[str, Conversion]] = {
    "rad/s": _linear(rpm=_TURN / 60, rps=_TURN, Hz=_TURN)
    | {"deg/s": Conversion(_DEGREE), "dps": Conversion(_DEGREE), "mrad/s": Conversion(1e-3)}
    | {"rev/min": Conversion(_TURN / 60), "1/min": Conversion(_TURN / 60), "rev/s": Conversion(_TURN)}
    | {"1/s": Conversion(_TURN), "krpm": Conversion(_TURN / 0.06)},
    "rad": _linear(deg=_DEGREE, mrad=1e-3, cdeg=_DEGREE / 100),
    "V": _linear(mV=1e-3, cV=1e-2),
    "A": _linear(mA=1e-3, cA=1e-2),
    "Ah": _linear(mAh=1e-3),
    "N": _linear(mN=1e-3, kN=1e3, kgf=G, gf=1e-3 * G, g=1e-3 * G, lbf=POUND, kp=G,
        ozf=OUNCE, oz=OUNCE) | {"kg f": Conversion(G)},
    "N m": _linear(Nm=1.0) | {"mN m": Conversion(1e-3), "mNm": Conversion(1e-3), "N cm": Conversion(1e-2),
        "N mm": Conversion(1e-3), "Nmm": Conversion(1e-3), "Ncm": Conversion(1e-2), "kgf m": Conversion(G),
        "kgf cm": Conversion(G / 100), "lbf ft": Conversion(POUND * FOOT), "lbf in": Conversion(POUND * FOOT / 12),
        "ozf in": Conversion(OUNCE * FOOT / 12), "oz in": Conversion(OUNCE * FOOT / 12)},
    "m": _linear(cm=1e-2, mm=1e-3, km=1e3, ft=FOOT, dm=0.1),
    "m/s": _linear(kn=1852 / 3600, kt=1852 / 3600) | {"cm/s": Conversion(1e-2), "mm/s": Conversion(1e-3),
        "km/h": Conversion(1 / 3.6), "ft/s": Conversion(FOOT)},
    "m/s^2": _linear(g=G, gn=G) | {"mg": Conversion(1e-3 * G), "cm/s^2": Conversion(1e-2),
        "mm/s^2": Conversion(1e-3)},
    "s": _linear(ms=1e-3, us=1e-6, ns=1e-9, min=60.0, h=3600.0),
    "degC": {"K": Conversion(1.0, -273.15), "degF": Conversion(5 / 9, -32.0)},
    "1": {"%": Conversion(1e-2)},
}  # fmt: skip
"""Our unit -> other ones of the same quantity."""
PASCALS = {"Pa": 1.0, "hPa": 100.0, "mbar": 100.0, "kPa": 1000.0, "dbar": 1e4, "bar": 1e5}
"""Units of a pressure. As one of a depth, pressure over that at the surface, it is that of fresh water, p / (rho g)."""
COMMANDS = ("us", "%", "1", "counts")
"""Units of commands that are no voltage: a map says at which one the thruster stands still, how many make a volt."""

_DEGREES = {"°C": "degC", "°F": "degF", "°": "deg"}
_ALIASES = {"": "1", "-": "1", "–": "1", "sec": "s", "seconds": "s", "usec": "us", "msec": "ms", "volt": "V",
            "degrees": "deg", "newton": "N", "percent": "%", "celsius": "degC", "c": "degC", "pwm": "us",
            "u/min": "rpm", "r/min": "rpm", "min^-1": "rpm", "min-1": "rpm", "kg": "kgf", "grams": "gf", "lbs": "lbf",
            "lb": "lbf", "nm": "N m", "n-m": "N m", "degheading": "deg", "digit": "counts", "digits": "counts",
            "count": "counts", "lsb": "counts", "raw": "counts", "adc": "counts"}  # fmt: skip


def _known() -> set[str]:
    return {*CONVERSIONS, *COMMANDS, *PASCALS, *(name for table in CONVERSIONS.values() for name in table)}


def _powers(unit: str) -> frozenset[tuple[str, int]] | None:
    factors = factors_of(unit)
    return None if factors is None else frozenset(factors.items())


_BY_FACTORS = {_powers(name): name for name in sorted(_known(), reverse=True)}
_BY_SMALL = {_powers(name.lower()): name for name in sorted(_known(), reverse=True)}


def is_unit(text: str) -> bool:
    """Tell whether a text is a unit that any channel could have."""
    return spelled(text) in _known()


def written_so(word: str) -> list[str]:
    """Return the units of these letters, small or capital, the one that is written just so last: kN and kn of "kn"."""
    return sorted((unit for unit in _known() if unit.lower() == word.lower()), key=lambda unit: (unit == word, unit))


def spelled(unit: str) -> str:
    """Return a unit as the table has it, however its factors and powers are written; what is not known comes back as
    it is."""
    text = plain(unit)
    for other, ours in _DEGREES.items():
        text = text.replace(other, ours)
    if text in _known():
        return text
    if text.lower() in _ALIASES:
        return _ALIASES[text.lower()]
    factors = factors_of(text)
    if factors is None:
        return text
    aliased = {_ALIASES.get(name.lower(), name): power for name, power in factors.items()}
    for table, letters in ((_BY_FACTORS, str), (_BY_SMALL, str.lower)):  # as written goes before small letters
        for own in (factors, aliased):
            powers = frozenset((letters(name), power) for name, power in own.items())
            if powers in table:
                return table[powers]
    return text


def conversion(unit: str, ours: str) -> Conversion | None:
    """Return what brings a unit to ours, None where it is of another quantity."""
    given = spelled(unit)
    if given == ours:
        return Conversion(1.0)
    if ours == "m" and given in PASCALS:
        return Conversion(PASCALS[given] / (WATER * G))
    return CONVERSIONS.get(ours, {}).get(given)


def is_pressure(unit: str) -> bool:
    """Tell whether a unit is one of a pressure."""
    return spelled(unit) in PASCALS


def accepted(ours: str) -> str:
    """Return the units that become ours, for a sentence."""
    return ", ".join([ours, *CONVERSIONS.get(ours, {}), *(PASCALS if ours == "m" else ())])
