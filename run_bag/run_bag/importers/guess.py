"""A proposal of a map, from the names, units and ranges that a recording has. To be read before it is used."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from ..known_topics import topic_type
from ..units import unit_of
from .axes import ANGLES, PARTS, unit_in_map
from .bag_source import BagSource
from .column_names import bare_name, without_unit
from .conversions import COMMANDS, conversion, spelled
from .csv_source import CsvSource
from .guess_rules import (
    BY_UNIT,
    LOGS,
    OF_BENCH,
    OF_TYPE,
    THRUSTER,
    UNTOLD,
    VEHICLE,
    WHICH_FLOW,
    WHOSE_ATTITUDE,
    OfType,
    Rule,
)
from .guessed_axes import axes_lines
from .guessed_clock import clock_of, is_time, own_times, time_of, unit_of_time, values_of
from .guessed_commands import alike_commands, moves
from .guessed_depth import WHICH_WATER, depths_of_pressures
from .guessed_names import beside, numbered, told_units, told_words, without_suffix
from .guessed_turning import gyro_by_attitude
from .guessed_units import fits, guessed_unit, named_units
from .log_source import LogSource
from .recording_map import ASKED
from .sources import Array, Source

_FULL = {"us": (1500, 80), "%": (0, 20), "1": (0, 0.2), "counts": (0, 1)}
"""`stop` and `per_volt` of a full command of 5 V, as in the sets of thrusters with such commands."""
SHOWN = 60


class _Found(NamedTuple):
    """A column or field that is likely a channel: its name, the format's unit ("" where it has none), its sign;
    entry: its unit and what belongs to it, where nothing is left to guess; why: what else than its name says so."""

    channel: str
    source: Source
    name: str
    usual: str = ""
    sign: int = 1
    entry: str = ""
    why: str = ""

    @property
    def topic(self) -> str:
        return self.channel.partition(".")[0]

    @property
    def group(self) -> str:
        """The vector or attitude of which it is a part: their unit is one."""
        head, _, part = self.channel.rpartition(".")
        return head if self.topic.startswith("rov/") and part in (*PARTS, *ANGLES) else self.channel


def guess(sources: Sequence[Source]) -> str:
    """Return a map as YAML text: what is likely as entries, everything else as comments."""
    clock, told = _clock(sources)
    found: dict[str, _Found] = {}
    of_topic: dict[str, str] = {}
    left: list[tuple[Source, str]] = []
    vehicle = any(map(_of_vehicle, sources))
    for source in sources:
        rules, types = _rules(source, vehicle=vehicle)
        times: set[str] = set()
        if isinstance(source, CsvSource):
            named = (name for name in source.names() if is_time(source, name))
            times = {_clock_in(source, clock), *own_times(source), *named}
        proposed = {name: _propose(source, name, rules, types) for name in _in_order(source) if name not in times}
        unfilled = _nobody_fills([each for each in proposed.values() if each])
        for name, each in proposed.items():
            topic = f"{source.path} {name.partition('.')[0]}" if isinstance(source, BagSource) else ""
            if (
                each is None
                or each.channel in found
                or name in unfilled
                or (each.topic.startswith("rov/") and of_topic.setdefault(each.topic, topic) != topic)
            ):
                left.append((source, name))
            else:
                found[each.channel] = each
    for each in [*_parted(found.values()), *_behind_the_last(found.values())]:
        del found[each.channel]
        left.append((each.source, each.name))
    columns = [(source, name) for source, name in left if isinstance(source, CsvSource)]
    fields = [(source, name) for source, name in left if not isinstance(source, LogSource)]
    unnamed = [] if any(channel.endswith(".commanded") for channel in found) else _commands(fields)
    for each in [*unnamed, *(_by_pressure(columns) if vehicle else _by_unit(columns))]:
        if each.channel not in found and (each.source, each.name) in left:
            found[each.channel] = each
            left.remove((each.source, each.name))
    for each in _attitude_apart(found.values(), clock):
        found[each.channel] = each._replace(why=WHOSE_ATTITUDE)
    names = Counter(name for source in sources for name in source.names())
    groups: dict[str, list[_Found]] = {}
    for each in found.values():
        groups.setdefault(each.group, []).append(each)
    force = _rows(groups.get("rov/imu.linear_acceleration", []))
    entries = [
        _line(each, groups[each.group], clock, shared=names[each.name] > 1, force=list(force.values()))
        for each in found.values()
    ]
    entries = gyro_by_attitude(sources, told, entries)
    head = ["# A proposal: read it, correct it, and import with --map.", *told]
    if not any(channel.endswith(".commanded") for channel in found):
        head.append("# No command of a thruster was recognised, and nothing is done without one: which field is it?")
    lines = [*head, *_axes(found.values(), sources, [*told, *entries]), *entries]
    left = [(source, name) for source, name in left if isinstance(source, CsvSource) or not UNTOLD.search(name)]
    empty = {each for each in left if not isinstance(each[0], CsvSource) and _is_0(*each)}
    left = [each for each in left if each not in empty]
    left.sort(key=lambda each: _never_changes(*each))
    lines += ["# Not recognised:"] if left else []
    lines += [f"# {_quoted(name)}{_seen(source, name)}" for source, name in left[:SHOWN]]
    lines += [f"# and {len(left) - SHOWN} more"] if len(left) > SHOWN else []
    lines += [f"# 0 in all messages: {len(empty)} fields more"] if empty else []
    return "\n".join(lines) + "\n"


def _parted(found: Iterable[_Found]) -> list[_Found]:
    """Return parts of attitudes that make none: without the others, or angles beside a quaternion."""
    parts: dict[str, dict[str, _Found]] = {}
    for each in found:
        head, _, part = each.channel.rpartition(".")
        if head.endswith("orientation"):
            parts.setdefault(head, {})[part] = each
    return [
        each
        for own in parts.values()
        for kept in [next((names for names in (PARTS, ANGLES) if set(names) <= set(own)), ())]
        for part, each in own.items()
        if part not in kept
    ]


def _attitude_apart(found: Iterable[_Found], clock: str) -> list[_Found]:
    """Return the parts of an attitude in tables that has another time than the gyro: it may not be the IMU's."""
    places: dict[str, list[tuple[Any, _Found]]] = {"rov/imu.orientation": [], "rov/imu.angular_velocity": []}
    for each in found:
        if each.group in places and isinstance(each.source, CsvSource):
            places[each.group].append(((each.source.path, _own_clock(each.source, each.name, clock)), each))
    attitude, gyro = places.values()
    return [each for place, each in attitude if gyro and place not in [other for other, _ in gyro]]


