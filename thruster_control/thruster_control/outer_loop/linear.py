"""The linear law: (2.22) made linear about a level vehicle at rest, as matrices that are made once."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from thruster_control.outer_loop.model import restoring_for
from thruster_control.outer_loop.settings import LinearLaw, euler_law

__all__ = ["linear_law"]


def linear_law(coefficients: Any, K_P: ArrayLike, k_I: float) -> LinearLaw:
    """Return the law for a vehicle's coefficients; gains as `settings.euler_law` takes them.

    Raises:
        ValueError: with all that is wrong.
    """
    gains = euler_law(K_P, k_I)
    c = coefficients
    by_roll, by_pitch = (restoring_for(c, down) for down in ((0.0, 1.0, 0.0), (-1.0, 0.0, 0.0)))
    return LinearLaw(
        gains.K_P,
        gains.k_I,
        np.array(c.M_RB + c.M_A),
        np.array(c.D_L),
        np.array(restoring_for(c, (0.0, 0.0, 1.0))),
        np.column_stack((by_roll, by_pitch, np.zeros(6))),
    )
