r"""Where a gap goes: what share each cause takes of what the simulator, as stated, gets wrong.

With g the gap (measured less simulated as stated), t_i what cause i does to the predictions and w the noise of each
row, the Shapley value of "squared gap removed" is, for traces that add up,

    share_i = <t_i, 2 g - sum_j t_j>_w / (|g|_w^2 - what noise and disturbances make).

What causes do together beyond the sum of what each does alone is given to them in equal parts. Intervals come from
draws of all unknowns as far as they are known, over re-drawn runs; parameters and effects that compensate each other
have wide ones.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted
from system_identification.hypothesis import Hypothesis, traces_of

__all__ = ["PARAMETERS", "Budget", "Share", "budget_of"]

Array = NDArray[np.float64]
PARAMETERS = "parameters"
"""All parameters together as one cause."""
_DRAWS = 400
_NONE = 0.02
"""Share of the squared error as stated below which there is no gap to be shared."""


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


def budget_of(found: Hypothesis, as_stated: Array, nameless: Array, seed: int = 0, tempered: float = 1.0) -> Budget:
    """Return the budget of a hypothesis.

    Args:
        found: the hypothesis.
        as_stated: predictions with parameters as stated and without effects, (R,).
        nameless: what functions without a name explain of the residuals, (R,); zero where they are not significant.
        seed: of the draws.
        tempered: by how much evidence is divided where what is simulated is never quite what was recorded.
    """
    fitted, system = found.fitted, found.system
    known = system.known
    weight = np.zeros(known.size)
    for each in system.series:
        weight[each.rows] = 1.0 / found.noise.level(each.signal)
    weight *= known
    count = max(float(np.sum(weight > 0.0)), 1.0)
    if found.noise.wild is not None:
        weight /= found.noise.wild
    full = system.predicted(fitted.x)
    traces = traces_of(fitted, found.suspects)
    without = _without_effects(fitted, found)
    parameters = without - as_stated
    together = (full - as_stated) - parameters - sum(traces.values(), start=np.zeros(known.size))
    names = [PARAMETERS, *traces]
    rows = [each + together / len(names) for each in (parameters, *traces.values())]
    moves = [np.nan_to_num(fitted.sensitivities[:, : system.parameters])]
    places: list[NDArray[np.int64]] = [np.arange(system.parameters)]
    for suspect in found.suspects:
        at = found.sizes_of(suspect).astype(np.int64)
        moves.append(np.nan_to_num(fitted.sensitivities[:, at]))
        places.append(at)
    gap = np.nan_to_num(system.measured - as_stated)
    left = np.nan_to_num(system.measured - full)
    columns = np.stack([*rows, gap, left, nameless], axis=1) * weight[:, None]
    steps = np.hstack(moves) * weight[:, None]
    everything = np.hstack((columns, steps))
    runs = sorted({each.recording for each in system.series})
    grams = []
    for run in runs:
        own = np.concatenate([everything[each.rows] for each in system.series if each.recording == run])
        grams.append(own.T @ own)
    n = len(names)
    whole = np.sum(grams, axis=0)
    total = whole[n, n] - whole[n + 1, n + 1] + whole[n + 2, n + 2]
    if total < _NONE * whole[n, n]:
        # Free runs of the best fit come no nearer than those as stated: nothing of the gap is explained.
        worse = float(whole[n + 1, n + 1] > (1.0 + _NONE) * whole[n, n])
        nothing = dict.fromkeys(names, Share(0.0, 0.0, 0.0))
        return Budget(float(np.sqrt(max(total, 0.0) / count)), nothing, Share(worse, 0.0, worse))
    of = np.concatenate([np.full(p.size, k) for k, p in enumerate(places)])
    at = np.concatenate(places)

    def shares(delta: Array, counts: Array) -> Array:
        gram = np.tensordot(counts, np.array(grams), axes=1)
        total = gram[n, n] - gram[n + 1, n + 1] + gram[n + 2, n + 2]
        combined = np.zeros((n, everything.shape[1]))
        combined[np.arange(n), np.arange(n)] = 1.0
        combined[of, n + 3 + np.arange(of.size)] = delta
        whole = combined.sum(axis=0)
        target = -whole
        target[n] += 2.0
        return (combined @ gram @ target) / max(total, 1e-12)

    central = shares(np.zeros(of.size), np.ones(len(runs)))
    rng = np.random.default_rng(seed)
    covariance = tempered * fitted.covariance[np.ix_(at, at)]
    spread = np.linalg.cholesky(covariance + 1e-12 * np.eye(at.size))
    draws = np.array(
        [
            shares(spread @ rng.standard_normal(at.size), len(runs) * rng.dirichlet(np.ones(len(runs))))
            for _ in range(_DRAWS)
        ]
    )
    low, high = np.percentile(draws, [5.0, 95.0], axis=0)
    rest = 1.0 - draws.sum(axis=1)
    unexplained = Share(float(1.0 - central.sum()), float(np.percentile(rest, 5.0)), float(np.percentile(rest, 95.0)))
    made = {name: Share(float(central[k]), float(low[k]), float(high[k])) for k, name in enumerate(names)}
    return Budget(float(np.sqrt(total / count)), made, unexplained)


def _without_effects(fitted: Fitted, found: Hypothesis) -> Array:
    system = fitted.problem
    if not found.suspects:
        return system.predicted(fitted.x)
    return system.with_effects(()).predicted(fitted.x[: system.nuisances])
