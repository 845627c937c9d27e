"""The linear law: (2.22) made linear about a level vehicle at rest, as matrices that are made once."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from thruster_control.outer_loop.settings import LinearLaw, euler_law
from thruster_model.equations.attitude import quaternion_from_euler
from thruster_model.equations.hydrodynamics import restoring

__all__ = ["linear_law"]


def linear_law(coefficients: Any, K_P: ArrayLike, k_I: float) -> LinearLaw:
    """Return the law for a vehicle's coefficients; gains as `settings.euler_law` takes them.

    Raises:
        ValueError: with all that is wrong.
    """
    gains = euler_law(K_P, k_I)
    c = coefficients
    # g is linear in the direction of down, whose slopes over roll and pitch are what a quarter of a turn makes of it
    level, by_roll, by_pitch = (
        np.concatenate(restoring(quaternion_from_euler(angles), c.weight, c.buoyancy, c.r_G, c.r_B))
        for angles in ((0.0, 0.0, 0.0), (0.5 * np.pi, 0.0, 0.0), (0.0, 0.5 * np.pi, 0.0))
    )
    return LinearLaw(
        gains.K_P,
        gains.k_I,
        np.array(c.M_RB + c.M_A),
        np.array(c.D_L),
        level,
        np.column_stack((by_roll, by_pitch, np.zeros(6))),
    )
