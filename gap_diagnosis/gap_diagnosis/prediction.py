"""What a simulator with suspected effects predicts for a recording, at the recording's own stamps.

Delays and misaligned stamps move the instants at which outputs are read: the plant does not depend on time, so
nothing is simulated anew for them. What scatters (jitter, spikes, lost samples) has no place in a prediction.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.recording import Recording
from thruster_model.effects.stages import LIBRARY, NO_EFFECTS, effect_values
from thruster_model.flow_tank import PlantState, simulate
from thruster_model.identification.experiment import SIGNALS
from thruster_model.identification.prediction import Shifts, seen

__all__ = [
    "JUMPING",
    "LOG_CHANNELS",
    "NO_GATES",
    "Simulated",
    "Situation",
    "Sizes",
    "acts_in_plant",
    "nearest",
    "predict",
    "simulated",
    "true_time",
]

Array = NDArray[np.float64]
Sizes = Mapping[str, Mapping[str, float]]
NO_GATES = np.empty(0)
_BETWEEN = 3.5e-3
"""Largest step [s] of what is read between the steps: speed bends within longer ones by more than its noise."""
# Largest steps [s] at which effects are simulated. What a lag makes of a step of the command is a curve: its stairs
# must be fine, or the plant's ramp limit sees steps. The others are read between the steps, or ring faster.
_LARGEST_STEPS = {
    "command_lag": 2e-3, "command_delay": _BETWEEN, "log_alignment": _BETWEEN, "flow_delay": _BETWEEN,
    "clock_drift": _BETWEEN, "load_cell_resonance": _BETWEEN,
}  # fmt: skip
_UNLIMITED = 1e9  # [V/s]
JUMPING = {"flow_reversal_loss", "ventilation"}
"""Effects with which a reading jumps where a state passes a threshold."""
LOG_CHANNELS = {"speed": "speed", "axial": "flow", "ambient": "flow", "thrust": "load", "torque": "load"}
"""Parameter of `log_alignment` that concerns a signal."""


@dataclass(frozen=True, kw_only=True)
class Situation:
    """What is particular to one recording: the state at its start, its clocks and its rest values."""

    start: PlantState
    shifts: Shifts = field(default_factory=Shifts)
    gates: Array = field(default_factory=lambda: NO_GATES)


class Simulated(NamedTuple):
    """What happened in the plant.

    Attributes:
        dense: outputs by signal, each (finer N + 1,), `finer` times for every `dt` of the experiment.
        throttle: acting [V], every `dt`, (N + 1,).
        finer: 1 or more.
    """

    dense: dict[str, Array]
    throttle: Array
    finer: int

    @property
    def outputs(self) -> dict[str, Array]:
        """By signal, each (N + 1,), every `dt` of the experiment."""
        return {name: values[:: self.finer] for name, values in self.dense.items()}


def simulated(recording: Recording, coefficients: Any, sizes: Sizes, situation: Situation) -> Simulated:
    """Return what happens in the plant."""
    experiment = recording.experiment
    finer = int(np.ceil(experiment.dt / min([_BETWEEN, *(_LARGEST_STEPS.get(name, np.inf) for name in sizes)])))
    step = experiment.dt / finer
    commands = np.repeat(experiment.throttle, finer) if finer > 1 else experiment.throttle
    for effect in _of("command", sizes):
        if effect.id == "throttle_rate_limit":
            # The plant's own ramp limit says the same without steps in the ramp.
            slowest = min(coefficients.u_dot_max, sizes[effect.id].get("rate", np.inf))
            coefficients = coefficients._replace(u_dot_max=slowest)
        elif effect.id != "command_delay":
            commands = np.asarray(effect.samples(commands, step, **_sized(effect, sizes)))
    if "command_lag" in sizes and np.max(np.abs(np.diff(commands)), initial=0.0) < coefficients.u_dot_max * step:
        coefficients = coefficients._replace(u_dot_max=_UNLIMITED)  # it would see stairs, and delay each
    in_plant = {name: sizes[name] for name in sizes if LIBRARY[name].hooks}
    trajectory = simulate(
        coefficients,
        commands,
        step,
        initial=situation.start,
        largest_step=experiment.dt,
        effects=effect_values(in_plant) if in_plant else NO_EFFECTS,
        gates=np.repeat(situation.gates, finer),
    )
    dense = {name: getattr(trajectory, s.plant_output) for name, s in SIGNALS.items()}
    return Simulated(dense, trajectory.u[::finer], finer)


def predict(
    recording: Recording, coefficients: Any, sizes: Sizes, situation: Situation, happened: Simulated | None = None
) -> dict[str, Array]:
    """Return predictions of every measured signal, each of its measurement's shape."""
    happened = happened or simulated(recording, coefficients, sizes, situation)
    experiment = recording.experiment
    result = {}
    sensors = _of("sensor", sizes)
    for name, measurement in experiment.measurements.items():
        values, dt = happened.dense[name], experiment.dt / happened.finer
        for effect in sensors:
            if name in effect.channel.split() and effect.id != "flow_delay":
                values = np.asarray(effect.samples(values, happened.dense, dt, None, **_sized(effect, sizes)))
        at = true_time(name, measurement.time, sizes, situation.shifts)
        result[name] = seen(values, dt, at, measurement.width, measurement.readings)
        offset = situation.shifts.offsets.get(name, 0.0)
        if offset:
            result[name] += offset * (np.clip(result[name], -1.0, 1.0) if name == "speed" else 1.0)
    return result


def acts_in_plant(effect: str) -> bool:
    """Tell whether the plant has to be simulated anew for an effect."""
    return LIBRARY[effect].block not in ("log", "sensor") and effect != "command_delay"


def nearest(signal: str, recording: Recording, sizes: Sizes, shifts: Shifts) -> NDArray[np.int64]:
    """Return at which instant of the simulation each sample of a signal was taken, rounded; shape of the samples."""
    experiment = recording.experiment
    at = true_time(signal, experiment.measurements[signal].time, sizes, shifts) / experiment.dt
    return np.clip(np.round(at).astype(np.int64), 0, experiment.throttle.size)


def true_time(signal: str, stamps: Array, sizes: Sizes, shifts: Shifts) -> Array:
    """Return when on the plant's clock the samples of a signal with these stamps [s] were taken."""
    late = shifts.throttle + shifts.signals.get(signal, 0.0)
    rate = 0.0
    if sizes:
        late += _size(sizes, "command_delay", "time") - _size(sizes, "log_alignment", "throttle")
        late += _size(sizes, "log_alignment", LOG_CHANNELS[signal])
        if signal in ("axial", "ambient"):
            late += _size(sizes, "flow_delay", "time")
        rate = _size(sizes, "clock_drift", "rate")
    return np.asarray(stamps / (1.0 + rate) - late)


def _size(sizes: Sizes, effect: str, parameter: str) -> float:
    return float(sizes[effect].get(parameter, 0.0)) if effect in sizes else 0.0


def _of(block: str, sizes: Sizes) -> list[Any]:
    effects = [LIBRARY[name] for name in sizes if LIBRARY[name].samples and LIBRARY[name].block == block]
    return sorted(effects, key=lambda effect: effect.order)


def _sized(effect: Any, sizes: Sizes) -> dict[str, float]:
    return {p.name: float(sizes[effect.id].get(p.name, p.neutral)) for p in effect.parameters}
