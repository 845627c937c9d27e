"""Hypotheses, fitted: one more suspect, better starts, air, and whether something is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from gap_diagnosis.converter_steps import likely_speed_steps
from gap_diagnosis.discrepancy import Discrepancy, discrepancy
from gap_diagnosis.fitting import Fitted, fit, fit_from_afar, fit_past_jumps, outlying
from gap_diagnosis.noise import NoiseModel
from gap_diagnosis.prediction import JUMPING
from gap_diagnosis.problem import CONVENTION
from gap_diagnosis.screening import STRETCHED, Screened, refined
from gap_diagnosis.suspects import JAGGED, ROUNDED, SEARCHED, Suspect
from gap_diagnosis.ventilation import stretches_of

__all__ = [
    "LOOKALIKES",
    "Candidate",
    "examined",
    "extended",
    "is_imitated",
    "is_likely",
    "leaves_something",
    "past_jumps",
    "retried",
    "strains",
    "unstretched",
    "with_air",
]

Array = NDArray[np.float64]
LOOKALIKES = 12.0
"""Units of evidence (logarithm) behind the best within which hypotheses count as its look-alikes."""
_EXAMINED = 4
_TURNS = 3
_IN_VAIN, _BETTER = 3, 0.95
"""Starts past jumps in a row that end no better, by that factor, after which no more are tried."""
_STRAINED = 1e-3
_PRESSED = 5.0
_CONVENTIONAL = 3.0 * CONVENTION  # [s]


@dataclass(frozen=True, kw_only=True, eq=False)
class Candidate:
    """One hypothesis, fitted: the suspects in it (none: re-tuned parameters alone) and what they leave unexplained.

    `evidence`: logarithm of the probability of the data, above that of the hypothesis without effect; `nameless`:
    thrust is lost as air would take it, but in stretches that the states foresee.
    """

    suspects: tuple[Suspect, ...]
    fitted: Fitted
    evidence: float
    noise: NoiseModel
    unexplained: Discrepancy | None = None
    nameless: bool = False

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the suspects."""
        return tuple(suspect.key for suspect in self.suspects)

    @cached_property
    def named(self) -> tuple[str, ...]:
        """Names of the suspects that are more than conventions leave open: a lag of a fraction of a step is not."""
        return tuple(suspect.key for suspect in self.suspects if not self.is_shorter(suspect, _CONVENTIONAL))

    def is_shorter(self, suspect: Suspect, time: float) -> bool:
        """Tell whether the size of a suspect is a time, and shorter than this one [s]."""
        slot = suspect.slots[0]
        size = self.fitted.problem.sizes(self.fitted.x)[slot.effect][slot.parameter]
        return slot.unit == "s" and abs(size) < time

    def switches(self, none: "Candidate") -> float:
        """Return what the changes of its gates, if any, add to its evidence; `none`: without effects, same noise."""
        return self.evidence - (self.fitted.evidence - none.fitted.evidence)

    @cached_property
    def pressed(self) -> tuple[str, ...]:
        """Effects of which the data want more than is plausible: five deviations beyond the end of a size's range."""
        fitted = self.fitted
        problem, pull = fitted.problem, fitted.pull
        found = []
        for k, slot in enumerate(problem.slots, start=problem.nuisances):
            end = slot.upper if pull[k] > 0.0 else slot.lower
            at_end = abs(fitted.x[k] * slot.width - end) < 1e-6 * slot.width
            if at_end and end != 0.0 and slot.lower < slot.upper and slot.effect != SEARCHED:
                gain = pull[k] ** 2 * fitted.covariance[k, k]  # the others re-tuned beside it
                found += [slot.effect] if gain > _PRESSED**2 else []
        return tuple(dict.fromkeys(found))


def extended(on: Candidate, screened: Screened, likely: bool, start: Array | None = None) -> Candidate:
    """Return a hypothesis with one more suspect, refitted; only a likely one is worth starts past its jumps.

    `start`: unknowns at which an earlier fit of it ended.
    """
    if start is None or screened.suspect.effect in JAGGED:
        start = np.concatenate((screened.anchor.x, refined(screened, on.noise).sizes))
    fitted = fit(screened.problem, on.noise, start, iterations=25, near=screened.anchor)
    if likely:
        fitted = past_jumps(fitted, on.noise, screened)
    if on.suspects and fitted.cost > on.fitted.cost + 1.0:
        fitted = _from_nothing(fitted, on)
    if screened.suspect.effect == ROUNDED:
        fitted = _rounded_anew(fitted, on.noise)
    return replace(
        on,
        suspects=(*on.suspects, screened.suspect),
        fitted=fitted,
        evidence=on.evidence + fitted.evidence - on.fitted.evidence,
        unexplained=None,
    )


def _from_nothing(fitted: Fitted, on: Candidate) -> Fitted:
    """Return the fit of one more effect than `on` has from where that is, the effect at zero, if it ends lower.

    One more unknown cannot do worse: the size that a rating to first order proposes has led across jumps of the others.
    """
    problem, size = fitted.problem, on.fitted.x.size
    slot = problem.slots[size - problem.nuisances]
    if slot.effect == SEARCHED or not slot.lower <= 0.0 < slot.upper:
        return fitted
    start = np.concatenate((on.fitted.x, [0.0], fitted.x[size + 1 :]))
    again = fit_from_afar(problem, on.noise, start)
    return again if again.cost < fitted.cost else fitted


