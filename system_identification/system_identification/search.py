"""Which set of effects is at work: forwards one at a time, each fitted with all others, then backwards and exchanged.

The linear model proposes, a fit disposes: every step screens all suspects about the present set, fits the likeliest
ones beside it, learns the noise that each of them leaves, and compares evidence. Sets are as likely before the data as
effects are rare: each further one is `MORE` times as likely as one less, all of a size alike.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from system_identification.exchange import Proposal, exchanges
from system_identification.fitting import Fitted, fit, fit_past_jumps
from system_identification.hypothesis import Hypothesis, weighed
from system_identification.learning import Caps
from system_identification.noise import whitener
from system_identification.rating import Rated, Trial, rated, standing_in, tried
from system_identification.suspects import Suspect
from system_identification.system import System

__all__ = ["Offer", "Search", "searched", "thinned"]

Array = NDArray[np.float64]
Offer = Callable[[Hypothesis], Sequence[Suspect]]
MORE = 0.6
"""How much rarer a set with one effect more is, before the data."""
MOST = 7
"""Effects at work together."""
_BEST, _PLAIN = 4, 3
"""Suspects that are fitted in a step: the likeliest under the noise that was learned, and under plain noise."""
_WEIGHED = 3
"""Of these, those for which the noise is learned anew."""
_FINER = 6
"""Rounds of a finer search about a size, each about three times as fine."""
_SHARP = 4.0
"""Cost that a size must take off to be searched more finely."""
_FAR = 3.5
"""Deviations of nuisances from which on they may have been pulled off by an effect that is missing."""
_SIZES = 2
"""Best sizes of a first look that are tried again."""
_ROUNDS, _EXCHANGES = 3, 8
"""Rounds of settling, of exchanges and of growing again; the most exchanges, as long as they bring a likelier set."""
_OTHERS, _GLANCE = 16, 3
"""Sets with effects exchanged that are looked at beside a set, and steps of such a look."""
_BEHIND = 40.0
"""Score by which a set may be behind after a look to be worth a fit."""
_NEAR = 15.0
"""Evidence by which a set may be behind for its own exchanges to be looked at."""
_PART = 0.5
"""Share of what the best set adds to the score, from which on another one may come out better once it has settled."""
_WORTH = 1.0
"""Evidence, prior included, that one more effect must add."""


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
        return _score(found, self.offered)


def _score(found: Hypothesis, offered: int) -> float:
    """Return the logarithm of a set's probability, up to what all share: its evidence, and how rare it is among all."""
    return found.evidence - sum(_rarer(k, offered) for k in range(len(found.suspects)))


def _rarer(count: int, offered: int) -> float:
    """Return how much rarer, nats, a set with one effect more than so many is, of those of its size."""
    return -float(np.log(MORE * (count + 1) / max(offered - count, 1)))


