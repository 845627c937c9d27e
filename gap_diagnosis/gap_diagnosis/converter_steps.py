"""Which steps the converter of a coarse throttle, or of a tachometer, may have: a fast search before any is simulated.

A step s shows as a sharp peak over s, one place among thousands: plateaus flip to another code as u/s changes by a few
hundredths. What a converter adds to the throttle is known for each s, and so is its trace to first order, in the model
linearised along the run; what a converter adds to the speed shows in the readings as it is. Steps are ranked by the
squares that this trace takes off, the other unknowns re-tuned beside it.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from gap_diagnosis.linear import linearised
from gap_diagnosis.prediction import Happened, nearest
from gap_diagnosis.sensitivities import largest_speed
from system_identification.fitting import Fitted, projector
from system_identification.noise import Whitener
from thruster_model.compilation import compiled

__all__ = ["SPACING", "TURN", "likely_speed_steps", "likely_steps"]

Array = NDArray[np.float64]

SPACING = 0.02
"""Of the steps tried, in codes per volt."""
TURN = 0.2
"""Of the steps of a tachometer tried, in codes at the largest speed."""
_FINEST = 0.5  # step of a tachometer in deviations of its noise, below which no trace is left
_MOST_SAMPLES = 20_000
_MOST_CODES = 200.0
"""Codes per volt beyond which no trace is left in ordinary noise."""
_FINE_CODES, _FINER = 60.0, 0.4  # below so many a trace is strong enough for its peak to be sharp
_CHUNK = 64
_LATEST = 60
"""Periods by which commands may act late."""
_ANSWERING = ("speed", "thrust", "torque")


def likely_steps(anchor: Fitted, noise: Whitener, upper: float, count: int) -> Array:
    """Return the steps [V] up to `upper` that take most off the residuals of a fit, best first, at most `count`.

    None where no reading answers to the throttle.
    """
    problem = anchor.problem
    runs = [_Run(anchor, noise, index, happened) for index, happened in enumerate(problem.happened(anchor.x))]
    strength: dict[str, float] = {}
    for run in runs:
        for signal, gains in run.gains.items():
            strength[signal] = strength.get(signal, 0.0) + float(np.sum(gains**2))
    if not strength:
        return np.empty(0)
    signal = max(strength, key=lambda name: strength[name])
    runs = [run for run in runs if signal in run.gains]
    rows = np.concatenate([run.rows[signal] for run in runs])
    fine = np.arange(1.0 / upper, _FINE_CODES, _FINER * SPACING)
    codes = np.concatenate((fine, np.arange(_FINE_CODES, _MOST_CODES, SPACING)))

    def traces(some: Array) -> Array:
        return np.hstack([run.traces(signal, some) for run in runs])

    return _best(anchor, noise.level(signal), rows, traces, codes, count)


def likely_speed_steps(anchor: Fitted, noise: Whitener, upper: float, count: int) -> Array:
    """Return the tachometer's steps [rad/s] up to `upper` that take most off the residuals of a fit, best first.

    At most `count`; none where the speed is not measured. Noise that is added after the converter hides its lattice.
    """
    problem = anchor.problem
    parts = [
        np.arange(each.first, each.last)[problem.known[each.rows]] for each in problem.series if each.signal == "speed"
    ]
    rows = np.concatenate(parts) if parts else np.empty(0, dtype=np.int64)
    if not rows.size:
        return np.empty(0)
    rows = rows[:: rows.size // _MOST_SAMPLES + 1]
    deviation = noise.level("speed")
    predicted = problem.predicted(anchor.x)
    speeds = predicted[rows]
    codes = np.arange(1.0 / upper, 1.0 / (_FINEST * deviation), TURN / largest_speed(problem, predicted))

    def traces(some: Array) -> Array:
        scaled = some[:, None] * speeds
        return np.asarray((np.rint(scaled) - scaled) / some[:, None] / deviation)

    return _best(anchor, deviation, rows, traces, codes, count)


def _best(
    anchor: Fitted,
    deviation: float,
    rows: NDArray[np.int64],
    traces: Callable[[Array], Array],
    codes: Array,
    count: int,
) -> Array:
    """Return the steps, best first, whose traces (C, M) in samples of a signal take most off what a fit left of them.

    `deviation`: of the signal's noise; `traces`: of codes (C,), over that deviation.
    """
    prior = anchor.prior
    basis = projector(anchor.sensitivities[rows] / deviation, prior)
    left = np.concatenate((anchor.residuals[rows] / deviation, -np.sqrt(prior) * anchor.x[: prior.size]))
    along = (left - basis @ (basis.T @ left))[: rows.size]
    score = np.empty(codes.size)
    for first in range(0, codes.size, _CHUNK):
        some = traces(codes[first : first + _CHUNK])
        power = np.sum(some**2, axis=1) - np.sum((some @ basis[: rows.size]) ** 2, axis=1)
        score[first : first + _CHUNK] = 2.0 * some @ along - power
    peaks, _ = find_peaks(np.concatenate(([-np.inf], score, [-np.inf])))
    best = peaks[np.argsort(-score[peaks - 1])[:count]] - 1
    return np.asarray(1.0 / codes[best])


class _Run:
    """How the readings of one recording answer to a little more throttle.

    Attributes:
        rows: of the samples that count, by signal.
        gains: by signal, deviations of the noise for each unit of the rotor's speed [s/rad] at these samples.
    """

    def __init__(self, anchor: Fitted, noise: Whitener, index: int, happened: Happened) -> None:
        problem = anchor.problem
        recording = problem.recordings[index]
        linear = linearised(problem, anchor.x, index, happened)
        self._throttle = _delayed(recording.experiment.throttle, happened.throttle)
        self._keeps = np.ascontiguousarray(linear.transition[:, 0, 0])
        self._pushes = np.ascontiguousarray(linear.gain[:, 0, 0] * linear.by_throttle[0][:, 0])
        shifts, sizes = problem.situation(anchor.x, index).shifts, problem.sizes(anchor.x)
        self.rows, self.gains, self._places = {}, {}, {}
        for each in problem.series:
            if each.recording != index or each.signal not in _ANSWERING:
                continue
            known = problem.known[each.rows]
            places = nearest(each.signal, recording, sizes, shifts)[known]
            self.rows[each.signal] = np.arange(each.first, each.last)[known]
            self._places[each.signal] = places
            self.gains[each.signal] = linear.readings[each.signal][places, 0] / noise.level(each.signal)

    def traces(self, signal: str, codes: Array) -> Array:
        """Return the whitened answers (C, M) of a signal's samples to steps of these codes per volt, shape (C,)."""
        speeds = np.zeros((codes.size, self._keeps.size))
        _answer(codes, self._throttle, self._keeps, self._pushes, speeds)
        return np.asarray(speeds[:, self._places[signal]] * self.gains[signal])


def _delayed(throttle: Array, acting: Array) -> Array:
    """Return commands (N,) by as many periods later as comes nearest to what acts in the plant, (N + 1,)."""
    count = throttle.size
    later = [np.concatenate((np.full(k, acting[0]), throttle))[:count] for k in range(min(_LATEST, count))]
    return later[int(np.argmin([np.sum(np.abs(acting[1:] - each)) for each in later]))]


@compiled
def _answer(codes, throttle, keeps, pushes, speeds):  # type: ignore[no-untyped-def]
    """Fill `speeds` (C, N + 1) with what converters of `codes` per volt add to the rotor's speed [rad/s]."""
    for k in range(codes.size):
        speed = 0.0
        for i in range(throttle.size):
            scaled = codes[k] * throttle[i]
            speed = keeps[i] * speed + pushes[i] * (np.rint(scaled) - scaled) / codes[k]
            speeds[k, i + 1] = speed
