r"""The thrust set points of the rig's closed-loop runs, as functions of time.

Time t [s] counts from the start of a run, thrust T_d [N] is positive forward. A run lasts 10 s.

step    T_d = -10 for t < 5,   +10 for t >= 5
sine    T_d = 5 cos(1.88 t) - 5
ramp    T_d = 0 -> -10 in 2 s, held 1 s, -> +10 in 4 s, held 1 s, -> 0 in 2 s; 0 before and after

The rig sampled each straight piece of its ramp with both ends included (50 or 100 samples), so that its recorded
ramp departs from this one by up to one period's change, 0.2 N at 25 Hz; step and sine agree to rounding.

Published scores leave out windows in which the load cell rings. Whether their ends count is not recorded; here a
window holds its start and not its end.

Source: README.md of the recordings of the thruster bench.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["DURATION", "REFERENCES", "Reference", "Window", "ramp", "scored", "sine", "step"]

Array = NDArray[np.float64]

DURATION = 10.0
"""Length of a run [s]."""

_LEVEL = 10.0  # N
_STEP_TIME = 5.0  # s
_SINE_AMPLITUDE = 5.0  # N
_SINE_OFFSET = -5.0  # N
_SINE_FREQUENCY = 1.88  # rad/s
_RAMP_TIMES = (0.0, 2.0, 3.0, 7.0, 8.0, 10.0)  # s
_RAMP_FORCES = (0.0, -_LEVEL, -_LEVEL, _LEVEL, _LEVEL, 0.0)  # N


class Window(NamedTuple):
    """Instants start <= t < end [s]."""

    start: float
    end: float


class Reference(NamedTuple):
    """A set point of thrust and the windows that published scores of it leave out."""

    thrust: Callable[[ArrayLike], Array]
    """From time [s] to desired thrust [N]."""
    left_out: tuple[Window, ...]


def step(time: ArrayLike) -> Array:
    """Return the step's desired thrust [N] at `time` [s], of the same shape; NaN at NaN."""
    t = np.asarray(time, dtype=np.float64)
    return np.where(np.isnan(t), np.nan, np.where(t < _STEP_TIME, -_LEVEL, _LEVEL))


def sine(time: ArrayLike) -> Array:
    """Return the sine's desired thrust [N] at `time` [s], of the same shape; NaN at NaN."""
    t = np.asarray(time, dtype=np.float64)
    return np.asarray(_SINE_AMPLITUDE * np.cos(_SINE_FREQUENCY * t) + _SINE_OFFSET)


def ramp(time: ArrayLike) -> Array:
    """Return the ramp's desired thrust [N] at `time` [s], of the same shape; NaN at NaN."""
    return np.asarray(np.interp(np.asarray(time, dtype=np.float64), _RAMP_TIMES, _RAMP_FORCES))


def scored(time: ArrayLike, left_out: tuple[Window, ...]) -> NDArray[np.bool_]:
    """Return where `time` [s] lies in the run and in none of the windows `left_out`; False at NaN."""
    t = np.asarray(time, dtype=np.float64)
    inside = (t >= 0.0) & (t <= DURATION)
    for window in left_out:
        inside = inside & ~((t >= window.start) & (t < window.end))
    return np.asarray(inside)


REFERENCES: Mapping[str, Reference] = MappingProxyType(
    {
        "step": Reference(step, (Window(0.0, 1.2), Window(5.0, 6.2))),
        "sine": Reference(sine, ()),
        "ramp": Reference(ramp, (Window(0.0, 0.6), Window(4.8, 6.0))),
    }
)
