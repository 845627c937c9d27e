"""Dates and times of day in a table, made seconds."""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Iterable, Sequence
from datetime import datetime

__all__ = ["READ", "called_date", "in_seconds"]

READ = "2026-05-04T12:00:00.25, 04.05.2026 12:00:00,25 or 12:00:00,25"
"""Forms of dates and times of day that are read, for a sentence."""
_CALLED = re.compile(r"(?<!\d)\d{1,4}([./-])\d{1,2}\1\d{1,4}(?!\d)|\d\d?:\d\d|\b[ap]m\b", re.IGNORECASE)
"""What is likely a date or a time of day, in whatever form."""

_LOOK = 100  # rows
_DAY_S, _HALF_DAY_H = 86400, 12
_DATE = re.compile(
    r"(?P<date>\d{4}-\d\d-\d\d)[T ](?P<day>\d\d:\d\d(:\d\d)?)([.,](?P<part>\d{1,9}))? ?(?P<zone>Z|[+-]\d\d(:?\d\d)?)?"
)
_GERMAN = re.compile(r"(?P<german>\d{1,2}\.\d{1,2}\.\d{4}),? +(?P<day>\d{1,2}:\d\d:\d\d)([.,](?P<part>\d{1,9}))?")
_TIME = re.compile(r"(?P<day>\d{1,2}:\d\d:\d\d)([.,](?P<part>\d{1,9}))?")
_FORMS = (_DATE, _GERMAN, _TIME)
_HINT = re.compile(rb"\d:\d\d")


def in_seconds(data: bytes, separator: str, decimal: str) -> tuple[bytes, frozenset[int]]:
    """Return a table with its dates (ISO 8601, or day.month.year) and times of day as seconds, line by line, and the
    columns they were in.

    A date becomes seconds since 1970, in UTC where it tells no zone; a time of day, seconds since midnight. Such a
    column has nothing else in its first rows; what cannot be read there further down stays as it is. Where a time of
    day falls by more than half a day from one row to the next, all those before noon are of the next day.
    """
    if not _HINT.search(data[: 1 << 20]):
        return data, frozenset()
    reader = csv.reader(io.TextIOWrapper(io.BytesIO(data), encoding="utf-8", newline=""), delimiter=separator)
    rows = ((reader.line_num, row) for row in reader)
    try:
        seen = list(itertools.islice(rows, _LOOK))
        columns = _columns([row for _, row in seen if any(cell.strip() for cell in row)])
        if not columns:
            return data, columns
        body = [*seen, *rows]
    except (UnicodeDecodeError, csv.Error):
        return data, frozenset()
    midnight = _passes_midnight([row for _, row in body], columns)
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator="\n")
    line = 0
    for last, row in body:
        text.write("\n" * (last - line - 1))
        line = last
        writer.writerow([_seconds(cell, decimal, midnight) if k in columns else cell for k, cell in enumerate(row)])
    return text.getvalue().encode(), columns


def called_date(cell: str) -> bool:
    """Tell whether a cell looks like a date or a time of day, also of a form that is not read."""
    return _CALLED.search(cell) is not None


def _columns(rows: Sequence[Sequence[str]]) -> frozenset[int]:
    """Return the columns with nothing but dates, or times of day, below a line or two of names and units."""
    width = max(map(len, rows), default=0)
    below = [[row[k].strip() for row in rows[2:] if k < len(row) and row[k].strip()] for k in range(width)]
    return frozenset(
        k for k, cells in enumerate(below) if cells and any(all(map(form.fullmatch, cells)) for form in _FORMS)
    )


def _passes_midnight(rows: Sequence[Sequence[str]], columns: Iterable[int]) -> bool:
    """Tell whether a time of day falls by more than half a day from one row to the next."""
    for k in columns:
        heads = (row[k].strip().partition(":")[0] for row in rows if k < len(row))
        hours = [int(head) for head in heads if head.isdecimal() and len(head) < 3]
        if any(before - after > _HALF_DAY_H for before, after in itertools.pairwise(hours)):
            return True
    return False


def _seconds(cell: str, decimal: str, midnight: bool) -> str:
    """Return a cell's date or time of day in seconds; another cell as it is.

    midnight: whether times of day before noon are of the day after the others.
    """
    found = next(filter(None, (form.fullmatch(cell.strip()) for form in _FORMS)), None)
    if not found:
        return cell
    told = found.groupdict()
    try:
        if "german" in told:
            read = datetime.strptime(f"{told['german']} {told['day']} +0000", "%d.%m.%Y %H:%M:%S %z")
            whole = int(read.timestamp())
        elif "date" in told:
            zone = (told["zone"] or "Z").replace("Z", "+00:00")
            whole = int(datetime.fromisoformat(f"{told['date']}T{told['day']}{zone}").timestamp())
        else:
            hours, minutes, seconds = map(int, told["day"].split(":"))
            whole = 3600 * hours + 60 * minutes + seconds
            whole += _DAY_S if midnight and hours < _HALF_DAY_H else 0
    except ValueError:
        return cell
    return f"{whole}{decimal}{told['part']}" if told["part"] else str(whole)
