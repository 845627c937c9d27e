"""The noise of each signal: an autoregression, and residuals whitened by it.

Missing samples are bridged by the autoregression's own forecast, so whitening stays linear in the residuals: columns
of a Jacobian are whitened by the same function. The first samples of a series count by the marginal deviation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.compilation import compiled
from thruster_model.identification.uncertainty import autocorrelation_time

__all__ = ["NoiseModel", "Series", "SignalNoise", "fit_noise", "white_noise", "widened"]

Array = NDArray[np.float64]
LARGEST_ORDER = 4
LARGEST_RATIO = 3.0
_BLOCK = 1.0  # [s]
_FEWEST_BLOCKS = 20
_BY_CHANCE = 9.0  # of a squared correlation times the number of blocks


class Series(NamedTuple):
    """Where the samples of one signal of one recording stand in the vector of residuals."""

    recording: int
    signal: str
    first: int
    last: int

    @property
    def rows(self) -> slice:
        """Of the vector."""
        return slice(self.first, self.last)


@dataclass(frozen=True, kw_only=True)
class SignalNoise:
    """Noise of one signal: r_k = sum_i coefficients_i r_{k-i} + innovation e_k; deviations in the signal's unit."""

    innovation: float
    marginal: float
    coefficients: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True)
class NoiseModel:
    """Noise by signal."""

    signals: dict[str, SignalNoise]

    def whiten(self, series: Sequence[Series], rows: Array) -> Array:
        """Return rows (R,) or (R, K) as white ones of standard deviation 1; NaN rows become 0."""
        flat = np.ascontiguousarray(rows.reshape(rows.shape[0], -1))
        out = np.empty_like(flat)
        for each in series:
            noise = self.signals[each.signal]
            _whiten(flat[each.rows], np.array(noise.coefficients), noise.innovation, noise.marginal, out[each.rows])
        return out.reshape(rows.shape)


@compiled
def _whiten(rows, coefficients, innovation, marginal, out):  # type: ignore[no-untyped-def]
    order = coefficients.size
    past = np.zeros(order + 1)
    for column in range(rows.shape[1]):
        past[:] = 0.0
        for k in range(rows.shape[0]):
            forecast = 0.0
            for i in range(order):
                forecast += coefficients[i] * past[i]
            value = rows[k, column]
            known = np.isfinite(value)
            if not known:
                value = forecast
            if k < order:
                out[k, column] = value / marginal if known else 0.0
            else:
                out[k, column] = (value - forecast) / innovation if known else 0.0
            for i in range(order - 1, 0, -1):
                past[i] = past[i - 1]
            if order > 0:
                past[0] = value


def white_noise(levels: dict[str, float]) -> NoiseModel:
    """Return white noise of these standard deviations by signal."""
    return NoiseModel(signals={name: SignalNoise(innovation=s, marginal=s) for name, s in levels.items()})


def fit_noise(series: Sequence[Series], residuals: Array, lost: float = 0.0, opaque: Sequence[str] = ()) -> NoiseModel:
    """Return the noise that residuals (R,), NaN = missing, have.

    Args:
        series: where the residuals of each signal stand.
        residuals: shape (R,).
        lost: share of freedom that fitting has used up.
        opaque: signals whose residuals are no autoregression (a coarse converter's): white, as large as their memory
            leaves them worth.

    The order of each autoregression, up to 4, is the one of least deviance with six units to pay for each coefficient;
    covariances are pooled over recordings.
    """
    signals = {}
    for name in dict.fromkeys(each.signal for each in series):
        pieces = [residuals[each.rows] for each in series if each.signal == name]
        covariance, count = _covariances(pieces, LARGEST_ORDER)
        covariance = covariance / (1.0 - lost)
        if name in opaque:
            level = float(np.sqrt(covariance[0] * _memory(pieces)))
            signals[name] = SignalNoise(innovation=level, marginal=level)
            continue
        best: tuple[float, tuple[float, ...], float] = (np.inf, (), float(covariance[0]))
        coefficients: Array = np.empty(0)
        variance = covariance[0]
        for order in range(LARGEST_ORDER + 1):
            if order:
                reflected = (covariance[order] - coefficients @ covariance[1:order][::-1]) / variance
                reflected = float(np.clip(reflected, -0.98, 0.98))
                coefficients = np.concatenate((coefficients - reflected * coefficients[::-1], [reflected]))
                variance = variance * (1.0 - reflected**2)
            criterion = count * np.log(variance) + 6.0 * order
            if criterion < best[0]:
                best = (float(criterion), tuple(float(c) for c in coefficients), float(variance))
        signals[name] = _bounded(pieces, covariance, best[1], best[2])
    return NoiseModel(signals=signals)


