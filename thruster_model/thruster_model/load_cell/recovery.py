"""Thrust out of a ringing load cell, with a standard deviation that knows how well the mode is known.

The smoothed thrust is that of the most likely mode; its variance is the smoother's plus the scatter of the smoothed
thrust over modes drawn from their standard deviations, plus the square of half the scatter between what force and
moment say on their own: two routes that share the mode but no measurement. Thrust is the mean over cells of 40 ms,
the period at which thrusters are controlled: faster changes of thrust are not claimed.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from thruster_model.load_cell.resonance import Resonance
from thruster_model.load_cell.smoothing import smooth
from thruster_model.load_cell.structure import MEAN, THRUST, Mode, Noise, Stretch, linear_model

__all__ = ["CELL", "Recovered", "Saved", "recover", "saved_share"]

Array = NDArray[np.float64]
CELL = 0.04
"""Width of a cell [s]."""
_DRAWS = 12


@dataclass(frozen=True, kw_only=True)
class Recovered:
    """Thrust of one recording.

    Attributes:
        time: of the samples [s] (N,).
        thrust, deviation: and its standard deviation [N] (N,).
        innovation: of force and moment in standard deviations (N, 2).
        cell_time: centres of the cells [s] (M,).
        cell_thrust, cell_deviation: means over them and their standard deviation [N] (M,).
        cell_reading: mean reading of the force [N] (M,).
        cell_difference: thrust from the force alone less thrust from the moment alone [N] (M,).
    """

    time: Array
    thrust: Array
    deviation: Array
    innovation: Array
    cell_time: Array
    cell_thrust: Array
    cell_deviation: Array
    cell_reading: Array
    cell_difference: Array


@dataclass(frozen=True, kw_only=True)
class Saved:
    """How much of a window that is otherwise cut is recovered: cells, and shares with a deviation below 0.5 and 1 N."""

    cells: int
    below_half: float
    below_one: float
    median_deviation: float


def recover(stretch: Stretch, resonance: Resonance, *, draws: int = _DRAWS, seed: int = 1) -> Recovered:
    """Return the thrust of a recording."""
    width = max(1, round(CELL / float(stretch.time[1] - stretch.time[0])))
    noise, mode = resonance.noise, resonance.single.get(stretch.name, resonance.mode)
    smoothed = smooth(stretch.reading, linear_model(stretch, mode, noise, cell=width))
    thrust, means = smoothed.mean[:, THRUST], smoothed.mean[width::width, MEAN]
    variance = smoothed.covariance[:, THRUST, THRUST]
    mean_variance = smoothed.covariance[width::width, MEAN, MEAN]
    # What a number differs by between recordings says more about the model's error than the curvature of one fit.
    known_scatter = {n: d for n, d in resonance.deviation.items() if np.isfinite(d)}
    deviations = {**resonance.single_deviation.get(stretch.name, {}), **known_scatter}
    rng = np.random.default_rng(seed)
    others = [
        smooth(stretch.reading, linear_model(stretch, _drawn(mode, deviations, rng), noise, cell=width)).mean
        for _ in range(draws)
    ]
    if others:
        variance = variance + np.mean([(x[:, THRUST] - thrust) ** 2 for x in others], axis=0)
        mean_variance = mean_variance + np.mean([(x[width::width, MEAN] - means) ** 2 for x in others], axis=0)
    alone = []
    for channel in (0, 1):
        only = np.full_like(stretch.reading, np.nan)
        only[:, channel] = stretch.reading[:, channel]
        alone.append(_one_channel(replace(stretch, reading=only), mode, noise, width))
    count = means.size
    jumping = _cells(stretch.jump, width)[:count] > 0.0
    difference = alone[0][:count] - alone[1][:count]
    known = np.all(np.isfinite(stretch.reading).any(axis=0))
    spread = _spread(difference, jumping) if known else np.zeros(count)
    fine = np.minimum(np.arange(stretch.time.size) // width, count - 1)
    return Recovered(
        time=stretch.time,
        thrust=thrust,
        deviation=np.sqrt(variance + spread[fine] ** 2),
        innovation=smoothed.innovation,
        cell_time=_cells(stretch.time, width)[:count],
        cell_thrust=means,
        cell_deviation=np.sqrt(mean_variance + spread**2),
        cell_reading=_cells(stretch.reading[:, 0], width)[:count],
        cell_difference=difference,
    )


def _one_channel(stretch: Stretch, mode: Mode, noise: Noise, width: int) -> Array:
    """Return cell means of the thrust from the channel that is not NaN."""
    model = linear_model(stretch, mode, noise, cell=width)
    first = stretch.reading[: 2 * width]
    start = np.nanmean(first) if np.isfinite(first).any() else 0.0
    mean = np.zeros_like(model.mean)
    mean[[0, THRUST]] = start / (1.0 if np.isfinite(stretch.reading[:, 0]).any() else mode.arm_gain)
    return np.asarray(smooth(stretch.reading, replace(model, mean=mean)).mean[width::width, MEAN])


def _spread(difference: Array, jumping: NDArray[np.bool_]) -> Array:
    """Return half the robust scatter between the two channels' own answers, around its median over a second."""
    seconds = 2 * round(0.5 / CELL) + 1
    fast = difference - median_filter(difference, seconds, mode="nearest")
    result = np.zeros(difference.size)
    for phase in (jumping, ~jumping):
        if phase.any():
            result[phase] = 0.5 * float(np.sqrt(np.mean(fast[phase] ** 2)))
    return result


def saved_share(recovered: Recovered, windows: Sequence[tuple[float, float]]) -> Saved:
    """Return what is recovered within windows (start, end) [s]."""
    at = recovered.cell_time
    inside = np.zeros(at.size, dtype=bool)
    for start, end in windows:
        inside |= (at >= start) & (at < end)
    deviation = recovered.cell_deviation[inside]
    if deviation.size == 0:
        return Saved(cells=0, below_half=float("nan"), below_one=float("nan"), median_deviation=float("nan"))
    return Saved(
        cells=int(deviation.size),
        below_half=float(np.mean(deviation < 0.5)),
        below_one=float(np.mean(deviation < 1.0)),
        median_deviation=float(np.median(deviation)),
    )


def _drawn(mode: Mode, deviations: Mapping[str, float], rng: np.random.Generator) -> Mode:
    """Return a mode drawn from the standard deviations; numbers whose deviation is unknown stay."""
    values = dict(vars(mode))
    for name, deviation in deviations.items():
        if np.isfinite(deviation):
            values[name] += deviation * rng.standard_normal()
    values["damping"] = float(np.clip(values["damping"], 0.005, 0.5))
    return Mode(**values)


def _cells(values: Array, width: int) -> Array:
    count = values.size // width
    return np.asarray(values[: count * width].reshape(count, width).mean(axis=1))