def _rounded_anew(fitted: Fitted, noise: NoiseModel) -> Fitted:
    """Return the fit from the step of a coarse tachometer that is likely once the nuisances are fitted beside one."""
    problem = fitted.problem
    bare = problem.with_effects(problem.slots[:-1])
    slot = problem.slots[-1]
    for _ in range(_TURNS):
        beside = fit(bare, noise, fitted.x[:-1], iterations=0)
        steps = likely_speed_steps(beside, noise, slot.upper, 1)
        if not steps.size:
            break
        again = fit(problem, noise, np.concatenate((fitted.x[:-1], steps / slot.width)), near=fitted)
        if again.cost >= fitted.cost - 1.0:
            break
        fitted = again
    return fitted


def past_jumps(fitted: Fitted, noise: NoiseModel, screened: Screened) -> Fitted:
    """Return a better fit from the parameters as stated, where samples at jumps may hold this one back."""
    suspect, problem = screened.suspect, screened.problem
    if suspect.effect not in JUMPING:
        return fitted
    stated = np.concatenate((np.zeros(problem.nuisances), screened.anchor.x[problem.nuisances :]))
    middle = np.median(suspect.grid[:, 0])
    in_vain = 0
    for sizes in sorted(suspect.grid, key=lambda s: float(abs(s[0] - middle))):
        if in_vain == _IN_VAIN or not np.any(outlying(problem, fitted.residuals)):
            break
        again = fit_past_jumps(problem, noise, np.concatenate((stated, sizes)))
        in_vain = 0 if again.cost < _BETTER * fitted.cost else in_vain + 1
        fitted = again if again.cost < fitted.cost else fitted
    return fitted


def is_likely(screened: Screened, among: Sequence[Screened]) -> bool:
    """Tell whether a suspect's first rating is at least half that of the most promising one."""
    return screened.criterion > 0.5 * among[0].criterion


def unstretched(candidate: Candidate, stated: Screened | None, none: Candidate, likely: bool) -> Candidate:
    """Return a hypothesis fitted from the nuisances as stated too, where its fit holds them pulled far off.

    What the effect does may have been left to them by the fit without it: a valley of its own.
    """
    nuisances = candidate.fitted.x[: candidate.fitted.problem.nuisances]
    if stated is None or np.max(np.abs(nuisances), initial=0.0) < STRETCHED:
        return candidate
    again = extended(none, stated, likely)
    return again if again.fitted.cost < candidate.fitted.cost - 1.0 else candidate


def retried(candidate: Candidate) -> Candidate:
    """Return a hypothesis fitted from other starts too, if one ends lower: some effects have several valleys."""
    problem, best = candidate.fitted.problem, candidate.fitted
    sizes = best.x[problem.nuisances :]
    for factor in (0.8, 0.93, 1.07, 1.25):
        start = np.concatenate((np.zeros(problem.nuisances), factor * sizes))
        fitted = fit(problem, candidate.noise, start, iterations=25)
        best = fitted if fitted.cost < best.cost - 1.0 else best
    if best is candidate.fitted:
        return candidate
    evidence = candidate.evidence + best.evidence - candidate.fitted.evidence
    return replace(candidate, fitted=best, evidence=evidence, unexplained=None)


def with_air(on: Candidate, least: float = 0.0, near: Candidate | None = None) -> Candidate | None:
    """Return a hypothesis with air beside, refitted; None where no gates are found worth `least`.

    `near`: a hypothesis whose nuisances are started from.
    """
    start = None if near is None else near.fitted.x[: on.fitted.x.size]
    found = stretches_of(on.fitted, on.noise, least, start)
    if found is None:
        return None
    slots = found.fitted.problem.slots[-2:]
    suspect = Suspect(effect="ventilation", channel="", slots=slots, grid=np.empty((0, 2)))
    return Candidate(
        suspects=(*on.suspects, suspect),
        fitted=found.fitted,
        evidence=float(on.evidence + found.evidence - on.fitted.evidence),
        noise=on.noise,
        nameless=found.foreseeable,
    )


def examined(candidates: Sequence[Candidate], noise: NoiseModel) -> list[Candidate]:
    """Return candidates, most evidence first; what the leading ones leave unexplained is looked for."""
    ranked = sorted(candidates, key=lambda c: -c.evidence)
    for place, each in enumerate(ranked[:_EXAMINED]):
        if each.evidence > ranked[0].evidence - LOOKALIKES and each.unexplained is None:
            ranked[place] = replace(each, unexplained=discrepancy(each.fitted, noise))
    return ranked


def leaves_something(candidate: Candidate) -> bool:
    """Tell whether residuals still depend on states or inputs."""
    return candidate.unexplained is not None and candidate.unexplained.evidence > 1.0


def strains(candidate: Candidate) -> bool:
    """Tell whether parameters had to leave their deviations farther than chance does: a second effect may pull."""
    count = len(candidate.fitted.problem.names)
    moved = candidate.fitted.x[:count]
    return float(moved @ moved) > chi2.isf(_STRAINED, count)


def is_imitated(candidate: Candidate) -> bool:
    """Tell whether parameters explain everything, but only far from what is stated.

    Then an effect that they imitate is at work. What it does instead of them is too much for a rating to first order:
    all such suspects are worth a fit.
    """
    return strains(candidate) and not leaves_something(candidate)