def _behind_the_last(found: Iterable[_Found]) -> list[_Found]:
    """Return a log's outputs behind the last one that ever moves: it has more of them than there are thrusters."""
    commands = [e for e in found if isinstance(e.source, LogSource) and e.channel.endswith(".commanded")]
    moving = [k for k, e in enumerate(commands) if moves(e.source, e.name)]
    return commands[max(moving, default=-1) + 1 :]


def _nobody_fills(proposed: Sequence[_Found]) -> set[str]:
    """Return the fields of a bag or log that are 0 in all messages, as where nothing is measured. Commands may be, and
    a part of a vector."""
    parts: dict[tuple[str, str], list[_Found]] = {}
    for each in proposed:
        if not (each.channel.endswith(".commanded") or each.entry or isinstance(each.source, CsvSource)):
            parts.setdefault((each.name.partition(".")[0], each.group), []).append(each)
    return {each.name for own in parts.values() if all(_is_0(e.source, e.name) for e in own) for each in own}


@lru_cache(maxsize=4096)  # more fields than the largest logs have
def _span(source: Source, name: str) -> tuple[int, float, float] | None:
    """Return how many numbers a column or field has, the least and the largest; None: none. It is read once."""
    values = values_of(source, name)
    return None if values is None else (int(np.isfinite(values).sum()), np.nanmin(values), np.nanmax(values))


