"""The effects as suspects: which sizes are tried first, and what a recording can say about them at all."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from system_identification.suspects import Suspect
from system_identification.system import SizeSlot
from thruster_model.effects.effect import EffectParameter, Search, Trace
from thruster_model.effects.stages import LIBRARY

__all__ = ["ROUNDED", "Suspect", "betrayed_by", "found_by", "slots_of", "suspects"]

Array = NDArray[np.float64]
_SIGNALS = {"throttle": "", "speed": "speed", "flow": "axial ambient", "load": "thrust torque"}


def found_by(*ways: Search) -> tuple[str, ...]:
    """Return the effects of the library whose sizes are found in one of these ways."""
    return tuple(name for name, effect in LIBRARY.items() if effect.search in ways)


def betrayed_by(trace: Trace) -> str:
    """Return the effect that leaves such a trace in a log."""
    return next(name for name, effect in LIBRARY.items() if effect.trace == trace)


(ROUNDED,) = found_by("reading_lattice")
"""Effect that rounds readings: they answer to all else, on the average, as if they were not rounded."""


def suspects(signals: set[str], excluded: tuple[str, ...] = ()) -> list[Suspect]:
    """Return all suspects that recordings of these signals can speak of, in the library's order."""
    found = []
    for name, effect in LIBRARY.items():
        if name in excluded or effect.search in ("log", "gates"):
            continue
        if effect.apart:
            for parameter in effect.parameters:
                concerned = _SIGNALS[parameter.name]
                if not concerned or signals & set(concerned.split()):
                    found.append(_suspect(name, (parameter,), parameter.name))
            continue
        if effect.channel and not signals & set(effect.channel.split()):
            continue
        found.append(_suspect(name, effect.parameters, ""))
    return found


def slots_of(name: str, parameters: Sequence[EffectParameter] | None = None) -> tuple[SizeSlot, ...]:
    """Return the unknown sizes of an effect: all, or those of some of its parameters."""
    parameters = LIBRARY[name].parameters if parameters is None else parameters
    return tuple(SizeSlot(name, p.name, -p.upper if p.both_signs else p.lower, p.upper, p.unit) for p in parameters)


def _suspect(name: str, parameters: Sequence[EffectParameter], channel: str) -> Suspect:
    slots = slots_of(name, parameters)
    tries = (*LIBRARY[name].tries, *[0] * len(slots))
    axes = [_axis(slot, tries[place], first=place == 0) for place, slot in enumerate(slots)]
    return Suspect(effect=name, channel=channel, slots=slots, grid=np.array(list(product(*axes))))


def _axis(slot: SizeSlot, count: int, *, first: bool) -> Array:
    """Return `count` sizes (0: a few) over the width of their range: denser near neutral, where most effects are."""
    if slot.lower == slot.upper:
        return np.array([slot.upper])
    if not first:
        count = count or 4
        if slot.lower > 0.0:
            return np.geomspace(slot.lower, slot.upper, 2 * count + 1)[1::2] / slot.width
        return (slot.lower + (np.arange(count) + 0.5) / count * (slot.upper - slot.lower)) / slot.width
    if slot.lower > 0.0:
        return np.geomspace(slot.lower, slot.upper, count or 8) / slot.width
    if count:
        return np.geomspace(0.04 * slot.upper, slot.upper, count) / slot.width
    upward = np.array([0.05, 0.15, 0.35, 0.7, 1.0]) * slot.upper
    downward = np.array([1.0, 0.6, 0.3, 0.1]) * slot.lower if slot.lower < 0.0 else np.empty(0)
    return np.concatenate((downward, upward)) / slot.width
