"""A long table, with a row for each reading and its name in a column of its own, made wide: a column for each name.

Further columns of words, such as remarks, are left out.
"""

from __future__ import annotations

import csv
import io
import itertools
import re
from collections.abc import Callable, Sequence

from .column_names import bare_name, called_time
from .conversions import is_unit

__all__ = ["made_wide"]

MOST_NAMES = 256
"""Of a long table: a wide one has so many cells in each row."""
MOST_COLUMNS = 12
"""Of a long table, remarks and all."""
_LOOK = 100  # rows
_UNITS = re.compile(r"_?(units?|einheit(en)?|unit(e|é)s?|dimension)", re.IGNORECASE)
"""What the column of units is called."""
_NAMES = re.compile(
    r"_?(signal|name|channel|sensor|topic|variable|var|key|measurement|field|metric|parameter|tag|quantity|series|label|"
    r"kanal|messgr(ö|oe)(ß|ss)e|bezeichnung|canal|grandeur)s?(_?name)?",
    re.IGNORECASE,
)
"""What the column of names is called: another one of words, a mode, stands beside one signal."""


def made_wide(
    data: bytes, separator: str, number: Callable[[str], float | None]
) -> tuple[bytes, tuple[str, ...]] | None:
    """Return a long table as a wide one, line by line, with the columns that are left out; None where it is none.

    A long table has, below the names of its columns, two columns of numbers (a time, then a value or the other way
    round), one of names, perhaps one of units, and others that are no numbers. A column of units may have words
    that are none of ours: they come behind their names as the known ones do.
    """
    reader = csv.reader(io.TextIOWrapper(io.BytesIO(data), encoding="utf-8", newline=""), delimiter=separator)
    rows = ((reader.line_num, [cell.strip() for cell in row]) for row in reader if any(cell.strip() for cell in row))
    try:
        first, head = next(rows, (0, []))
        seen = list(itertools.islice(rows, _LOOK))
        places = _places(head, [row for _, row in seen], number)
        if places is None:
            return None
        body = [*seen, *rows]
    except (UnicodeDecodeError, csv.Error):
        return None
    if any(len(row) != len(head) for _, row in body):
        return None
    time, name, value, unit = places
    units = {row[name]: row[unit] if unit is not None else "" for _, row in reversed(body)}
    names = list(dict.fromkeys(row[name] for _, row in body))
    if len(names) > MOST_NAMES:
        return None
    at = {each: k for k, each in enumerate(names)}
    text = io.StringIO()
    writer = csv.writer(text, delimiter=separator, lineterminator="\n")
    text.write("\n" * (first - 1))
    writer.writerow([head[time], *(f"{each} [{units[each]}]" if units[each] else each for each in names)])
    line = first
    for number_of_line, row in body:
        text.write("\n" * (number_of_line - line - 1))
        line, k = number_of_line, at[row[name]]
        text.write(f"{row[time]}{separator * (k + 1)}{row[value]}{separator * (len(names) - 1 - k)}\n")
    return text.getvalue().encode(), tuple(each for k, each in enumerate(head) if k not in places)


def _places(
    head: Sequence[str], rows: Sequence[Sequence[str]], number: Callable[[str], float | None]
) -> tuple[int, int, int, int | None] | None:
    """Return the columns of time, name, value and unit (None where there is none) of a long table."""
    if not 3 <= len(head) <= MOST_COLUMNS or len(rows) < 4 or any(len(row) != len(head) for row in rows):
        return None
    numbers, texts = [], []
    for k in range(len(head)):
        known = [number(row[k]) is not None for row in rows if row[k]]
        if known and all(known):
            numbers.append(k)
        elif not any(known):
            texts.append(k)
    told = [k for k in texts if any(row[k] for row in rows)]
    names = [k for k in told if _NAMES.fullmatch(bare_name(head[k])) and not all(is_unit(row[k]) for row in rows)]
    if len(numbers) != 2 or len(names) != 1:
        return None
    beside = [k for k in told if k != names[0]]
    stated = {k: {(row[names[0]], row[k]) for row in rows if row[k]} for k in beside}
    called = [k for k in beside if _UNITS.fullmatch(bare_name(head[k])) and _is_of_units(stated[k])]
    units = called or [k for k in beside if all(is_unit(row[k]) for row in rows)]
    units = units or [k for k in beside if _is_of_units(stated[k])]
    if len(units) > 1:
        return None
    if any(not row[names[0]] for row in rows):
        return None
    times = [k for k in numbers if called_time(head[k])]
    time = times[0] if len(times) == 1 else numbers[0]
    (value,) = (k for k in numbers if k != time)
    return time, names[0], value, units[0] if units else None


def _is_of_units(stated: set[tuple[str, str]]) -> bool:
    """Tell whether pairs of a name and a word state units: one for each name, and half of them or more are known.

    A word that is none of ours, such as that of another language, is unknown for its name alone.
    """
    known = sum(is_unit(word) for _, word in stated)
    return len(stated) == len({name for name, _ in stated}) and known > 0 and len(stated) <= 2 * known
