"""Where a table of text begins: instruments write lines of their own before it.

It begins where the number of columns becomes constant to the end, with the names of columns that stand right above the
first row of readings. What stands before is passed over, and said to be. Nothing that has readings is passed over:
where such lines stand before the rows of one width, a table begins in its first line, and the odd row is refused.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from typing import NamedTuple

from .conversions import is_unit
from .dated import called_date

__all__ = ["BLANKS", "Start", "in_tabs", "start_of", "stated_words", "without_lines"]

BLANKS = "blanks"
"""Runs of blanks as one separator."""
_SEPARATORS = (";", "\t", ",", "|", " ", BLANKS)
_SEEN = (";", "\t", ",", "|")


class Start(NamedTuple):
    """How a table begins.

    Attributes:
        separator: one letter, or `BLANKS`.
        passed: 0-based lines that are passed over.
        named: whether the first line that is left names columns; None where no column of numbers tells.
    """

    separator: str
    passed: tuple[int, ...] = ()
    named: bool | None = None


def start_of(lines: Sequence[str], told: str = "") -> Start:
    """Return how a table begins, by its first lines and the separator that a map tells, "" where it tells none."""
    there = [k for k, line in enumerate(lines) if line.strip()]
    found: list[tuple[int, int, Start]] = []
    for separator in (told,) if told not in ("", " ") else (" ", BLANKS) if told else _SEPARATORS:
        rows = [_cells(lines[k], separator) for k in there]
        start = _start(rows, there)
        if len(set(map(len, rows))) == 1 and len(rows[0]) > 1:
            found.append((0, -len(_of_numbers(rows[len(rows) // 2 :])), Start(separator, *(start or ((), None)))))
        elif start is not None:
            found.append((len(start[0]), 0, Start(separator, *start)))
    if found:  # the first of those that pass the least over and find the most columns of readings
        return min(found, key=lambda each: each[:2])[-1]
    present = [each for each in _SEEN if any(each in lines[k] for k in there[:1])]
    return Start(told or next(iter(present), ","))


def stated_words(cells: Sequence[str]) -> bool:
    """Tell whether a row of a table states units: more than one word that is a unit, and no number."""
    words = [cell.strip().strip("[]()") for cell in cells]
    return sum(is_unit(word) for word in words if word) > 1 and not any(map(_is_reading, words))


def in_tabs(data: bytes) -> bytes:
    """Return a table whose columns are aligned by blanks with one tab for each run of them, line by line."""
    return b"\n".join(b"\t".join(line.split()) for line in data.split(b"\n"))


def without_lines(data: bytes, passed: Sequence[int]) -> bytes:
    """Return a table with these 0-based lines empty, so that others keep their numbers."""
    if not passed:
        return data
    lines, out = data.splitlines(keepends=True), set(passed)
    return b"".join(b"\n" if k in out else line for k, line in enumerate(lines))


def _cells(line: str, separator: str) -> list[str]:
    if separator == BLANKS:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def _start(rows: Sequence[Sequence[str]], lines: Sequence[int]) -> tuple[tuple[int, ...], bool] | None:
    """Return the lines to be passed over, and whether names come then; None where nothing tells.

    rows, lines: cells of the lines that are not blank, and their numbers.
    """
    width = len(rows[-1]) if rows else 0
    first = next((k + 1 for k in reversed(range(len(rows))) if len(rows[k]) != width), 0)
    readings = _of_numbers(rows[(first + len(rows)) // 2 :])
    if width < 2 or len(rows) - first < 2 or not readings:
        return None
    if any(_has_readings(row, readings) for row in rows[:first]):
        return None
    begins = next(k for k in range(first, len(rows)) if _has_readings(rows[k], readings))
    names = _names(rows, lines, first, begins, readings)
    if names is None and begins > 0 and _may_name(rows[begins - 1], width):
        return None  # names of another width than the rows below
    last = begins if names is None else names
    kept = {last, begins}
    kept |= {k for k in range(last + 1, begins) if _is_kept(rows[k], readings, below=k == last + 1)}
    left = {lines[k] for k in kept}
    above = [k for k in range(lines[begins]) if k not in left]
    return (tuple(above) if len(kept) < begins + 1 else ()), names is not None


def _names(
    rows: Sequence[Sequence[str]], lines: Sequence[int], first: int, begins: int, readings: Sequence[int]
) -> int | None:
    """Return the row of names above the first row of readings: the lowest of different words that are no units."""
    above: list[int] = []
    for k in reversed(range(first, begins)):
        apart = above and lines[k] + 1 < lines[k + 1]
        if apart or 2 * sum(bool(rows[k][column]) for column in readings) < len(readings):
            break
        above.append(k)
    named = [k for k in above if not stated_words(rows[k])]
    different = [k for k in named if len({rows[k][column] for column in readings}) == len(readings)]
    return next(iter([*different, *named, *above[::-1]]), None)


def _is_kept(row: Sequence[str], readings: Sequence[int], *, below: bool) -> bool:
    """Tell whether a row between names and readings is kept: units right below the names, or what has numbers."""
    return (below and stated_words(row)) or any(_is_reading(row[column]) for column in readings)


def _may_name(row: Sequence[str], width: int) -> bool:
    """Tell whether words may name most columns of a table of so many."""
    words = [cell for cell in row if cell and not _is_reading(cell)]
    return len(words) > 1 and len(words) == len([cell for cell in row if cell]) and len(words) >= width - 1


def _of_numbers(rows: Sequence[Sequence[str]]) -> list[int]:
    """Return the columns of which most cells that are there are readings."""
    found = []
    for k in range(len(rows[0]) if rows else 0):
        known = [_is_reading(row[k]) for row in rows if row[k]]
        if 2 * sum(known) > len(known):
            found.append(k)
    return found


def _has_readings(row: Sequence[str], readings: Sequence[int]) -> bool:
    """Tell whether the first cell that is there in columns of readings is one; other lines begin with words."""
    there = [row[column] for column in readings if column < len(row) and row[column]]
    return bool(there) and _is_reading(there[0])


def _is_reading(cell: str) -> bool:
    """Tell whether a cell is a number, with a decimal point or comma, or a date or time of day."""
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return called_date(cell)
    return "_" not in cell
