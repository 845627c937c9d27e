"""Which column of a table is its time, or that of single sensors, by names and values."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from .column_names import bare_name, called_time
from .conversions import conversion
from .csv_source import CsvSource
from .guessed_units import Guessed, guessed_time_unit
from .guessed_values import values_of
from .recording_map import ASKED
from .sources import Source

__all__ = ["clock_in", "clock_of", "is_time", "own_times", "time_of", "unit_of_time"]

_OWN_TIME = re.compile(r"(t|time|stamp)_.+|.+_(s|ms|us|ns)", re.IGNORECASE)
"""The time of the columns that follow it: t_cmd, cmd_ms."""


def clock_of(sources: Sequence[Source]) -> tuple[CsvSource, str] | None:
    """Return the column of time that most tables have, with the first of these, "" where the first table shows none;
    None without tables."""
    tables = [each for each in sources if isinstance(each, CsvSource)]
    found = [(table, _likely_time(table)) for table in tables]
    if not found or not found[0][1]:
        return found[0] if found else None
    return max(found, key=lambda each: sum(each[1] in table.names() for table in tables))


def _likely_time(table: CsvSource) -> str:
    """Return the column that is likeliest the time of a table, "" where none is seen."""
    names = table.names()
    named = [name for name in names if is_time(table, name)]
    first = [name for name in names[:1] if table.heading and _never_falls(table, name)]
    return next(iter((*named, *own_times(table), *(name for name in names if _rises(table, name)), *first)), "")


def own_times(table: CsvSource) -> list[str]:
    """Return the columns of time of a table in which each sensor has its own; none where there is one time."""
    found = [name for name in table.names() if _OWN_TIME.fullmatch(bare_name(name)) and _never_falls(table, name)]
    return found if len(found) > 1 and not any(is_time(table, name) for name in table.names()) else []


def clock_in(table: CsvSource, clock: str) -> str:
    """Return the column of time of a table: that of most tables, or its own; "" where none is seen."""
    return clock if not clock or clock in table.names() else (clock_of([table]) or (table, ""))[1]


def time_of(table: CsvSource, name: str, clock: str) -> str:
    """Return the column of time of a column: one of its own, or the table's, see `clock_in`."""
    names, own = table.names(), own_times(table)
    before = [each for each in own if names.index(each) < names.index(name)]
    return before[-1] if before and before[-1] != own[0] else clock_in(table, clock)


def unit_of_time(table: CsvSource, name: str) -> Guessed:
    """Return the unit of a column of time: its own, or where nothing tells that, the one of all others beside it."""
    every = {each: _unit(table, each) for each in (name, *own_times(table))}
    others = {each.unit for each in every.values()} - {ASKED}
    own = every[name]
    return own if own.unit != ASKED or len(others) != 1 else Guessed(others.pop(), "unit of the times beside it")


def _unit(table: CsvSource, name: str) -> Guessed:
    return guessed_time_unit(bare_name(name), table.unit(name), values_of(table, name))


def is_time(table: CsvSource, name: str) -> bool:
    """Tell whether a column is called a time, and has no other unit: T is a thrust where its unit is N."""
    stated = table.unit(name)
    return name in table.dated or (called_time(name) and (not stated or conversion(stated, "s") is not None))


def _rises(table: CsvSource, name: str) -> bool:
    """Tell whether a column with a unit of time rises."""
    stated = table.unit(name)
    return bool(stated) and conversion(stated, "s") is not None and _never_falls(table, name)


def _never_falls(table: CsvSource, name: str) -> bool:
    """Tell whether values rise and never fall: two rows may have one stamp."""
    values = values_of(table, name)
    steps = np.zeros(0) if values is None else np.diff(values[np.isfinite(values)])
    return bool(np.all(steps >= 0.0) and np.any(steps > 0.0))
