"""A table with rows of several instances of a sensor, numbered by a column: a table of each, for a proposal."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence

import numpy as np

from .csv_source import CsvSource
from .guess_rules import LOGS
from .guessed_values import moves, values_of
from .sources import Source

__all__ = ["by_instance", "counters_of", "message_of", "told_apart"]

_NUMBERED = ("I", "Inst", "Instance", "instance")
"""Columns by which an ArduPilot's messages number their instances."""
_MOST = 16
_ALIKE = 2.0
"""Ratio of the readings of two instances: a current of whole amperes is as unlikely to be spread so."""


class _Instance(CsvSource):
    """The rows of a table in which a column has one number."""

    def __init__(self, whole: CsvSource, column: str, cell: str) -> None:
        vars(self).update(vars(whole))
        self.where = f"{column}: {cell}"
        self.message = f"{whole.path.stem}[{cell}]"
        at, text = whole.names().index(column), io.StringIO()
        writer = csv.writer(text, delimiter=whole.separator, lineterminator="\n")
        writer.writerows(row for _, row in whole.rows() if row[at].strip() == cell)
        self.data = b"".join(self.data.splitlines(keepends=True)[: whole.last_heading]) + text.getvalue().encode()
        self._columns, self._marks, self._texts = {}, {}, {}


def by_instance(sources: Sequence[Source]) -> list[Source]:
    """Return sources with a table for each instance of those that have several, the likelier one first."""
    return [part for source in sources for part in (_parts(source) if isinstance(source, CsvSource) else [source])]


def message_of(table: CsvSource) -> str:
    """Return the message that a table is of by its file's name, with its instance where there are several: BARO[1]."""
    return table.message if isinstance(table, _Instance) else table.path.stem


def counters_of(table: CsvSource) -> set[str]:
    """Return the columns of a table, or of one instance of it, that number instances: I may be a current elsewhere."""
    return {name for name in table.names() if name in _NUMBERED and not moves(table, name)}


def told_apart(source: Source) -> str:
    """Return the key of an entry that takes the rows of one instance, "" where there is but one."""
    return f", where: {{{source.where}}}" if isinstance(source, _Instance) else ""


def _parts(table: CsvSource) -> list[CsvSource]:
    for column in filter(table.names().__contains__, _NUMBERED):
        values = values_of(table, column)
        if table.unit(column) or values is None or not table.heading or np.isnan(values).any():
            continue
        numbers, times = np.unique(values, return_counts=True)
        whole = np.array_equal(numbers, np.round(numbers)) and numbers[0] >= 0.0
        if whole and 1 < numbers.size <= _MOST and times.max() <= _ALIKE * times.min():
            cells = sorted(set(table.cells(table.names().index(column))), key=float)
            return sorted((_Instance(table, column, cell) for cell in cells), key=_rank)
    return [table]


def _rank(table: CsvSource) -> int:
    """Return the place of the first rule about a message of a log."""
    names = [f"{message_of(table)}.{name}" for name in table.names()]
    return next((k for k, rule in enumerate(LOGS) if any(re.fullmatch(rule.names, name) for name in names)), len(LOGS))
