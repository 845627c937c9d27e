"""How a thruster's commands are written: µs of a pulse, -1 to 1, or volts, against the throttle u in volts.

    u = (command - stop) / per_volt,    held between `lowest` and `highest`

Inside, every throttle is in volts. Where the command is no voltage, `FULL_THROTTLE` volts stand for the full command:
the span of the rig's amplifier, to which the sizes of dead zones and of effects on the throttle are made.
"""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["FULL_THROTTLE", "VOLTS", "CommandScale"]

FULL_THROTTLE = 5.0
"""[V]"""


@dataclass(frozen=True, kw_only=True)
class CommandScale:
    """The commands of one thruster.

    Attributes:
        unit: of the command: µs, 1 or V.
        stop: command of no thrust.
        per_volt: how much command is a volt of throttle.
        lowest, highest: what the device takes.

    Raises:
        ValueError: with all that is wrong with it.
    """

    unit: str = "V"
    stop: float = 0.0
    per_volt: float = 1.0
    lowest: float = -inf
    highest: float = inf

    def __post_init__(self) -> None:
        problems = [] if self.unit else ["unit: expected a text; found none"]
        if not (isfinite(self.per_volt) and self.per_volt > 0.0):
            problems.append(f"per_volt: expected a finite number above 0; found {self.per_volt}")
        if not (isfinite(self.stop) and self.lowest <= self.stop <= self.highest):
            found = f"stop {self.stop:g}, lowest {self.lowest:g}, highest {self.highest:g}"
            problems.append(f"stop: expected a number between lowest and highest; found {found}")
        if problems:
            raise ValueError("\n".join(problems))

    def throttle(self, command: ArrayLike) -> NDArray[np.float64]:
        """Return the throttle [V] of commands, those beyond what the device takes at its limit; NaN stays NaN."""
        held = np.clip(np.asarray(command, dtype=np.float64), self.lowest, self.highest)
        return (held - self.stop) / self.per_volt

    def command(self, throttle: ArrayLike) -> NDArray[np.float64]:
        """Return the commands of throttles [V], held to what the device takes."""
        return np.clip(self.stop + self.per_volt * np.asarray(throttle, dtype=np.float64), self.lowest, self.highest)

    @property
    def largest_throttle(self) -> float:
        """The largest throttle in either direction [V]."""
        return float(np.max(np.abs(self.throttle([self.lowest, self.highest]))))


VOLTS = CommandScale()
"""Commands that are voltages already."""
