"""What the first lines of a table show: comments before it, its separator and its decimal sign."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence

__all__ = ["SEPARATORS", "decimal_of", "separator_of", "without_comments"]

SEPARATORS = "`;`, tabs, commas, `|` and single blanks are seen, or say `csv: {separator: ...}`"
"""What is read as a table, for a sentence."""
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?")


def without_comments(data: bytes) -> bytes:
    """Return a table whose first lines are empty where they are comments (#), so that lines keep their numbers.

    The last of them names the columns where numbers follow it: so numpy writes a header.
    """
    count = 0
    lines = data[: 1 << 20].splitlines(keepends=True)
    while count < len(lines) and lines[count].lstrip().startswith(b"#"):
        count += 1
    if count == 0:
        return data
    rest = data[sum(map(len, lines[:count])) :]
    follows = lines[count].strip()[:1] if count < len(lines) else b""
    last = lines[count - 1].lstrip().lstrip(b"#").lstrip() if follows in b"0123456789-+." and follows else b"\n"
    return b"\n" * (count - 1) + last + rest


def separator_of(lines: Sequence[str]) -> str:
    """Return the separator of which all the first lines have equally many, the likeliest first."""
    for separator in (";", "\t", ",", "|", " "):
        counts = {len(next(csv.reader([line], delimiter=separator), [])) for line in lines}
        if len(counts) == 1 and counts != {1}:
            return separator
    present = [s for s in (";", "\t", ",") if any(s in line for line in lines[:1])]
    return present[0] if present else ","


def decimal_of(lines: Sequence[str], separator: str) -> str:
    """Return the decimal sign: a comma where a cell is a number with one."""
    if separator == ",":
        return "."
    cells = [cell.strip() for line in lines for cell in line.split(separator)]
    return "," if any(_DECIMAL_COMMA.fullmatch(cell) for cell in cells) else "."
