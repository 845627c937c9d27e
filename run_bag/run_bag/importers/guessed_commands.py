"""Commands of thrusters whose names no rule knows: columns or fields that differ by a number, in %, in pulses, in
volts to both sides, or within -1 and 1; and their speeds: columns in turns per time that differ by a number, as many
as there are commands.

A vehicle's recording has one such group: M1 ... M8 of 1283 to 1701, thrust_pct_1 ... thrust_pct_6 of -57 to 57, or
channels[0] ... channels[7] of an array.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .bag_source import BagSource
from .column_names import bare_name
from .conversions import spelled
from .csv_source import CsvSource
from .guessed_names import is_element, numbered
from .guessed_units import pulses
from .guessed_values import moves, values_of
from .sources import Source
from .unit_words import named_units

__all__ = ["Alike", "alike_commands", "alike_speeds"]

_STICKS = ("mavros_msgs/msg/RCIn", "sensor_msgs/msg/Joy")
"""What a pilot moves: no command of several thrusters, but one stick may be that of a bench."""
_JOINTS = "sensor_msgs/msg/JointState"
"""Of one thruster it is as likely what was measured: a torque is within -1 and 1, too."""
_OUTPUT = re.compile(
    r"(^|[^a-z])(thr(uster)?s?|throttles?|motors?|m|cmd|commands?|pwm|escs?|actuators?|servos?|ch(annel)?s?|out(put)?s?|u|"
    r"joy)([^a-z]|$)",
    re.IGNORECASE,
)
"""Words one of which a name has whose numbers within -1 and 1, or in stated volts, are commands; many other things are
as large."""
_TURNS = ("rpm", "krpm", "rps", "rev/min", "rev/s", "1/min")
"""Units in which nothing else of a vehicle turns."""
_MOVED = 0.1
"""By which commands within -1 and 1, or in volts, go to either side at least."""
_VOLTS = re.compile(r"(^|[^a-z])volts?([^a-z]|$)", re.IGNORECASE)
"""The word of a name that says volts; a letter may be another quantity, as in dvl_v1."""


class Alike(NamedTuple):
    """A command: where it is, which thruster's, and what tells it: "unit", "values" or "" where nothing does."""

    source: Source
    name: str
    thruster: int
    told: str


def alike_commands(fields: Sequence[tuple[Source, str]]) -> list[Alike]:
    """Return commands of several thrusters; none where two groups may be them.

    An array may be longer than there are thrusters: elements behind the last one that ever changes are none. One that
    is left alone is a bench's.
    """
    groups: dict[tuple[str, str], list[Alike]] = {}
    for source, name in fields:
        table = isinstance(source, CsvSource)
        bare = bare_name(name) if table else name
        stem, thruster = numbered(bare, source.names())
        if stem != bare:
            words = f"{source.path.stem}_{stem}" if table and stem.split("_")[-1] == "data" else stem
            each = Alike(source, name, thruster, _tells_a_command(source, name, words))
            groups.setdefault((str(source.path), stem.lower()), []).append(each)
    likely = [own for group in groups.values() if (own := _used(group)) and all(each.told for each in own)]
    several = [own for own in likely if len(own) > 1 and _type_of(own[0]) not in _STICKS]
    single = [own for own in likely if len(own) == 1 and _type_of(own[0]) not in ("", _JOINTS)]
    found = several or single
    return found[0] if len(found) == 1 else []


def alike_speeds(columns: Sequence[tuple[CsvSource, str]], thrusters: set[int]) -> list[Alike]:
    """Return the speeds of these thrusters, of columns in turns per time; none where two groups may be them."""
    groups: dict[tuple[str, str], list[Alike]] = {}
    for source, name in columns:
        bare = bare_name(name)
        stem, thruster = numbered(bare, source.names())
        stated = source.unit(name)
        unit = spelled(stated) if stated else next(iter(named_units(name)[-1:]), "")
        if stem != bare and unit in _TURNS and values_of(source, name) is not None:
            groups.setdefault((str(source.path), stem.lower()), []).append(Alike(source, name, thruster, "unit"))
    found = [own for own in groups.values() if sorted(each.thruster for each in own) == sorted(thrusters)]
    return found[0] if len(found) == 1 and len(found[0]) > 1 else []


def _used(group: list[Alike]) -> list[Alike]:
    """Return a table's columns, and an array's elements up to the last one that changes."""
    if isinstance(group[0].source, CsvSource) and not is_element(group[0].source, group[0].name):
        return group
    moving = [each.thruster for each in group if moves(each.source, each.name)]
    return [each for each in group if each.thruster <= max(moving, default=-1)]


def _type_of(each: Alike) -> str:
    return each.source.types.get(each.name.partition(".")[0], "") if isinstance(each.source, BagSource) else ""


def _tells_a_command(source: Source, name: str, stem: str) -> str:
    """Return "unit" or "values" where that tells a column to be a command, "" where neither does.

    Pulses without a unit are whole numbers, as a timer counts them; a pressure in mbar may be as large.
    """
    values, stated = values_of(source, name), source.unit(name)
    unit = spelled(stated) if stated else next(iter(named_units(name)[-1:]), "")
    no_pulses = values is not None and unit == "us" and not pulses(values)
    if values is None or (no_pulses and stated):
        return ""
    unit = "" if no_pulses else unit
    if unit in ("us", "%"):
        return "unit"
    known = values[np.isfinite(values)]
    whole = pulses(values) and np.array_equal(known, np.round(known))
    low, high = float(np.min(known)), float(np.max(known))
    volts = unit == "V" and (_VOLTS.search(stem) or (stated and _OUTPUT.search(stem)))
    if volts and low < -_MOVED and high > _MOVED:  # no supply is negative
        return "unit"
    normed = unit in ("", "1") and _OUTPUT.search(stem) and -1.0 <= low < -_MOVED and _MOVED < high <= 1.0
    return "values" if (not unit and whole) or normed else ""
