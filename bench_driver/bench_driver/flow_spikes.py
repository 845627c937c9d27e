"""Which samples of an acoustic Doppler velocimeter can be used, sample by sample, from what came before.

A sample is usable if its beams' correlation and SNR suffice, its velocity is credible, and it lies inside the ellipse

    ((v − m)/(λ σ))² + ((v − v₋)/(λ σ_Δ))² ≤ 1

m, σ: median and 1.4826 times the median absolute deviation of the credible velocities v in a window up to now, σ_Δ the
same of their differences, v₋ the last usable velocity. These are the first two axes of phase-space thresholding (Goring
and Nikora 2002, doi:10.1061/(ASCE)0733-9429(2002)128:1(117)), with running statistics instead of the whole series', so
that the judgement needs no future. The window takes in what the ellipse rejects: after a true jump the median follows
within half a window and the samples are usable again.
"""

import math
from collections import deque
from dataclasses import dataclass
from itertools import pairwise
from statistics import median

__all__ = ["SpikeDetector", "SpikeLimits"]

_MAD = 1.4826  # standard deviation per median absolute deviation of a normal distribution


@dataclass(frozen=True, kw_only=True)
class SpikeLimits:
    """What makes a sample unusable.

    Attributes:
        correlation: smallest correlation of a beam [%]. On the thruster bench, where the median is 33 to 76 %, samples
            below 30 % stray by more than 0.1 m/s five to ten times as often as samples above 50 %.
        snr: smallest signal to noise of a beam [dB]; no limit: there, it told nothing about the scatter.
        velocity: largest credible |velocity| [m/s].
        window: number of samples that the running statistics cover.
        gate: λ above.
        least_deviation: σ and σ_Δ are taken to be at least this [m/s]; the instrument's resolution and still water.
    """

    correlation: float = 30.0
    snr: float = -math.inf
    velocity: float = 0.30
    window: int = 15
    gate: float = 5.0
    least_deviation: float = 0.003


class SpikeDetector:
    """Judges one velocity channel.

    Attributes:
        limits: see `SpikeLimits`.
    """

    def __init__(self, limits: SpikeLimits | None = None) -> None:
        self.limits = limits or SpikeLimits()
        self._velocities: deque[float] = deque(maxlen=self.limits.window)
        self._last: float | None = None
        self._age = 0  # samples since the last usable one

    def judge(self, velocity: float, *, correlation: float = math.nan, snr: float = math.nan) -> str:
        """Return why a velocity [m/s] is not usable, or an empty string.

        Args:
            velocity: of the next sample.
            correlation: smallest of the beams that measure this velocity (X: the first and the third) [%]; NaN if it is
                not known, as with the analogue output.
            snr: smallest of these beams [dB]; NaN if it is not known.
        """
        reason = self._judge(velocity, correlation, snr)
        if reason:
            self._age += 1
        else:
            self._last, self._age = velocity, 0
        return reason

    def _judge(self, velocity: float, correlation: float, snr: float) -> str:
        limits = self.limits
        if not abs(velocity) <= limits.velocity:
            return "velocity not credible"
        if correlation < limits.correlation:
            return "correlation too low"
        if snr < limits.snr:
            return "signal too weak"
        self._velocities.append(velocity)
        if len(self._velocities) < limits.window // 2:
            return ""
        history = list(self._velocities)
        middle = median(history)
        level = (velocity - middle) / (limits.gate * self._deviation([v - middle for v in history]))
        if self._last is None or self._age > limits.window // 2:
            change = 0.0
        else:
            steps = [b - a for a, b in pairwise(history)]
            change = (velocity - self._last) / (limits.gate * self._deviation(steps))
        return "spike" if level**2 + change**2 > 1 else ""

    def _deviation(self, values: list[float]) -> float:
        middle = median(values)
        return max(_MAD * median(abs(value - middle) for value in values), self.limits.least_deviation)
