"""The map from a recording of anyone's to channels: one YAML form for tables, bags and logs.

    time: {column: t, unit: ms}          # of tables, or a list of them; bags and logs bring their own
    thruster_0/throttle.commanded: {field: RCOU.C1, unit: us, stop: 1500, per_volt: 80, hold: previous}
    thruster_0/state.n: {column: rpm, unit: rpm, sign: -1}
    thruster_0/state.sign_source: {value: 1}                           # one value in all messages

`column` is a name of the header line or a number from 1, `field` a topic.field of a bag or a MESSAGE.field of a log.
value = sign * (scale * cell + offset), in `unit`, which is then brought to the channel's own; a throttle in µs, % or
1 is (value - stop) / per_volt volts. Cells equal to one of `nan`, empty ones and `nan` in any case are not measured.
`hold` says what a signal does between its samples, `clock_deviation` by how much the clock of throttle or flow may be
off [s] (standard deviation); both go into the run's metadata. An attitude is a quaternion
(`rov/imu.orientation.w`, x, y, z) or angles (`rov/imu.orientation.roll`, pitch, yaw).

    axes: {rov/imu: rep103}                                            # topics in REP 103's axes: ENU, FLU
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from safe_files.yaml_io import yaml_mapping

from ..alignment import HOLDS
from ..definitions import definitions
from ..errors import RecordingError
from ..known_topics import known_topics, topic_type
from ..units import UNITS
from .axes import ANGLES, PARTS, REP103, unit_in_map
from .conversions import COMMANDS, Conversion, accepted, conversion, spelled

TIME_KEYS = {"column", "unit"}
CSV_KEYS = {"separator", "decimal"}
KEYS = {
    "column", "field", "file", "unit", "time_column", "time_unit", "time_scale", "scale", "offset", "sign", "nan",
    "hold", "stop", "per_volt", "clock_deviation",
}  # fmt: skip
TIMES = ("time_column", "time_unit", "time_scale")
CLOCKS = ("throttle", "flow")
"""Kinds of topics of which a run can state by how much their clock may be off."""
CONSTANT_KEYS = {"value", "unit"}
TOP = {"time", "csv", "axes"}
SAME = Conversion(1.0)
ASKED = "?"
"""The unit of a proposal where neither the name nor the values say it: to be written by a person."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What every entry of the map says: the channel as written, and its topic, type, field and unit."""

    channel: str
    topic: str
    type: str
    path: str
    unit: str

    @property
    def kind(self) -> str:
        """Its topic without the thruster: "throttle"."""
        return self.topic.rsplit("/", 1)[-1]


@dataclass(frozen=True, kw_only=True)
class Mapped(Entry):
    """A channel out of a column or field.

    Attributes:
        column: its name in the recording, or its number from 1; `is_field` where the map calls it `field`.
        file: name of the file it is in, "" where one file alone has it.
        time_column: of a table; None where the entry has none of its own.
        time_scale: brings the time column to seconds; 0 where the entry does not say.
        nan: cells that mean "not measured".
        hold: what the signal does between its samples, "" where the map does not say.
        clock_deviation: by how much its clock may be off [s], 0 where the map does not say.
    """

    column: str | int
    is_field: bool = False
    file: str = ""
    time_column: str | int | None = None
    time_scale: float = 0.0
    scale: float = 1.0
    offset: float = 0.0
    convert: Conversion = SAME
    given_unit: str = ""
    nan: frozenset[str] = field(default_factory=frozenset)
    hold: str = ""
    clock_deviation: float = 0.0

    @property
    def topic_of_field(self) -> str:
        """The topic of a bag that its field is of."""
        return str(self.column).strip("/").partition(".")[0]

    @property
    def how(self) -> str:
        """How cells become values, for the run's metadata."""
        text = f"value = {self.scale:g} * cell + {self.offset:g}"
        if self.unit == "V" and self.given_unit in COMMANDS:  # the map's own numbers, as no table of units has them
            volts = f"(value - {-self.convert.offset:g}) / {1.0 / self.convert.factor:g} {self.unit}"
            return f"{text} in {self.given_unit}, brought to {volts}"
        return text if self.convert == (1.0, 0.0) else f"{text} in {self.given_unit}, brought to {self.unit}"


@dataclass(frozen=True, kw_only=True)
class Constant(Entry):
    """A channel that has one value in all messages of its topic."""

    value: float


@dataclass(frozen=True, kw_only=True)
class RecordingMap:
    """A whole map, checked: its entries, and what it says about tables of text ("" where it does not).

    Attributes:
        rep103: topics that are recorded in REP 103's axes.
        times: column and what brings it to seconds, of each `time`; of several a table's is the first that it has.
    """

    entries: tuple[Mapped | Constant, ...]
    times: tuple[tuple[str | int, float], ...] = ()
    rep103: frozenset[str] = frozenset()
    separator: str = ""
    decimal: str = ""

    @property
    def mapped(self) -> tuple[Mapped, ...]:
        """The entries that come out of a column or field."""
        return tuple(e for e in self.entries if isinstance(e, Mapped))

    def holds(self) -> dict[str, str]:
        """Return what each kind of topic ("throttle") does between its samples, as far as the map says."""
        return {e.kind: e.hold for e in self.mapped if e.hold}

    def clock_deviations(self) -> dict[str, float]:
        """Return by how much the clocks of each kind of topic ("flow") may be off [s], as far as the map says."""
        own = [e for e in self.mapped if e.clock_deviation]
        return {kind: max(e.clock_deviation for e in own if e.kind == kind) for kind in {e.kind for e in own}}


