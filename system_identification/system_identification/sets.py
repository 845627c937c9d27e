"""Sets of effects that were weighed, each fitted beside all that moves at random, and how likely they are.

Sets are as likely before the data as effects are rare: each further one is `MORE` times as likely as one less, all of a
size alike.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted, fit, fit_past_jumps, sharpened
from system_identification.hypothesis import Hypothesis, weighed
from system_identification.learning import Caps
from system_identification.noise import Whitener, whitener
from system_identification.suspects import Suspect
from system_identification.system import System

__all__ = ["FAR", "NEAR", "ROUNDS", "WORTH", "Begun", "Sets", "posed", "rarer", "score_of"]

Array = NDArray[np.float64]
Begun = tuple[float, tuple[Suspect, ...], Fitted]
"""Evidence of a set under the noise of one near it, its suspects, and its fit from a start."""
MORE = 0.6
"""How much rarer a set with one effect more is, before the data."""
NEAR = 15.0
"""Evidence by which a set may be behind for its own exchanges to be looked at."""
WORTH = 1.0
"""Evidence, prior included, that one more effect must add."""
ROUNDS = 3
"""Rounds of settling."""
FAR = 3.5
"""Deviations of nuisances from which on they may have been pulled off by an effect that is missing."""
_STEPS, _TURNS = 6, 4
"""Steps of a fit from a start, and how often as many more are taken where these still gain `NEAR`."""
_WEIGHED = 3
"""Of sets that were begun, those for which the noise is learned anew."""


def rarer(count: int, offered: int) -> float:
    """Return how much rarer, nats, a set with one effect more than so many is, of those of its size."""
    return -float(np.log(MORE * (count + 1) / max(offered - count, 1)))


def score_of(found: Hypothesis, offered: int) -> float:
    """Return the logarithm of a set's probability, up to what all share: its evidence, and how rare it is among all."""
    return found.evidence - sum(rarer(k, offered) for k in range(len(found.suspects)))


def posed(system: Any, suspects: Sequence[Suspect]) -> Any:
    """Return a system with the sizes of suspects as unknowns."""
    gates = next((tuple(each.gates) for each in suspects if each.gates), ())
    return system.with_effects(tuple(slot for each in suspects for slot in each.slots), gates)


def _descended(system: System, noise: Whitener, start: Array, near: Fitted) -> Fitted:
    """Return a fit from a start once it no longer gains much: one that is broken off while it does tells nothing."""
    fitted = fit(system, noise, start, iterations=_STEPS, near=near, polish=False)
    for _ in range(_TURNS):
        before, fitted = fitted, fit(system, noise, fitted.x, iterations=_STEPS, near=fitted, polish=False)
        if fitted.evidence < before.evidence + NEAR:
            break
    return fitted


class Sets:
    """All sets of a system that were weighed so far; the first is the empty one.

    Attributes:
        found: by the keys of their suspects.
        offered: how many suspects there are.
    """

    def __init__(self, system: System, caps: Caps) -> None:
        """Weigh the empty set."""
        self.caps, self.offered = caps, 1
        self.found: dict[frozenset[str], Hypothesis] = {}
        self._settled: dict[frozenset[str], Hypothesis] = {}
        plain = whitener(system, np.zeros(system.nuisances))
        self.stated = fit(system, plain, np.zeros(system.nuisances), iterations=0)
        base = fit(system, plain, self.stated.x, iterations=12, near=self.stated)
        self.keep(weighed(system, (), base.x, whitener(system, base.x), near=base, caps=caps, steps=8))

    def score(self, found: Hypothesis) -> float:
        """Return the logarithm of a set's probability, up to what all share."""
        return score_of(found, self.offered)

    @property
    def best(self) -> Hypothesis:
        """The likeliest one."""
        return max(self.found.values(), key=self.score)

    def keep(self, found: Hypothesis) -> Hypothesis:
        """Keep a set, unless it was fitted better before; return the better one."""
        keys = frozenset(found.keys)
        if keys not in self.found or found.evidence > self.found[keys].evidence:
            self.found[keys] = found
        return self.found[keys]

    def settled(self, found: Hypothesis) -> Hypothesis:
        """Return a set fitted and its noise learned again and again until neither adds evidence.

        A size was searched where others had not yet settled: beside them it is searched again.
        """
        keys = frozenset(found.keys)
        if self._settled.get(keys) is found:
            return found
        sharp = {int(found.sizes_of(each)[0]): each.spacing for each in found.suspects if each.spacing > 0.0}
        for _ in range(ROUNDS):
            start = sharpened(found.fitted, found.noise, sharp)
            again = weighed(found.system, found.suspects, start, found.noise, near=found.fitted, caps=self.caps)
            gained = again.evidence - found.evidence
            if gained > 0.0:
                self.found[keys] = found = again
            if gained < WORTH:
                break
        self._settled[keys] = found
        return found

    def begun(self, current: Hypothesis, suspects: tuple[Suspect, ...], start: Array) -> Begun:
        """Return the evidence of a set under the noise of a set near it, its suspects, and its fit from a start."""
        system = posed(current.system, suspects)
        nuisances = current.system.nuisances
        if system.jumps and not current.system.jumps:
            fitted = fit_past_jumps(system, current.noise, start)
        else:
            fitted = _descended(system, current.noise, start, self.bare(current))
        if np.max(np.abs(start[:nuisances])) > FAR:
            # What the effect does may have been left to them: a valley of its own begins where they are as stated.
            there = np.concatenate((self.stated.x, start[nuisances:]))
            again = _descended(system, current.noise.scattering(1.0), there, self.stated)
            fitted = again if again.evidence > fitted.evidence else fitted
        return fitted.evidence - sum(each.price for each in suspects), suspects, fitted

    def learn(self, current: Hypothesis, begun: Sequence[Begun]) -> None:
        """Learn the noise beside the likeliest of these sets, and keep them."""
        for _, suspects, fitted in sorted(begun, key=lambda one: -one[0])[:_WEIGHED]:
            self.keep(
                weighed(
                    fitted.problem, suspects, fitted.x, current.noise, iterations=4, near=fitted, caps=self.caps,
                    polish=False,
                )
            )  # fmt: skip

    def without(self, current: Hypothesis, suspect: Suspect, *, anew: bool = False) -> Hypothesis:
        """Return the set without one of its suspects, fitted from where it is; `anew`: even if it was fitted before."""
        keys = frozenset(current.keys) - {suspect.key}
        if anew or keys not in self.found:
            rest = tuple(each for each in current.suspects if each is not suspect)
            places = current.sizes_of(suspect)
            kept = [k for k in range(current.fitted.x.size) if k not in places]
            slots = tuple(slot for slot in current.system.slots if slot not in suspect.slots)
            system = current.system.with_effects(slots)
            near = self.bare(current)
            self.keep(weighed(system, rest, current.fitted.x[kept], current.noise, near=near, caps=self.caps))
        return self.found[keys]

    def bare(self, current: Hypothesis) -> Fitted:
        """Return a fitted set as if it had no effects: for its sensitivities to the nuisances."""
        count, fitted = current.system.nuisances, current.fitted
        return replace(
            fitted, x=fitted.x[:count], sensitivities=fitted.sensitivities[:, :count], anchor=fitted.anchor[:count]
        )

    def idle(self, found: Hypothesis) -> bool:
        """Tell whether a set is no likelier than another without some of its effects."""
        keys = frozenset(found.keys)
        return any(less < keys and self.score(h) >= self.score(found) for less, h in self.found.items())
