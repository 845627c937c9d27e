"""A proposal of a map, from the names, units and ranges that a recording has. To be read before it is used."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from .bag_source import BagSource
from .column_names import bare_name
from .conversions import COMMANDS
from .csv_source import CsvSource
from .guess_rules import SURROUNDING, UNTOLD, WAYS, WHICH_FLOW, quoted
from .guessed_axes import axes_lines
from .guessed_channels import Found, channels_in, ours_of
from .guessed_clock import clock_of, clocks_apart, is_time, own_times, time_of, unit_of_time
from .guessed_depth import is_height
from .guessed_supply import supply_of_bench
from .guessed_turning import gyro_by_attitude
from .guessed_units import guessed_unit, pulses, rest_and_volt
from .guessed_values import is_0, is_unknown, moves, span_of, values_of
from .instances import by_instance, told_apart
from .log_source import LogSource
from .recording_map import ASKED
from .sign_source import SIGN_UNKNOWN
from .sources import Array, Source
from .vehicle_advice import is_charging

_MIDDLE = 1500.0
"""[us] Of pulses, at which a thruster rests."""
_BOTH_WAYS = 0.2
"""Of the way that a command goes to one side: what it goes to the other one at least."""
SHOWN = 60
MOST_WORDS, LONGEST_WORD = 10, 40
"""Of a column that a proposal lists: how many, and how long [letters]."""
_ELECTRICAL = re.compile(r"(^|[\W_])e_?rpm|electrical", re.IGNORECASE)
"""Of a speed that a driver counts in periods of the current: as many for each turn as a motor has pairs of poles."""
HOLD = " hold is a guess: previous or linear?"
"""Asked once, of the first command."""
RESTS = " never changes: is it the command?"
"""Asked about a table's command that no other column is likelier to be."""
CONSTANT = " never changes: is it measured?"
"""Asked about a field of a bag or log, or of an array in a table; other columns are what somebody chose."""
_ELEMENT = re.compile(r"\w\[\d+\]\S")
"""A field of one element, as esc[0].esc_voltage."""


def guess(sources: Sequence[Source]) -> str:
    """Return a map as YAML text: what is likely as entries, everything else as comments."""
    clock, told = _clock(sources)
    parts = by_instance(sources)
    found, left = supply_of_bench(*channels_in(parts, clock))
    names = Counter(name for source in sources for name in source.names())
    numbered = {name for source in sources for name in source.names() if called(source, name).isdecimal()}
    shared = {name for name, files in names.items() if files > 1} | (numbered if len(sources) > 1 else set())
    groups: dict[str, list[Found]] = {}
    for each in found:
        groups.setdefault(each.group, []).append(each)
    force = _rows(groups.get("rov/imu.linear_acceleration", []))
    asked = next((each for each in found if each.is_command), None)
    both_ways = {_thruster(each) for each in found if each.is_command and _goes_both_ways(each)}
    arrays: dict[tuple[Source, str], list[Found]] = {}
    for each in found:
        arrays.setdefault(_array(each), []).append(each)
    entries = [
        line
        for each in found
        for line in (
            _line(
                each, groups[each.group], arrays[_array(each)], clock, shared=each.name in shared,
                force=list(force.values()), asked=each != asked,
            ),
            *_sign_source(each, both_ways),
        )
    ]  # fmt: skip
    if entries and all("time_column: " in e.partition("   #")[0] for e in entries if " {column: " in e):
        told = []
    entries = gyro_by_attitude(sources, told, entries)
    passed = [f"# {each}" for source in sources if isinstance(source, CsvSource) for each in source.warnings]
    head = ["# A proposal: read it, correct it, and import with --map.", *passed, *told]
    head += clocks_apart(((e.source, e.name) for e in found if isinstance(e.source, CsvSource)), clock)
    if not any(each.is_command for each in found):
        head.append("# No command of a thruster was recognised, and nothing is done without one: which field is it?")
    lines = [*head, *_axes(found, sources, [*told, *entries]), *entries]
    left = [(source, name) for source, name in left if isinstance(source, CsvSource) or not UNTOLD.search(name)]
    left = _but_parts(left, found)
    empty = {each for each in left if not isinstance(each[0], CsvSource) and is_0(*each)}
    unknown = {each for each in left if is_unknown(*each)}
    left = [each for each in left if each not in empty | unknown]
    left.sort(key=lambda each: not moves(*each))
    lines += ["# Not recognised:"] if left else []
    where = {each: f" of {each[0].path.name}:" if names[each[1]] > 1 else "" for each in left}
    lines += [f"# {quoted(name)}{where[source, name]}{_seen(source, name)}" for source, name in left[:SHOWN]]
    lines += [f"# and {len(left) - SHOWN} more"] if len(left) > SHOWN else []
    beside = [name for source in sources if isinstance(source, CsvSource) for name in source.left_out]
    lines += [f"# Beside the readings, left out: {', '.join(map(quoted, beside))}"] if beside else []
    lines += [f"# 0 in all messages: {len(empty)} fields more"] if empty else []
    lines += [f"# A mark that nothing is known in all messages: {len(unknown)} fields more"] if unknown else []
    return "\n".join(lines) + "\n"


