"""From probabilities to a verdict: what is claimed, in which group, and what is not."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap_diagnosis.candidate import Candidate
from gap_diagnosis.fitting import fit
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.posterior import Posterior
from gap_diagnosis.problem import Problem
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.screening import Screened
from gap_diagnosis.sizes import Size, sizes_of
from gap_diagnosis.suspects import Suspect, key_of
from thruster_model.effects.stages import LIBRARY

__all__ = ["VERDICTS", "Claim", "Verdict", "class_of", "power", "verdict_of"]

VERDICTS = ("no_gap", "parameters", "effect", "cannot_tell", "unknown", "not_enough_data")
CLAIMED = 0.89
"""Stated probability from which a group of effects is claimed."""
AGAINST_NONE = 30.0
"""And how much more probable than none it has to be: a false alarm is worse than a small effect that is passed over. In
328 simulated cases without effect the likeliest one was more probable than none in five, and at most 23 times."""
QUIET = 0.14
"""Probability of none from which nothing is said to be wrong, where nothing is claimed: the rest is spread over all
that may be there, too small to be seen."""
FAVOURED = 3.0
"""How much more probable than none an effect may be where nothing is said to be wrong."""
APART = 9.0
"""Squared distance (Fisher, in standard deviations) below which two hypotheses cannot be told apart."""
VISIBLE = 25.0
"""Cost that an effect has to take off so that it would have been found."""
LEAST_POWER = 0.5
"""Share of the suspects that recordings must be able to show for "no gap" to mean anything."""
DOUBTED = 4.0
"""Noise over that of the samples themselves from which nothing is said to suffice: something else is at work."""
IN_SPAN = 0.002
"""Share of an effect's energy outside the span of the parameters below which it counts as parametric."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A claimed effect: its probability, that of its whole group, sizes, class and look-alikes by key."""

    effect: str
    channel: str
    probability: float
    group_probability: float
    sizes: dict[str, Size]
    kind: str
    alike: tuple[str, ...] = ()
    scatters: bool = False

    @property
    def key(self) -> str:
        """Of the suspect that is claimed."""
        return key_of(self.effect, self.channel)


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """One of `VERDICTS`, what is claimed, the hypothesis behind it (None: no effect), and its probabilities.

    `reason`: why it cannot be told, where that is the verdict: "several" explanations remain, "parameters" beyond their
    deviations would do as well as two effects, the "noise" is larger than any sensor's, or none is needed but the
    recordings lack the "power" to show most effects.
    """

    verdict: str
    claims: tuple[Claim, ...]
    chosen: Candidate | None
    probabilities: dict[str, float]
    none: float
    unknown: float
    reason: str = ""


def power(screened: Sequence[Screened]) -> float:
    """Return the share of the suspects that would have been found at a third of their plausible size."""
    return float(np.mean([s.visibility > VISIBLE for s in screened])) if screened else 0.0


def verdict_of(
    found: Investigation, posterior: Posterior, scatters: Sequence[Scatter], foreign: Sequence[Scatter] = ()
) -> Verdict:
    """Return the verdict.

    Args:
        found: all hypotheses that were weighed.
        posterior: their probabilities.
        scatters: what the logs show of effects that only scatter.
        foreign: the same of effects that are not considered: something is there that has no name.
    """
    noise_claims = tuple(_scatter_claim(s) for s in scatters)
    stated = posterior.stated
    probabilities = _single_probabilities(stated, scatters)
    none = stated.none if not scatters else 0.0
    chosen: Candidate | None = None
    claims: tuple[Claim, ...] = ()
    leading = posterior.leading
    if leading is not None:
        claims = tuple(_claim(found, stated, leading, s) for s in leading.suspects if s.key in leading.named)
        chosen = leading
    least = max(CLAIMED, AGAINST_NONE * posterior.none)
    # Two effects that parameters can imitate say no more than that a parameter is off by more than is stated.
    certain = bool(claims) and min(c.group_probability for c in claims) >= least
    imitable = certain and len(claims) == 2 and all(claim.kind == "parametric" for claim in claims)
    named = certain and not imitable
    if len(claims) == 2 and not certain:
        # One of the two may be certain even though the other is not.
        sure = tuple(c for c in claims if c.group_probability >= least)
        if sure:
            single = next((c for c in found.candidates if c.keys == (sure[0].key,)), None)
            if single is not None and _at_work(stated, sure[0].key) >= least:
                claims, chosen, named = sure, single, True
    reason = ""
    if posterior.unknown > 0.5 or foreign:
        verdict = "unknown"
    elif named:
        verdict = "effect"
    else:
        reason = "parameters" if imitable else _doubt(found, posterior, bool(noise_claims))
        verdict = "cannot_tell" if reason else "parameters" if found.stated[1] < 0.0 else "no_gap"
    if verdict != "effect":
        claims, chosen = (), None
    if noise_claims and verdict in ("no_gap", "parameters"):
        verdict = "effect"
    if verdict == "effect":
        claims = (*claims, *noise_claims)
    return Verdict(
        verdict=verdict,
        claims=claims,
        chosen=chosen,
        probabilities=probabilities,
        none=none,
        unknown=stated.unknown,
        reason=reason,
    )


