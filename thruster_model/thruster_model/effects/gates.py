"""When a propeller near the surface may draw air: stretches of random length, for `effects.library.ventilation`.

Both kinds of stretches are exponentially distributed, 1.5 s without air and 1 s with it on average (assumed).
"""

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.active import ActiveEffects
from thruster_model.stepper import NO_GATES

__all__ = ["drawn_gates"]

_WITHOUT, _WITH = 1.5, 1.0  # s


def drawn_gates(effects: ActiveEffects, count: int, period: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return gates of `count` periods [s], 0 while air may be drawn, else 1; none where no effect asks for them."""
    if "ventilation" not in effects.sizes:
        return NO_GATES
    gates = np.ones(count)
    begin, closed = 0.0, bool(rng.random() < _WITH / (_WITHOUT + _WITH))
    while begin < count * period:
        end = begin + rng.exponential(_WITH if closed else _WITHOUT)
        if closed:
            gates[round(begin / period) : round(end / period)] = 0.0
        begin, closed = end, not closed
    return gates
