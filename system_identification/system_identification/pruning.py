"""Leave out of the likeliest set of effects what is not worth it, and look at those that may stand in for others."""

import numpy as np

from system_identification.hypothesis import Hypothesis
from system_identification.sets import NEAR, WORTH, Sets

__all__ = ["Pruning"]


class Pruning:
    """Of sets, which are not worth their last effect."""

    def __init__(self, sets: Sets) -> None:
        """Begin with none."""
        self.sets = sets
        self.needless = set[frozenset[str]]()

    def pruned(self) -> Hypothesis:
        """Return the likeliest set without what is not worth it."""
        sets = self.sets
        while True:
            best = sets.settled(sets.best)
            if self.stand_in(best):
                continue
            for suspect in best.suspects:
                sets.without(best, suspect)
            fewer = [each for each in sets.found.values() if len(each.suspects) < len(best.suspects)]
            leaner = max(fewer, key=sets.score, default=best)
            if leaner is best or sets.score(best) > sets.score(leaner) + WORTH:
                return best
            self.needless.add(frozenset(best.keys))
            del sets.found[frozenset(best.keys)]  # one of its effects is not worth it

    def stand_in(self, best: Hypothesis) -> bool:
        """Weigh sets in which one effect stands for others; tell whether one comes out likelier than the best one.

        Sets with both tell, where these were weighed: beside the new one the old one may as well be nothing, or is held
        at an end of its range, where no variance tells.
        """
        sets = self.sets
        least = sets.score(best) - NEAR
        for keys, both in list(sets.found.items()):
            if len(keys) > 1 and sets.score(both) > least:
                x, variances = both.fitted.x, np.diag(both.fitted.covariance)
                held = np.abs(both.system.bounded(1.01 * x) - x) < 0.005 * np.abs(x)
                for each in both.suspects:
                    own = both.sizes_of(each)[0]
                    trades = held[own] or x[own] ** 2 < 2.0 * NEAR * variances[own]
                    if trades and keys - {each.key} not in self.needless:
                        sets.without(both, each)
        return sets.best is not best
