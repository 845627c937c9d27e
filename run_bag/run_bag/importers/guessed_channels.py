"""Which channel each column or field of a recording likely is, by its name, unit, values or what is beside it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from ..known_topics import topic_type
from ..units import unit_of
from .axes import ANGLES, PARTS, unit_in_map
from .bag_source import BagSource
from .column_names import bare_name, without_unit
from .conversions import conversion, is_unit, spelled
from .csv_source import CsvSource
from .guess_rules import (
    BENCH,
    BY_TYPE,
    BY_UNIT,
    LOGS,
    OF_BENCH,
    OF_TYPE,
    OTHER_AXES,
    PX4,
    THRUSTER,
    VEHICLE,
    WHOSE_ATTITUDE,
    OfType,
    Rule,
    quoted,
)
from .guessed_clock import clock_in, is_time, own_times, time_of
from .guessed_commands import Alike, alike_commands, alike_speeds
from .guessed_depth import depth_by_unit, depths_of_pressures
from .guessed_names import beside, is_element, numbered, says_rate, told_units, told_words, without_suffix
from .guessed_units import fits, is_amplified
from .guessed_values import is_0, is_of_quaternion, is_unknown, moves, span_of, values_of
from .instances import counters_of, message_of
from .log_source import LogSource
from .sources import Source
from .unit_words import named_units

__all__ = ["Found", "channels_in", "ours_of"]


_AT_OTHERS = 0.1
"""Share by which an attitude has more or fewer readings than the gyro where it is told at other times; a few fail."""


class Found(NamedTuple):
    """A column or field that is likely a channel: its name, the format's unit ("" where it has none), its sign;
    entry: its unit and what belongs to it, where nothing is left to guess; why: what else than its name says so;
    by_word: a single word of its name says so, and a column with that word as its name goes before it."""

    channel: str
    source: Source
    name: str
    usual: str = ""
    sign: int = 1
    entry: str = ""
    why: str = ""
    by_word: bool = False

    @property
    def topic(self) -> str:
        return self.channel.partition(".")[0]

    @property
    def is_command(self) -> bool:
        return self.channel.endswith(".commanded")

    @property
    def is_doubtful(self) -> bool:
        """Tell whether another column goes before it: a word alone says what it is, or it is asked about, or it is a
        command that rests."""
        rests = self.is_command and isinstance(self.source, CsvSource) and not moves(self.source, self.name)
        return self.by_word or bool(self.why) or rests

    @property
    def group(self) -> str:
        """The vector or attitude of which it is a part: their unit is one."""
        head, _, part = self.channel.rpartition(".")
        return head if self.topic.startswith("rov/") and part in (*PARTS, *ANGLES) else self.channel


def channels_in(sources: Sequence[Source], clock: str) -> tuple[list[Found], list[tuple[Source, str]]]:
    """Return the likely channels of sources, and the columns and fields that none of them is.

    clock: the column of time of most tables, "" where none is seen.
    """
    found: dict[str, Found] = {}
    of_topic: dict[str, str] = {}
    left: list[tuple[Source, str]] = []
    vehicle = any(map(_of_vehicle, sources))
    of_sources = {source: _proposed(source, clock, vehicle=vehicle) for source in sources}
    sure = {e.channel for own in of_sources.values() for e in own.values() if e and not e.is_doubtful}
    for source, proposed in of_sources.items():
        unfilled = _nobody_fills([each for each in proposed.values() if each])
        for name, each in proposed.items():
            topic = f"{source.path} {name.partition('.')[0]}" if isinstance(source, BagSource) else ""
            if (
                each is None
                or each.channel in found
                or (each.is_doubtful and each.channel in sure)
                or name in unfilled
                or (each.topic.startswith("rov/") and isinstance(source, CsvSource) and not span_of(source, name))
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
    unnamed = [] if any(each.is_command for each in found.values()) else _commands(fields)
    thrusters = {each.channel.partition("/")[0] for each in [*found.values(), *unnamed] if each.is_command}
    told = _of_vehicle_by_unit(columns, thrusters) if vehicle else _by_unit(columns)
    one = not vehicle and thrusters <= {"thruster_0"} and not any(e.topic.startswith("rov/") for e in found.values())
    for each in [*unnamed, *told, *(_by_type(left) if one else [])]:
        if each.channel not in found and (each.source, each.name) in left:
            found[each.channel] = each
            left.remove((each.source, each.name))
    for each in _attitude_apart(found.values(), clock):
        found[each.channel] = each._replace(why=WHOSE_ATTITUDE)
    logged = [each for each in found.values() if each.topic == "rov/velocity"]
    for each in logged if len(logged) < 3 else ():
        found[each.channel] = each._replace(why=OTHER_AXES)
    return list(found.values()), left


def _proposed(source: Source, clock: str, *, vehicle: bool) -> dict[str, Found | None]:
    """Return the likely channel of each column or field of a source but its times."""
    rules, types = _rules(source, vehicle=vehicle)
    times: set[str] = set()
    if isinstance(source, CsvSource):
        named = (name for name in source.names() if is_time(source, name))
        times = {clock_in(source, clock), *own_times(source), *named, *counters_of(source)}
    return {name: _propose(source, name, rules, types) for name in _in_order(source) if name not in times}


def _parted(found: Iterable[Found]) -> list[Found]:
    """Return parts of attitudes that make none: without the others, or angles beside a quaternion."""
    parts: dict[str, dict[str, Found]] = {}
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


def _attitude_apart(found: Iterable[Found], clock: str) -> list[Found]:
    """Return the parts of an attitude in tables that has another time than the gyro, or is told at other rows: it may
    not be the IMU's."""
    places: dict[str, list[tuple[Any, int, Found]]] = {"rov/imu.orientation": [], "rov/imu.angular_velocity": []}
    for each in found:
        span = span_of(each.source, each.name)
        if each.group in places and isinstance(each.source, CsvSource) and span:
            place = each.source.path, time_of(each.source, each.name, clock)
            places[each.group].append((place, span.numbers, each))
    attitude, gyro = places.values()
    return [
        each
        for place, size, each in attitude
        if gyro and not any(place == own and abs(size - rows) < _AT_OTHERS * rows for own, rows, _ in gyro)
    ]


