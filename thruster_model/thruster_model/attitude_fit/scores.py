"""How much of the measured rates a fit explains: free from the first sample, and begun anew every few seconds.

share = 1 - sum e^2 / sum (omega - mean)^2, per axis and recording: 1 is perfect, 0 as good as the recording's own mean,
negative worse than that. Intervals: blocks of errors and measurements drawn with replacement.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.attitude_fit.model import simulate, simulate_pieces
from thruster_model.attitude_fit.recording import Recording

__all__ = ["Share", "shares"]

Array = NDArray[np.float64]
_BLOCK, _DRAWS = 2.0, 500


class Share(NamedTuple):
    """Explained share of the variance of each axis (3,), with the ends of its 90 % interval."""

    value: Array
    low: Array
    high: Array


def shares(recording: Recording, x: Array, *, piece: float | None, rng: np.random.Generator) -> Share:
    """Return what the unknowns explain of a recording; `piece` None: a free run from the first sample."""
    given = (recording.rates, recording.gravity, recording.moments, recording.dt)
    made = simulate(*given, x) if piece is None else simulate_pieces(*given, max(2, round(piece / recording.dt)), x)
    missed = (made - recording.rates) ** 2
    varied = (recording.rates - recording.rates.mean(axis=0)) ** 2
    size = max(1, round(_BLOCK / recording.dt))
    cuts = np.arange(0, missed.shape[0], size)
    parts = [np.add.reduceat(each, cuts, axis=0) for each in (missed, varied)]
    drawn = rng.integers(0, cuts.size, (_DRAWS, cuts.size))
    again = 1.0 - parts[0][drawn].sum(axis=1) / parts[1][drawn].sum(axis=1)
    low, high = np.quantile(again, [0.05, 0.95], axis=0)
    return Share(1.0 - missed.sum(axis=0) / varied.sum(axis=0), low, high)
