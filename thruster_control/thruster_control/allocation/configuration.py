r"""What a thruster configuration K_t (6, N) can do: its inverse, its null vectors, and the directions it lacks.

(2.21)   tau = K_t T,    tau = (X, Y, Z, K, M, N) [N, N m],    T [N]

The inverse keeps attitude before translation: it takes the rows of K_t in groups, first those of the moments, then
those of the forces, last those of axes that are given up, and for each group uses what the groups before leave free:

         P := 0,  Z := I;   for each group g:   B = Z (K_g Z)^+,   P := P + B (S_g - K_g P),   Z := Z null(K_g Z)

(S_g selects the group's entries of tau.) Where K_t has rank 6 this P is the pseudo-inverse, K_t^+ (the shortest T for
the wrench), and for six thrusters K_t^-1.

A left null vector d of K_t, d^T K_t = 0, is a direction of the wrench that is lost: whatever the thrusts, d^T tau = 0.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["AXES", "groups", "inverse", "lost_directions", "lost_in_words", "null_vectors", "rank"]

Array = NDArray[np.float64]
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_TOLERANCE = 1e-9  # of the largest singular value or entry: what is smaller is zero
_SAID = 0.05  # share of the largest component from which a component is put into words


def _checked(configuration: ArrayLike) -> Array:
    K_t = np.asarray(configuration, dtype=np.float64)
    if K_t.ndim != 2 or K_t.shape[0] != 6 or not np.all(np.isfinite(K_t)):
        found = f"shape {K_t.shape}" + ("" if np.all(np.isfinite(K_t)) else " with numbers that are not finite")
        raise ValueError(f"K_t: expected finite numbers of shape (6, N); found {found}")
    return K_t


def rank(configuration: ArrayLike) -> int:
    """Return the number of directions of the wrench that K_t (6, N) can make."""
    return int(np.linalg.matrix_rank(_checked(configuration), rtol=_TOLERANCE)) if np.size(configuration) else 0


def groups(given_up: Sequence[str] = ()) -> list[list[int]]:
    """Return the rows of the wrench in the order in which they are kept; `given_up`: axes of `AXES` that come last.

    Raises:
        ValueError: an axis that there is not.
    """
    if unknown := [axis for axis in given_up if axis not in AXES]:
        raise ValueError(f"given_up: expected axes among {', '.join(AXES)}; found {', '.join(unknown)}")
    last = [AXES.index(axis) for axis in given_up]
    kept = [[row for row in rows if row not in last] for rows in ((3, 4, 5), (0, 1, 2))]
    return [rows for rows in (*kept, last) if rows]


def inverse(configuration: ArrayLike, given_up: Sequence[str] = ()) -> Array:
    """Return (N, 6): the thrusts [N] for a wrench, attitude before translation before what is given up."""
    K_t = _checked(configuration)
    smallest = _TOLERANCE * max(float(np.abs(K_t).max(initial=0.0)), 1e-300)
    P, Z = np.zeros((K_t.shape[1], 6)), np.eye(K_t.shape[1])
    for rows in groups(given_up):
        free = K_t[rows] @ Z
        left, s, right = np.linalg.svd(free)
        count = int(np.sum(s > smallest))
        B = Z @ (right[:count].T / s[:count]) @ left[:, :count].T
        P += B @ (np.eye(6)[rows] - K_t[rows] @ P)
        Z = Z @ right[count:].T
    return np.ascontiguousarray(P)


def null_vectors(configuration: ArrayLike) -> Array:
    """Return (k, N): thrusts that add up to no wrench, each of as few thrusters as elimination finds, largest 1.

    Columns of zeros (thrusters that are left out) have none.
    """
    K_t = _checked(configuration)
    used = np.flatnonzero(np.any(K_t != 0.0, axis=0))
    R, pivots = _reduced(K_t[:, used])
    free = [column for column in range(used.size) if column not in pivots]
    vectors = np.zeros((len(free), K_t.shape[1]))
    for row, column in enumerate(free):
        vectors[row, used[column]] = 1.0
        vectors[row, used[pivots]] = -R[: len(pivots), column]
        vectors[row] /= vectors[row][np.argmax(np.abs(vectors[row]) > (1.0 - _TOLERANCE) * np.abs(vectors[row]).max())]
    vectors[np.abs(vectors) < _TOLERANCE] = 0.0
    return vectors


def _reduced(matrix: Array) -> tuple[Array, list[int]]:
    """Return the reduced row echelon form and its pivot columns."""
    R = matrix.copy()
    pivots: list[int] = []
    smallest = _TOLERANCE * float(np.abs(matrix).max(initial=0.0))
    for column in range(R.shape[1]):
        row = len(pivots)
        if row == R.shape[0]:
            break
        best = row + int(np.argmax(np.abs(R[row:, column])))
        if abs(R[best, column]) <= smallest:
            continue
        R[[row, best]] = R[[best, row]]
        R[row] /= R[row, column]
        others = np.arange(R.shape[0]) != row
        R[others] -= np.outer(R[others, column], R[row])
        pivots.append(column)
    return R, pivots


def lost_directions(configuration: ArrayLike) -> Array:
    """Return (k, 6): unit directions of the wrench that no thrusts can make, each on as few axes as elimination finds.

    The unit of length in them is the metre.
    """
    K_t = _checked(configuration)
    left, s, _ = np.linalg.svd(K_t)
    lost = left[:, int(np.sum(s > _TOLERANCE * max(float(s.max(initial=0.0)), 1e-300))) :].T
    if not lost.size:
        return np.zeros((0, 6))
    lost = _reduced(lost)[0]
    lost[np.abs(lost) < _TOLERANCE] = 0.0
    return np.asarray(lost / np.linalg.norm(lost, axis=1, keepdims=True))


def lost_in_words(configuration: ArrayLike, given_up: Sequence[str] = ()) -> str:
    """Return which directions of the wrench are lost, "" for none, e.g. 'sway (0.86) with surge (0.51)'.

    A lost direction ties axes to each other; named are those of its last group, which is what `inverse` gives up.
    """
    said = []
    for direction in lost_directions(configuration):
        rows = [rows for rows in groups(given_up) if np.abs(direction[rows]).max() > _TOLERANCE][-1]
        part = direction[rows] / np.linalg.norm(direction[rows])
        part = part * np.sign(part[np.argmax(np.abs(part))])
        shown = [i for i in np.argsort(-np.abs(part), kind="stable") if abs(part[i]) > _SAID]
        names = [AXES[rows[i]] for i in shown]
        if len(shown) > 1:
            names = [f"{name} ({part[i]:.2f})" for name, i in zip(names, shown, strict=True)]
        said.append(" with ".join(names))
    return " and ".join(said)
