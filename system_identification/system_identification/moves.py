r"""What rows do at random along columns that differ from run to run, and rows with that taken off.

Rows of run r move by C_r m_r u, u ~ N(0, 1): a few columns C_r, and what each of the J independent moves does to them.
A parameter that differs in each run is one column and as many moves. With W all of these, the rows' covariance is
1 + W W', of which the inverse square root is 1 - W K W' with a small matrix K (J, J).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.system import System

__all__ = ["Moves", "TakenOff", "rows_of_runs"]

Array = NDArray[np.float64]


def rows_of_runs(system: System) -> list[slice]:
    """Return where the rows of each run stand: the series of a run follow each other."""
    found: dict[int, slice] = {}
    for each in system.series:
        known = found.get(each.recording)
        found[each.recording] = each.rows if known is None else slice(known.start, each.last)
    return list(found.values())


class Moves(NamedTuple):
    """Columns (R, B), and by run what each move does to them, (runs, B, J)."""

    runs: Sequence[slice]
    columns: Array
    mixed: Array

    def along(self, moved: Array) -> Array:
        """Return what moves (J,) do to the rows, (R,)."""
        out = np.zeros(self.columns.shape[0])
        for run, mixed in zip(self.runs, self.mixed, strict=True):
            out[run] = self.columns[run] @ (mixed @ moved)
        return out

    def scaled(self, by: Array) -> "Moves":
        """Return moves so many times as large, (J,); those of no size are left out."""
        return self._replace(mixed=(self.mixed * by)[:, :, by != 0.0])

    @property
    def gram(self) -> Array:
        """Inner products of all moves, (J, J)."""
        out = np.zeros(self.mixed.shape[2:] * 2)
        for run, mixed in zip(self.runs, self.mixed, strict=True):
            here = np.flatnonzero(np.any(mixed != 0.0, axis=1) & np.any(self.columns[run] != 0.0, axis=0))
            there = np.flatnonzero(np.any(mixed[here] != 0.0, axis=0))
            columns, part = self.columns[run][:, here], mixed[np.ix_(here, there)]
            out[np.ix_(there, there)] += part.T @ (columns.T @ columns) @ part
        return out

    def onto(self, rows: Array) -> Array:
        """Return the inner products of all moves with rows (R, C), (J, C)."""
        found = [mixed.T @ (self.columns[run].T @ rows[run]) for run, mixed in zip(self.runs, self.mixed, strict=True)]
        return np.asarray(sum(found))


class TakenOff(NamedTuple):
    """White rows, of deviation 1 with moves beside them, made white again.

    Attributes:
        moves: of the white rows.
        core: K, (J, J).
        log_det: of 1 + W W'.
    """

    moves: Moves
    core: Array
    log_det: float

    @classmethod
    def of(cls, moves: Moves, gram: Array | None = None) -> "TakenOff":
        """Return the map beside these moves of white rows; `gram`: their inner products, where these are known."""
        values, vectors = np.linalg.eigh(moves.gram if gram is None else gram)
        values, vectors = values[values > 1e-9], vectors[:, values > 1e-9]
        core = (vectors * ((1.0 - 1.0 / np.sqrt(1.0 + values)) / values)) @ vectors.T
        return cls(moves, core, float(np.sum(np.log1p(values))))

    def __call__(self, white: Array) -> Array:
        """Return white rows (R, C) with what moves them taken off."""
        by = self.core @ self.moves.onto(white)
        out = np.empty_like(white)
        for run, mixed in zip(self.moves.runs, self.moves.mixed, strict=True):
            out[run] = white[run] - self.moves.columns[run] @ (mixed @ by)
        return out
