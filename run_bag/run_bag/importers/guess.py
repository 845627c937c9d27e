"""A proposal of a map, from the names, units and ranges that a recording has. To be read before it is used."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..errors import RunError
from ..known_topics import topic_type
from ..units import unit_of
from .conversions import COMMANDS, conversion, spelled
from .csv_source import CsvSource
from .recording_map import Entry, Mapped
from .sources import Source


class _Rule(NamedTuple):
    """A channel (with {i} for the thruster), the names that suggest it, the unit where none is stated."""

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
    _Rule("thruster_{i}/state.n", r"(n|rpm|omega|tach\w*|(rotor|motor|prop\w*|rotational)_?(speed|rpm)|speed)", ""),
    _Rule("thruster_{i}/load.wrench.force.x", r"(thrust|force|load|load_?cell|f_?x|fx)(_measured|_x)?", "N"),
    _Rule("thruster_{i}/load.wrench.torque.x", r"(torque|moment|q|m_?x|mx)(_measured|_x)?", "N m"),
    _Rule("thruster_{i}/flow.ambient", r"(ambient|flow|water|inflow)(_?(speed|flow|velocity))?", "m/s"),
    _Rule("thruster_{i}/flow.axial", r"(axial|duct)(_?(speed|flow|velocity))?", "m/s"),
    _Rule("thruster_{i}/state.supply_voltage", r"(supply|battery|bus|v_?bat\w*|vdc)(_?(volt\w*|v))?|voltage", "V"),
    _Rule("thruster_{i}/state.current", r"(current|amps?|i)(_a)?", "A"),
)  # fmt: skip
_TIME = re.compile(r"(t|time|timestamp|stamp|seconds|elapsed|time_?(s|ms|us|ns|sec|usec|msec))", re.IGNORECASE)
_SUFFIX = re.compile(r"_(us|ms|ns|rpm|kgf|gf|lbf|n|nm|v|mv|a|ma|rad_s|rads|deg_s|hz|pct|percent)$", re.IGNORECASE)
_SUFFIX_UNITS = {"rad_s": "rad/s", "rads": "rad/s", "deg_s": "deg/s", "nm": "N m", "n": "N", "pct": "%", "v": "V",
                 "a": "A", "mv": "mV", "ma": "mA", "hz": "Hz"}  # fmt: skip
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
            channel, entry = proposed
            taken.add(channel)
            lines.append(f"{channel}: {{{entry}{several}}}{'   #' + seen if seen else ''}")
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
        return found, [f"time: {{column: {_quoted(found)}, unit: {_time_unit(tables[0], found)}}}"]
    return "", ["time: {column: 1, unit: s}   # no column is called a time: is it the first one?"]


def _rises(table: CsvSource, name: str) -> bool:
    """Tell whether a column with a unit of time only rises."""
    stated = table.unit(name)
    values = _values(table, name) if stated and conversion(stated, "s") is not None else None
    return values is not None and values.size > 1 and bool(np.all(np.diff(values) > 0))


def _is_time(name: str) -> bool:
    return bool(_TIME.fullmatch(re.sub(r"\s*[\[(].*", "", name).strip().replace(" ", "_")))


def _time_unit(table: CsvSource, name: str) -> str:
    stated = table.unit(name) or next(iter(re.findall(r"_(ms|us|ns|usec|msec)$", name, re.IGNORECASE)), "")
    if stated and conversion(stated, "s") is not None:
        return spelled(stated)
    try:
        steps = np.diff(table.numbers(table.names().index(name)))
    except RunError:
        return "s"
    usual = float(np.median(steps)) if steps.size else 0.0
    return "ns" if usual > 1e5 else "us" if usual > 500 else "ms" if usual >= 1 else "s"


def _propose(source: Source, name: str) -> tuple[str, str] | None:
    """Return the channel that a name suggests, and its entry's text."""
    place = "column" if isinstance(source, CsvSource) else "field"
    if place == "field":
        topic, _, path = name.partition(".")
        if topic_type(topic) is not None and (unit := unit_of(str(topic_type(topic)), path, topic)):
            return name, f"field: {_quoted(name)}, unit: {_quoted(unit)}"
    bare = re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", name) if place == "column" else name
    bare = bare.strip().replace(" ", "_")
    suffix = _SUFFIX.search(bare)
    tail = bare.rsplit(".", 1)[-1].rsplit("/", 1)[-1]
    # a number alone has its name from its topic
    of_topic = [bare.removesuffix(".data").rsplit("/", 1)[-1]] if tail == "data" else []
    stated = source.unit(name) or (_SUFFIX_UNITS.get(suffix[1].lower(), suffix[1]) if suffix is not None else "")
    words = [word for word in tail.split("_") if len(word) > 1] if place == "column" else []
    # the whole name first; single words of it only where no rule knows that
    for candidates in ((bare, tail, _SUFFIX.sub("", tail), *of_topic), words):
        for rule in _RULES:
            for candidate in candidates:
                if match := re.fullmatch(rule.names, candidate, re.IGNORECASE):
                    return _entry(rule, match, name, place, stated, source)
    return None


def _entry(
    rule: _Rule, match: re.Match[str], name: str, place: str, stated: str, source: Source
) -> tuple[str, str] | None:
    groups = {key.rstrip("2"): value for key, value in match.groupdict().items() if value is not None}
    number = int(groups["one"]) - 1 if "one" in groups else int(groups.get("zero", 0))
    channel = rule.channel.format(i=number, axis=groups.get("axis", "").lower())
    topic, _, path = channel.partition(".")
    ours = unit_of(str(topic_type(topic)), path, topic)
    unit = spelled(stated or rule.unit) if stated or rule.unit else _by_range(source, name, ours)
    command = ours == "V" and unit in COMMANDS
    if conversion(unit, ours) is None and not command:
        unit = ours
    text = f"{place}: {_quoted(name)}, unit: {_quoted(unit)}"
    if command:
        stop, per_volt = {"us": (1500, 80), "%": (0, 100 / 12), "counts": (0, 1)}.get(unit, (0, 1 / 12))
        text += f", stop: {stop}, per_volt: {per_volt:.4g}"
    return channel, text + (", hold: previous" if path == "commanded" else "")


def _by_range(source: Source, name: str, ours: str) -> str:
    """Return the unit that the values suggest."""
    values = _values(source, name)
    if values is None:
        return ours
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if ours == "V":
        return (
            "us" if 700 < low <= high < 2300 else "1" if -1.001 <= low <= high <= 1.001 else "%" if high > 60 else "V"
        )
    return "rpm" if ours == "rad/s" and max(-low, high) > 800 else ours


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
