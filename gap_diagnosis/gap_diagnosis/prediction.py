"""What a simulator with suspected effects predicts for a recording, at the recording's own stamps.

It is the fit's prediction, from the state at the recording's start. What happens in the plant is simulated anew only
where it changes: sensors and stamps leave it as it is. What scatters (jitter, spikes, lost samples) is left out.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.recording import Recording
from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification import prediction
from thruster_model.identification.prediction import LARGEST_STEP, Happened, Shifts
from thruster_model.stepper import NO_GATES, PlantState

__all__ = [
    "LARGEST_STEP",
    "LOG_CHANNELS",
    "NO_GATES",
    "Happened",
    "Situation",
    "Sizes",
    "acts_in_plant",
    "nearest",
    "predict",
    "simulated",
    "taken",
]

Array = NDArray[np.float64]
Sizes = Mapping[str, Mapping[str, float]]
LOG_CHANNELS = {"speed": "speed", "axial": "flow", "ambient": "flow", "thrust": "load", "torque": "load"}
"""Topic whose stamps a signal shares."""


@dataclass(frozen=True, kw_only=True)
class Situation:
    """What is particular to one recording: the state at its start, its clocks and its rest values."""

    start: PlantState
    shifts: Shifts = field(default_factory=Shifts)
    gates: Array = field(default_factory=lambda: NO_GATES)


def simulated(
    recording: Recording,
    coefficients: Any,
    sizes: Sizes,
    situation: Situation,
    largest_step: float = LARGEST_STEP,
) -> Happened:
    """Return what happens in the plant."""
    effects = ActiveEffects(sizes=sizes)
    start, gates = situation.start, situation.gates
    return prediction.happened(recording.experiment, coefficients, effects, start, gates, largest_step)


def predict(
    recording: Recording,
    coefficients: Any,
    sizes: Sizes,
    situation: Situation,
    known: Happened | None = None,
    largest_step: float = LARGEST_STEP,
) -> dict[str, Array]:
    """Return predictions of every measured signal, each of its measurement's shape."""
    known = known or simulated(recording, coefficients, sizes, situation, largest_step)
    effects = ActiveEffects(sizes=sizes)
    return prediction.predict(recording.experiment, coefficients, situation.shifts, effects, known)


def acts_in_plant(effect: str) -> bool:
    """Tell whether the plant has to be simulated anew for an effect."""
    return LIBRARY[effect].block not in ("log", "sensor")


def taken(signal: str, recording: Recording, sizes: Sizes, shifts: Shifts) -> Array:
    """Return when each sample of a signal was taken, in steps of the simulation; shape of the samples."""
    experiment = recording.experiment
    stamps = experiment.measurements[signal].time
    at = prediction.taken(signal, stamps, shifts, ActiveEffects(sizes=sizes)) / experiment.dt
    return np.asarray(np.clip(at, 0.0, experiment.throttle.size))


def nearest(signal: str, recording: Recording, sizes: Sizes, shifts: Shifts) -> NDArray[np.int64]:
    """Return at which instant of the simulation each sample of a signal was taken, rounded; shape of the samples."""
    return np.round(taken(signal, recording, sizes, shifts)).astype(np.int64)
