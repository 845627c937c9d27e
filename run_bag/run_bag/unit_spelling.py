"""Spellings of one unit: factors with powers, in any order, of which m/s^2, m/s2, m s^-2, m·s⁻² and m/s² are one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

__all__ = ["factors_of", "plain", "same_unit"]

_POWERS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
_OTHERS = {"**": "^", "·": " ", "⋅": " ", "×": " ", "*": " ", "−": "-", "μ": "u", "µ": "u"}
_PART = re.compile(
    r"\s*(?P<over>/?)\s*(?:\((?P<inside>[^()]+)\)|(?P<name>[^\W\d_]+|%)(?P<power>\^\(?[-+]?\d{1,2}\)?|[-+]\d|[2-9])?|1)"
    r"(?=[\s/(.]|$)\.?"
)
"""A factor behind a slash or none. A power needs no ^ where it has a sign or is 2 to 9: s1 is a name with a number."""


def plain(unit: str) -> str:
    """Return a unit in plain letters, powers behind a ^, one space between factors: N·m² is N m^2."""
    text = re.sub(r"[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda power: "^" + power[0].translate(_POWERS), unit)
    for other, ours in _OTHERS.items():
        text = text.replace(other, ours)
    return " ".join(text.split())


@lru_cache(maxsize=4096)
def factors_of(unit: str) -> Mapping[str, int] | None:
    """Return the power of each factor, {} of "1", None where a text is no product of factors.

    A slash is of what follows at once: m/s/s, N s/m. What follows it behind a space must be in brackets, as it may be
    meant either way: kg/m s is refused.
    """
    text, at, below = plain(unit), 0, False
    found: dict[str, int] = {}
    while at < len(text) or not text:
        part = _PART.match(text, at)
        if part is None or (below and not part["over"]):
            return None
        below, at = bool(part["over"]), part.end()
        sign = -1 if below else 1
        if part["inside"]:
            inner = factors_of(part["inside"])
            if inner is None:
                return None
            for name, power in inner.items():
                found[name] = found.get(name, 0) + sign * power
        elif part["name"]:
            found[part["name"]] = found.get(part["name"], 0) + sign * int((part["power"] or "1").strip("^()"))
    return MappingProxyType({name: power for name, power in found.items() if power})


def same_unit(one: str, other: str) -> bool:
    """Tell whether two texts are spellings of one unit."""
    if one == other:
        return True
    factors = factors_of(one)
    return factors is not None and factors == factors_of(other)
