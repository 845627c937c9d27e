"""From recordings to weighed hypotheses: base fit, noise, screening, refits, pairs, what stays unexplained."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.candidate import (
    LOOKALIKES,
    Candidate,
    examined,
    extended,
    is_imitated,
    is_likely,
    leaves_something,
    past_jumps,
    retried,
    strains,
    unstretched,
    with_air,
)
from gap_diagnosis.discrepancy import discrepancy
from gap_diagnosis.fitting import Fitted, fit, fit_past_jumps
from gap_diagnosis.noise import NoiseModel, fit_noise, widened
from gap_diagnosis.pairs import pairs_of, with_parts
from gap_diagnosis.problem import Problem
from gap_diagnosis.screening import Screened, Trials, rated, tried
from gap_diagnosis.suspects import Suspect
from gap_diagnosis.ventilation import stretches_of

__all__ = ["Investigation", "investigate"]

Array = NDArray[np.float64]
Progress = Callable[[str], None]
_SINGLES = 7
_EVIDENT = 4.0
"""Evidence for an effect from which on a second one is looked for."""
_HIDDEN = 4.0
"""First rating that a second effect must have where nothing else asks for it."""
_AIR_BESIDE = 20.0
"""Evidence that a pair with air must be worth more than one effect alone: gates patch whatever another effect leaves.
"""
_WORTH_AIR = 0.3
_HOPELESS = 150.0  # units of evidence behind the best from which on a hypothesis is not refitted when the noise changes
_EXACT = 1e-4  # share of a signal by which integrators and conventions of simulators disagree
_TURNS = 3
_SAME_NOISE = 0.04


@dataclass(frozen=True, kw_only=True)
class Investigation:
    """All hypotheses that were weighed, the one without effect first, and the noise they share.

    Attributes:
        none: re-tuned parameters alone.
        candidates: single effects and pairs that were refitted, most evidence first.
        screened: every suspect's first rating.
        noise: frozen for all hypotheses.
        stated: cost of the parameters as stated under that noise, and its evidence above `none`.
        stretches: thrust lost in stretches that are not air, as a hypothesis; None where there are none.
    """

    none: Candidate
    candidates: tuple[Candidate, ...]
    screened: tuple[Screened, ...]
    noise: NoiseModel
    stated: tuple[float, float]
    stretches: Candidate | None = None

    @property
    def leading(self) -> Candidate | None:
        """The candidate with most evidence; None where none has more than no effect."""
        return self.candidates[0] if self.candidates and self.candidates[0].evidence > 0.0 else None

    @cached_property
    def inexact(self) -> float:
        """What a simulator's own inexactness may look like, in units of evidence: much where sensors are very good."""
        problem = self.none.fitted.problem
        readings = problem.whitened(problem.sample_noise, problem.measured)
        return float(0.5 * _EXACT**2 * np.nansum(readings**2))

    @cached_property
    def beyond_sensors(self) -> float:
        """How many times larger the noise is than the samples' own, as the mean over the signals; at least 1.

        What had to be called noise though no sensor makes it has a shape that nobody knows, and the evidence of every
        hypothesis beside it is overrated.
        """
        return _beyond_sensors(self.none.fitted.problem, self.noise)