def read_map(path: Path) -> RecordingMap:
    """Read and check a map.

    Raises:
        RecordingError: all that is wrong with it.
    """
    return _checked(yaml_mapping(path, _refused), str(path))


def parse_map(text: str) -> RecordingMap:
    """Read and check the text of a map; see `read_map`."""
    return _checked(yaml_mapping(text, _refused, "map"), "map")


def _checked(content: Mapping[Any, Any], origin: str) -> RecordingMap:
    if not set(content) - TOP:
        raise _refused(origin, ["expected entries `channel: {column or field, unit}`, found none"])
    problems: list[str] = []
    told = content.get("time")
    times = tuple(filter(None, (_time(each, problems) for each in (told if isinstance(told, list) else [told]))))
    text = _table(content.get("csv"), problems)
    made = [_entry(str(name), entry, problems) for name, entry in content.items() if name not in TOP]
    entries = [e for e in made if e is not None]
    for e in entries:
        if isinstance(e, Mapped) and not e.is_field and e.time_column is None:
            own = set(TIMES[1:]) & set(content[e.channel])
            if not times:
                problems.append(f"{e.channel}: key 'time_column' is missing, and there is no `time: {{column, unit}}`")
            elif own and len(times) > 1:
                problems.append(f"{e.channel}: {own.pop()}: expected beside time_column, as `time` has several")
    problems += _crossing(entries)
    rep103 = _axes(content.get("axes"), entries, problems)
    if problems:
        raise _refused(origin, problems)
    return RecordingMap(entries=tuple(entries), rep103=rep103, times=times, **text)


def _refused(origin: str, problems: list[str]) -> RecordingError:
    """Return the error about a map: a line for each sentence, with all channels of which it is true."""
    channels: dict[str, list[str]] = {}
    for problem in problems:
        channel, colon, sentence = problem.partition(": ")
        channels.setdefault(colon + sentence, []).append(channel)
    lines = [f"{origin}: {', '.join(of)}{sentence}" for sentence, of in channels.items()]
    return RecordingError("\n".join(lines), path=origin, found=problems)


def _time(entry: Any, problems: list[str]) -> tuple[str | int, float] | None:
    if entry is None:
        return None
    if not isinstance(entry, Mapping) or "column" not in entry or set(entry) - TIME_KEYS:
        problems.append(f"time: expected {{column, unit}}, or a list of them, found {entry!r:.80}")
        return None
    _check_column("time", "column", entry, problems)
    return entry["column"], _seconds("time", entry.get("unit", "s"), problems)


def _table(entry: Any, problems: list[str]) -> dict[str, str]:
    if entry is None:
        return {}
    known = {"separator": (",", ";", "\t", " ", "|"), "decimal": (".", ",")}
    if not isinstance(entry, Mapping) or not set(entry) <= CSV_KEYS:
        problems.append(f"csv: expected {{separator, decimal}}, found {entry!r:.80}")
        return {}
    for key, value in entry.items():
        if value not in known[key]:
            problems.append(f"csv: {key}: expected one of {known[key]}, found {value!r:.80}")
    return {key: str(value) for key, value in entry.items()}


def _axes(told: Any, entries: list[Mapped | Constant], problems: list[str]) -> frozenset[str]:
    """Return the topics that are in REP 103's axes; attitudes whose parts are not all there are problems."""
    there: dict[str, dict[str, set[str]]] = {}
    for e in entries:
        if e.topic.startswith("rov/"):
            head, _, part = e.path.rpartition(".")
            there.setdefault(e.topic, {}).setdefault(head, set()).add(part)
    if told is not None and not isinstance(told, Mapping):
        problems.append(f"axes: expected {{topic: {REP103}}}, found {told!r:.80}")
        told = None
    for topic, axes in (told or {}).items():
        if axes != REP103:
            problems.append(
                f"axes: {topic}: expected {REP103} (east, north, up; forward, port, up), found {axes!r:.80}"
            )
        if topic not in there:
            problems.append(f"axes: expected topics rov/... of this map, found {topic!r:.80}")
    rep103 = frozenset(map(str, told or {}))
    for topic, heads in there.items():
        for head, parts in heads.items():
            if not head.endswith("orientation"):
                continue
            wanted = set(ANGLES) if parts & set(ANGLES) else set(PARTS)
            if parts != wanted:
                which = "all of roll, pitch, yaw, or of w, x, y, z"
                problems.append(f"{topic}.{head}: expected {which}, found {', '.join(sorted(parts))}")
    return rep103


