"""One entry of a map, checked; what is wrong with it is a sentence among the problems of the map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..alignment import HOLDS
from ..definitions import definitions
from ..known_topics import known_topics, topic_type
from ..units import UNITS
from .axes import unit_in_map
from .conversions import COMMANDS, Conversion, accepted, conversion, spelled
from .recording_map import ASKED, Constant, Entry, Mapped

TOP = {"time", "csv", "axes"}
"""Keys of a map that are no channels."""
KEYS = {
    "column", "field", "file", "unit", "time_column", "time_unit", "time_scale", "scale", "offset", "sign", "nan",
    "hold", "stop", "per_volt", "clock_deviation", "time_offset", "where",
}  # fmt: skip
TIMES = ("time_column", "time_unit", "time_scale")
CLOCKS = ("throttle", "state", "load", "flow")
"""Kinds of topics of which a run can state by how much their clock may be off."""
MOST_OFFSET = 1e10
"""[s] Three hundred years: clocks count from 1904, 1970, 1980 or a boot."""
CONSTANT_KEYS = {"value", "unit"}


def entry_of(name: str, entry: Any, problems: list[str]) -> Mapped | Constant | None:
    """Return an entry, None (and problems) where something is wrong with it."""
    before = len(problems)
    topic, dot, path = name.strip("/").partition(".")
    kind = topic_type(topic)
    if kind is None and not dot and "/" not in topic:
        keys = ", ".join(sorted(TOP))
        problems.append(f"{name:.200}: unknown key: expected a channel, such as thruster_0/state.n, or one of {keys}")
        return None
    if kind is None:
        problems.append(f"{name:.200}: unknown topic {topic[:200]!r}; known are {known_topics()}")
        return None
    if not isinstance(entry, Mapping):
        problems.append(f"{name}: expected a mapping with column or field, and unit, or value, found {entry!r:.80}")
        return None
    definitions().require(kind)
    unit = unit_in_map(kind, path, topic)
    if not dot:
        problems.append(f"{name}: expected a channel, {name}.<field>, or one of {', '.join(sorted(TOP))}")
    elif not unit:
        problems.append(f"{name}: {kind} has no numeric field {path!r}; it has {', '.join(UNITS.get(kind, {}))}")
    constant = "value" in entry
    known, needed = (CONSTANT_KEYS, {"value"}) if constant else (KEYS, {"unit"})
    unknown, missing = sorted(map(str, set(entry) - known)), sorted(needed - set(entry))
    beside = " beside value" if constant else ""
    problems += [f"{name}: unknown key {k!r}{beside}; known are {', '.join(sorted(known))}" for k in unknown]
    problems += [f"{name}: key {k!r} is missing" for k in missing]
    for key in ("scale", "offset", "time_scale", "time_offset", "value", "stop", "per_volt", "clock_deviation"):
        if key == "scale" and entry.get(key) == ASKED:
            problems.append(
                f"{name}: scale is still '{ASKED}': expected a number, of an eRPM 1 / pole pairs of the motor"
            )
        elif key in entry and not _is_number(entry[key]):
            problems.append(f"{name}: {key}: expected a number, found {entry[key]!r:.80}")
        elif key in ("time_scale", "per_volt", "clock_deviation") and key in entry and entry[key] <= 0:
            problems.append(f"{name}: {key}: expected a positive number, found {entry[key]!r:.80}")
        elif key == "time_offset" and key in entry and abs(entry[key]) > MOST_OFFSET:
            problems.append(f"{name}: {key}: expected at most {MOST_OFFSET:g} s, found {entry[key]!r:.80}")
    if len(problems) > before:
        return None
    convert = _conversion(name, entry, unit, problems)
    if constant:
        if convert is None:
            return None
        value = float(entry["value"]) if convert == (1.0, 0.0) else convert.factor * (entry["value"] + convert.offset)
        return Constant(channel=name, topic=topic, type=kind, path=path, unit=unit, value=value)
    return _mapped(Entry(channel=name, topic=topic, type=kind, path=path, unit=unit), entry, convert, problems)


def _mapped(own: Entry, entry: Mapping[str, Any], convert: Conversion | None, problems: list[str]) -> Mapped | None:
    before, name = len(problems), own.channel
    places = [key for key in ("column", "field") if key in entry]
    if len(places) != 1:
        problems.append(f"{name}: expected column (of a table) or field (of a bag or log), found {places or 'neither'}")
    for key in (*places, "time_column"):
        if key in entry:
            check_column(name, key, entry, problems)
    if entry.get("sign", 1) not in (1, -1) or isinstance(entry.get("sign"), bool):
        problems.append(f"{name}: sign: expected 1 or -1, found {entry['sign']!r:.80}")
    if "hold" in entry and entry["hold"] not in HOLDS:
        problems.append(f"{name}: hold: expected one of {', '.join(HOLDS)}, found {entry['hold']!r:.80}")
    if "clock_deviation" in entry and own.kind not in CLOCKS:
        problems.append(f"{name}: clock_deviation: expected of topics {', '.join(CLOCKS)} of a thruster alone")
    if not isinstance(entry.get("file", ""), str):
        problems.append(f"{name}: file: expected a file's name, found {entry['file']!r:.80}")
    beside_field = [key for key in TIMES if "field" in entry and key in entry]
    problems += [f"{name}: {key}: expected beside column alone (a bag or log brings its times)" for key in beside_field]
    where = _rows(name, entry, problems)
    if "time_unit" in entry and "time_scale" in entry:
        problems.append(f"{name}: expected time_unit or time_scale, found both")
    time_scale = float(entry.get("time_scale", 0.0))
    if "time_unit" in entry:
        time_scale = seconds_of(f"{name}: time_unit", entry["time_unit"], problems)
    if len(problems) > before or convert is None:
        return None
    given = entry.get("nan", [])
    marks = given if isinstance(given, list) else [given]
    sign = float(entry.get("sign", 1))
    return Mapped(
        channel=name, topic=own.topic, type=own.type, path=own.path, unit=own.unit,
        column=entry[places[0]], is_field=places[0] == "field", file=entry.get("file", ""), where=where,
        time_column=entry.get("time_column"), time_scale=time_scale,
        scale=sign * float(entry.get("scale", 1.0)), offset=sign * float(entry.get("offset", 0.0)) + 0.0,  # no -0
        convert=convert, given_unit=spelled(str(entry["unit"] or own.unit)), nan=frozenset(str(m) for m in marks),
        hold=entry.get("hold", ""), clock_deviation=float(entry.get("clock_deviation", 0.0)),
        time_offset=float(entry.get("time_offset", 0.0)),
    )  # fmt: skip


def _conversion(name: str, entry: Mapping[str, Any], unit: str, problems: list[str]) -> Conversion | None:
    """Return what brings the given unit to the channel's, None (and a problem) where nothing does."""
    given = entry.get("unit", unit)
    if not isinstance(given, str):
        given = str(given) if isinstance(given, int) and not isinstance(given, bool) else ""
    if given == ASKED:
        problems.append(f"{name}: {_still_asked(unit)}" + (f", {', '.join(COMMANDS)}" if unit == "V" else ""))
        return None
    scale = [key for key in ("stop", "per_volt") if key in entry]
    if unit == "V" and spelled(given) in COMMANDS and "unit" in entry:
        if len(scale) == 2:
            return Conversion(1.0 / float(entry["per_volt"]), -float(entry["stop"]))
        problems.append(
            f"{name}: {given!r} is no voltage: expected stop (the command at rest) and per_volt (how many {given} make "
            "a volt, as in the parameter set's `command`) too"
        )
        return None
    if scale:
        problems.append(f"{name}: {', '.join(scale)}: expected beside a voltage given in {', '.join(COMMANDS)} alone")
        return None
    found = conversion(given, unit) if given or unit == "1" else None
    if found is None:
        hint = f"; of an amplifier say `unit: {unit}`, with `scale` and `offset`" if unit in ("N", "N m") else ""
        hint = hint if conversion(given, "V") is not None else ""
        problems.append(
            f"{name}: expected unit {unit!r} or one that becomes it ({accepted(unit)}), found {given!r:.80}{hint}"
        )
    return found