def _is_0(source: Source, name: str) -> bool:
    span = _span(source, name)
    return span is not None and span[1] == span[2] == 0.0


def _never_changes(source: Source, name: str) -> bool:
    span = _span(source, name)
    return span is None or span[1] == span[2]


def _commands(fields: Sequence[tuple[Source, str]]) -> list[_Found]:
    """Return commands of several thrusters that their units or values tell."""
    return [
        _Found(
            f"thruster_{each.thruster}/throttle.commanded",
            each.source,
            each.name,
            why=f" by its {each.told} alone: is it?",
        )
        for each in alike_commands(fields)
    ]


def _by_pressure(columns: Sequence[tuple[CsvSource, str]]) -> list[_Found]:
    """Return the depth as pressures tell it."""
    return [
        _Found("rov/depth.depth", source, name, entry=entry, why=WHICH_WATER)
        for source, name, entry in depths_of_pressures(columns)
    ]


def _by_unit(columns: Sequence[tuple[CsvSource, str]]) -> list[_Found]:
    """Return channels of a thruster that the unit of one column alone, stated or in its name, leaves no doubt about."""
    found: dict[str, list[_Found]] = {}
    for source, name in columns:
        unit = source.unit(name) or ["", *named_units(name)][-1]
        channel = next((c for ours, c in BY_UNIT.items() if unit and conversion(spelled(unit), ours) is not None), "")
        if channel and values_of(source, name) is not None:
            each = _Found(channel.format(i=0), source, name, why=" by its unit alone: is it?")
            found.setdefault(each.channel, []).append(each)
    return [each for (each, *others) in found.values() if not others]


def _clock(sources: Sequence[Source]) -> tuple[str, list[str]]:
    """Return the column of time of tables ("" where none is seen), and the lines of the map about it."""
    found = clock_of(sources)
    if found is None:
        return "", []
    table, name = found
    if not name:
        return "", ["time: {column: 1, unit: s}   # no column is called a time: is it the first one?"]
    tables = [source for source in sources if isinstance(source, CsvSource) and name in source.names()]
    guesses = [unit_of_time(each, name) for each in tables]
    unit, why = next((each for each in guesses if each.unit != ASKED), guesses[0])  # one entry serves all of them
    if not is_time(table, name) and name not in own_times(table):
        why = "; ".join(filter(None, (why, "its values rise: is it the time?")))
    return name, [f"time: {{column: {_quoted(name)}, unit: {_quoted(unit)}}}{'   # ' + why if why else ''}"]


def _rules(source: Source, *, vehicle: bool) -> tuple[tuple[Rule, ...], tuple[OfType, ...]]:
    """Return the rules of names and those of types for a source."""
    if isinstance(source, LogSource):
        return LOGS, ()
    return ((*LOGS, *VEHICLE, *THRUSTER), OF_TYPE) if vehicle else ((*LOGS, *THRUSTER), (*OF_BENCH, *OF_TYPE))


def _in_order(source: Source) -> list[str]:
    """Return the names of a source; of a log those first that go before others of their channel."""
    if not isinstance(source, LogSource):
        return source.names()
    ranks = {name: [k for k, rule in enumerate(LOGS) if re.fullmatch(rule.names, name)] for name in source.names()}
    return sorted(ranks, key=lambda name: (not ranks[name], ranks[name]))


def _of_vehicle(source: Source) -> bool:
    """Tell whether a table has several thrusters, or a gyro, and a bag messages of an IMU."""
    if isinstance(source, BagSource):
        return bool({"sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry"} & set(source.types.values()))
    if not isinstance(source, CsvSource):
        return False
    found = {name: _propose(source, name, THRUSTER) for name in source.names()}
    commands = {each.channel for each in found.values() if each and each.channel.endswith(".commanded")}
    gyro = [rule for rule in VEHICLE if "angular_velocity" in rule.channel]
    unnamed = [] if commands else _commands([(source, name) for name, each in found.items() if each is None])
    return len(commands) > 1 or bool(unnamed) or any(_propose(source, name, gyro) for name in source.names())


