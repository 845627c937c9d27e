"""Which thruster and which unit the name of a table's column tells."""

from __future__ import annotations

import re
from collections.abc import Sequence

from .column_names import bare_name, without_unit
from .conversions import COMMANDS, spelled
from .csv_source import CsvSource
from .sources import Source
from .unit_words import named_units

__all__ = ["beside", "is_element", "numbered", "says_rate", "told_units", "told_words", "without_suffix"]

_SUFFIX = re.compile(
    r"_(us|ms|ns|k?rpm|rps|rev(?:_per)?_(?:s|min)|kgf|gf|lbf|n|m?nm|v|mv|a|ma|rad_?s|deg_?s|dps|m_?s_?2|mps_?2|[cm]?m_?s|mps|kn|kt|hz|pct|percent|deg_?c|rad|deg|"
    r"[cm]?m|g|mg)$",
    re.IGNORECASE,
)

_WANTED = ("setpoint", "target", "desired", "wanted", "demand", "ref", "reference", "soll", "sollwert")
_RATES = ("rate", "rates", "drehrate", "speed", "velocity", "vel", "gyr", "gyro", "omega", "dot")


def without_suffix(name: str) -> str:
    """Return a name without the unit at its end: gyro_x_dps is gyro_x."""
    return _SUFFIX.sub("", name)


def beside(source: Source, name: str) -> set[str]:
    """Return the last parts of names that differ by these alone, without units, in small letters: ahrs.p, ahrs.q."""
    parent = _parted(name)[0]
    parted = map(_parted, source.names())
    return {without_suffix(last.replace(" ", "_")).lower() for above, last in parted if above == parent}


def _parted(name: str) -> tuple[str, str]:
    """Return what is before and behind the last dot or slash of a name."""
    *above, last = re.split(r"([./])", without_unit(name))
    return "".join(above), last


def told_words(name: str) -> tuple[list[str], bool]:
    """Return the words of a name that may tell what it is, and whether it is what somebody wants and nobody measures:
    target_rpm is no speed."""
    words = [word for word in name.split("_") if len(word) > 1]
    told = [word for word in words if word.lower() not in _WANTED]
    return told, len(told) < len(words)


def says_rate(name: str) -> bool:
    """Tell whether a word of a name says that it is how fast something turns: rate_roll is no angle."""
    return not set(_RATES).isdisjoint(name.lower().split("_"))


def is_element(source: Source, name: str) -> bool:
    """Tell whether a column of a table is an element of an array, as output[0]."""
    return isinstance(source, CsvSource) and re.search(r"\w\[\d{1,2}\]$", name) is not None


def numbered(name: str, names: Sequence[str]) -> tuple[str, int]:
    """Return the name without the number of a thruster, and which one that is: they count from 0 or from 1.

    It is at the name's end, or inside it where other columns differ by it alone: esc1_rpm, esc2_rpm. Elements of an
    array count from 0.
    """
    if element := re.fullmatch(r"(.+)\[(\d{1,2})\]", name):
        return element[1], int(element[2])
    match = re.fullmatch(r"(.*[^\W\d_])_?(\d{1,2})()", name) or re.fullmatch(r"(.*?[^\W\d_])_?(\d{1,2})(_.+)", name)
    if match is None:
        return name, 0
    alike = re.compile(re.escape(match[1]) + r"_?(\d{1,2})" + re.escape(match[3]), re.IGNORECASE)
    numbers = {int(m[1]) for other in names if (m := alike.fullmatch(bare_name(other)))}
    if match[3] and len(numbers) < 2:
        return name, 0
    return match[1] + match[3], max(int(match[2]) - (0 if 0 in numbers else 1), 0)


def told_units(source: CsvSource, name: str, bare: Sequence[str]) -> list[str]:
    """Return the units that a column can be in alone: a command's, stated, or at the end of its name; none if unsaid.

    A letter may be part of a name, as in dvl_v, "ms" is meant as m/s, too, and vel_mm as mm/s.
    """
    if stated := source.unit(name):
        return [spelled(stated)] if spelled(stated) in COMMANDS else []
    ending = next((match[1].lower() for each in bare if (match := _SUFFIX.search(each))), "")
    if len(ending) < 2:
        return []
    if ending in ("cm", "mm") and any(each.lower().startswith("vel") for each in bare):
        return [f"{ending}/s"]
    if ending.endswith("2"):
        return ["m/s^2"]
    return [*named_units(f"x_{ending}"), *(["m/s"] if ending == "ms" else [])]
