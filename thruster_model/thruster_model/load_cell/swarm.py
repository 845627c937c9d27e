"""The same calibration as the thesis did it: a particle swarm on J = |F_w - (H + H_E) f| (3.4).

J squared is a sum over rows of H_E, so each row is a swarm of its own in six dimensions instead of one in 36.
"""

import logging.config
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.load_cell.calibration import LoadData

__all__ = ["swarm_calibrate"]

Array = NDArray[np.float64]
_OPTIONS = {"c1": 1.49618, "c2": 1.49618, "w": 0.7298}  # Clerc and Kennedy's constriction: converges


def swarm_calibrate(
    data: LoadData,
    nominal: ArrayLike | None = None,
    *,
    bound: float = 2.0,
    particles: int = 80,
    iterations: int = 1500,
    seed: int = 1,
) -> Array:
    """Return H_A (6, 6) by particle swarm.

    Args:
        data: of the loads.
        nominal: H; zero if it is not known.
        bound: largest absolute value of an element of H_E; forces [1], moments [m].
        particles, iterations: of each of the six swarms.
        seed: of the swarm.
    """
    H = np.zeros((6, 6)) if nominal is None else np.asarray(nominal, dtype=np.float64)
    matrix = np.empty((6, 6))
    with _contained(seed):
        from pyswarms.single import GlobalBestPSO

        for row in range(6):
            target = data.loads[:, row] - data.legs @ H[row]

            def cost(candidates: Array, target: Array = target) -> Array:
                return np.asarray(np.linalg.norm(candidates @ data.legs.T - target, axis=1))

            limits = (np.full(6, -bound), np.full(6, bound))
            swarm = GlobalBestPSO(n_particles=particles, dimensions=6, options=_OPTIONS, bounds=limits)
            _, best = swarm.optimize(cost, iters=iterations, verbose=False)
            matrix[row] = H[row] + best
    return matrix


@contextmanager
def _contained(seed: int) -> Iterator[None]:
    """Keep pyswarms from what it does to the process: a report.log here, the root logger, NumPy's global generator."""
    configure, state = logging.config.dictConfig, np.random.get_state()  # noqa: NPY002
    logging.config.dictConfig = lambda config: None
    np.random.seed(seed)  # noqa: NPY002  pyswarms draws from the global generator
    try:
        yield
    finally:
        logging.config.dictConfig = configure
        np.random.set_state(state)  # noqa: NPY002