def _propose(source: Source, name: str, rules: Sequence[Rule], types: Sequence[OfType] = ()) -> _Found | None:
    """Return the channel that a name suggests."""
    table = isinstance(source, CsvSource)
    if not table:
        topic, _, path = name.partition(".")
        if topic_type(topic) is not None and (unit := unit_of(str(topic_type(topic)), path, topic)):
            return _Found(name, source, name, entry=f"unit: {_quoted(unit)}")
        kind = source.types.get(topic, "") if isinstance(source, BagSource) else ""
        typed = [each for each in types if re.fullmatch(each.types, kind)]
        for each in typed:
            match = re.fullmatch(each.path, path)
            if match and re.search(each.topics, topic):
                channel = each.channel.format(path=path, **match.groupdict())
                return _Found(channel, source, name, each.unit, entry=each.entry, why=each.why)
        if typed:
            return None
    whole = (without_unit(name) if table else name.strip()).replace(" ", "_")
    bare = bare_name(name) if table else whole
    tail = re.split("[./]", whole)[-1]
    # a number alone has its name from its topic
    of_topic = [whole.removesuffix(".data").rsplit("/", 1)[-1]] if tail == "data" else []
    words, wanted = told_words(tail) if table else ([], False)
    stem, number = numbered(bare, source.names()) if table else (tail, 0)
    units = told_units(source, name, (bare, stem)) if isinstance(source, CsvSource) else []
    last = tail if stem.endswith(tail) else stem[len(bare) - len(tail) :]
    # the whole name first, then what is behind its last dot or slash; single words only where no rule knows these
    for candidates, known in (
        ((whole, bare, without_suffix(bare)), rules),
        ((stem, without_suffix(stem)), rules),
        ((tail, without_suffix(tail), *of_topic), rules),
        ((last, without_suffix(last)), rules),
        (words, [rule for rule in rules if not rule.alone and (not wanted or rule.channel.endswith(".commanded"))]),
    ):
        for rule in known:
            spelling = re.NOFLAG if rule in LOGS else re.IGNORECASE  # a log's fields are written as its format has them
            for candidate in candidates:
                match = re.fullmatch(rule.names, candidate, spelling)
                channel = _channel(rule, match, number) if match else ""
                known_units = not units or any(_may_be_in(channel, unit) for unit in units)
                if match and known_units and (not rule.together or set(rule.together) <= beside(source, name)):
                    return _Found(channel, source, name, rule.unit, rule.sign, rule.entry, rule.why)
    return None


def _may_be_in(channel: str, unit: str) -> bool:
    return fits(unit, _ours(channel), command=channel.endswith(".commanded"))


def _ours(channel: str) -> str:
    """Return the unit of a channel."""
    topic, _, path = channel.partition(".")
    return unit_in_map(str(topic_type(topic)), path, topic)


def _channel(rule: Rule, match: re.Match[str], thruster: int) -> str:
    groups = {key.rstrip("2"): value.lower() for key, value in match.groupdict().items() if value is not None}
    number = rule.first + (int(groups["one"]) - 1 if "one" in groups else int(groups.get("zero", thruster)))
    (last, *_) = [key for key in groups if key not in ("axis", "angle", "part")] or [""]  # (?P<x>surge): axis x
    own = {key: groups.get(key, last) for key in ("axis", "angle", "part")}
    return rule.channel.format(i=number, **own)


def _axes(found: Iterable[_Found], sources: Sequence[Source], lines: Sequence[str]) -> list[str]:
    """Return the map's lines about axes, of topics whose axes neither the format nor a name of ours says."""
    vectors = [each for each in found if each.topic in ("rov/imu", "rov/odometry", "rov/velocity")]
    topics = {each.topic for each in vectors if each.topic != "rov/odometry" or not each.usual}
    force = {e.channel[-1]: values_of(e.source, e.name) for e in vectors if "linear_acceleration" in e.channel}
    return axes_lines(topics, force, sources, lines)


