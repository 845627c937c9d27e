"""A proposal of a map, from the names, units and ranges that a recording has. To be read before it is used."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import RunError
from ..known_topics import topic_type
from ..units import unit_of
from .conversions import COMMANDS, conversion
from .csv_source import CsvSource
from .guessed_units import guessed_time_unit, guessed_unit
from .recording_map import Entry, Mapped
from .sources import Source


class _Rule(NamedTuple):
    """A channel (with {i} for the thruster), the names that suggest it, the format's unit where none is stated."""

    channel: str
    names: str
    unit: str


_RULES = (
    # ArduPilot's autopilot and MAVLink
    _Rule("thruster_{i}/throttle.commanded", r"RCOU\.C(?P<one>\d+)|SERVO_OUTPUT_RAW\.servo(?P<one2>\d+)_raw", "us"),
    _Rule("thruster_{i}/state.n", r"ESC\[(?P<zero>\d+)\]\.RPM|ESC_TELEMETRY_1_TO_4\.rpm\[(?P<zero2>\d+)\]", "rpm"),
    _Rule("thruster_{i}/state.supply_voltage", r"ESC\[(?P<zero>\d+)\]\.Volt", "V"),
    _Rule("thruster_{i}/state.current", r"ESC\[(?P<zero>\d+)\]\.Curr", "A"),
    _Rule("rov/battery.voltage", r"BAT(\[0\])?\.Volt|SYS_STATUS\.voltage_battery", "V"),
    _Rule("rov/imu.angular_velocity.{axis}", r"IMU(\[0\])?\.Gyr(?P<axis>[XYZ])", "rad/s"),
    _Rule("rov/imu.linear_acceleration.{axis}", r"IMU(\[0\])?\.Acc(?P<axis>[XYZ])", "m/s^2"),
    # tables and other bags: the whole name, or its last part
    _Rule("thruster_{i}/throttle.commanded", r"(throttle|command|cmd|pwm|esc|u)(_?(in|out|signal|v|us|cmd))?", ""),
    _Rule("thruster_{i}/state.n", r"(n|k?rpm|omega|tach\w*|(rotor|motor|prop\w*|rotational)_?(speed|rpm)|speed)", ""),
    _Rule("thruster_{i}/load.wrench.force.x", r"(thrust|force|load|load_?cell|f_?x|fx)(_measured|_x)?", ""),
    _Rule("thruster_{i}/load.wrench.torque.x", r"(torque|moment|q|m_?x|mx)(_measured|_x)?", ""),
    _Rule("thruster_{i}/flow.ambient", r"(ambient|flow|water|inflow)(_?(speed|flow|velocity))?", ""),
    _Rule("thruster_{i}/flow.axial", r"(axial|duct)(_?(speed|flow|velocity))?", ""),
    _Rule("thruster_{i}/state.supply_voltage", r"(supply|battery|bus|v_?bat\w*|vdc)(_?(volt\w*|v))?|voltage", ""),
    _Rule("thruster_{i}/state.current", r"(current|amps?|i)(_a)?", ""),
)  # fmt: skip
_TIME = re.compile(r"(t|time|timestamp|stamp|seconds|elapsed|(t_|time_?)(s|ms|us|ns|sec|usec|msec))", re.IGNORECASE)
_SUFFIX = re.compile(r"_(us|ms|ns|rpm|kgf|gf|lbf|n|nm|v|mv|a|ma|rad_s|rads|deg_s|hz|pct|percent)$", re.IGNORECASE)
_FULL = {"us": (1500, 80), "%": (0, 20), "1": (0, 0.2), "counts": (0, 1)}
"""`stop` and `per_volt` of a full command of 5 V, as in the sets of thrusters with such commands."""
SHOWN = 60


def guess(sources: Sequence[Source]) -> str:
    """Return a map as YAML text: what is likely as entries, everything else as comments."""
    clock, told = _clock(sources)
    lines = ["# A proposal: read it, correct it, and import with --map.", *told]
    taken: set[str] = set()
    left: list[str] = []
    for source in sources:
        for name in source.names():
            if isinstance(source, CsvSource) and (_is_time(name) or name == clock):
                continue
            proposed = _propose(source, name)
            seen = _seen(source, name)
            several = f", file: {source.path.name}" if len(sources) > 1 else ""
            if proposed is None or proposed[0] in taken:
                left.append(f"# {_quoted(name)}{seen}")
                continue
            channel, entry, why = proposed
            taken.add(channel)
            notes = ";".join(part for part in (seen, f" {why}" if why else "") if part)
            lines.append(f"{channel}: {{{entry}{several}}}{'   #' + notes if notes else ''}")
    lines += ["# Not recognised:", *left[:SHOWN]] if left else []
    lines += [f"# and {len(left) - SHOWN} more"] if len(left) > SHOWN else []
    return "\n".join(lines) + "\n"


