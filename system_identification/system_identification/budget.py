r"""Where a gap goes: what share each cause takes of what the simulator, as stated, gets wrong.

With t_i what cause i does to the predictions and g = sum_j t_j the gap (what comes out less what is simulated as
stated), the Shapley value of "squared gap removed" is, for traces that add up, with rows over their samples' own noise,

    share_i = <t_i, g> / |g|^2.

What causes do together beyond the sum of what each does alone is given to them in equal parts. What pushed the system
while it was recorded is no part of the gap: no model predicts it. Intervals come from draws of the set of effects and
of all unknowns as far as they are known; parameters and effects that compensate each other have wide ones.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.hypothesis import Hypothesis

__all__ = ["PARAMETERS", "Budget", "Share", "budget_of"]

Array = NDArray[np.float64]
PARAMETERS = "parameters"
"""All parameters together as one cause."""
_REST = "unexplained"
_DRAWS = 400
_FINEST = 0.003
"""Shares are not told more finely: simulators differ by as much."""
_NONE = 0.02
"""Share of the squares that are left below which there is no gap to be shared."""


class Share(NamedTuple):
    """A share of the gap and its 90 % interval."""

    value: float
    low: float
    high: float


class Budget(NamedTuple):
    """The gap as stated, root mean square over the noise of its rows; shares by cause; what none of them explains."""

    gap: float
    shares: Mapping[str, Share]
    unexplained: Share


def budget_of(
    sets: Sequence[tuple[Hypothesis, float]], nameless: Array, seed: int = 0, tempered: float = 1.0
) -> Budget:
    """Return the budget of the first of these hypotheses.

    Args:
        sets: hypotheses, the likeliest first, and their probabilities: what else may be at work widens the intervals.
        nameless: what functions without a name explain of the residuals, (R,); zero where they are not significant.
        seed: of the draws.
        tempered: by how much evidence is divided where what is simulated is never quite what was recorded.
    """
    probabilities = np.array([probability for _, probability in sets])
    counts = np.round(_DRAWS * probabilities / probabilities.sum()).astype(int)
    rng = np.random.default_rng(seed)
    first = _Shared(sets[0][0], nameless)
    central = first.shares(np.zeros(first.at.size))
    if first.gap < _NONE * first.squares(sets[0][0].fitted.residuals):
        return Budget(0.0, dict.fromkeys(first.names, Share(0.0, 0.0, 0.0)), Share(0.0, 0.0, 0.0))
    draws = []
    for (found, _), count in zip(sets, counts, strict=True):
        if not count:
            continue
        shared = first if found is sets[0][0] else _Shared(found, nameless)
        spread = np.asarray(np.linalg.cholesky(shared.covariance(tempered)), dtype=np.float64)
        for _ in range(count):
            own = dict(zip((*shared.names, _REST), shared.drawn(rng, spread), strict=True))
            draws.append([own.get(name, 0.0) for name in (*first.names, _REST)])
    low, high = np.percentile(np.array(draws), [5.0, 95.0], axis=0)
    low, high = low - _FINEST, high + _FINEST
    made = [Share(*map(float, each)) for each in zip(central, low, high, strict=True)]
    return Budget(float(np.sqrt(first.gap / first.count)), dict(zip(first.names, made, strict=False)), made[-1])


class _Shared:
    """The traces of a hypothesis, and how they move with its unknowns."""

    def __init__(self, found: Hypothesis, nameless: Array) -> None:
        fitted, system = found.fitted, found.system
        self._weight = np.zeros(system.known.size)
        for each in system.series:
            self._weight[each.rows] = 1.0 / found.noise.levels.sensors[each.signal]
        self._weight *= system.known / system.spread
        if found.noise.wild is not None:
            self._weight /= found.noise.wild
        self.count = max(float(np.sum(self._weight > 0.0)), 1.0)
        bare = system.with_effects(()) if found.suspects else system
        here = fitted.x[: system.nuisances]
        stated = np.concatenate((np.zeros(system.parameters), here[system.parameters :]))
        as_stated = bare.predicted(stated)
        # Each cause by itself, beside what is stated; what they make of each other is shared out.
        traces = {PARAMETERS: bare.predicted(here) - as_stated}
        for each in found.suspects:
            alone = system.with_effects(each.slots, tuple(each.gates))
            traces[each.key] = alone.predicted(np.concatenate((stated, fitted.x[found.sizes_of(each)]))) - as_stated
        full = system.predicted(fitted.x)
        together = (full - as_stated - sum(traces.values())) / len(traces)
        self.names = tuple(traces)
        places = [np.arange(system.parameters), *(found.sizes_of(each).astype(np.int64) for each in found.suspects)]
        self.at = np.concatenate(places)
        self._of = np.concatenate([np.full(each.size, k) for k, each in enumerate(places)])
        rows = [*(each + together for each in traces.values()), nameless]
        everything = np.column_stack((*rows, fitted.sensitivities[:, self.at])) * self._weight[:, None]
        self._gram, self._covariance = everything.T @ everything, fitted.covariance[np.ix_(self.at, self.at)]
        self._shape = found.loose.levels.get("shape", 0.0)
        self.gap = float(np.sum(self._gram[: len(rows), : len(rows)]))

    def squares(self, rows: Array) -> float:
        """Return the sum of squares of rows (R,) over their noise."""
        return float(np.sum((np.nan_to_num(rows) * self._weight) ** 2))

    def covariance(self, tempered: float) -> Array:
        """Return the covariance of what moves the traces."""
        return np.asarray(tempered * self._covariance + 1e-12 * np.eye(self.at.size))

    def drawn(self, rng: np.random.Generator, spread: Array) -> Array:
        """Return the shares for unknowns, and equations, as they may as well be."""
        larger = np.ones(len(self.names) + 1)
        larger[1:-1] += self._shape * rng.standard_normal(larger.size - 2)
        return self.shares(spread @ rng.standard_normal(self.at.size), larger)

    def shares(self, moved: Array, larger: Array | float = 1.0) -> Array:
        """Return the share of each cause, and of what has no name, for unknowns that are moved by so much.

        `larger`: how many times as large the trace of each is.
        """
        count = len(self.names) + 1
        combined = np.eye(count, self._gram.shape[0])
        combined[self._of, count + np.arange(self.at.size)] = moved
        combined *= np.reshape(larger, (-1, 1))
        whole = combined.sum(axis=0)
        by = self._gram @ whole
        return np.asarray(combined @ by / max(float(whole @ by), 1e-12))