def _line(each: _Found, group: Sequence[_Found], clock: str, *, shared: bool, force: Sequence[Array]) -> str:
    """Return the entry of a channel.

    Args:
        each: the channel.
        group: the parts of one field, whose unit is found from all their values.
        clock: the column of time of most tables; shared: whether several files have a column of that name.
        force: readings of the accelerometer's three axes, none where they are not known.
    """
    source, name = each.source, each.name
    table, notes = isinstance(source, CsvSource), _seen(source, name)
    place = "column" if table else "field"
    more = f", file: {source.path.name}" if shared else ""
    if isinstance(source, CsvSource):
        marks = ", ".join(map(_quoted, sorted(source.marks(source.names().index(name)))))
        more += _own_clock(source, name, clock) + (f", nan: [{marks}]" if marks else "")
    if each.entry:
        notes = ";".join(filter(None, (notes, each.why)))
        return f"{each.channel}: {{{place}: {_quoted(name)}, {each.entry}{more}}}   #{notes}"
    topic, _, path = each.channel.partition(".")
    command = path == "commanded"
    parts = [values for part in group if (values := values_of(part.source, part.name)) is not None]
    unit, why = guessed_unit(
        _ours(each.channel), bare_name(name) if table else name, source.unit(name),
        np.concatenate(parts) if parts else None, usual=each.usual, command=command, vehicle=topic == "rov/imu",
        vector=_rows(group), force=force,
    )  # fmt: skip
    text = f"{place}: {_quoted(name)}, unit: {_quoted(unit)}"
    if command and unit in COMMANDS:
        stop, per_volt = _FULL[unit]
        text += f", stop: {stop}, per_volt: {per_volt:.4g}"
        why = "; ".join(filter(None, (why, "stop and per_volt are guesses: write yours")))
    if command:
        why = "; ".join(filter(None, (why, "hold is a guess: previous or linear?")))
    own = values_of(source, name)
    as_ours = path == "current" and own is not None and np.nanmedian(own) < 0.0  # negative while it is drawn
    text += (", hold: previous" if command else "") + (", sign: -1" if each.sign < 0 and not as_ours else "")
    doubt = WHICH_FLOW if path == "ambient" and "ambient" not in name.lower() else ""
    notes = ";".join(part for part in (notes, f" {why}" if why else "", each.why, doubt) if part)
    return f"{each.channel}: {{{text}{more}}}{'   #' + notes if notes else ''}"


def _rows(parts: Sequence[_Found]) -> dict[str, Array]:
    """Return the readings of a vector's parts, row by row, which have rows of their own in a long table; {} where
    they are not of the same."""
    read = {each.channel.rpartition(".")[2]: values_of(each.source, each.name) for each in parts}
    told = {part: values[np.isfinite(values)] for part, values in read.items() if values is not None}
    return told if len(told) == len(read) and len({values.size for values in told.values()}) == 1 else {}


def _own_clock(source: CsvSource, name: str, clock: str) -> str:
    """Return the keys about the time of a column whose time is not that of most."""
    own = time_of(source, name) or _clock_in(source, clock)
    if own in ("", clock):
        return ""
    unit, _ = unit_of_time(source, own)
    return f", time_column: {_quoted(own)}, time_unit: {_quoted(unit)}"


def _clock_in(source: CsvSource, clock: str) -> str:
    """Return the column of time of a table: that of most, or its own."""
    return clock if not clock or clock in source.names() else (clock_of([source]) or (source, ""))[1]


def _seen(source: Source, name: str) -> str:
    span = _span(source, name)
    if span is None:
        return " no numbers"
    unit, (count, low, high) = source.unit(name), span
    told = f"always {low:.4g}" if low == high else f"{low:.4g} to {high:.4g}"
    return f" {told}{' ' + unit if unit not in ('', '1') else ''}, {count} samples"


def _quoted(text: str) -> str:
    """Return a text as YAML that is read back as that text."""
    plain = re.fullmatch(r"[A-Za-z_/][\w./ ^-]*[\w]|[A-Za-z_/]", text) and text.lower() not in ("null", "true", "false")
    return text if plain else "'" + " ".join(text.split()).replace("'", "''") + "'"
