r"""What stands between the plant and the controller of the thruster bench: converters, noise, spikes, the load cell.

tachometer   c1 = round(|n + e| / (49.9723 * 5/1024)),          read as |n| = 49.9723 * 5/1024 c1           [rad/s]
flow         c2 = round((0.3 - U') / (0.3/2.5 * 5/1024)),       read as U = 0.3 - 0.3/2.5 * 5/1024 c2       [m/s]
throttle     c  = round((5 - u) * 255/10), half away from zero, acts as u = 5 - 10/255 c                    [V]
U' = U (1 + eddies) + e + spikes.     Counts end at 0 and 1023, those of the throttle at 0 and 255.

`bench_driver.text_protocol` is the same with checks, for one value; kernels cannot call it. A test holds them together.

Sizes: measured on the recordings of the bench's controllers at 25 Hz (`bench_study.real_runs`). Speed 0.9 rad/s; flow
0.0039 m/s, eddies included, here 0.0035 m/s and turbulence of 12 % that is forgotten in 0.04 s; spikes, 1.2 % of the
samples lie more than 0.1 m/s off the running median of 11, by 0.3 m/s rms after the converter, which ends at 0.3 m/s,
so that spikes of 0.3 m/s before it come out somewhat smaller; load cell 0.58 N in the mean over a period, most of it
lines of the shaft.
"""

from dataclasses import dataclass
from math import exp, isfinite, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from thruster_model.compilation import compiled, equation
from thruster_model.effects.mode import moved

__all__ = ["RECORDER", "Disturbances", "Rig", "disturbances", "flow_read", "rung", "speed_read", "throttle_acting"]

Array = NDArray[np.float64]

_SPEED_STEP = 49.9723 * 5 / 1024  # rad/s
_FLOW_AT_ZERO, _FLOW_STEP = 0.3, 0.3 / 2.5 * 5 / 1024  # m/s
_LARGEST_COUNT = 1023
_THROTTLE_STEP, _LARGEST_THROTTLE, _LARGEST_THROTTLE_COUNT = 10 / 255, 5.0, 255  # V, V


class Disturbances(NamedTuple):
    """What is random in one run of N periods, (N,) each: of speed [rad/s], flow [m/s], load cell [N]; eddies [1].

    told: readings of the flow [m/s] that stand in the place of the sensor's, NaN: the sensor's.
    """

    speed: Array
    flow: Array
    eddies: Array
    load: Array
    told: Array


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Sensors and converters of the bench.

    Attributes:
        speed_noise: standard deviation of a tachometer's sample [rad/s].
        flow_noise: of a sample of the ambient flow [m/s].
        turbulence: standard deviation of the eddies as a share of the flow; `memory`: their correlation time [s].
        spike_share: share of the flow's samples that are spikes; `spike_size`: their standard deviation [m/s].
        load_noise: of the load cell's mean over a period [N].
        resonance: frequency of the load cell's structure [Hz], inf: stiff; `damping`: share of the critical one.
        quantised: whether converters round.
        load_cell_in_loop: whether the controller reads the load cell; the bench's did not.
    """

    speed_noise: float = 0.9
    flow_noise: float = 0.0035
    turbulence: float = 0.12
    memory: float = 0.04
    spike_share: float = 0.012
    spike_size: float = 0.3
    load_noise: float = 0.58
    resonance: float = float("inf")
    damping: float = 0.039
    quantised: bool = True
    load_cell_in_loop: bool = False

    def __post_init__(self) -> None:
        wrong = []
        for name in ("speed_noise", "flow_noise", "turbulence", "spike_size", "load_noise"):
            if not (isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                wrong.append(f"{name}: expected a finite number, 0 or more; found {getattr(self, name)}")
        if not 0.0 <= self.spike_share <= 1.0:
            wrong.append(f"spike_share: expected a share from 0 to 1; found {self.spike_share}")
        for name in ("memory", "resonance", "damping"):
            if not getattr(self, name) > 0.0:
                wrong.append(f"{name}: expected a number above 0; found {getattr(self, name)}")
        if wrong:
            raise ValueError("rig: " + "; ".join(wrong))


RECORDER = Rig(
    speed_noise=0.02 * 49.9723, flow_noise=0.008, turbulence=0.08, memory=0.2, spike_share=0.05, load_noise=0.5,
    resonance=7.0, damping=0.04, quantised=False,
)  # fmt: skip
"""The same sensors before a recording system of their own, sampled in full and not only once a period."""


def disturbances(rig: Rig, count: int, period: float, rng: np.random.Generator) -> Disturbances:
    """Return the noise of `count` periods of `period` [s]; the share of spikes changes nothing but the spikes."""
    keep = exp(-period / rig.memory)
    white = rng.standard_normal((4, count))
    eddies = lfilter([sqrt(1.0 - keep**2)], [1.0, -keep], white[2]) * rig.turbulence
    hit, size = rng.random(count) < rig.spike_share, rig.spike_size * rng.standard_normal(count)
    flow = rig.flow_noise * white[1] + np.where(hit, size, 0.0)
    load, told = rig.load_noise * white[3], np.full(count, np.nan)
    return Disturbances(rig.speed_noise * white[0], flow, np.asarray(eddies), load, told)


@equation
def _count(x, largest):  # type: ignore[no-untyped-def]
    return np.minimum(np.maximum(np.floor(x + 0.5), 0.0), largest)


@equation
def speed_read(n, noise, quantised):  # type: ignore[no-untyped-def]
    """Return the magnitude [rad/s] that the tachometer tells of n [rad/s]."""
    size = np.abs(n + noise)
    return _SPEED_STEP * _count(size / _SPEED_STEP, _LARGEST_COUNT) if quantised else size


@equation
def flow_read(U, noise, eddies, quantised):  # type: ignore[no-untyped-def]
    """Return the ambient flow [m/s] that the velocimeter tells of U [m/s]."""
    told = U * (1.0 + eddies) + noise
    if not quantised:
        return told
    return _FLOW_AT_ZERO - _FLOW_STEP * _count((_FLOW_AT_ZERO - told) / _FLOW_STEP, _LARGEST_COUNT)


@equation
def throttle_acting(u, quantised):  # type: ignore[no-untyped-def]
    """Return the throttle [V] that the converter makes of u [V]; 0.02 V at u = 0 as zero has no count."""
    if not quantised:
        return u
    return _LARGEST_THROTTLE - _THROTTLE_STEP * _count(
        (_LARGEST_THROTTLE - u) / _THROTTLE_STEP, _LARGEST_THROTTLE_COUNT
    )


@compiled
def rung(loads, step, frequency, damping):  # type: ignore[no-untyped-def]
    """Return what a load cell on a mode at `frequency` [Hz] makes of loads (N,), `step` [s] apart, from rest at 0."""
    read = np.empty(loads.size)
    y, rate, last = 0.0, 0.0, 0.0
    for k in range(loads.size):
        y, rate = moved(y, rate, last, loads[k], step, frequency, damping)
        last, read[k] = loads[k], y
    return read