def _rows(name: str, entry: Mapping[str, Any], problems: list[str]) -> tuple[tuple[str | int, str], ...]:
    """Return the columns and cells of the rows that an entry takes, none where it takes all."""
    told = entry.get("where")
    if told is None:
        return ()
    if "field" in entry:
        problems.append(f"{name}: where: expected beside column alone (a bag's or log's topics are apart)")
        return ()
    cells = list(told.items()) if isinstance(told, Mapping) else []
    known = [
        _can_be_column(column) and isinstance(cell, str | int | float) and not isinstance(cell, bool)
        for column, cell in cells
    ]
    if not cells or not all(known):
        problems.append(f"{name}: where: expected {{column: text or number of its cells}}, found {told!r:.80}")
        return ()
    return tuple((column, str(cell).strip()) for column, cell in cells)


def check_column(name: str, key: str, entry: Mapping[str, Any], problems: list[str]) -> None:
    """Add a problem where what an entry calls a column or field can be none."""
    value = entry[key]
    if not _can_be_column(value) or (key == "field" and not isinstance(value, str)):
        what = "topic.field" if key == "field" else "a name or a number from 1"
        problems.append(f"{name}: {key}: expected {what}, found {value!r:.80}")


def _can_be_column(value: Any) -> bool:
    """Tell whether a value is a name or a number from 1."""
    numbered = isinstance(value, int) and not isinstance(value, bool)
    return bool((isinstance(value, str) and value) or (numbered and value >= 1))


def seconds_of(name: str, unit: Any, problems: list[str]) -> float:
    """Return how many seconds a unit of time is, 1 (and a problem) where it is none."""
    if unit == ASKED:
        problems.append(f"{name}: {_still_asked('s')}")
        return 1.0
    factor = conversion(unit, "s") if isinstance(unit, str) else None
    if factor is None:
        problems.append(f"{name}: expected a unit of time ({accepted('s')}), found {unit!r:.80}")
        return 1.0
    return factor.factor


def _still_asked(unit: str) -> str:
    return (
        f"unit is still '{ASKED}': expected that of the recording, which nothing in it tells: one of {accepted(unit)}"
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