def widened(noise: NoiseModel, series: Sequence[Series], times: Array, residuals: Array) -> NoiseModel:
    """Return the noise with innovations larger by what the signals have in common.

    A disturbance of the plant reaches several readings: together they say less than each by itself times their number.
    A signal's variance grows by the sum of its squared correlations with the others, as means over a second show them
    once whitened: a composite likelihood that counts what is common once.

    Args:
        noise: of each signal by itself.
        series: where the residuals of each signal stand.
        times: of the samples [s], shape (R,).
        residuals: that are left, NaN = missing, shape (R,).
    """
    white = noise.whiten(series, residuals)
    names = list(noise.signals)
    means: dict[tuple[int, int], Array] = {}
    for each in series:
        known = np.isfinite(residuals[each.rows])
        blocks = np.floor(times[each.rows] / _BLOCK).astype(np.int64)[known]
        for block, count in zip(*np.unique(blocks, return_counts=True), strict=True):
            row = means.setdefault((each.recording, int(block)), np.full(len(names), np.nan))
            row[names.index(each.signal)] = np.sum(white[each.rows][known][blocks == block]) / np.sqrt(count)
    table = np.array(list(means.values()))
    widths = dict.fromkeys(names, 1.0)
    for i, j in combinations(range(len(names)), 2):
        both = table[np.all(np.isfinite(table[:, [i, j]]), axis=1)][:, [i, j]]
        if both.shape[0] < _FEWEST_BLOCKS:
            continue
        squared = float(np.corrcoef(both.T)[0, 1] ** 2)
        if squared * both.shape[0] > _BY_CHANCE:
            widths[names[i]] += squared
            widths[names[j]] += squared
    return NoiseModel(
        signals={n: replace(s, innovation=s.innovation * float(np.sqrt(widths[n]))) for n, s in noise.signals.items()}
    )


def _bounded(
    pieces: Sequence[Array], covariance: Array, coefficients: tuple[float, ...], variance: float
) -> SignalNoise:
    """Return the noise with an innovation of at least a third of the marginal deviation.

    Residuals of a model that is wrong wander slowly, and an autoregression would let them: only the fastest would
    count. Where it predicts that well, it is damped, and the innovation stands for what then still remembers.
    """
    marginal = float(np.sqrt(covariance[0]))
    a = np.array(coefficients)
    if np.sqrt(variance) * LARGEST_RATIO >= marginal:
        return SignalNoise(innovation=float(np.sqrt(variance)), marginal=marginal, coefficients=coefficients)
    order = a.size
    table = covariance[np.abs(np.subtract.outer(np.arange(order), np.arange(order)))]
    while np.sqrt(variance) * LARGEST_RATIO < marginal:
        a = a * 0.97 ** np.arange(1, order + 1)
        variance = float(covariance[0] - 2.0 * a @ covariance[1 : order + 1] + a @ table @ a)
    left = [np.convolve(piece, np.concatenate(([1.0], -a)))[order : piece.size] for piece in pieces]
    remembered = float(np.sqrt(variance * _memory(left)))
    return SignalNoise(innovation=min(remembered, marginal), marginal=marginal, coefficients=tuple(float(c) for c in a))


def _memory(pieces: Sequence[Array]) -> float:
    """Return how many samples are worth one."""
    times = [autocorrelation_time(piece) for piece in pieces if np.sum(np.isfinite(piece)) > 50]
    return float(np.mean(times)) if times else 1.0


def _covariances(pieces: Sequence[Array], order: int) -> tuple[Array, int]:
    """Return autocovariances (order + 1,) of pieces about zero, and how many samples there are."""
    sums, counts = np.zeros(order + 1), np.zeros(order + 1)
    for piece in pieces:
        known = np.isfinite(piece)
        filled = np.where(known, piece, 0.0)
        for lag in range(min(order + 1, piece.size)):
            sums[lag] += float(filled[lag:] @ filled[: piece.size - lag])
            counts[lag] += float(np.sum(known[lag:] & known[: piece.size - lag]))
    covariance = sums / np.maximum(counts, 1.0)
    covariance[0] = max(covariance[0], 1e-300)
    table = covariance[np.abs(np.subtract.outer(np.arange(order + 1), np.arange(order + 1)))]
    if np.min(np.linalg.eigvalsh(table)) <= 1e-9 * covariance[0]:
        covariance = np.concatenate((covariance[:1], sums[1:] / max(counts[0], 1.0)))  # no covariance, because of gaps
    return covariance, int(counts[0])