def _doubt(found: Investigation, posterior: Posterior, in_log: bool) -> str:
    """Return why it cannot be told whether anything is wrong; empty where nothing is, but for what the log shows."""
    likeliest = max(posterior.marginal.values(), default=0.0)
    if posterior.none <= QUIET or likeliest > FAVOURED * posterior.none:
        return "several"
    if found.beyond_sensors > DOUBTED:
        return "noise"
    return "power" if power(found.screened) < LEAST_POWER and not in_log else ""


def _at_work(posterior: Posterior, key: str, *, beside_unknown: bool = True) -> float:
    """Return the probability that a suspect is at work, alone, in a pair or, if that counts, beside the unknown."""
    return posterior.marginal.get(key, 0.0) + (posterior.beside.get(key, 0.0) if beside_unknown else 0.0)


def _claim(found: Investigation, stated: Posterior, leading: Candidate, suspect: Suspect) -> Claim:
    others = set(leading.keys) - {suspect.key}
    alike = []
    for candidate in found.candidates:
        replaced = set(candidate.keys) - others
        if len(candidate.keys) != len(leading.keys) or not others <= set(candidate.keys) or suspect.key in replaced:
            continue
        if candidate.fitted.cost - leading.fitted.cost < APART and candidate.evidence > leading.evidence - APART:
            alike.append(next(iter(replaced)))
    # What is unknown beside two effects may be all that there is: two can imitate much.
    lone = len(leading.named) == 1
    group = min(sum(_at_work(stated, key, beside_unknown=lone) for key in (suspect.key, *alike)), 1.0)
    return Claim(
        effect=suspect.effect,
        channel=suspect.channel,
        probability=stated.marginal.get(suspect.key, 0.0),
        group_probability=group,
        sizes=sizes_of(leading.fitted, leading.noise, suspect),
        kind=class_of(leading, suspect),
        alike=tuple(dict.fromkeys(alike)),
    )


def class_of(candidate: Candidate, suspect: Suspect) -> str:
    """Return "parametric" where the nominal parameters, free of their deviations, can imitate the effect."""
    fitted = candidate.fitted
    problem = fitted.problem
    kept = tuple(slot for slot in problem.slots if slot not in suspect.slots)
    places = [problem.nuisances + i for i, slot in enumerate(problem.slots) if slot in kept]
    x = fitted.x[[*range(problem.nuisances), *places]]
    target = np.where(problem.known, problem.predicted(fitted.x), np.nan)
    wide = {name: 10.0 * deviation for name, deviation in problem.deviations.items()}
    gates = problem.gates if suspect.effect != "ventilation" else ()
    bare: Problem = replace(problem, slots=kept, deviations=wide, observed=target, gates=gates)
    x = x.copy()
    x[: len(problem.names)] /= 10.0
    noise = candidate.noise
    white = bare.whitened(noise, bare.residuals(x))
    imitated = fit(bare, noise, x, iterations=5)
    left = float(imitated.white @ imitated.white)
    return "parametric" if left < max(IN_SPAN * float(white @ white), APART) else "structural"


def _scatter_claim(scatter: Scatter) -> Claim:
    parameter = next(p for p in LIBRARY[scatter.effect].parameters if p.name == scatter.parameter)
    probability = float(1.0 / (1.0 + np.exp(-min(scatter.log_odds - 3.0, 50.0))))
    return Claim(
        effect=scatter.effect,
        channel="",
        probability=probability,
        group_probability=probability,
        sizes={scatter.parameter: Size(value=scatter.size, std=scatter.deviation, unit=parameter.unit)},
        kind="structural",
        scatters=True,
    )


def _single_probabilities(posterior: Posterior, scatters: Sequence[Scatter]) -> dict[str, float]:
    """Return probabilities over single candidates that sum to one with none and unknown.

    A pair's probability is shared by its two; an effect of the log that is there for certain takes the place of none.
    """
    result = dict(posterior.singles)
    for keys, probability in posterior.pairs.items():
        for key in keys:
            result[key] = result.get(key, 0.0) + probability / len(keys)
    for scatter in scatters:
        result[scatter.effect] = result.get(scatter.effect, 0.0) + posterior.none / len(scatters)
    return result