def _behind_the_last(found: Iterable[Found]) -> list[Found]:
    """Return outputs of a log, or of an array in a table, behind the last one that ever moves, and a table's
    that are always 0 behind the last one that is not: they are more than there are thrusters."""
    every = [e for e in found if e.is_command]
    of_table = [e for e in every if isinstance(e.source, CsvSource) and not is_element(e.source, e.name)]
    commands = [e for e in every if e not in of_table]
    moving = [k for k, e in enumerate(commands) if moves(e.source, e.name)]
    last = max((k for k, e in enumerate(of_table) if not is_0(e.source, e.name)), default=len(of_table))
    return [*commands[max(moving, default=-1) + 1 :], *of_table[last + 1 :]]


def _nobody_fills(proposed: Sequence[Found]) -> set[str]:
    """Return the fields of a bag or log that are 0 or unknown in all messages, as where nothing is measured, and
    attitudes that never change, or whose first covariance is -1 (REP 145). Commands may be 0, so may parts of vectors.
    """
    parts: dict[tuple[str, str], list[Found]] = {}
    for each in proposed:
        if not (each.is_command or each.entry or isinstance(each.source, CsvSource)):
            parts.setdefault((each.name.partition(".")[0], each.group), []).append(each)
    return {
        each.name
        for (_, group), own in parts.items()
        if all(is_0(e.source, e.name) or is_unknown(e.source, e.name) for e in own)
        or (group.endswith("orientation") and (not any(moves(e.source, e.name) for e in own) or _disowned(own[0])))
        for each in own
    }


def _disowned(part: Found) -> bool:
    """Tell whether all messages say that nobody measured this attitude."""
    covariance = span_of(part.source, f"{part.name.rpartition('.')[0]}_covariance[0]")
    return covariance is not None and covariance.low == covariance.high == -1.0


def _commands(fields: Sequence[tuple[Source, str]]) -> list[Found]:
    """Return commands of several thrusters that their units or values tell."""
    return [_of_thruster("throttle.commanded", each) for each in alike_commands(fields)]


def _of_thruster(path: str, each: Alike) -> Found:
    return Found(f"thruster_{each.thruster}/{path}", each.source, each.name, why=f" by its {each.told} alone: is it?")