def _but_parts(left: Iterable[tuple[Source, str]], found: Iterable[Found]) -> list[tuple[Source, str]]:
    """Return what is left, a column of several instances once, and none of which one instance is a channel."""
    known = {(each.source.path, each.name) for each in found}
    once = {(source.path, name): (source, name) for source, name in left if (source.path, name) not in known}
    return list(once.values())


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
        why = _joined(why, " its values rise: is it the time?").strip()
    return name, [f"time: {{column: {called(table, name)}, unit: {quoted(unit)}}}{'   # ' + why if why else ''}"]


def _axes(found: Iterable[Found], sources: Sequence[Source], lines: Sequence[str]) -> list[str]:
    """Return the map's lines about axes, of topics whose axes neither the format nor a name of ours says."""
    vectors = [each for each in found if each.topic in ("rov/imu", "rov/odometry", "rov/velocity")]
    topics = {each.topic for each in vectors if each.topic != "rov/odometry" or not each.usual}
    force = {e.channel[-1]: values_of(e.source, e.name) for e in vectors if "linear_acceleration" in e.channel}
    return axes_lines(topics, force, sources, lines, named=_named_axes(vectors))


def _named_axes(vectors: Iterable[Found]) -> dict[str, int]:
    """Return topics whose messages, or names of velocities to the side and down, say their axes: 1 ours, -1 REP 103's.

    A message of an IMU is in REP 103's by convention, in which its frame may say otherwise.
    """
    told: dict[str, set[int]] = {}
    for each in vectors:
        ways = told.setdefault(each.topic, set())
        if isinstance(each.source, BagSource):
            ours = each.source.channels[each.name].frame.endswith(("ned", "frd"))
            ways |= {1} if ours else {-1} if each.topic == "rov/imu" else set()
        elif each.channel.endswith(("linear.y", "linear.z")):
            ways |= {way for way, words in WAYS.items() if re.search(words, each.name)}
    return {topic: min(ways) for topic, ways in told.items() if len(ways) == 1}


def _array(each: Found) -> tuple[Source, str]:
    """Return the array of a bag or log of which a field is an element, else the field or column itself."""
    whole = isinstance(each.source, CsvSource) or not each.name.endswith("]")
    return each.source, each.name if whole else each.name.rpartition("[")[0]


def _line(
    each: Found, group: Sequence[Found], array: Sequence[Found], clock: str, *, shared: bool, force: Sequence[Array],
    asked: bool,
) -> str:  # fmt: skip
    """Return the entry of a channel.

    Args:
        each: the channel.
        group: the parts of one field, whose unit is found from all their values.
        array: elements of one array, which have one unit, too.
        clock: the column of time of most tables; shared: whether several files have a column of that name.
        force: readings of the accelerometer's three axes, none where they are not known.
        asked: whether the hold of commands is asked about elsewhere.
    """
    source, name = each.source, each.name
    table, notes, more = isinstance(source, CsvSource), [_seen(source, name)], _more(each, clock, shared)
    start = f"{each.channel}: {{{'column' if table else 'field'}: {called(source, name)}, "
    if each.entry:
        return f"{start}{each.entry}{more}}}   #{_joined(*notes, each.why)}"
    unit, why = _unit(each, group, array, force)
    minus, doubt = _sign(each, unit)
    keys = f"unit: {quoted(unit)}"
    if table and _ELECTRICAL.search(name):
        keys, why = f"{keys}, scale: '{ASKED}'", "electrical: write 1 / pole pairs of the motor as scale"
    notes += [f" {why}"] if why else []
    if each.is_command:
        if unit in COMMANDS:
            stop, per_volt = rest_and_volt(unit, values_of(source, name))
            keys += f", stop: {stop:.10g}, per_volt: {per_volt:.4g}"
            notes.append(" stop and per_volt are guesses: write yours")
        keys += ", hold: previous"
        notes += [] if asked else [HOLD]
        notes += [RESTS] if table and not moves(source, name) else []
    keys += ", sign: -1" if minus else ""
    chosen = table and not _ELEMENT.search(name)
    still = "" if chosen or each.is_command or len(group) > 1 or moves(source, name) else CONSTANT
    told = _joined(*notes, each.why, doubt, still)
    return f"{start}{keys}{more}}}{'   #' + told if told else ''}"


def _more(each: Found, clock: str, shared: bool) -> str:
    """Return the keys of an entry about its file, its time and what is not measured."""
    source, name = each.source, each.name
    more = f", file: {source.path.name}" if shared else ""
    more += told_apart(source)
    if isinstance(source, CsvSource):
        marks = ", ".join(map(quoted, sorted(source.marks(source.names().index(name)))))
        more += _own_clock(source, name, clock) + (f", nan: [{marks}]" if marks else "")
    return more


