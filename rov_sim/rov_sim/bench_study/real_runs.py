r"""Real closed-loop recordings: their scores, the disturbances in them, and the input map their controller ran with.

The input map follows from the law that was run. From nd, nhat, vhat, u of the recording, with e = nhat - nd,

    alpha = -e/dt + k_n nd + k_Q Q(nd, vhat) - k_P e - k_I sum e dt,      u = gamma^-1(alpha) = alpha/c + delta

on either side: a straight line whose slope and offset are 1/c_u and delta_u, without any remainder where the law, its
coefficients and the instants are the right ones. The sum includes the present sample.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from rov_sim.bench_study.controllers import InputMap
from rov_sim.bench_study.experiment import KINDS
from thruster_control.references import REFERENCES
from thruster_control.scores import Scores, tracking_scores
from thruster_control.settings import BENCH_GAINS
from thruster_control.wanted_speed import speed_on_side
from thruster_model.equations.thruster import torque

__all__ = [
    "PUBLISHED_START",
    "MeasuredDisturbances",
    "RealRun",
    "RecoveredMap",
    "load_means",
    "lookup_lines",
    "measured_disturbances",
    "model_followed",
    "real_score",
    "recovered_map",
]  # fmt: skip

Array = NDArray[np.float64]

PUBLISHED_START = {
    "CLLookupStep": 0.559, "CLLookupSine": 0.549, "CLLookupRamp": 0.559, "CL1stateStep": 0.399,
    "CL2stateKF1Sine": 0.429, "CL2stateNLO1Ramp": 0.299, "CL2stateKFNLO1Step": 0.389,
}  # fmt: skip
"""Beginning of the published 10 s window on the load cell's clock [s] (README of the recordings)."""
_SPIKE = 0.1  # m/s from the running median
_WINDOW = 11  # samples of the running median
_SAME_SPEED, _CLEARLY = 0.1, 5.0  # rad/s; times by which the other models must be further off
_NEAR_LIMIT, _LIMIT, _LARGEST_RATE = 0.01, 3.0, 100.0  # V, V, V/s


@dataclass(frozen=True, kw_only=True, eq=False)
class RealRun:
    """One recording of a controller on the bench, N periods, SI units, NaN where nothing was recorded.

    Attributes:
        name, strategy, reference: of the recording, of `controllers`, of `experiment.KINDS`.
        period: of the control [s].
        T_d, u, y_n, y_U, n_d, n_hat, v_hat, U_hat: set point [N], throttle [V], readings [rad/s, m/s], n_d [rad/s],
            estimates that u was computed from, (N,) each; y_n is a magnitude.
        load_time, load: the load cell's clock [s] and thrust above its rest [N], (M,).
        start: beginning of the scored 10 s on that clock [s], as published; matched_start: that of the controller's
            recording, from its tachometer against the load cell's.
    """

    name: str
    strategy: str
    reference: str
    period: float
    T_d: Array
    u: Array
    y_n: Array
    y_U: Array
    n_d: Array
    n_hat: Array
    v_hat: Array
    U_hat: Array
    load_time: Array
    load: Array
    start: float
    matched_start: float


class RecoveredMap(NamedTuple):
    """gamma as read off recordings, and the largest remainder of the law in u [V] over `samples` samples."""

    input_map: InputMap
    largest_remainder: float
    samples: int


class MeasuredDisturbances(NamedTuple):
    """Sizes of what disturbs the readings, over all recordings given; units as `rig_sensors.Rig`."""

    speed_noise: float
    flow_noise: float
    spike_share: float
    spike_size: float
    load_noise: float
    flow_samples: int


def load_means(run: RealRun, *, matched: bool = False) -> Array:
    """Return the load cell's mean over each period [N], (N,), NaN where there is none."""
    start = run.matched_start if matched else run.start
    edges = start + run.period * np.arange(run.T_d.size + 1)
    index = np.searchsorted(run.load_time, edges - 1e-9)
    sums = np.concatenate(([0.0], np.cumsum(run.load)))
    count = np.diff(index)
    return np.where(count > 0, np.diff(sums[index]) / np.maximum(count, 1), np.nan)


def real_score(run: RealRun, *, matched: bool = False) -> Scores:
    """Return the recording's score as the simulation is scored: means over the periods, published windows left out."""
    time = run.period * np.arange(run.T_d.size)
    return tracking_scores(time, load_means(run, matched=matched), run.u, REFERENCES[KINDS[run.reference]])


def measured_disturbances(runs: Sequence[RealRun]) -> MeasuredDisturbances:
    """Return the sizes of noise and spikes in recordings.

    Noise: 1.4826 times the median absolute second difference over sqrt(6), the standard deviation of white noise on a
    slow signal; of the load cell's period means while the set point rests. A spike is a sample of the flow more than
    0.1 m/s off the running median of 11.
    """
    speed = [_scatter(run.y_n) for run in runs]
    known = [run.y_U[np.isfinite(run.y_U)] for run in runs]
    flows = [flow for flow in known if flow.size > _WINDOW]
    off = np.concatenate([flow - median_filter(flow, _WINDOW) for flow in flows] or [np.empty(0)])
    spikes = np.abs(off) > _SPIKE
    loads = [_scatter(load_means(run)[_resting(run)]) for run in runs]
    return MeasuredDisturbances(
        float(np.median(speed)),
        float(np.median([_scatter(flow) for flow in flows])) if flows else float("nan"),
        float(np.mean(spikes)) if off.size else float("nan"),
        float(np.sqrt(np.mean(off[spikes] ** 2))) if np.any(spikes) else 0.0,
        float(np.nanmedian(loads)),
        int(off.size),
    )


