"""From a problem to weighed sets of effects: the search, their probabilities, and what the best one leaves."""

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp, softmax

from gap_diagnosis.bursts import bursts_of
from gap_diagnosis.discrepancy import Discrepancy, Feature, discrepancy
from gap_diagnosis.offers import offers_of
from gap_diagnosis.problem import Problem
from gap_diagnosis.rules import RULES
from gap_diagnosis.uneven_push import evidence_for_uneven_push
from system_identification.earning import Earned, earned
from system_identification.fitting import Fitted, fit
from system_identification.hypothesis import Hypothesis
from system_identification.learning import Caps, learned
from system_identification.left_out import (
    FEWEST_RUNS,
    LeftOut,
    fit_to_free_runs,
    folds_of,
    foreseen,
    foretold,
    helps_by,
    left_out,
)
from system_identification.levels import plain_levels
from system_identification.loose import groups_of, learned_levels, unsteady
from system_identification.noise import Whitener, whitener
from system_identification.rating import Rated
from system_identification.search import Search, searched, thinned
from system_identification.suspects import Suspect
from system_identification.traces import traces_of

__all__ = ["InVain", "Investigation", "imitated_by_parameters", "investigate", "weighed_up"]

_OTHERS = 5
"""Sets beside the best one that widen the intervals of its shares."""
_SEVERAL = 2
"""Effects beside which it is asked whether a further one explains anything: it takes a sixth of a step."""

_UNSTEADY = "changes its size with run, time or state"

Array = NDArray[np.float64]


