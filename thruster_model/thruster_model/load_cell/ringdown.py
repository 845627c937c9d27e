"""Frequency and damping of a mode from the ringing that is left when the throttle has stopped jumping.

A segment of a quarter of a second, too short for the amplitude to change much, is fitted by

    y(t) = exp(-zeta w t) (a cos w_d t + b sin w_d t) + c + d t,    w = 2 pi f,  w_d = w sqrt(1 - zeta^2)

with the thrust as a straight line; a, b, c, d are linear and eliminated. Over all segments, the joints' softening is

    f = f_1 - s log10(A / 1 N),     A = the ringing's root-mean-square over the segment, times sqrt(2).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from thruster_model.errors import UnfitDataError

__all__ = ["LEAST_AMPLITUDE", "RingDown", "Segment", "fit_segment", "ring_down"]

Array = NDArray[np.float64]
LEAST_AMPLITUDE = 1.0
"""Least amplitude [N] of a segment that counts."""
LEAST_RATIO = 2.0
"""Least ratio of a segment's amplitude to the root-mean-square of what the fit leaves over."""
BAND = (8.0, 20.0)
_BOOTSTRAPS = 400


@dataclass(frozen=True, kw_only=True)
class Segment:
    """One segment: recording, start [s], amplitude [N], frequency [Hz], damping ratio, rms left over [N]."""

    name: str
    start: float
    amplitude: float
    frequency: float
    damping: float
    residual: float

    @property
    def usable(self) -> bool:
        """Tell whether the ringing stands out and the fit is inside its bounds."""
        inside = BAND[0] + 0.05 < self.frequency < BAND[1] - 0.05 and -0.02 < self.damping < 0.3
        return inside and self.amplitude > max(LEAST_AMPLITUDE, LEAST_RATIO * self.residual)


@dataclass(frozen=True, kw_only=True)
class RingDown:
    """What the segments say together.

    Attributes:
        values: frequency at 1 N [Hz], softening [Hz per decade], damping [1].
        deviation: of these, from resampling whole recordings.
        frequency_scatter: of single segments around the law [Hz], robust.
        rigid_scatter: of single segments around one frequency [Hz], robust.
        segments: all, also those that were not usable.
        by_recording: median departure from the law in frequency [Hz], median damping, number of segments.
        left_out_scatter: frequencies of each recording against the law of the others [Hz], robust.
    """

    values: Mapping[str, float]
    deviation: Mapping[str, float]
    frequency_scatter: float
    rigid_scatter: float
    segments: tuple[Segment, ...]
    by_recording: Mapping[str, tuple[float, float, int]]
    left_out_scatter: float


def fit_segment(name: str, time: Array, reading: Array) -> Segment:
    """Fit one segment of a reading [N] over time [s]."""
    t = time - time[0]

    def basis(p: Array) -> Array:
        f, zeta = p
        w = 2 * np.pi * f
        decay, wd = np.exp(-zeta * w * t), w * np.sqrt(1.0 - zeta**2)
        return np.stack([decay * np.cos(wd * t), decay * np.sin(wd * t), np.ones_like(t), t], axis=1)

    def residual(p: Array) -> Array:
        X = basis(p)
        return np.asarray(reading - X @ np.linalg.lstsq(X, reading, rcond=None)[0])

    fits = [
        least_squares(residual, [f0, 0.03], bounds=([BAND[0], -0.05], [BAND[1], 0.5]), x_scale=[1.0, 0.05])
        for f0 in (11.0, 13.0, 15.0, 17.0)
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    X = basis(best.x)
    ring = X[:, :2] @ np.linalg.lstsq(X, reading, rcond=None)[0][:2]
    return Segment(
        name=name,
        start=float(time[0]),
        amplitude=float(np.sqrt(2.0 * np.mean(ring**2))),
        frequency=float(best.x[0]),
        damping=float(best.x[1]),
        residual=float(np.sqrt(np.mean(residual(best.x) ** 2))),
    )


def ring_down(segments: Sequence[Segment]) -> RingDown:
    """Return the law of frequency and damping over all usable segments.

    Raises:
        UnfitDataError: fewer than three segments ring.
    """
    used = [s for s in segments if s.usable]
    if len(used) < 3:
        text = f"expected at least 3 segments that ring by {LEAST_AMPLITUDE:g} N or more after jumps of the throttle"
        raise UnfitDataError([f"load cell: {text}; found {len(used)} of {len(segments)}"])
    names = sorted({s.name for s in used})
    values = _law(used)
    rng = np.random.default_rng(1)
    draws = []
    for _ in range(_BOOTSTRAPS if len(names) > 2 else 0):
        drawn = [s for name in rng.choice(names, len(names)) for s in used if s.name == name]
        draws.append(_law(drawn))
    departure = np.array([s.frequency - _at(values, s.amplitude) for s in used])
    left_out = []
    for name in names if len(names) > 2 else ():
        others = [s for s in used if s.name != name]
        if len(others) >= 3:
            law = _law(others)
            left_out += [s.frequency - _at(law, s.amplitude) for s in used if s.name == name]
    return RingDown(
        values=dict(zip(("frequency", "softening", "damping"), map(float, values), strict=True)),
        deviation=dict(
            zip(
                ("frequency", "softening", "damping"),
                map(float, np.std(draws, axis=0) if draws else [np.nan] * 3),
                strict=True,
            )
        ),
        frequency_scatter=_robust(departure),
        rigid_scatter=_robust(np.array([s.frequency for s in used])),
        segments=tuple(segments),
        by_recording={
            name: (
                float(np.median([d for d, s in zip(departure, used, strict=True) if s.name == name])),
                float(np.median([s.damping for s in used if s.name == name])),
                sum(s.name == name for s in used),
            )
            for name in names
        },
        left_out_scatter=_robust(np.array(left_out)) if left_out else float("nan"),
    )


def _at(values: Array, amplitude: float) -> float:
    return float(values[0] - values[1] * np.log10(amplitude))


def _law(segments: Sequence[Segment]) -> Array:
    """Return frequency at 1 N, softening and damping: a robust line, and the median."""
    decades = np.log10([s.amplitude for s in segments])
    frequency = np.array([s.frequency for s in segments])
    spread = float(np.ptp(decades))
    start = [float(np.median(frequency)), 0.0]
    if spread < 0.2:
        line = np.array(start)
    else:
        line = least_squares(lambda p: p[0] - p[1] * decades - frequency, start, loss="soft_l1", f_scale=0.4).x
    return np.array([*line, np.median([s.damping for s in segments])])


def _robust(values: Array) -> float:
    return float(1.4826 * np.median(np.abs(values - np.median(values))))
