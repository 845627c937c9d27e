"""Calibrate the load cell: the matrix H_A that turns forces in the legs into the wrench, by linear least squares.

    H_A = H + H_E,      J = |F_w - H_A f|                          (3.4)

Squared and summed over all loads, J is linear least squares in each row of H_A; it has one minimum and needs no
swarm. `population_search` minimises the same J without derivatives, as the thesis did; both must agree wherever the
loads determine H_A.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.errors import UnfitDataError

__all__ = ["Calibration", "LoadData", "calibrate", "wrench"]

Array = NDArray[np.float64]
ROWS = ("f_x", "f_y", "f_z", "m_x", "m_y", "m_z")
WORST_CONDITION = 1e4


@dataclass(frozen=True, kw_only=True)
class LoadData:
    """Loads reduced to what least squares needs: they may be many, or of many recordings.

    Attributes:
        samples: number of loads.
        legs: R of the QR decomposition of the forces in the legs [N] (k, 6), k <= 6.
        loads: Q^T times the wrenches [N, N m] (k, 6).
        rest: what no H_A explains: sum of squares of each component of the wrench (6,).
    """

    samples: int
    legs: Array
    loads: Array
    rest: Array

    @staticmethod
    def of(legs: ArrayLike, wrenches: ArrayLike) -> "LoadData":
        """Return the data for forces in the legs [N] (N, 6) and wrenches [N, N m] (N, 6)."""
        f, W = np.asarray(legs, dtype=np.float64), np.asarray(wrenches, dtype=np.float64)
        if f.ndim != 2 or f.shape[1:] != (6,) or f.shape != W.shape:
            raise UnfitDataError([f"calibration: expected legs and wrenches (N, 6); found {f.shape} and {W.shape}"])
        known = np.all(np.isfinite(f), axis=1) & np.all(np.isfinite(W), axis=1)
        if known.sum() < 1:
            raise UnfitDataError(["calibration: expected at least one load with all values; found none"])
        f, W = f[known], W[known]
        Q, R = np.linalg.qr(f)
        loads = Q.T @ W
        return LoadData(samples=len(f), legs=R, loads=loads, rest=np.sum((W - Q @ loads) ** 2, axis=0))

    @staticmethod
    def pooled(parts: Sequence["LoadData"]) -> "LoadData":
        """Return the data of several together."""
        legs, loads = np.vstack([p.legs for p in parts]), np.vstack([p.loads for p in parts])
        together = LoadData.of(legs, loads)
        return LoadData(
            samples=sum(p.samples for p in parts),
            legs=together.legs,
            loads=together.loads,
            rest=together.rest + sum(p.rest for p in parts),
        )

    def residual(self, matrix: Array) -> Array:
        """Return the root-mean-square of F_w - H_A f by component [N, N m] (6,)."""
        squares = np.sum((self.loads - self.legs @ matrix.T) ** 2, axis=0) + self.rest
        return np.asarray(np.sqrt(squares / self.samples))


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """H_A with what the data say about it.

    Attributes:
        matrix: H_A (6, 6); where the loads do not determine it, the one nearest to the nominal H.
        deviation: standard deviations of its elements, infinite where not determined (6, 6).
        residual: root-mean-square of F_w - H_A f, by component [N, N m] (6,).
        rank: of the forces in the legs: 6 when all columns are determined.
        condition: of the forces in the legs.
        missing: sentence for each combination of legs that no load excited.
        samples: number of loads.
    """

    matrix: Array
    deviation: Array
    residual: Array
    rank: int
    condition: float
    missing: tuple[str, ...]
    samples: int

    @property
    def complete(self) -> bool:
        """Tell whether the loads determine every column."""
        return self.rank == 6


def calibrate(data: LoadData, nominal: ArrayLike | None = None) -> Calibration:
    """Return H_A = H + H_E by linear least squares.

    Args:
        data: of the loads.
        nominal: H (6, 6), for what the loads do not determine; zero if it is not known.
    """
    H = np.zeros((6, 6)) if nominal is None else np.asarray(nominal, dtype=np.float64)
    _, values, V = np.linalg.svd(data.legs, full_matrices=True)
    values = np.concatenate([values, np.zeros(6 - values.size)])
    excited = values > values[0] / WORST_CONDITION if values[0] > 0 else np.zeros(6, dtype=bool)
    inverse = np.where(excited, 1.0 / np.where(excited, values, 1.0), 0.0)
    pseudo = V.T @ np.diag(inverse**2) @ V
    correction = (pseudo @ data.legs.T @ (data.loads - data.legs @ H.T)).T
    matrix = H + correction
    residual = data.residual(matrix)
    rank = int(excited.sum())
    freedom = max(1, data.samples - rank)
    sigma = residual * np.sqrt(data.samples / freedom)
    spread = np.sqrt(np.diag(pseudo))
    hidden = V[~excited]
    undetermined = np.any(np.abs(hidden) > 1e-3, axis=0) if hidden.size else np.zeros(6, dtype=bool)
    deviation = np.outer(sigma, np.where(undetermined, np.inf, spread))
    if data.samples <= rank:
        deviation = np.full((6, 6), np.inf)
    return Calibration(
        matrix=matrix,
        deviation=deviation,
        residual=residual,
        rank=rank,
        condition=float(values[0] / values[-1]) if values[-1] > 0 else float("inf"),
        missing=tuple(_sentence(row) for row in hidden),
        samples=data.samples,
    )


def wrench(matrix: ArrayLike, legs: ArrayLike) -> Array:
    """Return H_A f (..., 6) for forces in the legs [N] (..., 6)."""
    return np.asarray(np.asarray(legs, dtype=np.float64) @ np.asarray(matrix, dtype=np.float64).T)


def _sentence(row: Array) -> str:
    row = row * np.sign(row[np.argmax(np.abs(row))])
    parts = " ".join(f"{value:+.2f} f_{i + 1}" for i, value in enumerate(row) if abs(value) > 0.05)
    return f"no load changed {parts} by itself: H_A times that is not determined and was left as it was"
