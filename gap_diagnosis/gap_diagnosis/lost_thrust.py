"""What readings lose where an effect takes a share of the thrust in stretches that gates say."""

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.problem import Problem
from gap_diagnosis.suspects import slots_of

__all__ = ["falls_of"]

Array = NDArray[np.float64]
_LITTLE = 0.01  # share of thrust


def falls_of(problem: Problem, effect: str, gate: float, x: Array, without: Array) -> Array:
    """Return by how much readings change for each share that is lost, under one gate all the time, shape (R,).

    That is not the thrust that is read: a load cell's offset and accelerated water stay. `without`: predictions without
    the effect; sizes beside its share are at their lower ends.
    """
    slots = slots_of(effect)
    gates = tuple(np.full(recording.experiment.throttle.size, gate) for recording in problem.recordings)
    sizes = [_LITTLE / slots[0].width, *(slot.lower / slot.width for slot in slots[1:])]
    posed = problem.with_effects((*problem.slots, *slots), gates)
    return (posed.predicted(np.concatenate((x, sizes))) - without) / _LITTLE