def _seconds(name: str, unit: Any, problems: list[str]) -> float:
    if unit == ASKED:
        problems.append(f"{name}: {_still_asked('s')}")
        return 1.0
    factor = conversion(unit, "s") if isinstance(unit, str) else None
    if factor is None:
        problems.append(f"{name}: expected a unit of time ({accepted('s')}), found {unit!r:.80}")
        return 1.0
    return factor.factor


def _entry(name: str, entry: Any, problems: list[str]) -> Mapped | Constant | None:
    before = len(problems)
    topic, dot, path = name.strip("/").partition(".")
    kind = topic_type(topic)
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
    for key in ("scale", "offset", "time_scale", "value", "stop", "per_volt", "clock_deviation"):
        if key in entry and not _is_number(entry[key]):
            problems.append(f"{name}: {key}: expected a number, found {entry[key]!r:.80}")
        elif key in ("time_scale", "per_volt", "clock_deviation") and key in entry and entry[key] <= 0:
            problems.append(f"{name}: {key}: expected a positive number, found {entry[key]!r:.80}")
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
            _check_column(name, key, entry, problems)
    if entry.get("sign", 1) not in (1, -1) or isinstance(entry.get("sign"), bool):
        problems.append(f"{name}: sign: expected 1 or -1, found {entry['sign']!r:.80}")
    if "hold" in entry and entry["hold"] not in HOLDS:
        problems.append(f"{name}: hold: expected one of {', '.join(HOLDS)}, found {entry['hold']!r:.80}")
    if "clock_deviation" in entry and own.kind not in CLOCKS:
        problems.append(f"{name}: clock_deviation: expected of topics {' or '.join(CLOCKS)} alone")
    if not isinstance(entry.get("file", ""), str):
        problems.append(f"{name}: file: expected a file's name, found {entry['file']!r:.80}")
    beside_field = [key for key in TIMES if "field" in entry and key in entry]
    problems += [f"{name}: {key}: expected beside column alone (a bag or log brings its times)" for key in beside_field]
    if "time_unit" in entry and "time_scale" in entry:
        problems.append(f"{name}: expected time_unit or time_scale, found both")
    time_scale = float(entry.get("time_scale", 0.0))
    if "time_unit" in entry:
        time_scale = _seconds(f"{name}: time_unit", entry["time_unit"], problems)
    if len(problems) > before or convert is None:
        return None
    given = entry.get("nan", [])
    marks = given if isinstance(given, list) else [given]
    sign = float(entry.get("sign", 1))
    return Mapped(
        channel=name, topic=own.topic, type=own.type, path=own.path, unit=own.unit,
        column=entry[places[0]], is_field=places[0] == "field", file=entry.get("file", ""),
        time_column=entry.get("time_column"), time_scale=time_scale,
        scale=sign * float(entry.get("scale", 1.0)), offset=sign * float(entry.get("offset", 0.0)) + 0.0,  # no -0
        convert=convert, given_unit=spelled(str(entry["unit"] or own.unit)), nan=frozenset(str(m) for m in marks),
        hold=entry.get("hold", ""), clock_deviation=float(entry.get("clock_deviation", 0.0)),
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
        problems.append(
            f"{name}: expected unit {unit!r} or one that becomes it ({accepted(unit)}), found {given!r:.80}"
        )
    return found


def _still_asked(unit: str) -> str:
    return (
        f"unit is still '{ASKED}': expected that of the recording, which nothing in it tells: one of {accepted(unit)}"
    )


def _check_column(name: str, key: str, entry: Mapping[str, Any], problems: list[str]) -> None:
    value = entry[key]
    numbered = isinstance(value, int) and not isinstance(value, bool) and key != "field"
    if not ((isinstance(value, str) and value) or (numbered and value >= 1)):
        what = "topic.field" if key == "field" else "a name or a number from 1"
        problems.append(f"{name}: {key}: expected {what}, found {value!r:.80}")


def _crossing(entries: list[Mapped | Constant]) -> list[str]:
    """Say what is wrong between entries: a channel twice, a constant without any column, holds that differ."""
    problems: list[str] = []
    first: dict[tuple[str, str], str] = {}
    holds: dict[str, str] = {}
    for e in entries:
        key = (e.topic.strip("/"), e.path)
        if key in first:
            problems.append(f"{e.channel}: expected each channel once, found it as {first[key]} too")
        first.setdefault(key, e.channel)
        if isinstance(e, Mapped) and e.hold and holds.setdefault(e.kind, e.hold) != e.hold:
            problems.append(f"{e.channel}: hold: expected {holds[e.kind]} as for other topics {e.kind}, found {e.hold}")
    measured = {e.topic for e in entries if isinstance(e, Mapped)}
    alone = [e.channel for e in entries if e.topic not in measured]
    problems += [f"{c}: expected a column of the same topic beside the constant, found none" for c in alone]
    return problems


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
