"""Rows of a table that an entry of a map takes by the cells of another column: of one sender, or one instance."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["listed", "rows_with"]

_MOST = 10
"""Cells of a column that a sentence lists."""


def rows_with(cells: Sequence[str], told: str, number: Callable[[str], float | None]) -> NDArray[np.bool_]:
    """Return which rows have the cell that a map tells; a number is the same however it is written."""
    value = number(told)
    same = {cell for cell in set(cells) if cell == told or (value is not None and number(cell) == value)}
    return np.array([cell in same for cell in cells], dtype=np.bool_)


def listed(columns: Iterable[tuple[str | int, Sequence[str]]]) -> str:
    """Return which cells there are in some columns, for a sentence."""
    told = []
    for column, cells in columns:
        there = list(dict.fromkeys(cells))
        more = f" and {len(there) - _MOST} more" if len(there) > _MOST else ""
        told.append(f"{column}: {', '.join(there[:_MOST])}{more}")
    return "; ".join(told)
