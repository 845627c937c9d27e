r"""Set points of the vehicle over time: a script of moves, as a function of time that kernels call.

Each degree of freedom begins at zero and keeps its value until its next move. With x_0 the value before a move that
begins at t_0 and lasts d, s = (t - t_0) / d, and its size a:

step       x = a from t_0 on
quintic    x = x_0 + (a - x_0) (10 s^3 - 15 s^4 + 6 s^5), a from t_0 + d on: rate and acceleration begin and end at zero
sine       x = x_0 + a sin(2 pi (t - t_0) / period), x_0 from t_0 + d on
hold       x = x_0

Degrees of freedom: surge, sway, heave [m/s], roll, pitch, yaw [rad]. Their derivatives are exact; those of a step are
zero. Beyond the end of the script there is no set point: NaN.
"""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_control.allocation.configuration import AXES
from thruster_control.outer_loop.settings import VehicleSetPoint
from thruster_model.compilation import equation

__all__ = ["SHAPES", "Move", "Script", "script_of", "set_point_at"]

SHAPES = ("step", "quintic", "sine", "hold")
_STEP, _QUINTIC, _SINE = 0, 1, 2


class Move(NamedTuple):
    """One move: time and duration [s], of `SHAPES`, sizes by degree of freedom [m/s, rad], period [s] of a sine."""

    time: float
    shape: str
    size: Mapping[str, float]
    duration: float = 0.0
    period: float = 0.0


class Script(NamedTuple):
    """What a kernel gets: moves (K, 7) by time: axis, t_0, d, shape, x_0, a, period; end [s], infinite for none."""

    moves: NDArray[np.float64]
    end: float


def _problems(move: Move) -> list[str]:
    found = []
    if move.shape not in SHAPES:
        found.append(f"shape: expected one of {', '.join(SHAPES)}; found {move.shape!r}")
    if unknown := [axis for axis in move.size if axis not in AXES]:
        found.append(f"size: expected degrees of freedom among {', '.join(AXES)}; found {', '.join(map(str, unknown))}")
    if not move.size:
        found.append("size: expected a number for one or more degrees of freedom; found none")
    if not all(math.isfinite(size) for size in move.size.values()):
        found.append(f"size: expected finite numbers; found {', '.join(map(str, move.size.values()))}")
    lasts = move.shape in ("quintic", "sine")
    if not (0.0 <= move.time < math.inf and 0.0 <= move.duration < math.inf) or (lasts and move.duration == 0.0):
        least = "above 0" if lasts else "of 0 or more"
        found.append(f"expected a time of 0 s or more and a duration {least} s; found {move.time} s, {move.duration} s")
    if move.shape == "sine" and not 0.0 < move.period < math.inf:
        found.append(f"period: expected a finite time above 0 s; found {move.period} s")
    return found


def script_of(moves: Sequence[Move], end: float = math.inf) -> Script:
    """Return the script of these moves, in any order; at `end` [s] the set point is taken back.

    Raises:
        ValueError: with all that is wrong, one line for each.
    """
    found = [f"move {k}: {problem}" for k, move in enumerate(moves) for problem in _problems(move)]
    if not end > 0.0:
        found.append(f"end: expected a time above 0 s; found {end} s")
    if found:
        raise ValueError("\n".join(found))
    rows, values, free = [], dict.fromkeys(AXES, 0.0), dict.fromkeys(AXES, 0.0)
    for k, move in sorted(enumerate(moves), key=lambda entry: entry[1].time):
        for axis, size in move.size.items():
            if move.time < free[axis] - 1e-9:
                found.append(f"move {k}: {axis} is still moving at {move.time:g} s, until {free[axis]:g} s")
            before, free[axis] = values[axis], move.time + move.duration
            if move.shape in ("step", "quintic"):
                values[axis] = float(size)
            shape = SHAPES.index(move.shape)
            rows.append((AXES.index(axis), move.time, move.duration, shape, before, size, move.period))
    if found:
        raise ValueError("\n".join(found))
    return Script(np.array(rows, dtype=np.float64).reshape(-1, 7), float(end))


@equation
def _moved(shape, x_0, a, since, d, period):  # type: ignore[no-untyped-def]
    """Return (value, rate, acceleration) of a move `since` [s] after it began."""
    if shape == _STEP:
        return a, 0.0, 0.0
    if shape == _QUINTIC:
        s, way = since / d, a - x_0
        if s >= 1.0:
            return a, 0.0, 0.0
        x = x_0 + way * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
        rate = way / d * 30.0 * s * s * (1.0 - s) * (1.0 - s)
        return x, rate, way / (d * d) * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
    if shape == _SINE and since < d:
        w = 2.0 * math.pi / period
        return x_0 + a * math.sin(w * since), a * w * math.cos(w * since), -a * w * w * math.sin(w * since)
    return x_0, 0.0, 0.0


@equation
def _axis_at(script, axis, t):  # type: ignore[no-untyped-def]
    """Return (value, rate, acceleration) of a degree of freedom."""
    found = (0.0, 0.0, 0.0)
    for k in range(script.moves.shape[0]):
        m = script.moves[k]
        if m[0] == axis and m[1] <= t:
            found = _moved(int(m[3]), m[4], m[5], t - m[1], m[2], m[6])
    return found


@equation
def set_point_at(script, t):  # type: ignore[no-untyped-def]
    """Return the `VehicleSetPoint` at a time since the script's beginning [s]; NaN before it and from its end on."""
    if not (t >= 0.0 and t < script.end):
        nowhere = (math.nan, math.nan, math.nan)
        return VehicleSetPoint(nowhere, nowhere, nowhere, nowhere, nowhere)
    u, v, w = _axis_at(script, 0, t), _axis_at(script, 1, t), _axis_at(script, 2, t)
    x, y, z = _axis_at(script, 3, t), _axis_at(script, 4, t), _axis_at(script, 5, t)
    return VehicleSetPoint(
        (x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2]), (u[0], v[0], w[0]), (u[1], v[1], w[1])
    )
