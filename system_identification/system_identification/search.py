"""Which set of effects is at work: forwards one at a time, each fitted with all others, then backwards and exchanged.

The linear model proposes, a fit disposes: every step screens all suspects about the present set, fits the likeliest
ones beside it, learns the noise that each of them leaves, and compares evidence.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from system_identification.exchange import Proposal, exchanges
from system_identification.fitting import fit, zooming
from system_identification.hypothesis import Hypothesis, weighed
from system_identification.learning import Caps
from system_identification.noise import whitener
from system_identification.pruning import Pruning
from system_identification.rating import Rated, Trial, rated, standing_in, tried
from system_identification.sets import FAR, NEAR, ROUNDS, WORTH, Sets, posed, rarer, score_of
from system_identification.suspects import Suspect
from system_identification.system import System

__all__ = ["Offer", "Search", "searched", "thinned"]

Array = NDArray[np.float64]
Offer = Callable[[Hypothesis], Sequence[Suspect]]
MOST = 7
"""Effects at work together."""
_BEST, _PLAIN = 4, 3
"""Suspects that are fitted in a step: the likeliest under the noise that was learned, and under plain noise."""
_SHARP = 4.0
"""Cost that a size must take off to be searched more finely."""
_SIZES = 2
"""Best sizes of a first look that are tried again."""
_EXCHANGES = 8
"""The most exchanges, as long as they bring a likelier set."""
_OTHERS, _GLANCE = 16, 3
"""Sets with effects exchanged that are looked at beside a set, and steps of such a look."""
_BEHIND = 40.0
"""Score by which a set may be behind after a look to be worth a fit."""
_PULLED = 2.5
"""Deviations of conventions of all runs from which on a delay may do the same."""
_PART = 0.5
"""Share of what the best set adds to the score, from which on another one may come out better once it has settled."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Search:
    """What was weighed.

    Attributes:
        none: re-tuned parameters alone.
        best: the set with most evidence.
        weighed: every set that was fitted, by its keys.
        rated: the first look at all suspects beside nothing.
        sizes: by suspect those that this look found worth trying, see `thinned`.
        offered: how many suspects there are.
    """

    none: Hypothesis
    best: Hypothesis
    weighed: dict[frozenset[str], Hypothesis]
    rated: list[Rated]
    sizes: Mapping[str, Array]
    offered: int

    def score(self, found: Hypothesis) -> float:
        """Return the logarithm of a set's probability, up to what all share."""
        return score_of(found, self.offered)


def searched(
    system: System,
    offer: Offer,
    *,
    caps: Caps | None = None,
    grew: Callable[[Hypothesis], None] = lambda _: None,
    in_vain: Callable[[Hypothesis, Hypothesis], bool] = lambda _, __: False,
    progress: Callable[[str], None] = lambda _: None,
) -> Search:
    """Return the sets of effects that explain a system's rows.

    Args:
        system: without effects.
        offer: the suspects about a hypothesis, with sizes to try.
        caps: what noise may be.
        grew: is given each set that has become larger, and at last the best one; what it raises ends the search.
        in_vain: tells of a set and one that is larger by an effect whether more of them will explain nothing: then
            none is sought any more, nor others in their places.
        progress: is told of each stage.
    """
    return _Searching(system, offer, caps or Caps(), grew, in_vain, progress).run()


def _worth_trying(looks: Sequence[Rated]) -> dict[str, Array]:
    """Return by suspect its best sizes in a first look, and its smallest ones, (G, number of slots)."""
    found: dict[str, Array] = {}
    for each in looks:
        grid = each.suspect.grid
        kept = [grid[each.order[:_SIZES]], grid[np.argsort(np.abs(grid[:, 0]))[:2]]]
        if each.suspect.key in found:
            kept.append(found[each.suspect.key])
        found[each.suspect.key] = np.unique(np.vstack(kept), axis=0)
    return found


def thinned(suspect: Suspect, sizes: Mapping[str, Array]) -> Suspect:
    """Return a suspect with those of its sizes that were the best in a first look, and small ones."""
    grid = sizes.get(suspect.key)
    if grid is None or suspect.price or suspect.grid.shape[0] <= grid.shape[0]:
        return suspect
    return replace(suspect, grid=grid)