def _unit(each: Found, group: Sequence[Found], array: Sequence[Found], force: Sequence[Array]) -> tuple[str, str]:
    """Return the unit of a channel and why it is that one; of an array of speeds in rpm the first alone tells why."""
    name = bare_name(each.name) if isinstance(each.source, CsvSource) else each.name
    alike = group if len(group) > 1 else array
    parts = [values for part in alike if (values := values_of(part.source, part.name)) is not None]
    unit, why = guessed_unit(
        ours_of(each.channel), name, each.source.unit(each.name), np.concatenate(parts) if parts else None,
        usual=each.usual, command=each.is_command, vehicle=each.topic == "rov/imu", vector=_rows(group), force=force,
    )  # fmt: skip
    again = unit == "rpm" and each.usual == "rad/s" and each != array[0] and not each.is_command
    return unit, "" if again else why


def _sign(each: Found, unit: str) -> tuple[bool, str]:
    """Return whether an entry has `sign: -1`, and what is to be asked about it."""
    path, own, minus = each.channel.partition(".")[2], values_of(each.source, each.name), each.sign < 0
    if path == "ambient" and not re.search(SURROUNDING, each.name):
        return minus, WHICH_FLOW
    if own is None:
        return minus, ""
    if path == "depth" and is_height(own, unit):
        return True, "" if minus else " a height by its values: is it?"
    if each.channel == "rov/battery.current" and is_charging(own[np.isfinite(own)]):
        return True, "" if minus else " positive throughout: is it while it is drawn?"
    return minus and not (path == "current" and np.nanmedian(own) < 0.0), ""  # negative while it is drawn, as ours


def _thruster(each: Found) -> str:
    return each.channel.partition("/")[0]


def _goes_both_ways(each: Found) -> bool:
    """Tell whether a command goes about as far below as above the middle of its pulses, or of what is not pulses 0."""
    values = values_of(each.source, each.name)
    if values is None:
        return False
    off = values - (_MIDDLE if pulses(values) else 0.0)
    low, high = float(np.nanmin(off)), float(np.nanmax(off))
    return min(-low, high) > _BOTH_WAYS * max(-low, high)


def _sign_source(each: Found, both_ways: Collection[str]) -> list[str]:
    """Return the entry that a speed has no sign, of a vehicle's log or of a thruster whose command goes both ways."""
    span = span_of(each.source, each.name)
    likely = isinstance(each.source, LogSource) or _thruster(each) in both_ways
    if not (likely and each.channel.endswith("state.n") and span and span.low >= 0.0):
        return []
    return [
        f"{each.channel.removesuffix('n')}sign_source: {{value: {SIGN_UNKNOWN}}}   # never negative, as of most ESCs"
    ]


def _joined(*notes: str) -> str:
    """Return notes that each begin with a space as one; what follows a question is a sentence of its own."""
    return ";".join(filter(None, notes)).replace("?;", "?")


def _rows(parts: Sequence[Found]) -> dict[str, Array]:
    """Return the readings of a vector's parts, row by row, which have rows of their own in a long table; {} where
    they are not of the same."""
    read = {each.channel.rpartition(".")[2]: values_of(each.source, each.name) for each in parts}
    told = {part: values[np.isfinite(values)] for part, values in read.items() if values is not None}
    return told if len(told) == len(read) and len({values.size for values in told.values()}) == 1 else {}


def called(source: Source, name: str) -> str:
    """Return a column's or field's name as a map has it: the number of a column that has no name of its own."""
    numbered = isinstance(source, CsvSource) and name.isdecimal() and source.written(name) != name
    return name if numbered or (isinstance(source, CsvSource) and not source.heading) else quoted(name)


def _own_clock(source: CsvSource, name: str, clock: str) -> str:
    """Return the keys about the time of a column whose time is not that of most."""
    own = time_of(source, name, clock)
    if own in ("", clock):
        return ""
    unit, _ = unit_of_time(source, own)
    return f", time_column: {called(source, own)}, time_unit: {quoted(unit)}"


def _seen(source: Source, name: str) -> str:
    span = span_of(source, name)
    if span is None:
        return f" no numbers{_words(source, name)}"
    unit, told = (
        source.unit(name),
        f"{span.low:.4g} to {span.high:.4g}" if span.low < span.high else f"always {span.low:.4g}",
    )
    return f" {told}{' ' + unit if unit not in ('', '1') else ''}, {span.numbers} samples"


def _words(source: Source, name: str) -> str:
    """Return which few words a column of a table has, as those by which `where` takes rows; "" where many."""
    if not isinstance(source, CsvSource):
        return ""
    there = dict.fromkeys(filter(None, source.cells(source.names().index(name))))
    if not 0 < len(there) <= MOST_WORDS or max(map(len, there)) > LONGEST_WORD:
        return ""
    told = ", ".join(map(quoted, there))
    if len(there) == 1:
        return f": always {told}"
    return f": {told}; `where: {{{quoted(name)}: ...}}` of an entry takes the rows of one"