class Left(NamedTuple):
    """A set, fitted under the noise of a healthy thruster, and what differs from run to run beside it, (R,)."""

    fitted: Fitted
    noise: Whitener
    loose: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Investigation:
    """All sets that were weighed.

    Attributes:
        search: the sets.
        left: what the best one leaves, and `unexplained`: which functions of states and inputs that is.
        left_by_none: what re-tuning alone leaves, under the same noise.
        gained: evidence, nats, by which the best set exceeds the one without each of its effects.
        ahead: by effect of the best set, how much better it explains, in nats, what is left without it than functions
            of states and inputs, which have no name.
        offer: which effects are tried beside a set.
    """

    search: Search
    left: Left
    left_by_none: Left
    unexplained: Discrepancy
    gained: dict[str, float]
    ahead: dict[str, float]
    offer: Callable[[Hypothesis], list[Suspect]]
    _held: dict[tuple[str, ...], LeftOut] = field(default_factory=dict, repr=False)

    def held_out(self, found: Hypothesis) -> LeftOut:
        """Return predictions (R,) of every row by fits of a set that have not seen it, and their unknowns (F, K).

        All sets have parameters that scatter as the best one's do: what they could do beyond is no rival of an effect.
        """
        if found.keys not in self._held:
            noise = found.noise.scattering_as(self.best.noise.levels)
            self._held[found.keys] = left_out(*fit_to_free_runs(found.fitted, noise))
        return self._held[found.keys]

    @cached_property
    def free(self) -> tuple[Fitted, Whitener]:
        """Re-tuned parameters as they predict free runs best, and the noise by which these count."""
        return fit_to_free_runs(self.none.fitted, self.none.noise)

    @cached_property
    def earned(self) -> list[Earned]:
        """Re-tuned parameters and what earns its place beside them on runs left out; nothing where free runs are good.

        Free runs are good where they are off by no more than what pushes a healthy thruster.
        """
        off = max(
            self.free[1].level(signal) / self.left.noise.level(signal) for signal in self.none.system.signal_names
        )
        few = np.unique(folds_of(self.none.system)).size < FEWEST_RUNS
        if few or off < RULES.off:
            return []
        return earned(self.none, lambda found: [thinned(each, self.search.sizes) for each in self.offer(found)])

    @cached_property
    def as_stated(self) -> Array:
        """Predictions with the parameters as they are stated, and the situations of the runs as fitted, (R,)."""
        stated = self.none.fitted.x.copy()
        stated[: len(self.none.system.names)] = 0.0
        return np.asarray(self.none.system.predicted(stated))

    @cached_property
    def retuning_helps(self) -> float:
        """Probability that re-tuned parameters make a new run more probable than those as stated."""
        retuned = foreseen(self.noise, self.held_out(self.none).predicted)
        return helps_by(retuned - foreseen(self.noise, self.as_stated))

    @cached_property
    def helps(self) -> dict[str, float]:
        """Probability that each effect of the best set makes a new run more probable, beside the others."""
        whole = foretold(self.best)
        less = {key: self.search.weighed[frozenset(self.best.keys) - {key}] for key in self.best.keys}
        return {key: helps_by(whole - foretold(each)) for key, each in less.items()}

    @property
    def none(self) -> Hypothesis:
        """Re-tuned parameters alone."""
        return self.search.none

    @property
    def best(self) -> Hypothesis:
        """The set with most evidence."""
        return self.search.best

    @property
    def noise(self) -> Whitener:
        """Learned from what the best set leaves."""
        return self.best.noise

    @property
    def screened(self) -> list[Rated]:
        """The first look at all suspects."""
        return self.search.rated

    @cached_property
    def ranked(self) -> list[Hypothesis]:
        """All sets, the most probable first."""
        return sorted(self.search.weighed.values(), key=lambda each: -self.search.score(each))

    @cached_property
    def probabilities(self) -> dict[tuple[str, ...], float]:
        """Of all sets, by their keys; they sum to one."""
        scores = np.array([self.search.score(each) for each in self.ranked]) / RULES.tempered
        weights = softmax(scores)
        return {each.keys: float(p) for each, p in zip(self.ranked, weights, strict=True)}

    @property
    def likely_sets(self) -> list[tuple[Hypothesis, float]]:
        """The best set and others about as likely, with their probabilities."""
        others = [each for each in self.ranked if each.keys != self.best.keys][:_OTHERS]
        return [(each, self.probabilities[each.keys]) for each in (self.best, *others)]

    @cached_property
    def inclusion(self) -> dict[str, float]:
        """Probability of each suspect to be at work, by key; those that were only rated have what that says."""
        found: dict[str, float] = {}
        for keys, probability in self.probabilities.items():
            for key in keys:
                found[key] = min(found.get(key, 0.0) + probability, 1.0)
        return found

    @property
    def p_none(self) -> float:
        """Probability that no effect is at work."""
        return self.probabilities.get((), 0.0)

    @property
    def evident(self) -> float:
        """Evidence, prior included, by which all sets together exceed none."""
        scores = [self.search.score(each) for each in self.ranked if each.suspects]
        return float(logsumexp(scores) - self.search.score(self.none)) if scores else -np.inf

    @property
    def named_share(self) -> float:
        """Which share of what re-tuning leaves the best set explains, of what is not noise or disturbance.

        Squares count as the filter leaves them: of readings as they are, most may be what pushes do.
        """
        taken = max(self.left_by_none.fitted.cost - self.left.fitted.cost, 0.0)
        return taken / (taken + sum(each.gain for each in self.unexplained.features)) if taken > 0.0 else 0.0

    @cached_property
    def distances(self) -> dict[str, float]:
        """Squared Fisher distance of each effect of the best set from none, all else re-tuned.

        Where readings are rounded, the likelihood is jagged: an effect of next to no size may come out ahead by chance.
        """
        fitted = self.best.fitted
        found = {}
        for suspect in self.best.suspects:
            if not suspect.scalable:  # no slope tells how far none is
                found[suspect.key] = np.inf
                continue
            own = self.best.sizes_of(suspect).astype(np.int64)
            # As far as readings are not rounded: the slopes are those of what is.
            trace = fitted.jacobian[:, own[0]] * fitted.x[own[0]]
            beside = np.delete(np.arange(fitted.x.size), own)
            prior = np.append(fitted.prior, np.full(beside.size - fitted.prior.size, 1e-9))
            along = fitted.jacobian[:, beside].T @ trace
            information = fitted.jacobian[:, beside].T @ fitted.jacobian[:, beside] + np.diag(prior)
            found[suspect.key] = float(trace @ trace - along @ np.linalg.solve(information, along))
        return found

    @cached_property
    def imitated(self) -> dict[str, tuple[float, float]]:
        """What parameters leave of each effect of the best set when they imitate it, see `imitated_by_parameters`."""
        return {suspect.key: imitated_by_parameters(self.best, suspect) for suspect in self.best.suspects}

    @cached_property
    def unsteady(self) -> dict[str, float]:
        """Evidence, nats, that the size of an effect of the best set is not one size."""
        return _unsteady(self.best)

    @cached_property
    def doubts(self) -> dict[str, list[str]]:
        """Why effects of the best set only resemble what is at work, in words; those that may be claimed are not there.

        What explains less than is left without a name may be a part of that. What resembles something may be how the
        size of another one changes: those are asked again without it.
        """
        found: dict[str, list[str]] = {}
        for key in self.best.keys:
            reasons = {
                _UNSTEADY: self.unsteady[key] > RULES.unsteady,
                "explains no more than functions without a name": self.ahead[key] < 0.0,
                "makes runs that were left out less probable": self.helps[key] < RULES.helps,
                "is too small to be told from none": self.distances[key] < RULES.apart,
                "explains less than is left": self.nameless and self.gained[key] < self.unexplained.evidence,
            }
            if any(reasons.values()):
                found[key] = [reason for reason, holds in reasons.items() if holds]
        if found:
            again = _unsteady(self._beside(found))
            found |= {key: [_UNSTEADY] for key, evidence in again.items() if evidence > RULES.unsteady}
        return found

    def _beside(self, doubted: Container[str]) -> Hypothesis:
        """Return the likeliest set of effects of the best one that are not doubted."""
        sure = {key for key in self.best.keys if key not in doubted}
        return max((h for keys, h in self.search.weighed.items() if keys <= sure), key=self.search.score)

    @cached_property
    def resembling(self) -> dict[str, float]:
        """Which share of the evidence for the best set each effect has that only resembles what is at work."""
        whole = sum(max(gained, 0.0) for gained in self.gained.values())
        return {key: max(self.gained[key], 0.0) / max(whole, 1e-9) for key in self.doubts}

    @property
    def nameless(self) -> bool:
        """Tell whether something is left that nothing explains."""
        return self.unexplained.evidence > RULES.nameless

    @cached_property
    def unnamed(self) -> float:
        """Evidence, nats, for something without a name beside those effects of the best set that are not doubted."""
        if not self.doubts:
            return self.unexplained.evidence
        base = self._beside(self.doubts)
        left = _left(base, _healthy(self.best)) if base.suspects else self.left_by_none
        return _with_push(discrepancy(left.fitted, left.noise), left).evidence


