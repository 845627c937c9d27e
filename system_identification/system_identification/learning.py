"""Levels of noise that are learned from what a fit leaves."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from system_identification.levels import LEAST, Levels
from system_identification.noise import Whitener

__all__ = ["Caps", "learned"]

Array = NDArray[np.float64]
_MEMORIES = (0.3, 6.0)  # [s], of disturbances
_COLOURS = (0.1, 10.0)  # [s], memories of what sensors carry
_PULL = 0.02
"""Of logarithms of levels to ordinary ones: where the rows do not say."""
_STEP = 0.02
_DONE = 0.3  # of the deviance


@dataclass(frozen=True, kw_only=True)
class Caps:
    """What noise may be: ranges of white noise over the samples' own, of colours, and the largest level of pushes."""

    sensors: tuple[float, float] = (0.5, 30.0)
    colours: float = 30.0
    pushes: float = 5.0


def learned(base: Whitener, residuals: Array, caps: Caps, *, steps: int = 5, taken: float = 0.0) -> Whitener:
    """Return the map with levels under which residuals (R,) are most likely, within caps, by Fisher scoring.

    Args:
        base: where to start.
        residuals: measured less predicted, NaN where nothing counts.
        caps: what noise may be.
        steps: at most so many.
        taken: how many degrees of freedom fitting has used up.
    """
    system, bare = base.system, replace(base, loose=None)
    known = system.known
    share = 1.0 - min(taken / max(int(np.sum(known)), 1), 0.5)
    names, pushes = system.signal_names, len(base.levels.pushes)
    s = len(names)

    def levels_at(z: Array) -> Levels:
        values = np.exp(z)
        return replace(
            base.levels,
            sensors={n: float(system.levels[n] * v) for n, v in zip(names, values[:s], strict=True)},
            colours=dict(zip(names, values[s : 2 * s].tolist(), strict=True)),
            colour_memory=dict(zip(names, values[2 * s : 3 * s].tolist(), strict=True)),
            pushes=tuple(values[3 * s : 3 * s + pushes].tolist()),
            memory=float(values[-1]),
        )

    def seen(z: Array) -> tuple[Array, Array]:
        """Return white rows and logarithms of the innovations' variances."""
        trial = replace(bare, levels=levels_at(z))
        return trial.whiten(residuals)[known], 2.0 * np.log(trial.deviations[known])

    pulled = np.concatenate((np.zeros(s), np.full(2 * s + pushes + 1, _PULL)))

    def deviance(white: Array, logs: Array, z: Array) -> float:
        return float(white @ white) / share + float(np.sum(logs)) + float(pulled @ (z - centre) ** 2)

    low = np.log([caps.sensors[0]] * s + [LEAST] * s + [_COLOURS[0]] * s + [LEAST] * pushes + [_MEMORIES[0]])
    high = np.log(
        [caps.sensors[1]] * s + [caps.colours] * s + [_COLOURS[1]] * s + [caps.pushes] * pushes + [_MEMORIES[1]]
    )
    centre = np.log([1.0] * s + [0.1] * s + [1.0] * s + [0.5] * pushes + [1.5])
    z = np.log(
        [
            *(base.levels.sensors[n] / system.levels[n] for n in names),
            *(max(base.levels.colours[n], 0.1) for n in names),
            *(base.levels.colour_memory[n] for n in names),
            *(max(level, 0.1) for level in base.levels.pushes),
            base.levels.memory,
        ]
    )

    def differences(z: Array) -> Array:
        """Return steps for the slopes; at its least a colour is none, and has no memory."""
        step = np.where(z + _STEP <= high, _STEP, -_STEP)
        colours, memories = slice(s, 2 * s), slice(2 * s, 3 * s)
        none = z[colours] <= low[colours]
        step[colours] = np.where(none, (centre - low)[colours], step[colours])
        step[memories] = np.where(none, 0.0, step[memories])
        return step

    z = np.clip(z, low, high)
    white, logs = seen(z)
    here, damping = deviance(white, logs, z), 1e-3
    for _ in range(steps):
        by_white, by_logs = np.zeros((white.size, z.size)), np.zeros((white.size, z.size))
        steps_of_z = differences(z)
        for k in np.flatnonzero(steps_of_z):
            there = seen(z + np.where(np.arange(z.size) == k, steps_of_z, 0.0))
            by_white[:, k], by_logs[:, k] = (there[0] - white) / steps_of_z[k], (there[1] - logs) / steps_of_z[k]
        slope = np.sum(by_logs, axis=0) + 2.0 * by_white.T @ white / share + 2.0 * pulled * (z - centre)
        innovation = by_white + 0.5 * white[:, None] * by_logs
        curvature = 2.0 * innovation.T @ innovation + by_logs.T @ by_logs + np.diag(2.0 * pulled)
        held = ((z <= low) & (slope > 0.0)) | ((z >= high) & (slope < 0.0))
        curvature[held] = curvature[:, held] = 0.0
        curvature[np.diag_indices(z.size)] += np.where(held, 1.0, 1e-6)
        slope = np.where(held, 0.0, slope)
        gained = 0.0
        for _ in range(4):
            move = np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), -slope)
            trial = np.clip(z + np.clip(move, -1.5, 1.5), low, high)
            there = seen(trial)
            value = deviance(*there, trial)
            if value < here:
                gained, z, (white, logs), here = here - value, trial, there, value
                damping = max(0.1 * damping, 1e-6)
                break
            damping = max(10.0 * damping, 1e-2)
        if gained < _DONE:
            break
    return replace(bare, levels=levels_at(z))