def investigate(
    problem: Problem,
    suspects: Sequence[Suspect],
    *,
    with_ventilation: bool = True,
    progress: Progress = lambda _: None,
) -> Investigation:
    """Return the weighed hypotheses for a problem without effects."""
    noise = problem.sample_noise
    progress("base fit")
    base = fit(problem, noise, problem.start(), iterations=12)
    progress(f"{len(suspects)} suspects")
    trials = tried(base, noise, suspects)
    hasty: dict[str, Array] = {}
    for _ in range(_TURNS):
        base = fit(problem, noise, base.x, near=base)
        screened = rated(base, noise, trials)
        best = _first_best(base, noise, screened, hasty, with_ventilation)
        renewed = _renewed_noise(best, noise, screened[:25])
        if _settled(noise, renewed):
            break
        noise = renewed
    progress("refits of the most likely")
    none = _none(problem, noise, base.x)
    screened = rated(none.fitted, noise, trials)
    singles = _singles(none, screened, _from_stated(none, trials), hasty)
    aired = _aired(none, singles)
    stretches = aired if aired is not None and (aired.nameless or not with_ventilation) else None
    ranked = examined([*singles, aired] if aired is not None and stretches is None else singles, noise)
    leading = _best(none, ranked)
    if leading.suspects and leaves_something(leading):
        again = retried(leading)
        if again is not leading:
            ranked = examined([again, *ranked[1:]], noise)
            leading = _best(none, ranked)
    asked = bool(leading.suspects) and (leaves_something(leading) or strains(leading))
    if asked or (leading.evidence > _EVIDENT and not _has_air(leading)):
        progress("pairs")
        pairs = pairs_of(none, ranked, suspects, 0.0 if asked else _HIDDEN)
        if asked and with_ventilation and not _has_air(leading):
            pairs += _air_beside(leading)
        worth = leading.evidence + _AIR_BESIDE * _beyond_sensors(problem, none.noise)
        pairs = [pair for pair in pairs if not _has_air(pair) or pair.evidence > worth]
        ranked = with_parts(examined([*ranked, *pairs], none.noise), none)
    for _ in range(_TURNS if _best(none, ranked).suspects else 0):
        renewed = _renewed_noise(ranked[0].fitted, none.noise, screened[:25])
        if _settled(none.noise, renewed):
            break
        progress("noise of what is left")
        again, ranked = _again(none, ranked, renewed)
        stretches = _weighed(stretches, none, again) if stretches is not None else None
        none = again
    return Investigation(
        none=none,
        candidates=tuple(ranked),
        screened=tuple(screened),
        noise=none.noise,
        stated=_as_stated(problem, none.noise, none.fitted),
        stretches=stretches,
    )


def _none(problem: Problem, noise: NoiseModel, x: Array) -> Candidate:
    base = fit(problem, noise, x)
    return Candidate(suspects=(), fitted=base, evidence=0.0, noise=noise, unexplained=discrepancy(base, noise))


def _beyond_sensors(problem: Problem, noise: NoiseModel) -> float:
    own = problem.sample_noise.signals
    ratios = [s.marginal / own[n].marginal for n, s in noise.signals.items() if n not in problem.opaque]
    return max(float(np.mean(ratios)), 1.0) if ratios else 1.0


def _best(none: Candidate, ranked: Sequence[Candidate]) -> Candidate:
    return ranked[0] if ranked and ranked[0].evidence > 0.0 else none


def _again(none: Candidate, ranked: Sequence[Candidate], noise: NoiseModel) -> tuple[Candidate, list[Candidate]]:
    """Return all hypotheses weighed anew by the noise that the best of them leaves."""
    base = _none(none.fitted.problem, noise, none.fitted.x)
    within = ranked[0].evidence - _HOPELESS
    return base, examined([_weighed(each, none, base, refit=each.evidence > within) for each in ranked], noise)


def _weighed(candidate: Candidate, none: Candidate, again: Candidate, *, refit: bool = True) -> Candidate:
    """Return a hypothesis weighed anew by the noise of `again`, which is `none` under that noise."""
    problem, x, noise = candidate.fitted.problem, candidate.fitted.x, again.noise
    if not refit:
        fitted = fit(problem, noise, x, iterations=0)
    else:
        fitted = fit_past_jumps(problem, noise, x) if problem.jumps else fit(problem, noise, x, near=candidate.fitted)
    evidence = fitted.evidence - again.fitted.evidence + candidate.switches(none)
    return replace(candidate, fitted=fitted, evidence=evidence, noise=noise, unexplained=None)


def _settled(noise: NoiseModel, renewed: NoiseModel) -> bool:
    """Tell whether the noise is what the fit was weighed by, to 4 % in its deviations."""
    return all(
        abs(np.log(renewed.signals[n].innovation / s.innovation)) < _SAME_NOISE
        and abs(np.log(renewed.signals[n].marginal / s.marginal)) < _SAME_NOISE
        for n, s in noise.signals.items()
    )


def _singles(
    none: Candidate,
    screened: Sequence[Screened],
    stated: Mapping[str, Screened],
    hasty: Mapping[str, Array],
) -> list[Candidate]:
    """Return the most likely single effects, refitted."""
    singles = []
    for each in _promising(screened, imitated=is_imitated(none)):
        likely = is_likely(each, screened) and each.suspect.key not in hasty
        found = extended(none, each, likely, hasty.get(each.suspect.key))
        singles.append(unstretched(found, stated.get(each.suspect.key), none, likely))
    return singles


