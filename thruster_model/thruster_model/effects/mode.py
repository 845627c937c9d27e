"""A mode of vibration under a load: d2y/dt2 + 2 zeta w dy/dt + w^2 y = w^2 T, w = 2 pi f, for T in a straight line."""

import numpy as np

from thruster_model.compilation import equation

__all__ = ["moved"]

_CRITICAL = 1e-6


@equation
def moved(y, rate, last, load, step, frequency, damping):  # type: ignore[no-untyped-def]
    """Return (y, dy/dt) a step [s] later, while the load goes from `last` to `load`; frequency [Hz], damping [1]."""
    w = 2.0 * np.pi * frequency
    slope = (load - last) / step
    # What follows the line, a - 2 zeta / w behind it, and what dies away beside it.
    behind = 2.0 * damping / w * slope
    y0, rate0 = y - (last - behind), rate - slope
    square = 1.0 - damping * damping
    root = w * np.sqrt(abs(square))
    if abs(square) < _CRITICAL:
        even, odd = 1.0, step
    elif square > 0.0:
        even, odd = np.cos(root * step), np.sin(root * step) / root
    else:
        even, odd = np.cosh(root * step), np.sinh(root * step) / root
    dying = np.exp(-damping * w * step)
    y1 = dying * (even * y0 + odd * (rate0 + damping * w * y0))
    rate1 = dying * (even * rate0 - odd * (w * w * y0 + damping * w * rate0))
    return load - behind + y1, slope + rate1
