"""A simulator's own predictions against a recording: which signal differs, in which regime, how; no model is asked."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import RULES
from gap_diagnosis.where import regimes
from thruster_model.identification.experiment import SIGNALS

__all__ = ["Difference", "differences", "throttle_apart"]

Array = NDArray[np.float64]
LEAST = 20
"""Samples of a signal, or of a signal in a regime, below which nothing is said."""
_LATEST, _LAG_STEP = 1.0, 0.005  # [s]


@dataclass(frozen=True, kw_only=True)
class Difference:
    """Measured less predicted of one signal, in its unit.

    Attributes:
        signal: which.
        samples: that both have.
        rms: root mean square.
        noise: standard deviation of the measurement's own noise.
        mean: measured less predicted.
        by_regime: root mean square in each regime with enough samples.
        lag: by how much [s] the prediction must come later for the best fit of gain and offset.
        gain: that the prediction must have then.
        left: root mean square that lag, gain and offset leave.
    """

    signal: str
    samples: int
    rms: float
    noise: float
    mean: float
    by_regime: dict[str, float]
    lag: float
    gain: float
    left: float

    @property
    def differs(self) -> bool:
        """Whether there is more than noise."""
        return self.rms > RULES.healthy_sensor * self.noise

    @property
    def sentence(self) -> str:
        """In words: how much, where, and what would take most of it away."""
        unit, title = SIGNALS[self.signal].unit, SIGNALS[self.signal].title
        told = f"{title}: {self.rms:.3g} {unit} apart (root mean square), the noise is {self.noise:.2g} {unit}"
        if not self.differs:
            return f"{told}: no difference beyond the noise"
        if self.by_regime:
            worst = max(self.by_regime, key=lambda name: self.by_regime[name])
            best = min(self.by_regime, key=lambda name: self.by_regime[name])
            told += f"; most in the regime '{worst}' ({self.by_regime[worst]:.3g}), least in '{best}' "
            told += f"({self.by_regime[best]:.3g})"
        told += f"; measured less predicted {self.mean:+.3g} on the average"
        if self.left < 0.8 * self.rms:
            when = f"{abs(self.lag):.3g} s {'later' if self.lag > 0 else 'earlier'}" if self.lag else "at the same time"
            told += f"; the prediction {when}, times {self.gain:.3g} and with an offset, would be {self.left:.3g} apart"
        else:
            told += "; no delay, gain or offset of the prediction takes a fifth of it away"
        return told


def differences(
    measured: Recording, predicted: Recording, *, later: float = 0.0, edge: float = 0.0
) -> list[Difference]:
    """Return the difference of every signal that both have, predictions interpolated at the measurement's instants.

    Args:
        measured: the recording.
        predicted: the simulator's.
        later: how long after the recording's clock the simulator's begins [s].
        edge: of the dead zone [V]; 0: not known, and only a throttle at zero counts as inside.
    """
    u, dt = measured.experiment.throttle, measured.experiment.dt
    grid = np.asarray(dt * np.arange(u.size), dtype=np.float64)
    source = measured if "speed" in measured.experiment.measurements else predicted
    shift = 0.0 if source is measured else later
    speed = source.experiment.measurements.get("speed")
    n = u if speed is None else np.interp(grid, speed.time[speed.usable] + shift, speed.values[speed.usable])
    masks = {name: mask for name, mask in regimes(n, u, grid, edge).items() if edge > 0.0 or name != "dead zone"}
    found = []
    for name, m in measured.experiment.measurements.items():
        other = predicted.experiment.measurements.get(name)
        if other is None:
            continue
        at, values = other.time[other.usable] + later, other.values[other.usable]
        known = m.usable & (m.time >= at[0]) & (m.time <= at[-1])
        if np.sum(known) < LEAST:
            continue
        time, y = m.time[known], m.values[known]
        apart = y - np.interp(time, at, values)
        by_regime = {}
        for regime, mask in masks.items():
            here = np.interp(time, grid, mask) > 0.5
            if np.sum(here) >= LEAST:
                by_regime[regime] = _rms(apart[here])
        lag, gain, left = _reshaped(time, y, at, values)
        found.append(
            Difference(
                signal=name,
                samples=y.size,
                rms=_rms(apart),
                noise=m.noise,
                mean=float(np.mean(apart)),
                by_regime=by_regime,
                lag=lag,
                gain=gain,
                left=left,
            )
        )
    return found


def throttle_apart(measured: Recording, predicted: Recording, later: float = 0.0) -> float:
    """Return how far apart the throttles are, root mean square over the recording's largest command [1]."""
    one, other = measured.experiment, predicted.experiment
    grid = one.dt * np.arange(one.throttle.size)
    theirs = np.interp(grid, later + other.dt * np.arange(other.throttle.size), other.throttle)
    return _rms(one.throttle - theirs) / max(float(np.max(np.abs(one.throttle))), 1e-12)


def _reshaped(time: Array, y: Array, at: Array, values: Array) -> tuple[float, float, float]:
    """Return (lag [s], gain, what is left) of the prediction, shifted, scaled and offset, that fits best."""
    best = (0.0, 1.0, np.inf)
    steps = round(_LATEST / _LAG_STEP)
    for k in sorted(range(-steps, steps + 1), key=abs):
        then = time - k * _LAG_STEP
        inside = (then >= at[0]) & (then <= at[-1])
        if np.sum(inside) < 0.5 * time.size:
            continue
        p, own = np.interp(then[inside], at, values), y[inside]
        spread = float(np.var(p))
        gain = float(np.mean((p - np.mean(p)) * (own - np.mean(own)))) / spread if spread > 0.0 else 0.0
        left = _rms((own - np.mean(own)) - gain * (p - np.mean(p)))
        if left < 0.999 * best[2]:
            best = (k * _LAG_STEP, gain, left)
    return best


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
