"""Identify how the mode shows in force and moment, and all noise, by maximum likelihood; the mode itself is given.

Frequency, softening and damping come from `ringdown`: the first tenth of a second after a jump, which holds most of
the likelihood, is no free ringing, and fitting them there gives frequencies that later ringing contradicts.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from thruster_model.load_cell.ringdown import RingDown
from thruster_model.load_cell.smoothing import log_likelihood
from thruster_model.load_cell.structure import Mode, Noise, Stretch, linear_model

__all__ = ["START_NOISE", "Resonance", "identify", "likelihood"]

Array = NDArray[np.float64]
START_NOISE = Noise(
    walk=5.0, jump_walk=30.0, bias_walk=1.0, drive=0.1, jump_drive=0.3, mismatch=0.1,
    force_vibration=0.8, moment_vibration=2.0, force_frequency=45.0, moment_frequency=45.0, vibration_damping=0.1,
    force_reading=0.1, moment_reading=0.3,
)  # fmt: skip
_NOISE = tuple(Noise.__dataclass_fields__)
_FREE = ("leak", "arm_gain", *_NOISE)
_BOUNDS = {"force_frequency": (25.0, 80.0), "moment_frequency": (25.0, 80.0), "vibration_damping": (0.01, 0.9)}


@dataclass(frozen=True, kw_only=True)
class Resonance:
    """What was identified.

    Attributes:
        mode, noise: most likely over all stretches.
        deviation: standard deviation of frequency [Hz], softening [Hz] and damping [1], from `ringdown`; of leak and
            arm_gain [1] the scatter between recordings.
        single: by recording, the mode with the recording's own leak and arm_gain.
        single_deviation: of these two, by recording, from the curvature of the likelihood.
        log_likelihood: of all.
        samples: measurements used.
    """

    mode: Mode
    noise: Noise
    deviation: Mapping[str, float]
    single: Mapping[str, Mode]
    single_deviation: Mapping[str, Mapping[str, float]]
    log_likelihood: float
    samples: int


def likelihood(stretches: Sequence[Stretch], mode: Mode, noise: Noise) -> float:
    """Return the log likelihood of stretches."""
    return sum(log_likelihood(s.reading, linear_model(s, mode, noise)) for s in stretches)


def identify(stretches: Sequence[Stretch], ring: RingDown, start: Noise = START_NOISE) -> Resonance:
    """Fit the mode's share in the moment, the lever arm's correction and the noise to stretches around jumps."""
    known = {name: ring.values[name] for name in ("frequency", "softening", "damping")}
    begin = Mode(leak=0.25, arm_gain=1.0, **known)
    mode, noise, best = _maximise(stretches, begin, start, _FREE)
    single, single_deviation = {}, {}
    for name in sorted({s.name for s in stretches}):
        own = [s for s in stretches if s.name == name]
        single[name] = _maximise(own, mode, noise, ("leak", "arm_gain"))[0]
        single_deviation[name] = {n: _curvature(own, single[name], noise, n) for n in ("leak", "arm_gain")}
    scatter = {
        n: _robust([getattr(m, n) for m in single.values()]) if len(single) > 2 else float("nan")
        for n in ("leak", "arm_gain")
    }
    of_recording = float(np.fmax(ring.deviation["frequency"], ring.frequency_scatter))
    return Resonance(
        mode=mode,
        noise=noise,
        deviation={**ring.deviation, "frequency": of_recording, **scatter},
        single=single,
        single_deviation=single_deviation,
        log_likelihood=best,
        samples=int(sum(np.isfinite(s.reading).sum() for s in stretches)),
    )


def _curvature(stretches: Sequence[Stretch], mode: Mode, noise: Noise, name: str, step: float = 0.02) -> float:
    """Return the standard deviation of one number of the mode, the others given; at most 0.5."""
    values = vars(mode)
    around = [likelihood(stretches, Mode(**{**values, name: values[name] + d}), noise) for d in (-step, 0.0, step)]
    information = -(around[0] - 2 * around[1] + around[2]) / step**2
    return float(min(0.5, information**-0.5)) if information > 0 else 0.5


def _robust(values: Sequence[float]) -> float:
    middle = np.median(values)
    return float(1.4826 * np.median(np.abs(np.asarray(values) - middle)))


def _maximise(
    stretches: Sequence[Stretch], mode: Mode, noise: Noise, names: Sequence[str]
) -> tuple[Mode, Noise, float]:
    """Search over logarithms of the noise, and over the two numbers of the mode in tenths."""
    values = {**vars(mode), **vars(noise)}

    def unpacked(z: Array) -> tuple[Mode, Noise]:
        now = dict(values)
        for name, x in zip(names, z, strict=True):
            now[name] = float(np.exp(x)) if name in _NOISE else float(0.1 * x)
        return Mode(**{n: now[n] for n in vars(mode)}), Noise(**{n: now[n] for n in _NOISE})

    def cost(z: Array) -> float:
        found = -likelihood(stretches, *unpacked(z))
        return found if np.isfinite(found) else 1e12

    start, bounds = [], []
    for name in names:
        if name in _NOISE:
            start.append(float(np.log(values[name])))
            low, high = _BOUNDS.get(name, (np.exp(start[-1] - 5.0), np.exp(start[-1] + 5.0)))
            bounds.append((float(np.log(low)), float(np.log(high))))
        else:
            start.append(10.0 * values[name])
            bounds.append((-10.0, 30.0))
    found = minimize(cost, start, method="L-BFGS-B", bounds=bounds, options={"maxiter": 60})
    return *unpacked(found.x), -float(found.fun)
