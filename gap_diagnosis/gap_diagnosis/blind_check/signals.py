"""Excitation of the blind check: throttle programmes and speed programmes, at random within a range."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

__all__ = ["PERIOD", "POOR", "closed_loop_campaign", "poor_campaign", "rich_campaign"]

Array = NDArray[np.float64]

PERIOD = 0.04
"""Time between two commands and between two samples [s]."""
POOR = ("constant", "one_step", "low")
_REST = 25  # samples of zero throttle at both ends: 1 s


def rich_campaign(rng: np.random.Generator, duration: float = 30.0, largest: float = 3.5) -> dict[str, Array]:
    """Return the throttle [V] of the standard campaign's runs by name: steps, multisine, ramps, constant."""
    count = round(duration / PERIOD)
    return {
        "steps": _rested(_steps(count, rng, largest, 0.6, 3.0)),
        "multisine": _rested(_multisine(count, rng, largest)),
        "ramps": _rested(_ramps(count, rng, largest)),
        "constant": _rested(_constants(count, rng, largest)),
    }


def poor_campaign(kind: str, rng: np.random.Generator, duration: float = 30.0) -> dict[str, Array]:
    """Return the throttle [V] of runs that excite little: `POOR`."""
    count = round(duration / PERIOD)
    level = float(rng.choice([-1.0, 1.0]) * rng.uniform(1.2, 3.0))
    if kind == "constant":
        return {f"constant_{i}": np.full(count, level) for i in range(2)}
    if kind == "one_step":
        second = level * float(rng.uniform(1.05, 1.3))
        return {"one_step": np.concatenate((np.full(count // 2, level), np.full(count - count // 2, second)))}
    return {"low": _rested(_multisine(count, rng, 1.2)), "low_steps": _rested(_steps(count, rng, 1.2, 1.0, 4.0))}


def closed_loop_campaign(rng: np.random.Generator, duration: float = 30.0) -> dict[str, Array]:
    """Return the desired speeds [rad/s] of runs under a speed loop: steps, triangle, sine, multisine."""
    count = round(duration / PERIOD)
    time = PERIOD * np.arange(count)
    top = float(rng.uniform(80.0, 120.0))
    turns = time / float(rng.uniform(5.0, 10.0))
    triangle = top * (4.0 * np.abs((turns + 0.75) % 1.0 - 0.5) - 1.0)
    sine = top * np.sin(2.0 * np.pi * float(rng.uniform(0.1, 0.4)) * time)
    return {
        "speed_steps": _rested(_steps(count, rng, top, 1.0, 3.0)),
        "speed_triangle": _rested(triangle),
        "speed_sine": _rested(sine),
        "speed_multisine": _rested(_multisine(count, rng, top)),
    }


def _rested(values: Array) -> Array:
    values = values.copy()
    values[:_REST] = 0.0
    values[-_REST:] = 0.0
    return values


def _steps(count: int, rng: np.random.Generator, largest: float, shortest: float, longest: float) -> Array:
    pieces: list[Array] = []
    while sum(piece.size for piece in pieces) < count:
        held = round(float(rng.uniform(shortest, longest)) / PERIOD)
        pieces.append(np.full(held, float(rng.uniform(-largest, largest))))
    return np.concatenate(pieces)[:count]


def _multisine(count: int, rng: np.random.Generator, largest: float) -> Array:
    time = PERIOD * np.arange(count)
    frequencies = np.geomspace(0.05, 1.0, 12) * rng.uniform(0.9, 1.1, 12)
    phases = rng.uniform(0.0, 2.0 * np.pi, 12)
    sum_ = np.sum(np.sin(2.0 * np.pi * np.outer(time, frequencies) + phases), axis=1)
    return np.asarray(largest * sum_ / np.max(np.abs(sum_)))


def _ramps(count: int, rng: np.random.Generator, largest: float) -> Array:
    knots, levels, sign = [0.0], [0.0], float(rng.choice([-1.0, 1.0]))
    while knots[-1] < count * PERIOD:
        knots.append(knots[-1] + float(rng.uniform(1.5, 6.0)))
        levels.append(sign * float(rng.uniform(0.3, 1.0)) * largest)
        sign = -sign
    return np.interp(PERIOD * np.arange(count), knots, levels)


def _constants(count: int, rng: np.random.Generator, largest: float) -> Array:
    holds = int(rng.integers(3, 5))
    bounds = np.sort(rng.uniform(0.7, 1.3, holds)).cumsum()
    edges = np.concatenate(([0], np.round(bounds / bounds[-1] * count).astype(int)))
    values = np.empty(count)
    for begin, end in pairwise(edges):
        values[begin:end] = float(rng.choice([-1.0, 1.0]) * rng.uniform(1.1, largest))
    return values
