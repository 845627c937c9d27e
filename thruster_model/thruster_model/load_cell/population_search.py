"""The same calibration by a population of candidates, as the thesis did it by a swarm: J = |F_w - (H + H_E) f| (3.4).

It asks for no derivative and no form of J, and so checks the least squares. J squared is a sum over rows of H_E, so
each row is a search of its own in six dimensions instead of one in 36. The population evolves by differences between
its members (Storn and Price 1997).
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import Bounds, differential_evolution

from thruster_model.load_cell.calibration import LoadData

__all__ = ["searched"]

Array = NDArray[np.float64]
_PER_DIMENSION = 8
_AGREED = 1e-12
"""Spread of the population's costs, over their mean, at which it has found the minimum [1]."""


def searched(
    data: LoadData, nominal: ArrayLike | None = None, *, bound: float = 2.0, iterations: int = 1000, seed: int = 1
) -> Array:
    """Return H_A (6, 6).

    Args:
        data: of the loads.
        nominal: H; zero if it is not known.
        bound: largest absolute value of an element of H_E; forces [1], moments [m].
        iterations: of each of the six searches, at most.
        seed: of the searches.
    """
    H = np.zeros((6, 6)) if nominal is None else np.asarray(nominal, dtype=np.float64)
    rng, limits = np.random.default_rng(seed), Bounds(np.full(6, -bound), np.full(6, bound))
    matrix = np.empty((6, 6))
    for row in range(6):
        target = data.loads[:, row] - data.legs @ H[row]

        def cost(candidates: Array, target: Array = target) -> Array:
            return np.asarray(np.linalg.norm(candidates.T @ data.legs.T - target, axis=1))

        found = differential_evolution(
            cost, limits, rng=rng, maxiter=iterations, popsize=_PER_DIMENSION, tol=_AGREED, polish=False,
            vectorized=True, updating="deferred",
        )  # fmt: skip
        matrix[row] = H[row] + found.x
    return matrix
