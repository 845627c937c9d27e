"""Where a vehicle's thrusters are and which way they push; ArduSub's frames by name.

ArduSub gives factors of forward, lateral and throttle for each motor, in its order; a positive command of a motor
pushes along (forward, lateral, -throttle) in body axes x forward, y starboard, z down. Positions are the builder's.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["FRAMES", "LayoutEntry", "frame_axes"]

_C = math.sqrt(0.5)
FRAMES: dict[str, tuple[tuple[float, float, float], ...]] = {
    "bluerov1": ((1, 0, 0), (1, 0, 0), (0, 0, -1), (0, 0, -1), (0, 0, -1), (0, 1, 0)),
    "vectored": ((-_C, _C, 0), (-_C, -_C, 0), (_C, _C, 0), (_C, -_C, 0), (0, 0, 1), (0, 0, 1)),
    "vectored_6dof": (
        (-_C, _C, 0), (-_C, -_C, 0), (_C, _C, 0), (_C, -_C, 0), (0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1),
    ),
    "simplerov_3": ((1, 0, 0), (1, 0, 0), (0, 0, 1)),
    "simplerov_4": ((1, 0, 0), (1, 0, 0), (0, 0, 1), (0, 0, 1)),
}  # fmt: skip
"""Directions of positive command of ArduSub's frames, motors 1, 2, ... in order."""


@dataclass(frozen=True, kw_only=True)
class LayoutEntry:
    """One thruster of a layout.

    Attributes:
        name: on the vehicle, such as T1.
        position: in body axes [m].
        axis: direction of forward thrust in body axes, of length one.
        hand: of its propeller: `left`, `right`, or None where it is not known.
        model: its parameter set, or None for the vehicle's.
    """

    name: str
    position: tuple[float, float, float]
    axis: tuple[float, float, float]
    hand: str | None = None
    model: str | None = None

    @property
    def turn(self) -> float:
        """+1 right-handed, -1 left-handed, 0 not known."""
        return {"right": 1.0, "left": -1.0}.get(self.hand or "", 0.0)


def frame_axes(frame: str) -> NDArray[np.float64]:
    """Return the directions (N, 3) of an ArduSub frame; KeyError where there is none of that name."""
    return np.array(FRAMES[frame], dtype=np.float64)
