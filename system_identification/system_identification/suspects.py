"""An effect as a suspect: which of its sizes are unknown, and which are tried first."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from system_identification.system import SizeSlot

__all__ = ["Suspect", "key_of"]

Array = NDArray[np.float64]


def key_of(effect: str, channel: str) -> str:
    """Return the key of an effect as a suspect: with its channel, where it may concern several."""
    return f"{effect}:{channel}" if channel else effect


@dataclass(frozen=True, kw_only=True, eq=False)
class Suspect:
    """One hypothesis about what a simulator lacks.

    Attributes:
        effect: identifier.
        channel: of effects that may concern several, else "".
        slots: unknown sizes.
        grid: sizes to try first, over their ranges' widths, shape (G, number of slots).
        spacing: how finely its sizes must be searched about one of the grid, as a share of it; 0: a slope leads there.
        price: logarithm of how many sizes were searched for it beyond this grid.
        gates: what it needs beside sizes, for the system.
    """

    effect: str
    channel: str
    slots: tuple[SizeSlot, ...]
    grid: Array
    spacing: float = 0.0
    price: float = 0.0
    gates: Sequence[Any] = field(default=())

    @property
    def key(self) -> str:
        """Unique name."""
        return key_of(self.effect, self.channel)

    @property
    def exact(self) -> bool:
        """Whether it has no size that is unknown."""
        return all(slot.lower == slot.upper for slot in self.slots)

    @property
    def scalable(self) -> bool:
        """Whether its trace grows in proportion to its first size, from nothing at zero."""
        slot = self.slots[0]
        return self.spacing == 0.0 and slot.lower <= 0.0 <= slot.upper and slot.lower < slot.upper