def _of_vehicle_by_unit(columns: Sequence[tuple[CsvSource, str]], commanded: set[str]) -> list[Found]:
    """Return the speeds of commanded thrusters, and the depth as a pressure or a unit of length tells it."""
    speeds = alike_speeds(columns, {int(name.removeprefix("thruster_")) for name in commanded})
    return [
        *(_of_thruster("state.n", each) for each in speeds),
        *(
            Found("rov/depth.depth", source, name, entry=entry, why=why)
            for source, name, entry, why in depths_of_pressures(columns)
        ),
        *(Found("rov/depth.depth", *each, why=" by its unit alone: is it?") for each in depth_by_unit(columns)),
    ]


def _by_unit(columns: Sequence[tuple[CsvSource, str]]) -> list[Found]:
    """Return channels of a thruster that the unit of one column alone, stated or in its name, leaves no doubt about."""
    found: dict[str, list[Found]] = {}
    for source, name in columns:
        unit = source.unit(name) or ["", *named_units(name)][-1]
        channel = next((c for ours, c in BY_UNIT.items() if unit and conversion(spelled(unit), ours) is not None), "")
        if channel and values_of(source, name) is not None:
            each = Found(channel.format(i=0), source, name, why=" by its unit alone: is it?")
            found.setdefault(each.channel, []).append(each)
    return [each for (each, *others) in found.values() if not others]


def _by_type(left: Sequence[tuple[Source, str]]) -> list[Found]:
    """Return channels of a bench that the one topic of its type in a bag has, but for those that are only wanted."""
    found = []
    for source, name in left:
        topic, _, path = name.partition(".")
        if not isinstance(source, BagSource):
            continue
        for rule in BY_TYPE:
            match = re.fullmatch(rule.path, path)
            alike = [own for own, kind in source.types.items() if kind == rule.types and re.search(rule.topics, own)]
            single = f"{topic}.velocity[1]" not in source.channels  # several joints are no thruster's
            if match and alike == [topic] and single and not is_0(source, name):
                found.append(Found(rule.channel.format(**match.groupdict()), source, name, rule.unit, why=rule.why))
    return found


def _rules(source: Source, *, vehicle: bool) -> tuple[tuple[Rule, ...], tuple[OfType, ...]]:
    """Return the rules of names and those of types for a source."""
    if isinstance(source, LogSource):
        return LOGS, ()
    named = (*LOGS, *PX4)
    return ((*named, *VEHICLE, *THRUSTER), OF_TYPE) if vehicle else ((*named, *BENCH, *THRUSTER), (*OF_BENCH, *OF_TYPE))


def _in_order(source: Source) -> list[str]:
    """Return the names of a source; of a log those first that go before others of their channel."""
    if not isinstance(source, LogSource):
        return source.names()
    ranks = {name: [k for k, rule in enumerate(LOGS) if re.fullmatch(rule.names, name)] for name in source.names()}
    return sorted(ranks, key=lambda name: (not ranks[name], ranks[name]))


def _of_vehicle(source: Source) -> bool:
    """Tell whether a table or log has several thrusters, a table a gyro, and a bag messages of an IMU."""
    if isinstance(source, BagSource):
        return bool({"sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry"} & set(source.types.values()))
    if isinstance(source, LogSource):
        driven = {e.channel for name in source.names() if moves(source, name) and (e := _propose(source, name, LOGS))}
        return sum(channel.endswith(".commanded") for channel in driven) > 1
    found = {name: _propose(source, name, THRUSTER) for name in source.names()}
    commands = {each.channel for each in found.values() if each and each.is_command}
    gyro = [rule for rule in (*PX4, *VEHICLE) if "angular_velocity" in rule.channel]
    unnamed = [] if commands else _commands([(source, name) for name, each in found.items() if each is None])
    return len(commands) > 1 or bool(unnamed) or any(_propose(source, name, gyro) for name in source.names())


