"""What a recording offers a map: named series of numbers on its own clock."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..errors import RecordingError
from .recording_map import Mapped

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Samples of one column or field.

    Attributes:
        origin: zero of the stamps [ns].
        stamps: [ns] after the origin, non-decreasing, (N,).
        values: as recorded, (N,); NaN = not measured.
        rows: which row or message of the recording each one is, (N,).
    """

    origin: int
    stamps: NDArray[np.int64]
    values: Array
    rows: NDArray[np.intp]


class Source(Protocol):
    """A recording that is open."""

    path: Path

    def __hash__(self) -> int:
        """Return a hash: what was read of it is kept."""

    def names(self) -> list[str]:
        """Return the columns or fields, as a map names them."""

    def unit(self, name: str) -> str:
        """Return the unit that the recording states, "" where it states none."""

    def has(self, entry: Mapped) -> bool:
        """Tell whether the entry's column or field is in it."""

    def series(self, entry: Mapped) -> Series:
        """Return the samples of an entry; RecordingError where they make no sense."""

    def refusal(self, entry: Mapped, row: int, expected: str) -> RecordingError:
        """Return the error about one value of an entry."""
