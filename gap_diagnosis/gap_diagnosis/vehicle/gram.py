r"""Sensitivities of whitened innovations, and all that follows from their products.

r(x) = r_0 + J (x - x_0) for independent numbers r of deviation 1, and x with deviations L: of the recordings

    log p = -1/2 r^T r + 1/2 b^T (A + L^-2)^-1 b - 1/2 log |1 + L A L|,     A = J^T J,  b = -J^T r

so that any set of columns is judged from A and b alone. A column is the change of r by a finite probe.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.descent import normal
from gap_diagnosis.vehicle.side_by_side import side_by_side

__all__ = ["Column", "Gram", "evidence", "gathered", "solution"]

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """A direction: its name, the deviation of its size (0: a switch, on or off), and the change of r of each run by a
    probe, over the probe."""

    name: object
    deviation: float
    change: Callable[[int], Array]


@dataclass(frozen=True, kw_only=True, eq=False)
class Gram:
    """Products of the columns and the residual, over all runs.

    Attributes:
        names: of the columns.
        deviations: of their sizes; 0: a switch.
        A: (n, n); b: (n,), of -r; rr: r^T r.
        scatter: (n,), by how much more than expected the columns' scores vary from block to block, 1 or more.
    """

    names: tuple[object, ...]
    deviations: Array
    A: Array
    b: Array
    rr: float
    scatter: Array = field(default_factory=lambda: np.ones(0))

    def index(self, name: object) -> int:
        """Return the place of a column."""
        return self.names.index(name)


def gathered(residuals: Sequence[Array], columns: Sequence[Column], base: int = 0, block: int = 0) -> Gram:
    """Return the products for residuals r_0 of each run, flat, and columns.

    base, block: with both, `scatter` is judged of the columns beyond the first `base`, by blocks of so many rows.
    """
    n, whole = len(columns), []
    for k, r in enumerate(residuals):
        J = np.empty((r.size, n), dtype=np.float32, order="F")

        def fill(j: int, k: int = k, J: NDArray[np.float32] = J) -> None:
            J[:, j] = columns[j].change(k).ravel()

        side_by_side(fill, range(n))
        J[~np.isfinite(J)] = 0.0
        whole.append((J, r.ravel().astype(np.float32)))
    A, slope = normal([J for J, _ in whole], [r.ravel() for r in residuals], np.zeros(n), np.zeros(n))
    rr = sum(float(r.ravel() @ r.ravel()) for r in residuals)
    return Gram(
        names=tuple(c.name for c in columns),
        deviations=np.array([c.deviation for c in columns]),
        A=A,
        b=-slope,
        rr=rr,
        scatter=_scatter(whole, A, -slope, base, block) if block else np.ones(n),
    )


def _scatter(whole: Sequence[tuple[Any, Any]], A: Array, b: Array, base: int, block: int) -> Array:
    """Return the variance of the columns' scores between blocks over the expected one, nuisances projected out.

    What is left of a column v once the base explains what it can of it has the score sum v r of each block, which
    varies by sum v^2 where the numbers r are what they should be. A jump that no noise explains makes it vary more, and
    what a column gains from it counts as much less.
    """
    inverse = np.linalg.inv(A[:base, :base] + np.eye(base))
    shadow = inverse @ A[:base]
    x = inverse @ b[:base]

    def by_block(of_run: tuple[Any, Any]) -> tuple[Array, Array]:
        J, r = of_run
        left = r + J[:, :base] @ x.astype(np.float32)
        edges = np.arange(0, len(r), block)
        scores, squares = np.zeros((len(edges), J.shape[1])), np.zeros((len(edges), J.shape[1]))
        for first in range(base, J.shape[1], 128):
            last = min(first + 128, J.shape[1])
            v = J[:, first:last] - J[:, :base] @ shadow[:, first:last].astype(np.float32)
            scores[:, first:last] = np.add.reduceat(v * left[:, None], edges)
            squares[:, first:last] = np.add.reduceat(v * v, edges)
        return scores, squares

    s, q = (np.concatenate(each) for each in zip(*side_by_side(by_block, whole), strict=True))
    total = q.sum(axis=0)
    size = s.sum(axis=0) / np.maximum(total, 1e-9)
    around = ((s - size * q) ** 2).sum(axis=0)
    out = np.ones(A.shape[0])
    seen = total > 1e-6
    out[seen] = np.maximum(around[seen] / total[seen], 1.0)
    out[:base] = 1.0
    return out


def solution(gram: Gram, chosen: Sequence[int], on: Sequence[int] = ()) -> tuple[Array, Array]:
    """Return the most likely sizes of the chosen columns and their covariance; `on`: switches that are on."""
    c = np.asarray(chosen, dtype=int)
    b = gram.b[c] - (gram.A[c][:, list(on)].sum(axis=1) if on else 0.0)
    H = gram.A[np.ix_(c, c)] + np.diag(1.0 / gram.deviations[c] ** 2)
    factor = _factor(H)
    inverse = np.linalg.inv(factor)
    covariance = inverse.T @ inverse
    return covariance @ b, covariance


def evidence(gram: Gram, chosen: Sequence[int], on: Sequence[int] = ()) -> float:
    """Return the log likelihood of the recordings, sizes of the chosen columns averaged over their deviations."""
    c = np.asarray(chosen, dtype=int)
    rr, b = gram.rr, gram.b[c]
    if on:
        o = list(on)
        rr = rr - 2.0 * gram.b[o].sum() + gram.A[o][:, o].sum()
        b = b - gram.A[c][:, o].sum(axis=1)
    L = gram.deviations[c]
    H = np.eye(c.size) + L[:, None] * gram.A[np.ix_(c, c)] * L[None, :]
    factor = _factor(H)
    z = np.linalg.solve(factor, L * b)
    return float(-0.5 * rr + 0.5 * z @ z - np.sum(np.log(np.diag(factor))))


def _factor(H: Array) -> Array:
    """Return the Cholesky factor of a matrix whose smallest eigenvalues may be lost in the rounding of its largest."""
    return np.linalg.cholesky(H + 1e-13 * np.trace(H) * np.eye(len(H)))