def investigate(
    problem: Problem,
    signals: set[str],
    excluded: Sequence[str] = (),
    *,
    grew: Callable[[Hypothesis], None] = lambda _: None,
    progress: Callable[[str], None] = lambda _: None,
) -> Investigation:
    """Return the weighed sets for a problem without effects; `grew`: see `searched`."""
    offer = offers_of(signals, excluded)
    search = searched(problem, offer, grew=grew, in_vain=InVain(), progress=progress)
    progress("what is left")
    return weighed_up(search, offer)


class InVain:
    """Tells where a further effect explains less than is left without a name, and leaves as much of that as there was.

    A model that is wrong in a way without a name is fitted better by one effect after the other, and none of them is
    at work. What several effects are at work in leaves less with each that is found.
    """

    def __init__(self) -> None:
        self.known: dict[tuple[str, ...], float] = {}

    def __call__(self, before: Hypothesis, found: Hypothesis) -> bool:
        if len(before.suspects) < _SEVERAL:
            return False
        left = self.left(found)
        return left > max(RULES.nameless, found.evidence - before.evidence) and left >= self.left(before)

    def left(self, found: Hypothesis) -> float:
        """Return the evidence for something without a name beside a set."""
        if found.keys not in self.known:
            left = _left(found, _healthy(found))
            self.known[found.keys] = discrepancy(left.fitted, left.noise).evidence
        return self.known[found.keys]


