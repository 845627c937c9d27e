r"""Whether what pushes the plant at random comes in bursts: then something happens at times, in a way without a name.

Water pushes all the time, as hard at one time as at another. What is wrong in a way that no function of states and
inputs tells, a plug that is loose for a second or a play in the command, lets a filter miss by much now and then.

Filters with pushes of the learned level times m each give the probability p_w(m) of the readings in a window w, all
earlier ones known. Compared are levels that differ from window to window and one level for all:

    \max_\pi \sum_w \log \sum_m \pi_m p_w(m)     and     \max_m \sum_w \log p_w(m)

(likeliest mixture: Kiefer and Wolfowitz 1956, Ann. Math. Statist. 27, 887). Each level more pays for having been chosen
and for its share.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp, softmax

from gap_diagnosis.rules import RULES
from system_identification.fitting import Fitted
from system_identification.moves import rows_of_runs
from system_identification.noise import Whitener

__all__ = ["bursts_of", "evidence_for_bursts"]

Array = NDArray[np.float64]
_TIMES = np.geomspace(1 / 16, 16, 9)
"""m."""
_WINDOW = 1.0
"""[s] As long as what comes and goes, and longer than a rotor remembers."""
_ROUNDS = 200
"""Of expectation and maximisation."""


def bursts_of(fitted: Fitted, noise: Whitener, loose: Array) -> dict[str, float]:
    """Return by the signal that reads a pushed state the logarithm of evidence that its push comes in bursts.

    None, -inf, where at their height they move the state by less than the noise of its reading. `loose`: what differs
    from run to run, (R,), is no push.
    """
    if not noise.linear:
        return {}
    rows, window = np.nan_to_num(fitted.residuals - loose), _windows(noise)
    found = {}
    for place, signal in enumerate(noise.system.pushed):
        by_level = np.column_stack([_by_window(noise.pushing(place, m), rows, window) for m in _TIMES])
        evidence, highest = evidence_for_bursts(by_level)
        found[signal] = evidence if noise.levels.pushes[place] * _TIMES[highest] >= RULES.noteworthy else -np.inf
    return found


def evidence_for_bursts(by_level: Array) -> tuple[float, int]:
    """Return the logarithm of evidence that levels differ, and the highest one of those that take part.

    `by_level`: log likelihood of each window's readings at each level, (W, M).
    """
    count, levels = by_level.shape
    shares = np.full(levels, 1.0 / levels)
    for _ in range(_ROUNDS):
        shares = np.mean(softmax(np.log(np.maximum(shares, 1e-300)) + by_level, axis=1), axis=0)
    there = np.flatnonzero(shares > 1.0 / count)  # less than a window is none
    mixed = float(np.sum(logsumexp(by_level[:, there], b=shares[there] / np.sum(shares[there]), axis=1)))
    price = (there.size - 1) * (0.5 * np.log(count) + np.log(levels))
    return mixed - float(np.max(np.sum(by_level, axis=0))) - float(price), int(there[-1])


def _windows(noise: Whitener) -> NDArray[np.int64]:
    """Return the window of each row, (R,)."""
    run = np.zeros(noise.system.known.size)
    for place, rows in enumerate(rows_of_runs(noise.system)):
        run[rows] = place
    windows = np.stack((run, np.floor(noise.system.times / _WINDOW)), axis=1)
    return np.asarray(np.unique(windows, axis=0, return_inverse=True)[1].ravel())


def _by_window(noise: Whitener, rows: Array, window: NDArray[np.int64]) -> Array:
    """Return the log likelihood of the rows (R,) of each window, (W,)."""
    own = -0.5 * noise.whiten(rows) ** 2 - np.log(noise.deviations)
    return np.asarray(np.bincount(window, np.where(noise.system.known, own, 0.0)), dtype=np.float64)