def _scatter(x: Array) -> float:
    """Return the standard deviation of white noise on a slow signal."""
    if x.size < 10:
        return float("nan")
    return float(1.4826 * np.nanmedian(np.abs(np.diff(x, 2))) / np.sqrt(6.0))


def _resting(run: RealRun) -> NDArray[np.bool_]:
    """Return where the set point has not changed for a second."""
    time = run.period * np.arange(run.T_d.size)
    changes = time[np.flatnonzero(np.diff(run.T_d, prepend=run.T_d[0] + 1.0) != 0.0)]
    last = changes[np.searchsorted(changes, time, side="right") - 1]
    return np.asarray(time - last > 1.0)


def model_followed(T_d: Array, n_d: Array, v_hat: Array, models: Mapping[str, Any]) -> str | None:
    """Return which model's n_d a controller followed, by (4.22) or (4.23) at its own v_hat; None: none of them fits.

    Args:
        T_d, n_d, v_hat: set point [N], wanted speed [rad/s] and estimate [m/s] as recorded, (N,) each.
        models: coefficients by name.
    """
    turning = np.isfinite(n_d + v_hat) & (n_d != 0.0)
    off = {}
    for name, p in models.items():
        wanted = [
            speed_on_side(T, v, 0.0, np.sign(n), p)
            for T, v, n in zip(T_d[turning], v_hat[turning], n_d[turning], strict=True)
        ]
        off[name] = float(np.median(np.abs(np.array(wanted) - n_d[turning]))) if wanted else np.inf
    best, *others = sorted(off, key=lambda name: off[name])
    clear = off[best] < _SAME_SPEED and all(off[name] > _CLEARLY * off[best] for name in others)
    return best if clear else None


def recovered_map(runs: Sequence[RealRun], bench: Any) -> RecoveredMap:
    """Return the input map that the controllers of recordings with feedback ran with; bench: HL's coefficients there.

    Raises:
        ValueError: too few samples within the limits of the throttle on a side.
    """
    alphas, throttles = [], []
    for run in runs:
        if not np.any(np.isfinite(run.n_hat)):
            continue
        e = run.n_hat - run.n_d
        flow = np.where(np.isfinite(run.v_hat), run.v_hat, 0.0)
        losses = bench.k_n * run.n_d + bench.k_Q * torque(run.n_d, flow, bench)
        sigma = np.cumsum(e) * run.period
        alpha = -e / BENCH_GAINS.rate_time + losses - BENCH_GAINS.k_P * e - BENCH_GAINS.k_I * sigma
        free = _unlimited(run)
        alphas.append(alpha[free])
        throttles.append(run.u[free])
    alpha, u = (np.concatenate(x) if x else np.empty(0) for x in (alphas, throttles))
    found, remainders = [], []
    for side, word in ((-1.0, "reverse"), (1.0, "forward")):
        here = (side * u > 0.0) & (side * alpha > 0.0)
        if np.count_nonzero(here) < 10:
            raise ValueError(f"input map: expected at least 10 samples in {word}; found {np.count_nonzero(here)}")
        slope, offset = np.polyfit(alpha[here], u[here], 1)
        found += [float(1.0 / slope), float(offset)]
        remainders.append(np.max(np.abs(u[here] - slope * alpha[here] - offset)))
    return RecoveredMap(InputMap(*found), float(max(remainders)), int(u.size))


def _unlimited(run: RealRun) -> NDArray[np.bool_]:
    """Return where neither size nor rate of the throttle was at its limit."""
    within = np.abs(run.u) < _LIMIT - _NEAR_LIMIT
    return np.asarray(within & (np.abs(np.diff(run.u, prepend=0.0)) < _LARGEST_RATE * run.period - _NEAR_LIMIT))


def lookup_lines(runs: Sequence[RealRun]) -> Array | None:
    """Return the table (throttle, thrust, speed) that open-loop recordings ran with; None without such.

    Their throttle is a straight line over n_d on either side, which is fitted; thrusts are not needed by speed.
    """
    given = [run for run in runs if run.strategy == "lookup" and np.any(np.isfinite(run.n_d))]
    n_d, u = (
        np.concatenate([getattr(run, name)[_unlimited(run)] for run in given] or [np.empty(0)]) for name in ("n_d", "u")
    )
    ends = []
    for side in (-1.0, 1.0):
        here = side * n_d > 1.0
        if not np.any(here) or np.ptp(n_d[here]) < 10.0:
            return None
        slope, offset = np.polyfit(n_d[here], u[here], 1)
        ends.append((offset, side * (_LIMIT - side * offset) / slope))
    (low, n_low), (high, n_high) = ends
    speed = np.array([n_low, 0.0, 0.0, n_high])
    return np.array([[-_LIMIT, low, high, _LIMIT], 1e-3 * np.sign(speed) * speed**2, speed])