def _clock(sources: Sequence[Source]) -> tuple[str, list[str]]:
    """Return the column of time of tables ("" where none is seen), and the lines of the map about it."""
    tables = [s for s in sources if isinstance(s, CsvSource)]
    if not tables:
        return "", []
    names = tables[0].names()
    found = next((name for name in names if _is_time(name)), "") or next(
        (name for name in names if _rises(tables[0], name)), ""
    )
    if found:
        unit, why = guessed_time_unit(_bare(found), tables[0].unit(found), _values(tables[0], found))
        return found, [f"time: {{column: {_quoted(found)}, unit: {_quoted(unit)}}}{'   # ' + why if why else ''}"]
    return "", ["time: {column: 1, unit: s}   # no column is called a time: is it the first one?"]


def _rises(table: CsvSource, name: str) -> bool:
    """Tell whether a column with a unit of time only rises."""
    stated = table.unit(name)
    values = _values(table, name) if stated and conversion(stated, "s") is not None else None
    return values is not None and values.size > 1 and bool(np.all(np.diff(values) > 0))


def _is_time(name: str) -> bool:
    return bool(_TIME.fullmatch(_bare(name)))


def _bare(name: str) -> str:
    """Return the name of a column without its unit in brackets."""
    return re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", name).strip().replace(" ", "_")


def _propose(source: Source, name: str) -> tuple[str, str, str] | None:
    """Return the channel that a name suggests, its entry's text, and what is to be known about its unit."""
    place = "column" if isinstance(source, CsvSource) else "field"
    if place == "field":
        topic, _, path = name.partition(".")
        if topic_type(topic) is not None and (unit := unit_of(str(topic_type(topic)), path, topic)):
            return name, f"field: {_quoted(name)}, unit: {_quoted(unit)}", ""
    bare = _bare(name) if place == "column" else name.strip().replace(" ", "_")
    tail = bare.rsplit(".", 1)[-1].rsplit("/", 1)[-1]
    # a number alone has its name from its topic
    of_topic = [bare.removesuffix(".data").rsplit("/", 1)[-1]] if tail == "data" else []
    words = [word for word in tail.split("_") if len(word) > 1] if place == "column" else []
    stem, number = _numbered(tail, source) if place == "column" else (tail, 0)
    # the whole name first; single words of it only where no rule knows that
    for candidates, thruster in (
        ((bare, tail, _SUFFIX.sub("", tail), *of_topic), 0),
        ((stem, _SUFFIX.sub("", stem)), number),
        (words, number),
    ):
        for rule in _RULES:
            for candidate in candidates:
                if match := re.fullmatch(rule.names, candidate, re.IGNORECASE):
                    return _entry(rule, match, name, bare, place, source, thruster)
    return None


def _numbered(name: str, source: Source) -> tuple[str, int]:
    """Return the name without a number at its end, and the thruster that it is: they count from 0 or from 1."""
    match = re.fullmatch(r"(.*[^\W\d_])_?(\d{1,2})", name)
    if match is None:
        return name, 0
    first = any(re.fullmatch(re.escape(match[1]) + "_?0", _bare(other)) for other in source.names())
    return match[1], max(int(match[2]) - (0 if first else 1), 0)


def _entry(
    rule: _Rule, match: re.Match[str], name: str, bare: str, place: str, source: Source, thruster: int
) -> tuple[str, str, str]:
    groups = {key.rstrip("2"): value for key, value in match.groupdict().items() if value is not None}
    number = int(groups["one"]) - 1 if "one" in groups else int(groups.get("zero", thruster))
    channel = rule.channel.format(i=number, axis=groups.get("axis", "").lower())
    topic, _, path = channel.partition(".")
    ours = unit_of(str(topic_type(topic)), path, topic)
    command = path == "commanded"
    unit, why = guessed_unit(ours, bare, source.unit(name), _values(source, name), usual=rule.unit, command=command)
    text = f"{place}: {_quoted(name)}, unit: {_quoted(unit)}"
    if command and unit in COMMANDS:
        stop, per_volt = _FULL[unit]
        text += f", stop: {stop}, per_volt: {per_volt:.4g}"
    return channel, text + (", hold: previous" if command else ""), why


def _values(source: Source, name: str) -> np.ndarray | None:
    try:
        if isinstance(source, CsvSource):
            values = source.numbers(source.names().index(name))
        else:
            own = Entry(channel=name, topic="", type="", path="", unit="")
            entry = Mapped(**vars(own), column=name, is_field=True)
            if not source.has(entry):
                return None
            values = source.series(entry).values
    except RunError:
        return None
    return values if np.isfinite(values).any() else None


def _seen(source: Source, name: str) -> str:
    values = _values(source, name)
    if values is None:
        return " no numbers"
    unit = source.unit(name)
    return f" {np.nanmin(values):.4g} to {np.nanmax(values):.4g}{' ' + unit if unit else ''}, {values.size} samples"


def _quoted(text: str) -> str:
    """Return a text as YAML that is read back as that text."""
    plain = re.fullmatch(r"[A-Za-z_/][\w./ ^-]*[\w]|[A-Za-z_/]", text) and text.lower() not in ("null", "true", "false")
    return text if plain else "'" + " ".join(text.split()).replace("'", "''") + "'"
