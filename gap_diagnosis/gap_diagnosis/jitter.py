"""Stamps that scatter where no log shows it: residuals grow with the slope of the signals, each by itself."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.rules import LOG_RULES
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.suspects import betrayed_by
from system_identification.fitting import Fitted
from system_identification.system import Series

__all__ = ["jitter_in", "jitter_of", "scales_beside"]

Array = NDArray[np.float64]
_CURVED = 0.05  # of a size, by which the signals' curvature may mislead: a slope is taken for the way between instants
_OUTLIER = 25.0  # square over its variance, from which on it is an outlier's


class _Slope(NamedTuple):
    """Residuals of a series and the rate [1/s] of what is predicted, NaN where samples are missing, (M,) each."""

    residuals: Array
    rate: Array


def jitter_in(fitted: Fitted) -> Scatter | None:
    """Return what residuals say of stamps that scatter; None: they do not, or what is wrong on slopes is no chance."""
    size, deviation, odds = jitter_of(fitted)
    if odds < LOG_RULES.jitter or not _is_at_random(fitted, size):
        return None
    return Scatter(
        effect=betrayed_by("stamps"),
        signal="",
        parameter="deviation",
        size=size,
        deviation=deviation,
        log_odds=odds,
        sentence=f"residuals grow with the slope of the signals as if stamps scattered by {1000 * size:.1f} ms",
    )


def jitter_of(fitted: Fitted, sizes: Array | None = None) -> tuple[float, float, float]:
    """Return (size [s], its deviation, log odds) of stamps that scatter, from how residuals grow with the slope.

    A sample is held against the mean of its neighbours: what scatters differs from it, a disturbance that lasts hardly
    does, and that may grow with the slope as well. With r_k - (r_(k-1) + r_(k+1)) / 2 the variance is that of the noise
    plus s^2 (y'_k^2 + (y'_(k-1)^2 + y'_(k+1)^2) / 4); that of the noise is found anew for each signal and each s.
    """
    sizes = np.concatenate(([0.0], np.geomspace(0.001, 0.03, 30))) if sizes is None else sizes
    problem = fitted.problem
    total = np.zeros(sizes.size)
    for signal in problem.signal_rows:
        squares, slopes, own = [], [], []
        for each in problem.series:
            if each.signal != signal:
                continue
            on = _slope(fitted, each)
            if on is None:
                continue
            residuals, slope = on
            apart = (residuals[1:-1] - 0.5 * (residuals[2:] + residuals[:-2])) ** 2
            kept = np.isfinite(apart)
            squares.append(apart[kept])
            slopes.append((slope[1:-1] ** 2 + 0.25 * (slope[2:] ** 2 + slope[:-2] ** 2))[kept])
            own.append(min(_share_of_its_own(apart[kept]), _share_of_its_own(residuals[np.isfinite(residuals)] ** 2)))
        if squares:
            square, slope = np.concatenate(squares), np.concatenate(slopes)
            total += np.mean(own) * np.array([_log_likelihood(square, slope * s**2) for s in sizes])
    best = int(np.argmax(total))
    if best == 0:
        return 0.0, 0.0, 0.0
    likely = np.exp(total - total[best])
    widths = np.gradient(sizes)
    mean = float(np.sum(sizes * likely * widths) / np.sum(likely * widths))
    deviation = float(np.sqrt(np.sum((sizes - mean) ** 2 * likely * widths) / np.sum(likely * widths)))
    occam = np.log(max(np.sqrt(2 * np.pi) * max(deviation, 1e-5) / 0.03, 1e-4))
    return mean, max(deviation, _CURVED * mean), float(total[best] - total[0] + occam)


def _is_at_random(fitted: Fitted, size: float) -> bool:
    """Tell whether errors on slopes look like stamps that scatter by a size [s], and not like a wrong model.

    Over the slope they are times: of either sign, and no two in a row have more to do with each other than others.
    """
    problem = fitted.problem
    times, pairs = [], []
    for each in problem.series:
        on = _slope(fitted, each)
        if on is None:
            continue
        steep = np.abs(on.rate) * size > LOG_RULES.steep * problem.levels[each.signal]
        late = np.where(steep, on.residuals, np.nan) / np.where(steep, on.rate, 1.0)
        late = np.clip(late, -3.0 * size, 3.0 * size)
        times.append(late[np.isfinite(late)])
        pairs.append((late[1:] * late[:-1])[np.isfinite(late[1:] * late[:-1])])
    together, products = np.concatenate([*times, np.empty(0)]), np.concatenate([*pairs, np.empty(0)])
    if min(together.size, products.size) < LOG_RULES.fewest:
        return False
    power = float(np.mean(together**2))
    in_common = abs(float(np.mean(together))) / np.sqrt(power)
    in_a_row = float(np.mean(products)) / power  # below zero where the log has put stamps in order
    return max(in_common, in_a_row) < LOG_RULES.remembered


def scales_beside(fitted: Fitted, size: float) -> Array:
    """Return what whitened samples are worth beside stamps that scatter by a size [s], 1 where nothing moves, (R,)."""
    problem = fitted.problem
    scales = np.ones(problem.known.size)
    for each in problem.series:
        on = _slope(fitted, each)
        if on is not None:
            noise = problem.levels[each.signal]
            scales[each.rows] = 1.0 / np.hypot(1.0, size * on.rate / noise)
    return scales


def _slope(fitted: Fitted, series: Series) -> _Slope | None:
    """Return that of a series; None: too few samples, or a converter's steps are what is left of it."""
    problem = fitted.problem
    if series.signal in problem.opaque:
        return None
    time = problem.recordings[series.recording].experiment.measurements[series.signal].time
    residuals = fitted.residuals[series.rows]
    values = problem.measured[series.rows] - residuals
    found = np.isfinite(values) & problem.known[series.rows]
    if np.sum(found) < 10:
        return None
    filled = np.interp(time, time[found], values[found])
    rate = np.gradient(filled) / np.maximum(np.gradient(time), 1e-4)
    return _Slope(np.where(found, residuals, np.nan), rate)


def _share_of_its_own(squares: Array) -> float:
    """Return the share of a sample that it does not have in common with its neighbours, by their correlation."""
    alike = max(float(np.corrcoef(squares[1:], squares[:-1])[0, 1]), 0.0) if squares.size > 2 else 1.0
    return (1.0 - alike) / (1.0 + alike)


def _log_likelihood(square: Array, extra: Array) -> float:
    """Return that of squares whose variances are `extra` and a common one, outliers left out of that."""
    variance = float(np.median(square) / 0.4549)
    for _ in range(12):
        weight = (square < _OUTLIER * (variance + extra)) / (variance + extra) ** 2
        variance = max(float(np.sum(weight * (square - extra)) / np.sum(weight)), 1e-3 * variance)
    ratio = square / (variance + extra)
    return float(-0.5 * np.sum(np.log(variance + extra) + np.minimum(ratio, _OUTLIER)))
