r"""A velocity log whose axes are not the body's, told without a model: it must change as IMU and depth say.

With Q the attitude as a rotation, f the specific force, z_g gravity, y what the log tells and R a mounting of it
(`mounting`), over windows from instant a to b

    Q_b R y_b - Q_a R y_a - int (Q f + z_g) dt - int Q dt f_0,      depth_b - depth_a - int [Q R y]_z dt

are least for the mounting that is true; f_0 is a bias of the accelerometer. A log that is late by a part of what it
tells of looks turned: each mounting is tried with delays, and has the best of them. The same sums tell how many times
as large as them the log reads, and whether a turn by no right angle leaves less.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation, Slerp

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.mounting import MOUNTINGS
from gap_diagnosis.vehicle.rules import TURNED_IMU, WIRING_MARGIN
from gap_diagnosis.vehicle.turns import rotations
from rov_sim.vehicle.innovations import LATE

__all__ = ["velocity_between", "velocity_mounting", "velocity_size"]

Array = NDArray[np.float64]
_WINDOW = 1.0
"""[s] Over which velocities change by more than a bias of an accelerometer makes of them, and noise by less."""
_DELAYS = (0.0, 0.15, 0.3, 0.45, 0.6)
"""[s] Of the log."""
_FEWEST = 20
"""Windows below which nothing is said."""
_ALIKE = 0.7
"""Correlation of what a log tells with what others do, from which on their sizes are compared."""
_BETWEEN = 0.45
"""[rad] Of a turn from the nearest right angle, beyond any that the effect of a log mounted askew has."""


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
    costs = _tried(tuple(logs))[1].min(axis=0)
    k, second = (int(j) for j in np.argsort(costs)[:2])
    gain = float(costs[0] - costs[k])
    sure = gain > WIRING_MARGIN * TURNED_IMU and costs[second] > costs[k] + WIRING_MARGIN
    return (MOUNTINGS[k], gain) if sure else stated


def velocity_between(logs: Sequence[VehicleLog]) -> float:
    """Return by how much a velocity log is turned from the nearest right angle [rad], 0 where as stated or one of these
    explains it, or nothing tells.

    It must be worth as many wrong wires as a turned IMU, against the best of them and of those with a wrong sign.
    """
    if not any(log.there["velocity"] for log in logs):
        return 0.0
    tried, costs = _tried(tuple(logs))
    delay = int(np.argmin(costs.min(axis=1)))
    seen = tried[delay]
    mirrored = min(_cost(seen, -R) for R in MOUNTINGS)

    def cost(turn: Array) -> float:
        return _cost(seen, Rotation.from_rotvec(turn).as_matrix())

    start = Rotation.from_matrix(MOUNTINGS[int(np.argmin(costs[delay]))]).as_rotvec()
    simplex = start + np.vstack((np.zeros(3), 0.5 * np.eye(3)))
    found = minimize(
        cost, start, method="Nelder-Mead", options={"initial_simplex": simplex, "xatol": 0.01, "fatol": 0.1}
    )
    turn = Rotation.from_rotvec(found.x)
    apart = min(float((turn * Rotation.from_matrix(R).inv()).magnitude()) for R in MOUNTINGS)
    sure = min(costs.min(), mirrored) - found.fun > WIRING_MARGIN * TURNED_IMU
    return apart if sure and apart > _BETWEEN else 0.0


def velocity_size(logs: Sequence[VehicleLog]) -> float | None:
    """Return how many times as large as depth or accelerometer say a velocity log reads, None where neither says it."""
    told = []
    for delay in _DELAYS if any(log.there["velocity"] for log in logs) else ():
        changed, gained, fallen, depth = _changes([_seen(log, delay) for log in logs], MOUNTINGS[0])
        told += [_alike(changed, gained), _alike(fallen, depth)]
    likeness, ratio = max(told, default=(0.0, 1.0))
    return ratio if likeness > _ALIKE else None


@lru_cache(maxsize=1)  # both questions about a log's direction are asked of the same recordings
def _tried(logs: tuple[VehicleLog, ...]) -> tuple[list[list[_Seen]], Array]:
    """Return the recordings as seen with each delay of the log, and the cost of each mounting then, (delays, 24)."""
    tried = [[_seen(log, delay) for log in logs] for delay in _DELAYS]
    return tried, np.array([[_cost(seen, R) for R in MOUNTINGS] for seen in tried])


def _alike(read: Array, true: Array) -> tuple[float, float]:
    """Return the correlation of two changes, and the ratio of their sizes."""
    good = np.isfinite(read) & np.isfinite(true)
    sizes = float(np.linalg.norm(read[good])), float(np.linalg.norm(true[good]))
    if good.sum() < _FEWEST or min(sizes) == 0.0:
        return 0.0, 1.0
    return float(read[good] @ true[good]) / (sizes[0] * sizes[1]), sizes[0] / sizes[1]


def _cost(recordings: Sequence[_Seen], R: Array) -> float:
    """Return n log of the mean square left of both, as each has its own noise; 0 where nothing can be said."""
    changed, gained, fallen, depth = _changes(recordings, R)
    return _left(changed - gained) + _left(depth - fallen)


def _changes(recordings: Sequence[_Seen], R: Array) -> tuple[Array, Array, Array, Array]:
    """Return by how much velocity changes in each window, as read and by force, and depth, as read and by the log.

    Those of velocity are without what a bias of the accelerometer, constant in the body, may explain.
    """
    changed, gained, fallen, depth, sums = [], [], [], [], []
    for seen in recordings:
        a, b = seen.windows
        v = np.einsum("kij,kj->ki", seen.attitude, seen.read @ R.T)
        changed.append((v[b] - v[a]).ravel())
        gained.append((seen.gained[b] - seen.gained[a]).ravel())
        sums.append((seen.turned[b] - seen.turned[a]).reshape(-1, 3))
        through = _summed(v[:, 2:], seen.period)[:, 0]
        fallen.append(through[b] - through[a])
        depth.append(seen.depth[b] - seen.depth[a])
    of_velocity, columns = np.column_stack([np.concatenate(changed), np.concatenate(gained)]), np.concatenate(sums)
    good = np.isfinite(of_velocity).all(axis=1) & np.isfinite(columns).all(axis=1)
    of_velocity, columns = of_velocity[good], columns[good]
    of_velocity -= columns @ np.linalg.lstsq(columns, of_velocity, rcond=None)[0]
    return of_velocity[:, 0], of_velocity[:, 1], np.concatenate(fallen), np.concatenate(depth)


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
