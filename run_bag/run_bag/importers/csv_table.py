"""A csv in memory: rows of one width, and the names of its columns if it has a header line."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError

Array = NDArray[np.float64]


class Table:
    """Rows of text with their lines (1-based) in the file; blank lines are left out.

    Raises:
        RecordingError: not readable, without rows, or a row of another width than the first.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            with path.open(encoding="utf-8-sig", newline="") as file:
                reader = csv.reader(file, strict=True)
                rows = [(reader.line_num, row) for row in reader if len(row) > 1 or any(c.strip() for c in row)]
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise RecordingError(f"{path}: cannot be read as csv: {error}", path=path) from error
        named = bool(rows) and any(_number(cell) is None and cell.strip() for cell in rows[0][1])
        self.names = [cell.strip() for cell in rows[0][1]] if named else []
        self.rows = rows[1:] if named else rows
        if not self.rows:
            raise RecordingError(f"{path}: expected rows of numbers, found none", path=path, found=0)
        self.width = len(rows[0][1])
        for line, row in rows:
            if len(row) != self.width:
                text = f"{path}, line {line}: expected {self.width} columns as in line {rows[0][0]}, found {len(row)}"
                raise RecordingError(text, path=path, position=line, expected=self.width, found=len(row))

    def line(self, row: int) -> int:
        """Return the line in the file of a 0-based row."""
        return self.rows[row][0]

    def index(self, column: str | int, channel: str) -> int:
        """Return the 0-based index of a column."""
        if isinstance(column, int):
            if column <= self.width:
                return column - 1
            found = f"{self.width} columns"
        elif self.names.count(column) == 1:
            return self.names.index(column)
        else:
            found = ", ".join(self.names) or "no header line"
            found += f" ({column!r} more than once)" if column in self.names else ""
        text = f"{self.path}: {channel}: expected column {column!r}, found {found}"
        raise RecordingError(text, path=self.path, expected=column, found=found)

    def numbers(self, index: int, nan: frozenset[str], scale: float = 1.0, offset: float = 0.0) -> Array:
        """Return scale * cell + offset of a column; empty cells and those in `nan` are NaN.

        Raises:
            RecordingError: another cell is no finite number, or does not give one.
        """
        result = np.full(len(self.rows), np.nan)
        for i, (_, row) in enumerate(self.rows):
            cell = row[index].strip()
            if not cell or cell in nan:
                continue
            value = _number(cell)
            result[i] = math.nan if value is None else scale * value + offset
            if not math.isfinite(result[i]):
                raise self.refusal(i, index, "a finite number, or this text in the map's `nan`", cell)
        return result

    def refusal(self, row: int, index: int, expected: str, found: str) -> RecordingError:
        """Return the error about one cell."""
        line = self.line(row)
        text = f"{self.path}, line {line}, column {index + 1}: expected {expected}, found {found!r}"
        return RecordingError(text, path=self.path, position=line, expected=expected, found=found)


def _number(cell: str) -> float | None:
    try:
        return None if "_" in cell else float(cell)  # Python reads 1_000 as a number
    except ValueError:
        return None
