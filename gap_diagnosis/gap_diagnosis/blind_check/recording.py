"""What sensors and log make of the true signals of a run in the blind check.

A sensor is a chain: its dynamics, scale and offset, noise, converter. The tachometer's chain is in the integrator,
where a speed loop needs its readings.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["FLOW_SPIKE", "Colour", "Recorded", "clean_channels", "log", "stamps_of"]

Array = NDArray[np.float64]
Sizes = Mapping[str, Mapping[str, float]]

FLOW_SPIKE = 0.3
"""Standard deviation of the spikes of a velocimeter [m/s]."""
_TOPIC = {"throttle": "throttle", "n": "speed", "ambient": "flow", "thrust": "load", "torque": "load"}


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """Samples of one signal: stamps [s], shape (N,), in order, and values, shape (N,)."""

    time: Array
    values: Array


@dataclass(frozen=True, kw_only=True)
class Colour:
    """Disturbances that remember (Ornstein and Uhlenbeck).

    Attributes:
        outputs: their standard deviation in each channel, in standard deviations of its white noise.
        rotor: that of a disturbance of the rotor [rad/s^2].
        memory: [s].
    """

    outputs: float
    rotor: float
    memory: float

    def wander(self, count: int, period: float, rng: np.random.Generator) -> Array:
        """Return a stationary path of standard deviation 1, shape (count,), samples `period` [s] apart."""
        keep = float(np.exp(-period / self.memory))
        shocks = rng.standard_normal(count)
        path = np.empty(count)
        path[0] = shocks[0]
        for k in range(1, count):
            path[k] = keep * path[k - 1] + np.sqrt(1.0 - keep**2) * shocks[k]
        return path


def _size(effects: Sizes, name: str, parameter: str) -> float:
    return float(effects[name][parameter]) if name in effects else 0.0


def clean_channels(
    true: Mapping[str, Array], effects: Sizes, outside: Sizes, period: float, begins: float = 0.0
) -> dict[str, Array]:
    """Return what the sensors read without noise, (N,) each: n, ambient, thrust, torque.

    Args:
        true: rows of `integrator.CHANNELS`, and `ambient_fine` on the integrator's grid.
        effects, outside: sizes of effects.
        period: of the samples [s].
        begins: when the recording does [s]; before it nothing drifts.
    """
    count = true["n"].size
    at = period * np.arange(count)
    flow = true["ambient"]
    late = _size(effects, "flow_delay", "time")
    if late > 0.0:
        fine = period * count / true["ambient_fine"].size * np.arange(true["ambient_fine"].size)
        flow = np.interp(at - late, fine, true["ambient_fine"])
    bend = _size(outside, "flow_compression", "curvature")
    if bend > 0.0:
        flow = np.tanh(bend * flow / 0.5) / (bend / 0.5)
    flow = flow * (1.0 + _size(effects, "flow_scale", "share")) + _size(effects, "flow_bias", "offset")
    scale = 1.0 + _size(effects, "load_cell_scale", "share")
    moment = true["load_moment"] * scale
    force = true["load_force"] * scale + _size(effects, "load_cell_crosstalk", "gain") * true["torque"]
    force = (
        force
        + _size(effects, "load_cell_bias", "offset")
        + _size(effects, "load_cell_drift", "rate") * np.maximum(at - begins, 0.0)
    )
    return {"n": true["tach"], "ambient": flow, "thrust": force, "torque": moment}


def log(
    commands: Array,
    noisy: Mapping[str, Array],
    clean: Mapping[str, Array],
    effects: Sizes,
    outside: Sizes,
    period: float,
    rng: np.random.Generator,
) -> tuple[dict[str, Recorded], dict[str, Array]]:
    """Return (what is written by channel, throttle included; the clean values that belong to it)."""
    at = np.asarray(period * np.arange(commands.size), dtype=np.float64)
    noisy = dict(noisy)
    if "flow_spikes" in effects:
        hit = rng.random(at.size) < effects["flow_spikes"]["share"]
        noisy["ambient"] = noisy["ambient"] + np.where(hit, FLOW_SPIKE * rng.standard_normal(at.size), 0.0)
    stamps, picked = {}, {}
    for topic in ("throttle", "speed", "flow", "load"):
        stamps[topic] = stamps_of(at, topic, effects, outside, rng)
        picked[topic] = np.arange(at.size)
        if topic != "throttle" and "dropped_samples" in effects:
            kept = rng.random(at.size) >= effects["dropped_samples"]["share"]
            kept[0] = True
            picked[topic] = np.maximum.accumulate(np.where(kept, np.arange(at.size), 0))
    signals = {"throttle": commands, **noisy}
    recorded = {
        name: Recorded(time=stamps[_TOPIC[name]], values=values[picked[_TOPIC[name]]])
        for name, values in signals.items()
    }
    return recorded, {name: values[picked[_TOPIC[name]]] for name, values in clean.items()}


def stamps_of(at: Array, topic: str, effects: Sizes, outside: Sizes, rng: np.random.Generator) -> Array:
    """Return the stamps [s] of a topic, in order."""
    stamps = at + float(effects.get("log_alignment", {}).get(topic, 0.0))
    if topic != "throttle":
        stamps = stamps * (1.0 + _size(effects, "clock_drift", "rate"))
    if "clock_jump" in outside and topic != "throttle":
        late = np.where(at >= outside["clock_jump"]["when"] * at[-1], outside["clock_jump"]["time"], 0.0)
        stamps = np.maximum.accumulate(stamps + late)
    if "timestamp_jitter" in effects:
        stamps = np.sort(stamps + effects["timestamp_jitter"]["deviation"] * rng.standard_normal(at.size))
    return stamps
