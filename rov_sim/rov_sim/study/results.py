"""The scores of a study, by strategy and what it was tried on, and the comparisons that the thesis draws from them."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rov_sim.study.statistics import Interval, mean_interval, ratio_interval

__all__ = ["BASELINE", "Results", "merged"]

Array = NDArray[np.float64]
BASELINE = "lookup"
"""The strategy that the thesis normalises by."""


@dataclass(frozen=True, kw_only=True)
class Results:
    """Scores by (strategy, reference) and name of the score, (seeds,) each, NaN where there is none.

    Attributes:
        scores: by name; the k-th entry of all belongs to one seed, that is to one drawn plant.
        seed: of the intervals.
    """

    scores: Mapping[tuple[str, str], Mapping[str, Array]]
    seed: int = 0

    @property
    def strategies(self) -> tuple[str, ...]:
        """In the order of the study."""
        return tuple(dict.fromkeys(strategy for strategy, _ in self.scores))

    @property
    def references(self) -> tuple[str, ...]:
        """In the order of the study."""
        return tuple(dict.fromkeys(reference for _, reference in self.scores))

    @property
    def seeds(self) -> int:
        """How many plants were drawn."""
        return min(x.size for values in self.scores.values() for x in values.values())

    def of(self, strategy: str, reference: str, name: str) -> Array:
        """Return one score over the seeds.

        Raises:
            ValueError: the study has not run the strategy on it.
        """
        if (strategy, reference) not in self.scores:
            ran = ", ".join(f"{s} on {r}" for s, r in self.scores)
            raise ValueError(f"study: expected scores of {strategy} on {reference}; found those of {ran}")
        return self.scores[strategy, reference][name]

    def mean(self, strategy: str, reference: str, name: str) -> Interval:
        """Return a score's mean."""
        return mean_interval(self.of(strategy, reference, name), self._rng())

    def normalised(self, strategy: str, reference: str, name: str = "rmse", by: str = BASELINE) -> Interval:
        """Return mean(score) over that of the strategy `by` on the same reference and plants (Fig. 5.5)."""
        return ratio_interval(self.of(strategy, reference, name), self.of(by, reference, name), self._rng())

    def difference(self, one: str, other: str, reference: str, name: str = "rmse") -> Interval:
        """Return the mean of one strategy's score less another's, plant by plant."""
        return mean_interval(self.of(one, reference, name) - self.of(other, reference, name), self._rng())

    def _rng(self) -> np.random.Generator:
        return np.random.default_rng(self.seed)


def merged(parts: Iterable[tuple[str, str, Mapping[str, Sequence[float | None]]]], seed: int = 0) -> Results:
    """Return the results of (strategy, reference, scores) in the order of their seeds."""
    collected: dict[tuple[str, str], dict[str, list[float]]] = {}
    for strategy, reference, scores in parts:
        here = collected.setdefault((strategy, reference), {name: [] for name in scores})
        for name, values in scores.items():
            here[name] += [np.nan if x is None else x for x in values]
    arrays = {key: {name: np.array(x) for name, x in scores.items()} for key, scores in collected.items()}
    return Results(scores=arrays, seed=seed)
