"""Scores of one tracking experiment from what was recorded: set point, thrust, throttle, each on its own stamps.

The run begins where the recorded set point is the named one: at the stamp from which the root mean square of their
difference over the run, 0 <= t < 10 s, is smallest. Thrust is the mean over each period of the set point; the published
windows are left out (`thruster_control.references`).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thruster_control.references import DURATION, REFERENCES, Reference
from thruster_control.scores import Scores, tracking_scores

__all__ = ["KINDS", "Experiment", "Recorded", "experiment_of", "period_means"]

Array = NDArray[np.float64]

KINDS = {"step": "step", "sine": "sine", "triangle": "ramp", "ramp": "ramp"}
"""Names of the set points and what `references` calls them."""
_DIGITS = 6  # of seconds; ends of windows shall not depend on how large a stamp is
_ALIKE = 0.3  # N; the rig's own ramp departs from the reference by 0.2 N


@dataclass(frozen=True, kw_only=True, eq=False)
class Recorded:
    """A signal: instants [s], values, (N,) each."""

    time: Array
    values: Array

    def __post_init__(self) -> None:
        if self.time.ndim != 1 or self.time.shape != self.values.shape:
            raise ValueError(f"expected instants and values of one shape; found {self.time.shape}, {self.values.shape}")


@dataclass(frozen=True, kw_only=True, eq=False)
class Experiment:
    """A run of a set point, N periods.

    Attributes:
        begin: instant of its beginning on the recording's clock [s].
        period: of the control [s].
        time: since the beginning [s], T_d: wanted thrust [N], u: throttle as commanded [V], (N,) each.
        load: mean thrust over each period as the load cell tells it [N], true: the simulator's; (N,), NaN: none.
        scores, true_scores: of either.
    """

    begin: float
    period: float
    time: Array
    T_d: Array
    u: Array
    load: Array
    true: Array
    scores: Scores
    true_scores: Scores


def experiment_of(
    kind: str, set_point: Recorded, throttle: Recorded, load: Recorded | None, true: Recorded | None
) -> Experiment:
    """Return the experiment in a recording.

    Args:
        kind: one of `KINDS`.
        set_point: wanted thrust [N].
        throttle: as commanded [V].
        load: thrust of a load cell, mean or samples [N], None: not recorded.
        true: thrust of a simulator, samples [N], None: not recorded.

    Raises:
        ValueError: the set point is not in the recording.
    """
    if kind not in KINDS:
        raise ValueError(f"reference: expected one of {', '.join(KINDS)}; found {kind!r}")
    reference = REFERENCES[KINDS[kind]]
    if set_point.time.size < 2:
        raise ValueError(f"expected set points of a {kind} of {DURATION:g} s; found {set_point.time.size} samples")
    period = round(float(np.median(np.diff(set_point.time))), _DIGITS)
    count = round(DURATION / period)
    first, off = _beginning(set_point, reference, count)
    if not off < _ALIKE:
        raise ValueError(
            f"expected the set point of a {kind} for {DURATION:g} s; found none, the likest is {off:.2g} N off"
        )
    begin = float(set_point.time[first])
    stamps = set_point.time[first : first + count]
    time = np.round(stamps - begin, _DIGITS)
    u = _at(throttle, stamps)
    edges = np.append(stamps, stamps[-1] + period)
    of_load = np.full(count, np.nan) if load is None else period_means(load, edges)
    of_truth = np.full(count, np.nan)
    if true is not None:
        ends = np.interp(edges, true.time, true.values, left=np.nan, right=np.nan)
        of_truth = 0.5 * (ends[:-1] + ends[1:])
    return Experiment(
        begin=begin, period=period, time=time, T_d=set_point.values[first : first + count], u=u, load=of_load,
        true=of_truth, scores=tracking_scores(time, of_load, u, reference),
        true_scores=tracking_scores(time, of_truth, u, reference),
    )  # fmt: skip


def _beginning(set_point: Recorded, reference: Reference, count: int) -> tuple[int, float]:
    """Return (index, root mean square difference [N]) of the likest beginning, inf where the recording is too short."""
    best = (0, np.inf)
    for first in range(set_point.time.size - count + 1):
        part = slice(first, first + count)
        wanted = reference.thrust(set_point.time[part] - set_point.time[first])
        off = float(np.sqrt(np.mean((set_point.values[part] - wanted) ** 2)))
        if off < best[1]:
            best = (first, off)
    return best


def _at(signal: Recorded, instants: Array) -> Array:
    """Return the values that held at the instants; NaN before the first."""
    index = np.searchsorted(signal.time, instants + 1e-6, side="right") - 1
    return np.asarray(np.where(index >= 0, signal.values[np.maximum(index, 0)], np.nan))


def period_means(signal: Recorded, edges: Array) -> Array:
    """Return the means of the samples in [edge, next edge), (N,), NaN where there is none."""
    index = np.searchsorted(signal.time, edges - 1e-6)
    sums = np.concatenate(([0.0], np.cumsum(signal.values)))
    count = np.diff(index)
    return np.asarray(np.where(count > 0, np.diff(sums[index]) / np.maximum(count, 1), np.nan))
