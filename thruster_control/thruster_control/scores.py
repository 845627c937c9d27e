r"""How well a wanted thrust was followed, and what that cost the throttle.

Tracking error e = T - T_d over the scored samples (`references.scored`):

    rmse          sqrt(mean e^2)                                   [N]
    of_reference  rmse / sqrt(mean T_d^2)                          over the same samples
    of_lookup     rmse / rmse of the lookup table on the same set point, the thesis' normalisation (section 5.1)
    chatter       integral of |du/dt| = sum |u_k+1 - u_k|          [V], over the whole run

Samples whose thrust or set point is NaN are left out; where none is left the score is NaN.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_control.references import Reference, scored

__all__ = ["Scores", "chatter", "normalised", "overshoot", "reversals", "settling_time", "tracking_scores"]

Array = NDArray[np.float64]


class Scores(NamedTuple):
    """Scores of one run: see the module; `largest` is max |e| [N], `samples` how many were scored."""

    rmse: float
    of_reference: float
    largest: float
    chatter: float
    samples: int


def tracking_scores(time: ArrayLike, thrust: ArrayLike, throttle: ArrayLike, reference: Reference) -> Scores:
    """Return the scores of a run on `reference`: time [s], thrust [N], throttle [V], shape (N,) each."""
    t, T, u = (np.asarray(x, dtype=np.float64) for x in (time, thrust, throttle))
    if t.ndim != 1 or t.shape != T.shape or t.shape != u.shape:
        raise ValueError(f"expected time, thrust and throttle of one shape (N,); found {t.shape}, {T.shape}, {u.shape}")
    T_d = reference.thrust(t)
    kept = scored(t, reference.left_out) & np.isfinite(T) & np.isfinite(T_d)
    e, wanted = (T - T_d)[kept], T_d[kept]
    if e.size == 0:
        return Scores(np.nan, np.nan, np.nan, chatter(u), 0)
    rmse, size = (float(np.sqrt(np.mean(x**2))) for x in (e, wanted))
    share = rmse / size if size > 0.0 else np.nan
    return Scores(rmse, share, float(np.max(np.abs(e))), chatter(u), int(e.size))


def normalised(rmse: float, lookup_rmse: float) -> float:
    """Return the rmse [N] over the lookup table's [N] on the same set point; below 1 is better than the table."""
    return rmse / lookup_rmse if lookup_rmse > 0.0 else float("nan")


def chatter(throttle: ArrayLike) -> float:
    """Return the integral of |du/dt| [V] of a throttle [V], shape (N,), held between samples; NaN is skipped."""
    u = np.asarray(throttle, dtype=np.float64)
    return float(np.sum(np.abs(np.diff(u[np.isfinite(u)]))))


def reversals(throttle: ArrayLike) -> int:
    """Return how often the throttle [V], shape (N,), changes its sign; zeros in between do not hide a change."""
    u = np.asarray(throttle, dtype=np.float64)
    signs = np.sign(u[np.isfinite(u) & (u != 0.0)])
    return int(np.count_nonzero(np.diff(signs)))


def overshoot(thrust: ArrayLike, before: float, after: float) -> float:
    """Return by how much the thrust [N] after a step passes its end, over the step's height; 0 where it does not."""
    T = np.asarray(thrust, dtype=np.float64)
    T = T[np.isfinite(T)]
    if after == before or T.size == 0:
        return float("nan")
    return float(max(np.max((T - after) / (after - before)), 0.0))


def settling_time(time: ArrayLike, thrust: ArrayLike, before: float, after: float, *, band: float = 0.05) -> float:
    """Return the time [s] after which the thrust [N] stays within `band` of the step's height about its end.

    Counted from the first sample, which is the step's; inf where it has not settled by the last one. A thrust that is
    unknown does not count as settled.
    """
    t, T = np.asarray(time, dtype=np.float64), np.asarray(thrust, dtype=np.float64)
    outside = np.flatnonzero(~(np.abs(T - after) <= band * abs(after - before)))
    if outside.size == 0:
        return 0.0
    last = int(outside[-1])
    return float(t[last + 1] - t[0]) if last + 1 < t.size else float("inf")
