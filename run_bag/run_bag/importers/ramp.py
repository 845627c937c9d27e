"""When an unlogged throttle ramp happened, from the rotor's answer.

The throttle leaves the dead zone at t0, goes on in a straight line for D seconds and stays. The rotor's speed answers
as a first-order lag tau of a straight line from 0 to the plateau A above its rest b:

    n(t) = b + A [g(t - t0) - g(t - t0 - D)] / D,   g(x) = x - tau (1 - exp(-x / tau)) for x > 0, else 0

fitted by least squares with a soft-L1 loss to running means of |n|, glitches left out, from the start of the
recording to a little behind the ramp. The shutdown is where the straight line through the first part of the
fall meets the plateau.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..errors import RecordingError
from .signals import glitches, period, running_median, smooth

Array = NDArray[np.float64]
CELL = 0.01  # [s] means that are fitted
BEHIND = 1.0  # [s] of plateau that is fitted
STEP = 0.02  # [s] a shorter ramp is a step
LEAST_PLATEAU = 3.0  # [rad/s] above rest
START = {"duration": 1.0, "lag": 0.05}


@dataclass(frozen=True, kw_only=True)
class Ramp:
    """What the fit found; times on the recording's clock [s], speeds in rad/s, with standard deviations."""

    start: float
    start_std: float
    duration: float
    duration_std: float
    lag: float
    lag_std: float
    plateau: float
    rest: float
    shutdown: float
    shutdown_std: float
    residual: float


def answer(time: Array, start: float, duration: float, lag: float, plateau: float, rest: float) -> Array:
    """Return the rotor's answer to the ramp [rad/s]."""

    def integral(x: Array) -> Array:
        x = np.maximum(x, 0.0)
        return x - lag * (1 - np.exp(-x / lag))

    return rest + plateau * (integral(time - start) - integral(time - start - duration)) / duration


def fit_ramp(time: Array, speed: Array, *, where: str) -> Ramp:
    """Fit the ramp.

    Args:
        time: [s] (N,).
        speed: |n| as measured [rad/s] (N,), rest value included.
        where: what to call the recording in errors.

    Raises:
        RecordingError: the rotor never turns, or turns from the start.
    """
    calm = running_median(speed, time)
    first = time <= time[0] + 0.3
    rest = float(np.median(speed[first]))
    plateau = float(np.percentile(calm, 90)) - rest
    if plateau < LEAST_PLATEAU:
        text = f"{where}: expected the rotor to turn, found |n| never {LEAST_PLATEAU} rad/s above its rest"
        raise RecordingError(text, expected=LEAST_PLATEAU, found=plateau)
    above = np.flatnonzero(calm > rest + plateau / 2)
    if calm[0] > rest + plateau / 2 or above[0] < 10:
        raise RecordingError(f"{where}: expected the recording to start at rest, found the rotor turning", found=rest)
    half = float(time[above[0]])
    below = np.flatnonzero((time > half) & (calm < rest + plateau / 2))
    fall = float(time[below[0]]) if below.size else float(time[-1])
    shutdown, shutdown_std = _shutdown(time, speed, rest, plateau, half, fall, bool(below.size))

    size = max(1, round(CELL / period(time)))
    cells = len(time) // size
    t = time[: cells * size].reshape(cells, size).mean(axis=1)
    n = speed[: cells * size].reshape(cells, size).mean(axis=1)
    reached = float(time[np.flatnonzero(calm > rest + 0.95 * plateau)[0]])
    keep = t < min(reached + BEHIND, shutdown - 0.05)
    for glitch in glitches(time, speed):
        if glitch.time < half:
            keep &= ~((t > glitch.time - 0.15) & (t < glitch.time + 0.45))
    t, n = t[keep], n[keep]
    scale = max(1.4826 * float(np.median(np.abs(n[t < half - 0.5] - rest))), 0.05) if (t < half - 0.5).any() else 1.0

    def residuals(p: Array) -> Array:
        return (answer(t, p[0], p[1], p[2], p[3], p[4]) - n) / scale

    guesses = [(half - d / 2, d) for d in (0.1, 0.5, 1.0, 1.5, 2.5)]
    bounds = ([time[0], 0.005, 0.002, plateau / 2, -np.inf], [fall, 60.0, 1.0, plateau * 2, np.inf])
    fits = [
        least_squares(
            residuals, [max(s, time[0] + 1e-3), d, START["lag"], plateau, rest],
            bounds=bounds, loss="soft_l1", x_scale=[0.1, 0.1, 0.02, plateau, 1.0],
        )
        for s, d in guesses
    ]  # fmt: skip
    best = min(fits, key=lambda f: f.cost)
    r = best.fun
    # neighbouring means share what the model lacks: their correlation widens the deviations
    rho = float(np.clip(np.corrcoef(r[1:], r[:-1])[0, 1], 0.0, 0.98))
    spread = float(np.sum(r**2) / max(len(r) - 5, 1)) * (1 + rho) / (1 - rho)
    jacobian = np.array(best.jac, dtype=np.float64)
    if best.x[1] < STEP:  # a step: its duration cannot be told from zero and must not widen the rest
        jacobian[:, 1] = 0.0
    deviations = np.sqrt(np.maximum(np.diag(np.linalg.pinv(jacobian.T @ jacobian)) * spread, 0.0))
    deviations[1] = max(deviations[1], STEP if best.x[1] < STEP else 0.0)
    start, duration, lag, height, level = (float(x) for x in best.x)
    return Ramp(
        start=start, start_std=float(deviations[0]), duration=duration, duration_std=float(deviations[1]),
        lag=lag, lag_std=float(deviations[2]), plateau=height, rest=level, shutdown=shutdown,
        shutdown_std=shutdown_std, residual=float(np.std(r) * scale),
    )  # fmt: skip


def _shutdown(
    time: Array, speed: Array, rest: float, plateau: float, half: float, fall: float, falls: bool
) -> tuple[float, float]:
    if not falls:
        return float(time[-1]) + period(time), 0.0
    before = (time > max(half, fall - 1.5)) & (time < fall - 0.4)
    level = float(np.median(speed[before])) if before.any() else rest + plateau
    calm = smooth(speed, time, 0.02)
    part = (time > fall - 0.5) & (time < fall + 0.5)
    t, n = time[part], calm[part]
    lowest = np.flatnonzero(n < rest + 0.6 * (level - rest))
    last = int(lowest[0]) if lowest.size else len(n) - 1
    high = np.flatnonzero(n[: last + 1] > rest + 0.9 * (level - rest))
    begin = int(high[-1]) + 1 if high.size else 0
    if last - begin < 3:
        return fall, 0.05
    slope, offset = np.polyfit(t[begin : last + 1], n[begin : last + 1], 1)
    onset = (level - offset) / slope
    return float(onset), max(abs(float(t[begin] - onset)) / 2, period(time))