def weighed_up(search: Search, offer: Callable[[Hypothesis], list[Suspect]]) -> Investigation:
    """Return the sets of a search with what the best one leaves."""
    best = search.best
    healthy = _healthy(best)
    left = _left(best, healthy)
    none = left if not best.suspects else _left(search.none, healthy)
    unexplained = discrepancy(left.fitted, left.noise)
    gained, ahead = {}, {}
    for key, trace in traces_of(best.fitted, best.suspects).items():
        keys = frozenset(best.keys) - {key}
        less = none if not keys else _left(search.weighed[keys], healthy)
        gained[key] = left.fitted.evidence - less.fitted.evidence
        ahead[key] = gained[key] + unexplained.evidence - discrepancy(less.fitted, less.noise, trace).evidence
    return Investigation(
        search=search,
        left=left,
        left_by_none=none,
        unexplained=_with_push(unexplained, left),
        gained=gained,
        ahead=ahead,
        offer=offer,
    )


def _with_push(unexplained: Discrepancy, left: Left) -> Discrepancy:
    """Return what is left, with what is odd about a random push where more evidence is for that than for functions."""
    odd = [("speed", "a random push that grows with |n|", evidence_for_uneven_push(*left))]
    odd += [(signal, "a random push that comes in bursts", evidence) for signal, evidence in bursts_of(*left).items()]
    signal, name, evidence = max(odd, key=lambda each: each[2])
    if evidence <= max(unexplained.evidence, RULES.nameless):
        return unexplained
    feature = Feature(signal, name, 2.0 * evidence)
    return unexplained._replace(features=(feature, *unexplained.features), evidence=evidence)


def imitated_by_parameters(found: Hypothesis, suspect: Suspect) -> tuple[float, float]:
    """Return the energy that the set's parameters, free of their deviations, leave of an effect in its place, and that
    of the effect.
    """
    fitted = found.fitted
    problem = fitted.problem
    kept = tuple(slot for slot in problem.slots if slot not in suspect.slots)
    places = [problem.nuisances + i for i, slot in enumerate(problem.slots) if slot in kept]
    x = fitted.x[[*range(problem.nuisances), *places]]
    target = np.where(problem.known, problem.predicted(fitted.x), np.nan)
    wide = {name: 10.0 * deviation for name, deviation in problem.deviations.items()}
    gates = () if suspect.gates else problem.gates
    bare: Problem = replace(problem, slots=kept, deviations=wide, observed=target, gates=gates)
    x = x.copy()
    x[: len(problem.names)] /= 10.0
    noise = replace(found.noise, system=bare)
    white = noise.whiten(bare.residuals(x))
    imitated = fit(bare, noise, x, iterations=5)
    return float(imitated.white @ imitated.white), float(white @ white)


def _unsteady(found: Hypothesis) -> dict[str, float]:
    """Return by effect of a set the evidence, nats, that its size is not one size."""
    return unsteady(found.fitted, found.noise, found.loose, found.suspects)


def _healthy(found: Hypothesis) -> Whitener:
    """Return the noise of a healthy thruster that comes nearest to what a set leaves."""
    caps = Caps(
        sensors=(0.5, RULES.healthy_sensor), colours=RULES.healthy_colour, pushes=RULES.healthy_push,
    )  # fmt: skip
    system, fitted = found.system, found.fitted
    start = whitener(system, fitted.x, plain_levels(system, len(found.noise.levels.pushes), 0.5))
    start = start.tamed(fitted.residuals - found.loose.explained)
    return learned(start, fitted.residuals - found.loose.explained, caps, taken=fitted.x.size)


def _left(found: Hypothesis, healthy: Whitener) -> Left:
    system = found.system
    noise = whitener(system, found.fitted.x, healthy.levels).scattering_as(found.noise.levels)
    noise = noise.tamed(found.fitted.residuals - found.loose.explained)
    groups = groups_of(found.fitted, found.suspects)
    loose, _, noise = learned_levels(found.fitted, noise, groups)
    noise = noise.scattering_as(found.noise.levels)
    fitted = fit(system, noise, found.fitted.x, iterations=3, near=found.fitted)
    return Left(fitted=fitted, noise=noise, loose=loose.explained)
