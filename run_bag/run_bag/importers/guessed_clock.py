"""Which column of a table is its time, or that of single sensors, by names and values."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np

from .column_names import bare_name, called_time, is_stamp
from .conversions import conversion
from .csv_source import CsvSource
from .guessed_units import Guessed, guessed_time_unit
from .guessed_values import moves, span_of, values_of
from .recording_map import ASKED
from .sources import Array, Source

__all__ = ["clock_in", "clock_of", "clocks_apart", "is_time", "own_times", "time_of", "unit_of_time"]

_OWN_TIME = re.compile(r"(t|time|stamp|zeit)_.+|.+_(s|ms|us|ns)", re.IGNORECASE)
"""The time of the columns that follow it: t_cmd, cmd_ms."""
_SELDOM = 0.1
"""Share of rows in which a time may be less than in the row before: an import names the first of them."""


def clock_of(sources: Sequence[Source]) -> tuple[CsvSource, str] | None:
    """Return the column of time that most tables have, with the first of these, "" where the first table shows none;
    None without tables."""
    tables = [each for each in sources if isinstance(each, CsvSource)]
    found = [(table, _likely_time(table)) for table in tables]
    if not found or not found[0][1]:
        return found[0] if found else None
    return max(found, key=lambda each: sum(clock_in(table, each[1]) == each[1] for table in tables))


def _likely_time(table: CsvSource) -> str:
    """Return the column that is likeliest the time of a table, "" where none is seen."""
    names = table.names()
    named = [*_stamp(table), *(name for name in names if is_time(table, name))]
    rising = (name for name in (names[:1] if table.heading else names) if _never_falls(table, name))
    return next(iter((*named, *own_times(table), *(name for name in names if _rises(table, name)), *rising)), "")


def own_times(table: CsvSource) -> list[str]:
    """Return the columns of time of a table in which sensors have their own; none where there is one time.

    Beside a time of all, such a column shares its range: t_n is a time then, and no force in N. Without one, whatever
    rises in a unit of time is one, and so are columns of one name that rise.
    """
    names = table.names()
    common = next((name for name in names if is_time(table, name)), "")
    written = Counter(map(table.written, names))
    named = [name for name in names if _OWN_TIME.fullmatch(bare_name(name))]
    if not common:
        named = [n for n in names if n in named or _in_time(table, n) or written[table.written(n)] > 1]
    own = [name for name in named if _never_falls(table, name)]
    found = [name for name in own if not common or name == common or _share_range(table, common, name)]
    found = sorted({*found, common} - {""}, key=table.names().index)
    return found if len(found) > 1 else []


def clock_in(table: CsvSource, clock: str) -> str:
    """Return the column of time of a table: its messages' stamps, that of most tables, or its own; "" where none is
    seen."""
    first = [*_stamp(table), *(name for name in table.names() if name == clock)] if clock else [clock]
    return first[0] if first else _likely_time(table)


def _stamp(table: CsvSource) -> list[str]:
    """Return the messages' own stamps of a table, where they are any."""
    return [name for name in table.names() if is_stamp(name) and is_time(table, name) and moves(table, name)][:1]


def time_of(table: CsvSource, name: str, clock: str) -> str:
    """Return the column of time of a column: its own, to the left with as many numbers, or the table's: `clock_in`."""
    names = table.names()
    before = [each for each in own_times(table) if names.index(each) < names.index(name)]
    as_often = [each for each in before if _numbers(table, each) >= _numbers(table, name)]
    return (as_often or before)[-1] if before else clock_in(table, clock)


def clocks_apart(columns: Iterable[tuple[CsvSource, str]], clock: str) -> list[str]:
    """Return a comment about times of the columns of a proposal that have nothing in common, none where all do.

    clock: the column of time of most tables.
    """
    spans: dict[tuple[str, str], tuple[float, float]] = {}
    for table, name in columns:
        own = time_of(table, name, clock)
        span = span_of(table, own) if own else None
        factor = conversion(unit_of_time(table, own).unit, "s") if span else None
        if span and factor:
            spans[table.path.name, own] = factor.factor * span.low, factor.factor * span.high
    groups: list[tuple[float, list[str]]] = []  # ends, and what each has
    for (file, own), (low, high) in sorted(spans.items(), key=lambda each: each[1]):
        told = f"{file} ({own}: {low:.3f} to {high:.3f} s)"
        if groups and low <= groups[-1][0]:
            end, files = groups.pop()
            groups.append((max(end, high), [*files, told]))
        else:
            groups.append((high, [told]))
    if len(groups) < 2:
        return []
    each = "; ".join(", ".join(files) for _, files in groups)
    return [f"# No common clock: {each}. `time_offset` of entries brings one's times to the other's"]


def unit_of_time(table: CsvSource, name: str) -> Guessed:
    """Return the unit of a column of time: its own, or where nothing tells that, the one of all others beside it."""
    every = {each: _unit(table, each) for each in (name, *own_times(table))}
    others = {each.unit for each in every.values()} - {ASKED}
    own = every[name]
    return own if own.unit != ASKED or len(others) != 1 else Guessed(others.pop(), "unit of the times beside it")


def _unit(table: CsvSource, name: str) -> Guessed:
    return guessed_time_unit(bare_name(name), table.unit(name), values_of(table, name))


def is_time(table: CsvSource, name: str) -> bool:
    """Tell whether a column is called a time, has no other unit, and rises as a rule: T may be a thrust."""
    stated = table.unit(name)
    named = called_time(name) and (not stated or conversion(stated, "s") is not None)
    return name in table.dated or (named and float(np.mean(_steps(table, name) < 0.0)) <= _SELDOM)


def _rises(table: CsvSource, name: str) -> bool:
    """Tell whether a column with a unit of time rises."""
    return _in_time(table, name) and _never_falls(table, name)


def _in_time(table: CsvSource, name: str) -> bool:
    """Tell whether a column is stated to be in a unit of time."""
    stated = table.unit(name)
    return bool(stated) and conversion(stated, "s") is not None


def _numbers(table: CsvSource, name: str) -> int:
    span = span_of(table, name)
    return span.numbers if span else 0


def _never_falls(table: CsvSource, name: str) -> bool:
    """Tell whether values rise and never fall: two rows may have one stamp."""
    steps = _steps(table, name)
    return bool(np.all(steps >= 0.0) and np.any(steps > 0.0))


def _steps(table: CsvSource, name: str) -> Array:
    """Return the steps between the numbers of a column, one of 0 where it has none."""
    values = values_of(table, name)
    known = np.zeros(0) if values is None else values[np.isfinite(values)]
    return np.diff(known) if known.size > 1 else np.zeros(1)


def _share_range(table: CsvSource, name: str, other: str) -> bool:
    """Tell whether two columns have most of their ranges in common."""
    one, two = span_of(table, name), span_of(table, other)
    if one is None or two is None:
        return False
    return 2.0 * (min(one.high, two.high) - max(one.low, two.low)) > max(one.high, two.high) - min(one.low, two.low)
