r"""What wanders at random about zero and forgets: eddies, a tether's pull, what pushes a plant beside its equations.

Ornstein-Uhlenbeck   dw = -w dt / tau + s sqrt(2 / tau) dW,   of standard deviation s and correlation time tau
exactly, over h      w_{k+1} = a w_k + s sqrt(1 - a^2) z,     a = exp(-h / tau),   w_0 = s z
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

__all__ = ["wandering"]

Array = NDArray[np.float64]


def wandering(z: Array, size: Array, keep: float, before: Array | None = None) -> Array:
    """Return a path (count, n).

    Args:
        z: standard normal, (count, n).
        size: standard deviations s, (n,).
        keep: a, what is left after a step.
        before: the value before the path, (n,); None: it begins anywhere.
    """
    out = np.empty(z.shape)
    fresh = size * sqrt(1.0 - keep**2)
    for k in range(len(z)):
        out[k] = before = size * z[k] if before is None else keep * before + fresh * z[k]
    return out
