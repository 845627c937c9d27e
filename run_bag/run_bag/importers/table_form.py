"""What a table shows: comments before it, its decimal sign, and whether its rows are plain."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

__all__ = ["SEPARATORS", "decimal_of", "is_uniform", "without_comments"]

SEPARATORS = "`;`, tabs, commas, `|` and blanks are seen, or say `csv: {separator: ...}`"
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


def decimal_of(lines: Sequence[str], separator: str) -> str:
    """Return the decimal sign: a comma where a cell is a number with one."""
    if separator == ",":
        return "."
    cells = [cell.strip() for line in lines for cell in line.split(separator)]
    return "," if any(_DECIMAL_COMMA.fullmatch(cell) for cell in cells) else "."


def is_uniform(body: bytes, separator: str, width: int) -> bool:
    """Tell whether rows are plain: no quotes, and as many separators in each line as `width` columns have."""
    if b'"' in body or b"\0" in body or b"\r" in body.replace(b"\r\n", b"\n") or not body.isascii():
        return False
    marks = np.frombuffer(body, dtype=np.uint8)
    ends = np.flatnonzero(marks == 10)
    ends = ends if marks[-1] == 10 else np.append(ends, marks.size)
    before = np.searchsorted(np.flatnonzero(marks == ord(separator)), ends)
    counts = np.diff(before, prepend=0)
    lengths = np.diff(ends, prepend=-1) - 1
    blank = lengths == 0
    if b"\r" in body:
        blank |= (lengths == 1) & (marks[np.maximum(ends - 1, 0)] == 13)
    return bool(np.all(counts[~blank] == width - 1)) and (width > 1 or not blank.any())
