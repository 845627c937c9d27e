r"""Where a gap goes: what share each cause takes of what the simulator, as stated, gets wrong.

With t_i what cause i does to the predictions and g = sum_j t_j the gap (what comes out less what is simulated as
stated), the Shapley value of "squared gap removed" is, for traces that add up, with rows over their samples' own noise,

    share_i = <t_i, g> / |g|^2.

What causes do together beyond the sum of what each does alone is given to them in equal parts. What pushed the system
while it was recorded is no part of the gap: no model predicts it. Intervals come from draws of the set of effects and
of all unknowns as far as they are known, each simulated; parameters and effects that compensate each other have wide
ones.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.hypothesis import Hypothesis

__all__ = ["PARAMETERS", "Budget", "Share", "budget_of"]

Array = NDArray[np.float64]
PARAMETERS = "parameters"
"""All parameters together as one cause."""
_REST = "unexplained"
_DRAWS = 32
"""What causes do together bends with each of them: each draw is simulated."""
_WITHIN = 1.645
"""Standard deviations to either side of the mean within which nine in ten draws lie."""
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
    best = sets[0][0]
    first = _Shared(best, nameless)
    central, whole = first.shares(best.fitted.x)
    if whole < _NONE * first.squares(best.fitted.residuals):
        return Budget(0.0, dict.fromkeys(first.names, Share(0.0, 0.0, 0.0)), Share(0.0, 0.0, 0.0))
    draws = []
    for (found, _), count in zip(sets, counts, strict=True):
        if not count:
            continue
        shared = first if found is best else _Shared(found, nameless)
        for x, larger in shared.drawn(rng, count, tempered):
            own = dict(zip((*shared.names, _REST), shared.shares(x, larger)[0], strict=True))
            draws.append([own.get(name, 0.0) for name in (*first.names, _REST)])
    mean, spread = np.mean(draws, axis=0), _WITHIN * np.std(draws, axis=0) + _FINEST
    low, high = np.minimum(mean - spread, central - _FINEST), np.maximum(mean + spread, central + _FINEST)
    made = [Share(*map(float, each)) for each in zip(central, low, high, strict=True)]
    return Budget(float(np.sqrt(whole / first.count)), dict(zip(first.names, made, strict=False)), made[-1])


class _Shared:
    """The traces of a hypothesis for any of its unknowns."""

    def __init__(self, found: Hypothesis, nameless: Array) -> None:
        system = found.system
        self._weight = np.zeros(system.known.size)
        for each in system.series:
            self._weight[each.rows] = 1.0 / found.noise.levels.sensors[each.signal]
        self._weight *= system.known / system.spread
        if found.noise.wild is not None:
            self._weight /= found.noise.wild
        self.count = max(float(np.sum(self._weight > 0.0)), 1.0)
        self.names = (PARAMETERS, *found.keys)
        self._found, self._nameless = found, nameless * self._weight
        self._bare = system.with_effects(()) if found.suspects else system
        self._alone = [
            (system.with_effects(each.slots, tuple(each.gates)), found.sizes_of(each)) for each in found.suspects
        ]

    def squares(self, rows: Array) -> float:
        """Return the sum of squares of rows (R,) over their noise."""
        return float(np.sum((np.nan_to_num(rows) * self._weight) ** 2))

    def drawn(self, rng: np.random.Generator, count: int, tempered: float) -> Iterator[tuple[Array, Array]]:
        """Yield so many times unknowns (K,), and how many times larger each trace is, as they may as well be."""
        fitted, system = self._found.fitted, self._found.system
        sizes = np.arange(system.nuisances, fitted.x.size)
        at = np.concatenate((np.arange(system.parameters), sizes))
        covariance = tempered * fitted.covariance[np.ix_(at, at)] + 1e-12 * np.eye(at.size)
        spread = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
        shape = self._found.loose.levels.get("shape", 0.0)
        for _ in range(count):
            x, larger = fitted.x.copy(), np.ones(len(self.names) + 1)
            x[at] += spread @ rng.standard_normal(at.size)
            larger[1:-1] += shape * rng.standard_normal(larger.size - 2)
            yield system.bounded(x), larger

    def shares(self, x: Array, larger: Array | float = 1.0) -> tuple[Array, float]:
        """Return the share of each cause, and of what has no name, for unknowns (K,), and the squares of the gap.

        `larger`: how many times as large the trace of each is.
        """
        system = self._found.system
        here = x[: system.nuisances]
        stated = np.concatenate((np.zeros(system.parameters), here[system.parameters :]))
        as_stated = self._bare.predicted(stated)
        # Each cause by itself, beside what is stated; what they make of each other is shared out.
        traces = [self._bare.predicted(here) - as_stated]
        traces += [alone.predicted(np.concatenate((stated, x[at]))) - as_stated for alone, at in self._alone]
        together = (system.predicted(x) - as_stated - sum(traces)) / len(traces)
        rows = np.array([*((each + together) * self._weight for each in traces), self._nameless])
        rows *= np.reshape(larger, (-1, 1))
        whole = rows.sum(axis=0)
        gap = float(whole @ whole)
        return np.asarray(rows @ whole / max(gap, 1e-12)), gap