class _Searching:
    def __init__(
        self,
        system: System,
        offer: Offer,
        caps: Caps,
        grew: Callable[[Hypothesis], None],
        in_vain: Callable[[Hypothesis, Hypothesis], bool],
        progress: Callable[[str], None],
    ) -> None:
        self.offer, self.grew, self.in_vain, self.progress = offer, grew, in_vain, progress
        self.ended = False
        progress("base fit")
        self.sets = Sets(system, caps)
        self.pruning = Pruning(self.sets)
        self.first: list[Rated] = []
        self.seen = set[frozenset[str]]()
        self.sizes: dict[str, Array] = {}
        self.trials: dict[frozenset[str], list[Trial]] = {}

    def run(self) -> Search:
        sets = self.sets
        current = self.grown(sets.settled(sets.best))
        best = self.exchanged()
        for _ in range(ROUNDS):
            if best.keys == current.keys or self.ended:
                break
            current = self.grown(best)  # what is exchanged may have made room for more
            best = self.exchanged()
        self.grew(best)
        return Search(
            none=sets.found[frozenset()], best=best, weighed=sets.found, rated=self.first, sizes=self.sizes,
            offered=sets.offered,
        )  # fmt: skip

    def grown(self, current: Hypothesis) -> Hypothesis:
        """Return a set with one effect more after the other, as long as one is worth it."""
        while len(current.suspects) < MOST and not self.ended:
            self.progress(f"suspects beside {', '.join(current.keys) or 'nothing'}")
            ranked, tries = self.look(current)
            self.first = self.first or ranked
            better = self.step(current, tries)
            if better is None:
                break
            self.grew(better)
            self.ended = better.keys != current.keys and self.in_vain(current, better)
            current = better
        return current

    def trials_beside(self, current: Hypothesis) -> list[Trial]:
        """Return what all other suspects do beside a set."""
        keys = frozenset(current.keys)
        if keys not in self.trials:
            named = {each.effect for each in current.suspects}
            suspects = [each for each in self.offer(current) if each.effect not in named or each.channel]
            suspects = [thinned(each, self.sizes) for each in suspects if each.key not in keys]
            self.sets.offered = max(self.sets.offered, len(suspects) + len(keys))
            self.trials = {
                keys: tried(current.fitted, suspects, lambda each: current.system.tried(current.fitted.x, each))
            }
        return self.trials[keys]

    def look(self, current: Hypothesis) -> tuple[list[Rated], list[Rated]]:
        """Return all suspects beside a set, the likeliest first, and those that are worth a fit."""
        trials = self.trials_beside(current)
        ranked = rated(current.fitted, current.noise, trials)
        plain = rated(current.fitted, whitener(current.system, current.fitted.x), trials)
        ranked = [self.refined(current, each) for each in ranked]
        ranked.sort(key=lambda each: -each.promise)
        if not self.sizes:
            self.sizes = _worth_trying((*ranked, *plain))
        picked = [each for each in ranked[:_BEST] if each.promise > 0.0]
        others = [plain]
        x, shared = current.fitted.x[: current.system.nuisances], current.system.shared_conventions
        if current.noise.levels.parameters > 1.0 or np.max(np.abs(x[shared]), initial=0.0) > _PULLED:
            # What parameters do by scattering widely, or conventions, an effect may do beside these as stated.
            others.append(standing_in(current.fitted, current.noise.scattering(1.0), trials))
        for looks in others:
            keys = {each.suspect.key for each in picked}
            picked += [each for each in looks[:_PLAIN] if each.promise > 3.0 and each.suspect.key not in keys]
        if np.max(np.abs(current.fitted.x[: current.system.nuisances])) > FAR:
            # What has no size is right or wrong as a whole: no first order about a fit that is far off tells.
            keys = {each.suspect.key for each in picked}
            picked += [each for each in ranked if each.suspect.exact and each.suspect.key not in keys]
        return ranked, picked

    def refined(self, current: Hypothesis, each: Rated) -> Rated:
        """Return a suspect whose trace is sharp over its size at the best of ever finer sizes."""
        if each.suspect.spacing == 0.0 or each.gain <= _SHARP:
            return each
        for factors in zooming(each.suspect.spacing):
            grid = each.sizes * factors[:, None]
            width = each.suspect.slots[0].width
            grid = grid[(grid[:, 0] * width <= each.suspect.slots[0].upper)]
            trial = tried(
                current.fitted, [replace(each.suspect, grid=grid)], lambda s: current.system.tried(current.fitted.x, s)
            )
            (again,) = rated(current.fitted, current.noise, trial)
            if again.gain > each.gain:
                each = replace(again, visibility=each.visibility, suspect=each.suspect, order=each.order)
        return each

    def step(self, current: Hypothesis, tries: Sequence[Rated]) -> Hypothesis | None:
        """Return the set with one of the suspects more that is likeliest, or the present one where it is fitted better
        from there; None where neither is likelier.

        All are fitted under the noise that is known, with sensitivities that are; for the best few of them the noise is
        learned anew.
        """
        quick = [
            self.sets.begun(current, (*current.suspects, each.suspect), np.concatenate((current.fitted.x, each.sizes)))
            for each in tries
        ]
        self.sets.learn(current, quick)
        size = len(current.keys) + 1
        more = [h for keys, h in self.sets.found.items() if set(current.keys) < keys and len(keys) == size]
        best = self.likeliest(more, self.sets.score(current))
        if best is None or self.sets.score(best) <= self.sets.score(current) + WORTH:
            return None
        # A set may have been fitted better than the one without, by where it began: that one is fitted from there too.
        (added,) = (each for each in best.suspects if each.key not in current.keys)
        again = self.sets.without(best, added, anew=True)
        if self.sets.score(best) > self.sets.score(again) + WORTH:
            return best
        # From there it may be fitted so much better that others stand out beside it.
        self.trials.pop(frozenset(again.keys), None)
        return again if self.sets.score(again) > self.sets.score(current) + WORTH else None

    def likeliest(self, more: Sequence[Hypothesis], without: float) -> Hypothesis | None:
        """Return the likeliest of sets once they have settled; `without`: score of the set that they were made from.

        Such a set is where its first fit ended, under a noise in which there was room for what it explains. So all that
        explain a good part of what the best one does are fitted again under the noise that is left beside that one;
        and where none is likelier than without, all that are not far behind.
        """
        best: Hypothesis | None = None
        for each in sorted(more, key=self.sets.score, reverse=True):
            if best is None:
                best = self.sets.settled(each)
                continue
            far = self.sets.score(best) - (NEAR if self.sets.score(best) > without else _BEHIND)
            if self.sets.score(each) > min(far, without + _PART * (self.sets.score(best) - without)):
                again = weighed(
                    each.system, each.suspects, each.fitted.x, best.noise, near=each.fitted, caps=self.sets.caps
                )  # fmt: skip
                each = self.sets.keep(again)
                if self.sets.score(each) > far:
                    best = max(best, self.sets.settled(each), key=self.sets.score)
        return best

    def glanced(self, current: Hypothesis, proposal: Proposal) -> tuple[float, tuple[Suspect, ...], Array]:
        """Return the score of a proposed set after some steps with slopes that are only corrected, and its unknowns.

        What is large is not linear: a simulation tells more of a set than the linearised model that proposed it.
        """
        suspects, start, _ = proposal
        system, near = posed(current.system, suspects), self.sets.bare(current)
        fitted = fit(system, current.noise, start, iterations=_GLANCE, near=near, polish=False, anew=False)
        price = sum(each.price for each in suspects) + sum(rarer(k, self.sets.offered) for k in range(len(suspects)))
        return fitted.evidence - price, suspects, fitted.x

    def exchanged(self) -> Hypothesis:
        """Return the likeliest set once those were fitted that lack one effect, or have one or two others instead.

        Sets that come out about as likely are left in the same way: two exchanged effects are one step each.
        """
        for done in range(0 if self.ended else _EXCHANGES):
            best = self.sets.best
            least = self.sets.score(best) - NEAR
            near = [
                h
                for keys, h in self.sets.found.items()
                if keys and self.sets.score(h) > least and keys not in self.seen and not self.sets.idle(h)
            ]
            if not near or (done >= ROUNDS and frozenset(best.keys) in self.seen):
                break
            current = self.sets.settled(max(near, key=self.sets.score))
            self.seen.add(frozenset(current.keys))
            self.progress(f"others than {', '.join(current.keys)}")
            more = rarer(len(current.suspects), self.sets.offered) if len(current.suspects) < MOST else None
            others = [
                each
                for each in exchanges(current, self.trials_beside(current), _OTHERS, more)
                if frozenset(suspect.key for suspect in each.suspects) not in self.sets.found
            ]
            quick = sorted((self.glanced(current, each) for each in others), key=lambda each: -each[0])
            worth = self.sets.score(current) - _BEHIND
            tries = [self.sets.begun(current, suspects, x) for score, suspects, x in quick[:_BEST] if score > worth]
            self.sets.learn(current, tries)
        return self.pruning.pruned()
