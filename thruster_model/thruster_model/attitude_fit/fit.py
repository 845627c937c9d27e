"""Least squares over short runs: the unknowns under which the rates, begun anew every few seconds, come out best."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from thruster_model.attitude_fit.model import DEFINITIONS, centre, simulate_pieces
from thruster_model.attitude_fit.recording import Recording
from thruster_model.errors import UnfitDataError
from thruster_model.identification.uncertainty import autocorrelation_time

__all__ = ["AttitudeFit", "FitOptions", "fit_attitude"]

Array = NDArray[np.float64]
_LOWER, _UPPER, _WIDTH = (np.array([getattr(d, name) for d in DEFINITIONS]) for name in ("lower", "upper", "width"))
_THINNED = 5
_SMALLEST = 0.02  # rad/s


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """How to fit.

    Attributes:
        piece: after how long the simulation begins anew from the measurement [s]; a free run over a whole recording
            loses its way, and then says nothing of the unknowns.
        passes: solutions, each with the weights that the one before implies.
    """

    piece: float = 2.0
    passes: int = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class AttitudeFit:
    """Unknowns (P,) by `NAMES`, their standard deviations, and what was fitted.

    `deviations` come from scores summed over pieces, so errors within a piece may be correlated as they like. NaN where
    there are no more pieces than unknowns, where a bound was met, or where the prior alone decides.
    """

    values: Array
    deviations: Array
    sizes: Array
    recordings: tuple[str, ...]
    message: str


def fit_attitude(recordings: Sequence[Recording], options: FitOptions | None = None) -> AttitudeFit:
    """Fit the unknowns to recordings together.

    Raises:
        UnfitDataError: no recording, or none that is longer than a piece.
    """
    chosen = options or FitOptions()
    usable = [each for each in recordings if each.time.size * each.dt > chosen.piece]
    if not usable:
        found = ", ".join(f"{each.name} ({each.time.size * each.dt:.1f} s)" for each in recordings) or "none"
        raise UnfitDataError([f"expected recordings longer than a piece of {chosen.piece:g} s; found {found}"])
    values, sizes, memory, message = centre(), np.ones(3), 1.0, ""
    for _ in range(chosen.passes):
        weights = 1.0 / (sizes * np.sqrt(memory))

        def residuals(x: Array, weights: Array = weights) -> Array:
            data = [(e * weights).ravel() for each in usable for e in _errors(each, chosen.piece, x)]
            return np.concatenate((*data, (x - centre()) / _WIDTH))

        found = least_squares(
            residuals,
            np.clip(values, _LOWER + 1e-9, _UPPER - 1e-9),
            bounds=(_LOWER, _UPPER),
            x_scale=_WIDTH,
            max_nfev=60,
        )
        values, message = found.x, str(found.message)
        left = [np.concatenate(_errors(each, chosen.piece, values)) for each in usable]
        sizes = np.maximum(np.sqrt(np.mean(np.concatenate(left) ** 2, axis=0)), _SMALLEST)
        memory = float(np.mean([autocorrelation_time(e[:, k]) for e in left for k in range(3)]))
    return AttitudeFit(
        values=values,
        deviations=_deviations(usable, chosen.piece, values, sizes * np.sqrt(memory)),
        sizes=sizes,
        recordings=tuple(each.name for each in usable),
        message=message,
    )


def _errors(recording: Recording, piece: float, x: Array) -> list[Array]:
    """Return what the simulation misses in each piece, (n, 3) [rad/s]; a piece begins without error and is left out."""
    every = max(2, round(piece / recording.dt))
    made = simulate_pieces(recording.rates, recording.gravity, recording.moments, recording.dt, every, x)
    missed = made - recording.rates
    return [missed[k + _THINNED : k + every : _THINNED] for k in range(0, missed.shape[0] - 2 * _THINNED, every)]


def _deviations(recordings: Sequence[Recording], piece: float, x: Array, sizes: Array) -> Array:
    step = 1e-4 * _WIDTH
    here = [e / sizes for each in recordings for e in _errors(each, piece, x)]
    moved = []
    for k in range(x.size):
        ahead = x.copy()
        ahead[k] += step[k] if x[k] + step[k] <= _UPPER[k] else -step[k]
        there = [e / sizes for each in recordings for e in _errors(each, piece, ahead)]
        moved.append([(b - a).ravel() / (ahead[k] - x[k]) for a, b in zip(here, there, strict=True)])
    pieces = [np.stack([moved[k][i] for k in range(x.size)], axis=1) for i in range(len(here))]
    hessian = sum(J.T @ J for J in pieces) + np.diag(_WIDTH**-2.0)
    scores = np.array([J.T @ e.ravel() for J, e in zip(pieces, here, strict=True)])
    count = len(pieces)
    if count <= x.size:
        return np.full(x.size, np.nan)
    inverse = np.linalg.pinv(np.asarray(hessian), hermitian=True)
    middle = scores.T @ scores * count / (count - x.size) + np.diag(_WIDTH**-2.0)
    deviations = np.sqrt(np.maximum(np.diag(inverse @ middle @ inverse), 0.0))
    held = (x < _LOWER + 1e-6) | (x > _UPPER - 1e-6) | (deviations > 0.5 * _WIDTH)
    return np.where(held, np.nan, deviations)
