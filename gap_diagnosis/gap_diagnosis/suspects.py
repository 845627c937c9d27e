"""The effects as suspects: which sizes are tried first, and what a recording can say about them at all."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from system_identification.suspects import Suspect
from system_identification.system import SizeSlot
from thruster_model.effects.stages import LIBRARY

__all__ = ["JAGGED", "LIMIT", "RINGING", "ROUNDED", "SCATTERING", "SEARCHED", "Suspect", "suspects"]

Array = NDArray[np.float64]

SCATTERING = ("timestamp_jitter", "dropped_samples", "flow_spikes")
"""Effects that only scatter: judged by the shape of the noise, not by a prediction."""
SEARCHED = "command_quantization"
"""Effect whose size no slope can improve: it stays in a fit where the search for it has put it."""
ROUNDED = "tach_quantization"
"""Effect that rounds readings: they answer to all else, on the average, as if they were not rounded."""
LIMIT = "throttle_saturation"
"""Effect that does nothing above the largest command of the recordings."""
JAGGED = (SEARCHED, ROUNDED, "tach_dropout")
"""Effects whose predictions jump as their size grows: their sizes are searched, not fitted."""
RINGING = "load_cell_resonance"
"""Effect whose frequency is right within a fraction of its width, or not at all: it is searched more finely."""
_DENSE = {ROUNDED: 60, "tach_dropout": 16, SEARCHED: 16, RINGING: 24}
_SECOND = {RINGING: 5}
_SIGNALS = {"throttle": "", "speed": "speed", "flow": "axial ambient", "load": "thrust torque"}


def suspects(signals: set[str], excluded: tuple[str, ...] = ()) -> list[Suspect]:
    """Return all suspects that recordings of these signals can speak of, in the library's order."""
    found = []
    for name, effect in LIBRARY.items():
        if name in excluded or name in SCATTERING or name == "ventilation":
            continue
        if name == "log_alignment":
            for parameter in effect.parameters:
                concerned = _SIGNALS[parameter.name]
                if not concerned or signals & set(concerned.split()):
                    found.append(_suspect(name, (parameter,), parameter.name))
            continue
        if effect.channel and not signals & set(effect.channel.split()):
            continue
        found.append(_suspect(name, effect.parameters, ""))
    return found


def _suspect(name: str, parameters: tuple, channel: str) -> Suspect:  # type: ignore[type-arg]
    slots = tuple(SizeSlot(name, p.name, -p.upper if p.both_signs else p.lower, p.upper, p.unit) for p in parameters)
    axes = [_axis(name, slot, first=place == 0) for place, slot in enumerate(slots)]
    return Suspect(effect=name, channel=channel, slots=slots, grid=np.array(list(product(*axes))))


def _axis(name: str, slot: SizeSlot, *, first: bool) -> Array:
    """Return sizes over the width of their range: denser near neutral, where most effects are."""
    if slot.lower == slot.upper:
        return np.array([slot.upper])
    if not first:
        count = _SECOND.get(name, 4)
        if slot.lower > 0.0:
            return np.geomspace(slot.lower, slot.upper, 2 * count + 1)[1::2] / slot.width
        return (slot.lower + (np.arange(count) + 0.5) / count * (slot.upper - slot.lower)) / slot.width
    dense = _DENSE.get(name)
    if slot.lower > 0.0:
        return np.geomspace(slot.lower, slot.upper, dense or 8) / slot.width
    if dense:
        return np.geomspace(0.04 * slot.upper, slot.upper, dense) / slot.width
    upward = np.array([0.05, 0.15, 0.35, 0.7, 1.0]) * slot.upper
    downward = np.array([1.0, 0.6, 0.3, 0.1]) * slot.lower if slot.lower < 0.0 else np.empty(0)
    return np.concatenate((downward, upward)) / slot.width
