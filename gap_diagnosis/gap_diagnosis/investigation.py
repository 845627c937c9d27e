"""From recordings to weighed hypotheses: base fit, noise, screening, refits, pairs, what stays unexplained."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from gap_diagnosis.discrepancy import Discrepancy, discrepancy
from gap_diagnosis.fitting import OUTLYING, Fitted, fit, fit_past_jumps
from gap_diagnosis.noise import NoiseModel, fit_noise, white_noise
from gap_diagnosis.prediction import JUMPING
from gap_diagnosis.problem import Problem
from gap_diagnosis.screening import STRETCHED, Screened, Trials, rated, refined, tried
from gap_diagnosis.suspects import Suspect
from gap_diagnosis.ventilation import change_cost, ventilated

__all__ = ["Candidate", "Investigation", "investigate"]

Array = NDArray[np.float64]
Progress = Callable[[str], None]
_SINGLES = 7
_LOOKALIKES = 12.0  # nats behind the best screened one within which suspects are refitted
_PAIRS = 4
_EXAMINED = 4
_AIR_BESIDE = 20.0
_TURNS = 3
_SAME_NOISE = 0.04
_STRAINED = 1e-3


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One hypothesis, fitted: the suspects in it (none: re-tuned parameters alone) and what they leave unexplained.

    `evidence`: logarithm of the probability of the data, above that of the hypothesis without effect.
    """

    suspects: tuple[Suspect, ...]
    fitted: Fitted
    evidence: float
    noise: NoiseModel
    unexplained: Discrepancy | None = None

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the suspects."""
        return tuple(suspect.key for suspect in self.suspects)


@dataclass(frozen=True, kw_only=True)
class Investigation:
    """All hypotheses that were weighed, the one without effect first, and the noise they share.

    Attributes:
        none: re-tuned parameters alone.
        candidates: single effects and pairs that were refitted, most evidence first.
        screened: every suspect's first rating.
        noise: frozen for all hypotheses.
        stated: cost of the parameters as stated under that noise, and its evidence above `none`.
    """

    none: Candidate
    candidates: tuple[Candidate, ...]
    screened: tuple[Screened, ...]
    noise: NoiseModel
    stated: tuple[float, float]


def investigate(
    problem: Problem,
    suspects: Sequence[Suspect],
    *,
    with_ventilation: bool = True,
    progress: Progress = lambda _: None,
) -> Investigation:
    """Return the weighed hypotheses for a problem without effects."""
    noise = white_noise(problem.noise_levels)
    progress("base fit")
    base = fit(problem, noise, problem.start(), iterations=12)
    progress(f"{len(suspects)} suspects")
    trials = tried(base, noise, suspects)
    for _ in range(_TURNS):
        base = fit(problem, noise, base.x, near=base)
        screened = rated(base, noise, trials)
        renewed = _renewed_noise(_first_best(base, noise, screened, with_ventilation), noise, screened[:25])
        if _settled(noise, renewed):
            break
        noise = renewed
    progress("refits of the most likely")
    none = _none(problem, noise, base.x)
    screened = rated(none.fitted, noise, trials)
    ranked = _singles(none, screened, with_ventilation, _from_stated(none, trials))
    leading = _best(none, ranked)
    if leading.suspects and _leaves_something(leading):
        again = _retried(leading)
        if again is not leading:
            ranked = _examined([again, *ranked[1:]], noise)
            leading = _best(none, ranked)
    if leading.suspects and (_leaves_something(leading) or _strains(leading)):
        progress("pairs")
        pairs = _pairs(none, ranked, suspects)
        if with_ventilation and leading.suspects[0].effect != "ventilation":
            # Gates of its own choice patch whatever another effect leaves: they have to be worth more.
            pairs += [c for c in _with_air(leading) if c.evidence > leading.evidence + _AIR_BESIDE]
        ranked = _examined([*ranked, *pairs], none.noise)
    for _ in range(_TURNS if ranked and ranked[0].evidence > 0.0 else 0):
        renewed = _renewed_noise(ranked[0].fitted, none.noise, screened[:25])
        if _settled(none.noise, renewed):
            break
        progress("noise of what is left")
        none, ranked = _again(none, ranked, renewed)
    return Investigation(
        none=none,
        candidates=tuple(ranked),
        screened=tuple(screened),
        noise=none.noise,
        stated=_as_stated(problem, none.noise, none.fitted),
    )


def _none(problem: Problem, noise: NoiseModel, x: Array) -> Candidate:
    base = fit(problem, noise, x)
    return Candidate(suspects=(), fitted=base, evidence=0.0, noise=noise, unexplained=discrepancy(base, noise))


def _best(none: Candidate, ranked: Sequence[Candidate]) -> Candidate:
    return ranked[0] if ranked and ranked[0].evidence > 0.0 else none


def _leaves_something(candidate: Candidate) -> bool:
    return candidate.unexplained is not None and candidate.unexplained.evidence > 1.0


def _strains(candidate: Candidate) -> bool:
    """Tell whether parameters had to leave their deviations farther than chance does: a second effect may pull."""
    count = len(candidate.fitted.problem.names)
    moved = candidate.fitted.x[:count]
    return float(moved @ moved) > chi2.isf(_STRAINED, count)


def _again(none: Candidate, ranked: Sequence[Candidate], noise: NoiseModel) -> tuple[Candidate, list[Candidate]]:
    """Return all hypotheses weighed anew by the noise that the best of them leaves."""
    base = _none(none.fitted.problem, noise, none.fitted.x)
    weighed = []
    for candidate in ranked:
        switches = candidate.evidence - (candidate.fitted.evidence - none.fitted.evidence)  # of gates, if any
        problem, x = candidate.fitted.problem, candidate.fitted.x
        jumps = any(slot.effect in JUMPING for slot in problem.slots)
        fitted = fit_past_jumps(problem, noise, x) if jumps else fit(problem, noise, x, near=candidate.fitted)
        evidence = fitted.evidence - base.fitted.evidence + switches
        weighed.append(replace(candidate, fitted=fitted, evidence=evidence, noise=noise, unexplained=None))
    return base, _examined(weighed, noise)


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
    with_ventilation: bool,
    stated: Mapping[str, Screened],
) -> list[Candidate]:
    """Return the most likely single effects, refitted, most evidence first."""
    singles = [
        _unstretched(_candidate(none, s, _likely(s, screened)), stated.get(s.suspect.key), none)
        for s in _promising(screened, _SINGLES)
    ]
    if with_ventilation:
        singles += _with_air(none, 0.3 * max((c.evidence for c in singles), default=0.0))
    return _examined(singles, none.noise)


def _examined(candidates: Sequence[Candidate], noise: NoiseModel) -> list[Candidate]:
    """Return candidates, most evidence first; what the leading ones leave unexplained is looked for."""
    ranked = sorted(candidates, key=lambda c: -c.evidence)
    within = [c for c in ranked[:_EXAMINED] if c.evidence > ranked[0].evidence - _LOOKALIKES]
    looked = [
        replace(c, unexplained=c.unexplained or discrepancy(c.fitted, noise)) if c in within else c for c in ranked
    ]
    return looked


def _promising(screened: Sequence[Screened], most: int) -> list[Screened]:
    best = screened[0].criterion if screened else 0.0
    kept = [s for s in screened[:most] if s.criterion > -3.0]
    more = [s for s in screened[most : 2 * most] if s.criterion > best - _LOOKALIKES and s.criterion > 0.0]
    return [*kept, *more]


def _candidate(on: Candidate, screened: Screened, likely: bool = True) -> Candidate:
    """Return a hypothesis with one more suspect, refitted; only a likely one is worth starts past its jumps."""
    start = np.concatenate((screened.anchor.x, refined(screened, on.noise).sizes))
    fitted = fit(screened.problem, on.noise, start, iterations=25, near=screened.anchor)
    if likely:
        fitted = _past_jumps(fitted, on.noise, screened)
    return replace(
        on,
        suspects=(*on.suspects, screened.suspect),
        fitted=fitted,
        evidence=on.evidence + fitted.evidence - on.fitted.evidence,
        unexplained=None,
    )


def _past_jumps(fitted: Fitted, noise: NoiseModel, screened: Screened) -> Fitted:
    """Return a better fit from the parameters as stated, where samples at jumps may hold this one back."""
    suspect, problem = screened.suspect, screened.problem
    if suspect.effect not in JUMPING:
        return fitted
    stated = np.concatenate((np.zeros(problem.nuisances), screened.anchor.x[problem.nuisances :]))
    middle = np.median(suspect.grid[:, 0])
    for sizes in sorted(suspect.grid, key=lambda s: float(abs(s[0] - middle))):
        white = problem.whitened(white_noise(problem.noise_levels), fitted.residuals)
        if np.max(np.abs(white)) < OUTLYING:
            break
        again = fit_past_jumps(problem, noise, np.concatenate((stated, sizes)))
        fitted = again if again.cost < fitted.cost else fitted
    return fitted


def _likely(screened: Screened, among: Sequence[Screened]) -> bool:
    return screened.criterion > 0.5 * among[0].criterion


def _from_stated(none: Candidate, trials: Sequence[Trials]) -> dict[str, Screened]:
    """Return the best trials of suspects beside nuisances as stated, by key; empty where those were not tried."""
    first = trials[0].anchor if trials else None
    others = [each for each in trials if each.anchor is not first]
    return {each.suspect.key: each for each in rated(none.fitted, none.noise, others)}


def _unstretched(candidate: Candidate, stated: Screened | None, none: Candidate) -> Candidate:
    """Return a hypothesis fitted from the nuisances as stated too, where its fit holds them pulled far off.

    What the effect does may have been left to them by the fit without it: a valley of its own.
    """
    nuisances = candidate.fitted.x[: candidate.fitted.problem.nuisances]
    if stated is None or np.max(np.abs(nuisances), initial=0.0) < STRETCHED:
        return candidate
    again = _candidate(none, stated)
    return again if again.fitted.cost < candidate.fitted.cost - 1.0 else candidate


def _retried(candidate: Candidate) -> Candidate:
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


def _first_best(base: Fitted, noise: NoiseModel, screened: Sequence[Screened], with_ventilation: bool) -> Fitted:
    """Return the best of a few hypotheses, fitted in haste: to see what noise is left."""
    best = base
    aired = ventilated(base, noise, 0.15 * screened[0].gain) if with_ventilation else None
    if aired is not None and aired[0].evidence + aired[1] * change_cost(base.problem) > best.evidence:
        best = aired[0]
    for each in screened[:3]:
        start = np.concatenate((each.anchor.x, each.sizes))
        fitted = fit(each.problem, noise, start, near=each.anchor, iterations=10)
        if _likely(each, screened):
            fitted = _past_jumps(fitted, noise, each)
        best = fitted if fitted.evidence > best.evidence else best
    return best


def _renewed_noise(best: Fitted, noise: NoiseModel, screened: Sequence[Screened]) -> NoiseModel:
    """Return the noise of what is left once everything that could be explained, by any effect, has been."""
    residuals = best.residuals
    signatures = [s.signature for s in screened if not set(s.problem.slots) & set(best.problem.slots)]
    unexplained = discrepancy(best, noise, most=12, more=signatures)
    left = residuals - unexplained.explained
    used = (len(best.x) + len(unexplained.features)) / max(int(np.sum(best.problem.known)), 1)
    return fit_noise(best.problem.series, left, min(used, 0.5), best.problem.opaque)


def _with_air(on: Candidate, least: float = 0.0) -> list[Candidate]:
    found = ventilated(on.fitted, on.noise, least)
    if found is None:
        return []
    fitted, changes = found
    evidence = on.evidence + fitted.evidence - on.fitted.evidence + changes * change_cost(fitted.problem)
    slots = fitted.problem.slots[-2:]
    suspect = Suspect(effect="ventilation", channel="", slots=slots, grid=np.empty((0, 2)))
    return [Candidate(suspects=(*on.suspects, suspect), fitted=fitted, evidence=float(evidence), noise=on.noise)]


def _pairs(
    none: Candidate,
    singles: Sequence[Candidate],
    suspects: Sequence[Suspect],
) -> list[Candidate]:
    """Return pairs: the best second for the two best singles, then the best first for the best second."""
    found: dict[frozenset[str], Candidate] = {}
    noise = none.noise

    def keep(candidates: Sequence[Candidate]) -> None:
        for candidate in candidates:
            key = frozenset(candidate.keys)
            if key not in found or candidate.evidence > found[key].evidence:
                found[key] = candidate

    def extend(single: Candidate) -> None:
        others = [s for s in suspects if s.effect != single.suspects[0].effect]
        screened = rated(single.fitted, noise, tried(single.fitted, noise, others))
        likely = [each for each in screened[:_PAIRS] if each.criterion > 0.0]
        keep([_candidate(single, each, _likely(each, screened)) for each in likely])

    extend(singles[0])
    if found:
        best = max(found.values(), key=lambda c: c.evidence)
        second = best.suspects[1]
        alone = next((s for s in singles if s.keys == (second.key,)), None)
        if alone is None:
            x = np.concatenate((none.fitted.x, best.fitted.x[-len(second.slots) :]))
            fitted = fit(none.fitted.problem.with_effects(second.slots), noise, x)
            evidence = fitted.evidence - none.fitted.evidence
            alone = replace(none, suspects=(second,), fitted=fitted, evidence=evidence)
        if best.suspects[0].effect == "ventilation":
            keep(_with_air(alone))  # gates decoded without the second effect have patched what it leaves
        else:
            extend(alone)
    return list(found.values())


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