def _propose(source: Source, name: str, rules: Sequence[Rule], types: Sequence[OfType] = ()) -> Found | None:
    """Return the channel that a name suggests."""
    table = isinstance(source, CsvSource)
    if not table:
        topic, _, path = name.partition(".")
        if topic_type(topic) is not None and (unit := unit_of(str(topic_type(topic)), path, topic)):
            return Found(name, source, name, entry=f"unit: {quoted(unit)}")
        kind = source.types.get(topic, "") if isinstance(source, BagSource) else ""
        typed = [each for each in types if re.fullmatch(each.types, kind)]
        for each in typed:
            match = re.fullmatch(each.path, path)
            if match and re.search(each.topics, topic):
                channel = each.channel.format(path=path, **match.groupdict())
                return Found(channel, source, name, each.unit, entry=each.entry, why=each.why)
        if typed:
            return None
    whole = (without_unit(name) if table else name.strip()).replace(" ", "_")
    bare = bare_name(name) if table else whole
    tail = re.split("[./]", whole)[-1]
    # fields have their message's name from a file that is called so; a number alone from its topic, or its file
    formats = (*LOGS, *PX4)
    of_file = (f"{message_of(source)}.{whole}",) if isinstance(source, CsvSource) else ()
    topic = source.path.stem if table else whole.partition(".")[0].rsplit("/", 1)[-1]
    of_topic = [topic] if tail == "data" or (not table and named_units(tail)) else []
    words, wanted = told_words(tail) if table else ([], False)
    parts = re.split("[./]", whole)
    measured = table and not told_words("_".join(parts))[1]
    behind = [("_".join(parts[k:]),) for k in range(1, len(parts) - 1)] if measured else []
    stem, number = numbered(bare, source.names()) if table else (tail, 0)
    units = told_units(source, name, (bare, stem)) if isinstance(source, CsvSource) else []
    last = tail if stem.endswith(tail) else stem[len(bare) - len(tail) :]
    of_words = [
        rule
        for rule in rules
        if not rule.alone
        and (not wanted or rule.channel.endswith(".commanded"))
        and not (rule.channel.endswith("{angle}") and says_rate(tail))
    ]
    # the whole name first, then what is behind each dot or slash; single words only where no rule knows these
    for candidates, known in (
        (of_file, formats),
        ((whole, bare, without_suffix(bare)), rules),
        ((stem, without_suffix(stem)), rules),
        *((each, rules) for each in behind),
        ((tail, without_suffix(tail), *of_topic), rules),
        ((last, without_suffix(last)), rules),
        (words, of_words),
    ):
        for rule in known:
            spelling = re.NOFLAG if rule in LOGS else re.IGNORECASE  # a log's fields are written as its format has them
            for candidate in candidates:
                match = re.fullmatch(rule.names, candidate, spelling)
                channel = _channel(rule, match, number) if match else ""
                known_units = (
                    not units
                    or known is formats
                    or any(
                        _may_be_in(channel, unit) or (known is not of_words and is_amplified(unit, ours_of(channel)))
                        for unit in units
                    )
                )
                if (
                    match
                    and known_units
                    and not _denied(channel, source, name)
                    and not ((rule in BENCH or known is of_words) and _in_other_units(channel, source, name))
                    and (not rule.together or set(rule.together) <= beside(source, name))
                ):
                    by_word = known is of_words
                    if by_word and rule.channel.endswith(".commanded") and not units and not moves(source, name):
                        continue  # esc_count is none
                    return Found(channel, source, name, rule.unit, rule.sign, rule.entry, rule.why, by_word)
    return None


def _may_be_in(channel: str, unit: str) -> bool:
    return fits(unit, ours_of(channel), command=channel.endswith(".commanded"))


def _in_other_units(channel: str, source: Source, name: str) -> bool:
    """Tell whether the recording states a unit in which the channel cannot be."""
    stated = source.unit(name)
    return stated != "" and is_unit(stated) and not _may_be_in(channel, spelled(stated))


def _denied(channel: str, source: Source, name: str) -> bool:
    """Tell whether readings deny a channel: no supply is negative, but for an offset of its sensor, and four columns
    whose squares add up to 1 are no torques."""
    if channel.endswith("torque.x"):
        return is_of_quaternion(source, name)
    if not channel.endswith(("supply_voltage", "battery.voltage")):
        return False
    span = span_of(source, name)
    return span is not None and span.low < -0.1 * abs(span.high)


def _channel(rule: Rule, match: re.Match[str], thruster: int) -> str:
    groups = {key.rstrip("2"): value.lower() for key, value in match.groupdict().items() if value is not None}
    number = rule.first + (int(groups["one"]) - 1 if "one" in groups else int(groups.get("zero", thruster)))
    (last, *_) = [key for key in groups if key not in ("axis", "angle", "part")] or [""]  # (?P<x>surge): axis x
    own = {key: groups.get(key, last) for key in ("axis", "angle", "part")}
    return rule.channel.format(i=number, **own)


def ours_of(channel: str) -> str:
    """Return the unit of a channel."""
    topic, _, path = channel.partition(".")
    return unit_in_map(str(topic_type(topic)), path, topic)