def searched(
    system: System,
    offer: Offer,
    *,
    caps: Caps | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Search:
    """Return the sets of effects that explain a system's rows.

    Args:
        system: without effects.
        offer: the suspects about a hypothesis, with sizes to try.
        caps: what noise may be.
        progress: is told of each stage.
    """
    return _Searching(system, offer, caps or Caps(), progress).run()


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


def _posed(system: Any, suspects: Sequence[Suspect]) -> Any:
    """Return a system with the sizes of suspects as unknowns."""
    gates = next((tuple(each.gates) for each in suspects if each.gates), ())
    return system.with_effects(tuple(slot for each in suspects for slot in each.slots), gates)


class _Searching:
    def __init__(self, system: System, offer: Offer, caps: Caps, progress: Callable[[str], None]) -> None:
        self.system, self.offer, self.caps, self.progress = system, offer, caps, progress
        self.found: dict[frozenset[str], Hypothesis] = {}
        self.first: list[Rated] = []
        self.seen = set[frozenset[str]]()
        self.needless = set[frozenset[str]]()
        self.offered = 1
        self.sizes: dict[str, Array] = {}
        self.trials: dict[frozenset[str], list[Trial]] = {}

    def run(self) -> Search:
        self.progress("base fit")
        plain = whitener(self.system, np.zeros(self.system.nuisances))
        self.stated = fit(self.system, plain, np.zeros(self.system.nuisances), iterations=0)
        base = fit(self.system, plain, self.stated.x, iterations=12, near=self.stated)
        none = weighed(self.system, (), base.x, whitener(self.system, base.x), near=base, caps=self.caps, steps=8)
        self.found[frozenset()] = none
        current = self.grown(self.settled(none))
        best = self.exchanged()
        for _ in range(_ROUNDS):
            if best.keys == current.keys:
                break
            current = self.grown(best)  # what is exchanged may have made room for more
            best = self.exchanged()
        return Search(
            none=self.found[frozenset()], best=best, weighed=self.found, rated=self.first, sizes=self.sizes,
            offered=self.offered,
        )  # fmt: skip

    def grown(self, current: Hypothesis) -> Hypothesis:
        """Return a set with one effect more after the other, as long as one is worth it."""
        while len(current.suspects) < MOST:
            self.progress(f"suspects beside {', '.join(current.keys) or 'nothing'}")
            ranked, tries = self.look(current)
            self.first = self.first or ranked
            better = self.step(current, tries)
            if better is None:
                break
            current = better
        return current

    def score(self, found: Hypothesis) -> float:
        return _score(found, self.offered)

    def trials_beside(self, current: Hypothesis) -> list[Trial]:
        """Return what all other suspects do beside a set."""
        keys = frozenset(current.keys)
        if keys not in self.trials:
            named = {each.effect for each in current.suspects}
            suspects = [each for each in self.offer(current) if each.effect not in named or each.channel]
            suspects = [thinned(each, self.sizes) for each in suspects if each.key not in keys]
            self.offered = max(self.offered, len(suspects) + len(keys))
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
        if current.noise.levels.parameters > 1.0:
            # What parameters do by scattering widely an effect may do beside parameters as stated.
            others.append(standing_in(current.fitted, current.noise.scattering(1.0), trials))
        for looks in others:
            keys = {each.suspect.key for each in picked}
            picked += [each for each in looks[:_PLAIN] if each.promise > 3.0 and each.suspect.key not in keys]
        if np.max(np.abs(current.fitted.x[: current.system.nuisances])) > _FAR:
            # What has no size is right or wrong as a whole: no first order about a fit that is far off tells.
            keys = {each.suspect.key for each in picked}
            picked += [each for each in ranked if each.suspect.exact and each.suspect.key not in keys]
        return ranked, picked

    def refined(self, current: Hypothesis, each: Rated) -> Rated:
        """Return a suspect whose trace is sharp over its size at the best of ever finer sizes."""
        spacing = each.suspect.spacing
        for _ in range(_FINER if spacing > 0.0 and each.gain > _SHARP else 0):
            grid = each.sizes * np.exp(spacing * np.linspace(-1.0, 1.0, 9))[:, None]
            width = each.suspect.slots[0].width
            grid = grid[(grid[:, 0] * width <= each.suspect.slots[0].upper)]
            trial = tried(
                current.fitted, [replace(each.suspect, grid=grid)], lambda s: current.system.tried(current.fitted.x, s)
            )
            (again,) = rated(current.fitted, current.noise, trial)
            if again.gain > each.gain:
                each = replace(again, visibility=each.visibility, suspect=each.suspect, order=each.order)
            spacing *= 0.3
        return each

    def step(self, current: Hypothesis, tries: Sequence[Rated]) -> Hypothesis | None:
        """Return the set with one of the suspects more that is likeliest, or the present one where it is fitted better
        from there; None where neither is likelier.

        All are fitted under the noise that is known, with sensitivities that are; for the best few of them the noise is
        learned anew.
        """
        quick = [
            self.begun(current, (*current.suspects, each.suspect), np.concatenate((current.fitted.x, each.sizes)))
            for each in tries
        ]
        self.weighed(current, quick)
        size = len(current.keys) + 1
        more = [h for keys, h in self.found.items() if set(current.keys) < keys and len(keys) == size]
        best = self.likeliest(more, self.score(current))
        if best is None or self.score(best) <= self.score(current) + _WORTH:
            return None
        # A set may have been fitted better than the one without, by where it began: that one is fitted from there too.
        (added,) = (each for each in best.suspects if each.key not in current.keys)
        again = self.without(best, added, anew=True)
        if self.score(best) > self.score(again) + _WORTH:
            return best
        # From there it may be fitted so much better that others stand out beside it.
        self.trials.pop(frozenset(again.keys), None)
        return again if self.score(again) > self.score(current) + _WORTH else None

    def likeliest(self, sets: Sequence[Hypothesis], without: float) -> Hypothesis | None:
        """Return the likeliest of sets once they have settled; `without`: score of the set that they were made from.

        Such a set is where its first fit ended, under a noise in which there was room for what it explains. So all that
        explain a good part of what the best one does are fitted again under the noise that is left beside that one;
        and where none is likelier than without, all that are not far behind.
        """
        best: Hypothesis | None = None
        for each in sorted(sets, key=self.score, reverse=True):
            if best is None:
                best = self.settled(each)
                continue
            far = self.score(best) - (_NEAR if self.score(best) > without else _BEHIND)
            if self.score(each) > min(far, without + _PART * (self.score(best) - without)):
                again = weighed(
                    each.system, each.suspects, each.fitted.x, best.noise, near=each.fitted, caps=self.caps
                )  # fmt: skip
                each = self.keep(again)
                if self.score(each) > far:
                    best = max(best, self.settled(each), key=self.score)
        return best

    def begun(
        self, current: Hypothesis, suspects: tuple[Suspect, ...], start: Array
    ) -> tuple[float, tuple[Suspect, ...], Fitted]:
        """Return the evidence of a set under the noise of a set near it, its suspects, and its fit from a start."""
        posed = _posed(current.system, suspects)
        nuisances = current.system.nuisances
        if posed.jumps and not current.system.jumps:
            fitted = fit_past_jumps(posed, current.noise, start, across=False)
        else:
            fitted = fit(posed, current.noise, start, iterations=6, near=self.bare(current), polish=False)
        if np.max(np.abs(start[:nuisances])) > _FAR:
            # What the effect does may have been left to them: a valley of its own begins where they are as stated.
            there = np.concatenate((self.stated.x, start[nuisances:]))
            noise = current.noise.scattering(1.0)
            again = fit(posed, noise, there, iterations=10, near=self.stated, polish=False)
            fitted = again if again.evidence > fitted.evidence else fitted
        return fitted.evidence - sum(each.price for each in suspects), suspects, fitted

    def idle(self, found: Hypothesis) -> bool:
        """Tell whether a set is no likelier than another without some of its effects."""
        keys = frozenset(found.keys)
        return any(less < keys and self.score(h) >= self.score(found) for less, h in self.found.items())

    def glanced(self, current: Hypothesis, proposal: Proposal) -> tuple[float, tuple[Suspect, ...], Array]:
        """Return the score of a proposed set after some steps with slopes that are only corrected, and its unknowns.

        What is large is not linear: a simulation tells more of a set than the linearised model that proposed it.
        """
        suspects, start, _ = proposal
        posed = _posed(current.system, suspects)
        near = self.bare(current)
        fitted = fit(posed, current.noise, start, iterations=_GLANCE, near=near, polish=False, anew=False)
        price = sum(each.price for each in suspects) + sum(_rarer(k, self.offered) for k in range(len(suspects)))
        return fitted.evidence - price, suspects, fitted.x

    def bare(self, current: Hypothesis) -> Fitted:
        """Return a fitted set as if it had no effects: for its sensitivities to the nuisances."""
        count, fitted = current.system.nuisances, current.fitted
        return replace(
            fitted, x=fitted.x[:count], sensitivities=fitted.sensitivities[:, :count], anchor=fitted.anchor[:count]
        )

    def weighed(self, current: Hypothesis, begun: Sequence[tuple[float, tuple[Suspect, ...], Fitted]]) -> None:
        """Learn the noise beside the likeliest of these sets, and keep them."""
        for _, suspects, fitted in sorted(begun, key=lambda one: -one[0])[:_WEIGHED]:
            self.keep(
                weighed(
                    fitted.problem, suspects, fitted.x, current.noise, iterations=4, near=fitted, caps=self.caps,
                    polish=False,
                )
            )  # fmt: skip

    def keep(self, found: Hypothesis) -> Hypothesis:
        """Keep a set, unless it was fitted better before; return the better one."""
        keys = frozenset(found.keys)
        if keys not in self.found or found.evidence > self.found[keys].evidence:
            self.found[keys] = found
        return self.found[keys]

    def settled(self, found: Hypothesis) -> Hypothesis:
        """Return a set fitted and its noise learned again and again until neither adds evidence."""
        keys = frozenset(found.keys)
        for _ in range(_ROUNDS):
            again = weighed(
                found.system, found.suspects, found.fitted.x, found.noise, near=found.fitted, caps=self.caps
            )
            gained = again.evidence - found.evidence
            if gained > 0.0:
                self.found[keys] = found = again
            if gained < _WORTH:
                break
        return found

    def exchanged(self) -> Hypothesis:
        """Return the likeliest set once those were fitted that lack one effect, or have one or two others instead.

        Sets that come out about as likely are left in the same way: two exchanged effects are one step each.
        """
        for done in range(_EXCHANGES):
            best = max(self.found.values(), key=self.score)
            least = self.score(best) - _NEAR
            near = [
                h
                for keys, h in self.found.items()
                if keys and self.score(h) > least and keys not in self.seen and not self.idle(h)
            ]
            if not near or (done >= _ROUNDS and frozenset(best.keys) in self.seen):
                break
            current = self.settled(max(near, key=self.score))
            self.seen.add(frozenset(current.keys))
            self.progress(f"others than {', '.join(current.keys)}")
            more = _rarer(len(current.suspects), self.offered) if len(current.suspects) < MOST else None
            others = [
                each
                for each in exchanges(current, self.trials_beside(current), _OTHERS, more)
                if frozenset(suspect.key for suspect in each.suspects) not in self.found
            ]
            quick = sorted((self.glanced(current, each) for each in others), key=lambda each: -each[0])
            worth = self.score(current) - _BEHIND
            tries = [self.begun(current, suspects, x) for score, suspects, x in quick[:_BEST] if score > worth]
            self.weighed(current, tries)
        while True:
            best = self.settled(max(self.found.values(), key=self.score))
            if self.stand_in(best):
                continue
            for suspect in best.suspects:
                self.without(best, suspect)
            fewer = [each for each in self.found.values() if len(each.suspects) < len(best.suspects)]
            leaner = max(fewer, key=self.score, default=best)
            if leaner is best or self.score(best) > self.score(leaner) + _WORTH:
                return best
            self.needless.add(frozenset(best.keys))
            del self.found[frozenset(best.keys)]  # one of its effects is not worth it

    def stand_in(self, best: Hypothesis) -> bool:
        """Weigh sets in which one effect stands for others; tell whether one comes out likelier than the best one.

        Sets with both tell, where these were weighed: beside the new one the old one may as well be nothing, or is held
        at an end of its range, where no variance tells.
        """
        least = self.score(best) - _NEAR
        for keys, both in list(self.found.items()):
            if len(keys) > 1 and self.score(both) > least:
                x, variances = both.fitted.x, np.diag(both.fitted.covariance)
                held = np.abs(both.system.bounded(1.01 * x) - x) < 0.005 * np.abs(x)
                for each in both.suspects:
                    own = both.sizes_of(each)[0]
                    trades = held[own] or x[own] ** 2 < 2.0 * _NEAR * variances[own]
                    if trades and keys - {each.key} not in self.needless:
                        self.without(both, each)
        return max(self.found.values(), key=self.score) is not best

    def without(self, current: Hypothesis, suspect: Suspect, *, anew: bool = False) -> Hypothesis:
        """Return the set without one of its suspects, fitted from where it is; `anew`: even if it was fitted before."""
        keys = frozenset(current.keys) - {suspect.key}
        if anew or keys not in self.found:
            rest = tuple(each for each in current.suspects if each is not suspect)
            places = current.sizes_of(suspect)
            kept = [k for k in range(current.fitted.x.size) if k not in places]
            slots = tuple(slot for slot in current.system.slots if slot not in suspect.slots)
            posed = current.system.with_effects(slots)
            near = self.bare(current)
            self.keep(weighed(posed, rest, current.fitted.x[kept], current.noise, near=near, caps=self.caps))
        return self.found[keys]
