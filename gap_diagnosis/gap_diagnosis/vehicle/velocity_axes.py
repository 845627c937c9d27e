r"""A velocity log whose axes are not the body's, told without a model: it must change as IMU and depth say.

With Q the attitude as a rotation, f the specific force, z_g gravity, y what the log tells and R a mounting of it
(`mounting`), over windows from instant a to b

    Q_b R y_b - Q_a R y_a - int (Q f + z_g) dt - int Q dt f_0,      depth_b - depth_a - int [Q R y]_z dt

are least for the mounting that is true; f_0 is a bias of the accelerometer. A log that is late by a part of what it
tells of looks turned: each mounting is tried with delays, and has the best of them.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.spatial.transform import Slerp

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.mounting import MOUNTINGS
from gap_diagnosis.vehicle.rules import TURNED_IMU, WIRING_MARGIN
from gap_diagnosis.vehicle.turns import rotations
from rov_sim.vehicle.innovations import LATE

__all__ = ["velocity_mounting"]

Array = NDArray[np.float64]
_WINDOW = 1.0
"""[s] Over which velocities change by more than a bias of an accelerometer makes of them, and noise by less."""
_DELAYS = (0.0, 0.15, 0.3, 0.45, 0.6)
"""[s] Of the log."""
_FEWEST = 20
"""Windows below which nothing is said."""


class _Seen(NamedTuple):
    """Of one recording, (K, ...) at its instants: attitude, velocity read, speed gained by force, attitude summed up,
    depth; NaN: not measured. Windows: their first and last instants."""

    period: float
    attitude: Array
    read: Array
    gained: Array
    turned: Array
    depth: Array
    windows: tuple[NDArray[np.intp], NDArray[np.intp]]


def velocity_mounting(logs: Sequence[VehicleLog]) -> tuple[Array, float]:
    """Return how the velocity log is mounted, and by how much that is cheaper than as stated [chi squared].

    It is the identity, and nothing, where that would not be worth as many wrong wires as a turned IMU, or where another
    mounting does as well.
    """
    stated = MOUNTINGS[0], 0.0
    if not any(log.there["velocity"] for log in logs):
        return stated
    costs: Array = np.full(len(MOUNTINGS), np.inf)
    for delay in _DELAYS:
        seen = [_seen(log, delay) for log in logs]
        costs = np.minimum(costs, [_cost(seen, R) for R in MOUNTINGS])
    k, second = (int(j) for j in np.argsort(costs)[:2])
    gain = float(costs[0] - costs[k])
    sure = gain > WIRING_MARGIN * TURNED_IMU and costs[second] > costs[k] + WIRING_MARGIN
    return (MOUNTINGS[k], gain) if sure else stated


def _cost(recordings: Sequence[_Seen], R: Array) -> float:
    """Return n log of the mean square left of both, as each has its own noise; 0 where nothing can be said."""
    by_force, by_depth, sums = [], [], []
    for seen in recordings:
        a, b = seen.windows
        v = np.einsum("kij,kj->ki", seen.attitude, seen.read @ R.T)
        by_force.append((v[b] - v[a] - seen.gained[b] + seen.gained[a]).ravel())
        sums.append((seen.turned[b] - seen.turned[a]).reshape(-1, 3))
        fallen = _summed(v[:, 2:], seen.period)[:, 0]
        by_depth.append(seen.depth[b] - seen.depth[a] - fallen[b] + fallen[a])
    force, columns = np.concatenate(by_force), np.concatenate(sums)
    good = np.isfinite(force) & np.isfinite(columns).all(axis=1)
    bias = np.linalg.lstsq(columns[good], force[good], rcond=None)[0]
    return _left(force[good] - columns[good] @ bias) + _left(np.concatenate(by_depth))


def _left(errors: Array) -> float:
    errors = errors[np.isfinite(errors)]
    return errors.size * float(np.log(np.mean(errors**2) + 1e-12)) if errors.size >= _FEWEST else 0.0


def _seen(log: VehicleLog, delay: float) -> _Seen:
    instants: Array = log.period * np.arange(log.count, dtype=np.float64)
    attitude = _rotations(log, instants)
    force = np.einsum("kij,kj->ki", attitude, _between(instants, log.told[:, 6:9], instants))
    force[:, 2] += 9.81
    late = log.period * log.lateness[:, LATE.index("velocity")] + delay
    read = _between(instants - late, log.told[:, 10:13], instants)
    return _Seen(
        period=log.period, attitude=attitude, read=read, gained=_summed(force, log.period),
        turned=_summed(attitude, log.period), depth=_between(instants, log.told[:, 9:10], instants)[:, 0],
        windows=_windows(log, read),
    )  # fmt: skip


def _summed(rates: Array, period: float) -> Array:
    """Return the integral up to each instant of rates (K, ...) that are NaN at both ends alone."""
    return np.where(np.isnan(rates), np.nan, cumulative_trapezoid(np.nan_to_num(rates), dx=period, axis=0, initial=0.0))


def _rotations(log: VehicleLog, instants: Array) -> Array:
    """Return the attitude as matrices (K, 3, 3), between readings on the shortest way; NaN beyond them."""
    there = np.flatnonzero(np.isfinite(log.attitude).all(axis=1))
    out = np.full((log.count, 3, 3), np.nan)
    if there.size > 1:
        within = slice(there[0], there[-1] + 1)
        turns = Slerp(instants[there], rotations(log.attitude[there]))
        out[within] = turns(instants[within]).as_matrix()
    return out


def _between(time: Array, values: Array, at: Array) -> Array:
    """Return columns (K, m) that were told at times, at others, on straight lines; NaN beyond what was told."""
    there = np.isfinite(values).all(axis=1)
    if there.sum() < 2:
        return np.full(values.shape, np.nan)
    return np.column_stack([np.interp(at, time[there], v[there], np.nan, np.nan) for v in values.T])


def _windows(log: VehicleLog, read: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first and last instants of windows beside each other."""
    edges = np.arange(0, log.count, max(round(_WINDOW / log.period), 1))
    edges = edges[np.isfinite(read[edges]).all(axis=1)]
    near = np.diff(edges) * log.period < 1.5 * _WINDOW
    return edges[:-1][near], edges[1:][near]