def _aired(none: Candidate, singles: Sequence[Candidate]) -> Candidate | None:
    """Return the hypothesis of air alone, or of what looks like it; None where no thrust is lost in stretches."""
    best = max(singles, key=lambda c: c.evidence, default=none)
    found = with_air(none, _WORTH_AIR * max(best.evidence, 0.0))
    if found is None and best.suspects and best.suspects[0].effect == "cavitation":
        # Both take thrust at high speed: without it the nuisances may have hidden the air.
        found = with_air(none, near=best)
    return found


def _promising(screened: Sequence[Screened], *, imitated: bool) -> list[Screened]:
    best = screened[0].criterion if screened else 0.0
    kept = [s for s in screened[:_SINGLES] if s.criterion > -3.0]
    lookalikes = [s for s in screened[_SINGLES : 2 * _SINGLES] if s.criterion > max(best - LOOKALIKES, 0.0)]
    return [*kept, *lookalikes, *(s for s in screened[2 * _SINGLES :] if imitated and s.is_imitable)]


def _from_stated(none: Candidate, trials: Sequence[Trials]) -> dict[str, Screened]:
    """Return the best trials of suspects beside nuisances as stated, by key; empty where those were not tried."""
    first = trials[0].anchor if trials else None
    others = [each for each in trials if each.anchor is not first]
    return {each.suspect.key: each for each in rated(none.fitted, none.noise, others)}


def _has_air(candidate: Candidate) -> bool:
    return any(suspect.effect == "ventilation" for suspect in candidate.suspects)


def _air_beside(leading: Candidate) -> list[Candidate]:
    """Return the leading hypothesis with air beside it, in a list; none where no thrust is lost at random."""
    beside = with_air(leading)
    return [] if beside is None or beside.nameless else [beside]


def _first_best(
    base: Fitted, noise: NoiseModel, screened: Sequence[Screened], hasty: dict[str, Array], with_ventilation: bool
) -> Fitted:
    """Return the best of a few hypotheses, fitted in haste: to see what noise is left.

    `hasty`: unknowns of such fits by suspect; they begin where those ended, and are kept there.
    """
    best = base
    worth = 0.15 * screened[0].gain if screened else 0.0
    aired = stretches_of(base, noise, worth) if with_ventilation else None
    if aired is not None and not aired.foreseeable and aired.evidence > best.evidence:
        best = aired.fitted
    for each in screened[:3]:
        start = hasty.get(each.suspect.key, np.concatenate((each.anchor.x, each.sizes)))
        fitted = fit(each.problem, noise, start, near=each.anchor, iterations=10)
        if is_likely(each, screened) and each.suspect.key not in hasty:
            fitted = past_jumps(fitted, noise, each)
        hasty[each.suspect.key] = fitted.x
        best = fitted if fitted.evidence > best.evidence else best
    return best


def _renewed_noise(best: Fitted, noise: NoiseModel, screened: Sequence[Screened]) -> NoiseModel:
    """Return the noise of what is left once everything that could be explained, by any effect, has been."""
    residuals = best.residuals
    signatures = [s.signature for s in screened if not set(s.problem.slots) & set(best.problem.slots)]
    unexplained = discrepancy(best, noise, most=12, more=signatures)
    left = best.problem.scaled(residuals - unexplained.explained)
    used = (len(best.x) + len(unexplained.features)) / max(int(np.sum(best.problem.known)), 1)
    series = best.problem.series
    return widened(fit_noise(series, left, min(used, 0.5), best.problem.opaque), series, best.problem.times, left)


def _as_stated(problem: Problem, noise: NoiseModel, base: Fitted) -> tuple[float, float]:
    """Return cost and evidence (above the re-tuned fit) of the parameters as stated; situations stay re-tuned."""
    x = base.x.copy()
    x[: len(problem.names)] = 0.0
    white = problem.whitened(noise, problem.residuals(x))
    cost = float(white @ white + x @ x)
    situations = base.jacobian[:, len(problem.names) : problem.nuisances]
    information = situations.T @ situations + np.eye(situations.shape[1])
    evidence = -0.5 * cost - 0.5 * float(np.linalg.slogdet(information)[1])
    return cost, evidence - base.evidence
