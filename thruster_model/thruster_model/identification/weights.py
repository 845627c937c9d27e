"""How much residuals count: by their size in each signal, by their memory, and less where they are large."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from thruster_model.identification.problem import Problem
from thruster_model.identification.uncertainty import autocorrelation_time

__all__ = ["RobustLoss", "weighted"]

Array = NDArray[np.float64]
_FAR = 8.0  # residuals beyond this multiple of the median one count as this multiple: spikes that were not masked


@dataclass(frozen=True, kw_only=True)
class RobustLoss:
    """Soft-L1 for the data's residuals, linear from `knee` on, and plain squares for the last `priors` ones."""

    knee: float
    priors: int

    def __call__(self, z: Array) -> Array:
        """Return (rho, rho', rho'') of the squared residuals z, shape (3, R), as scipy's `least_squares` wants."""
        root = np.sqrt(1.0 + z / self.knee**2)
        rho = np.stack((2.0 * self.knee**2 * (root - 1.0), 1.0 / root, -0.5 / (self.knee**2 * root**3)))
        rho[:, -self.priors :] = np.stack((z, np.ones_like(z), np.zeros_like(z)))[:, -self.priors :]
        return np.asarray(rho)


def weighted(problem: Problem, unknowns: Array) -> Problem:
    """Return the problem with the excess and the memory that its residuals at `unknowns` have."""
    residuals = problem.residuals(unknowns)
    squares: dict[str, list[Array]] = {}
    times: list[float] = []
    first = 0
    for row in problem.rows:
        piece = residuals[first : first + row.cells.size] * (problem.sigma(row.signal) / problem.noise[row.signal])
        first += row.cells.size
        if row.cells.size:
            series = np.full(problem.experiments[row.experiment].measurements[row.signal].values.size, np.nan)
            series[row.cells] = piece
            squares.setdefault(row.signal, []).append(np.minimum(piece**2, _FAR**2 * np.median(piece**2)))
            times.append(autocorrelation_time(series))
    if not squares:
        return problem
    excess = {name: max(1.0, float(np.sqrt(np.mean(np.concatenate(s))))) for name, s in squares.items()}
    return replace(problem, excess={**problem.excess, **excess}, memory=float(np.mean(times)))
