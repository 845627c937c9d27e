"""One recording as the attitude fit sees it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Recording"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """Rates, gravity and commanded moments on one grid.

    Attributes:
        name: of the run.
        dt: of the grid [s].
        rates: (N, 3) p, q, r [rad/s].
        gravity: (N, 3) unit vector of gravity in body axes.
        moments: (N, 3) commanded moments about the body axes [N m], held for `dt`.
    """

    name: str
    dt: float
    rates: Array
    gravity: Array
    moments: Array

    def __post_init__(self) -> None:
        shapes = {self.rates.shape, self.gravity.shape, self.moments.shape}
        if len(shapes) != 1 or self.rates.ndim != 2 or self.rates.shape[1] != 3 or not self.dt > 0:
            raise ValueError(f"{self.name}: expected three arrays of one shape (N, 3); found {shapes}, dt {self.dt}")
        if not all(np.all(np.isfinite(each)) for each in (self.rates, self.gravity, self.moments)):
            raise ValueError(f"{self.name}: expected finite rates, gravity and moments")

    @property
    def time(self) -> Array:
        """Instants of the grid [s]."""
        return np.asarray(self.dt * np.arange(self.rates.shape[0]), dtype=np.float64)

    @property
    def pushed(self) -> tuple[bool, bool, bool]:
        """Whether any moment was commanded about each axis."""
        moved = np.any(np.abs(self.moments) > 1e-6, axis=0)
        return bool(moved[0]), bool(moved[1]), bool(moved[2])
