"""From weighed sets to a verdict: what is claimed, in which group of look-alikes, and what is not."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import expit

from gap_diagnosis.investigation import Investigation
from gap_diagnosis.rules import RULES
from gap_diagnosis.scatter import Scatter, probability_at
from gap_diagnosis.sizes import Size, sizes_of
from system_identification.hypothesis import Hypothesis
from system_identification.rating import Rated
from system_identification.suspects import Suspect, key_of
from thruster_model.effects.stages import LIBRARY

__all__ = ["VERDICTS", "Claim", "Verdict", "class_of", "power", "verdict_of"]

VERDICTS = ("no_gap", "parameters", "effect", "cannot_tell", "unknown", "not_enough_data")


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
    """One of `VERDICTS`, what is claimed, the set behind it (None: no effect), and inclusion probabilities by key.

    `resembles`: effects of the best set where something nameless is left, or which are not certain enough to claim.
    `reason`: why it cannot be told, where that is the verdict: "several" explanations remain, or none is needed but the
    recordings lack the "power" to show most effects.
    """

    verdict: str
    claims: tuple[Claim, ...]
    chosen: Hypothesis | None
    probabilities: dict[str, float]
    none: float
    unknown: float
    resembles: tuple[Claim, ...] = ()
    reason: str = ""


def power(rated: Sequence[Rated]) -> float:
    """Return the share of suspects that would have shown at a middle size."""
    seen = [each.visibility > RULES.visible for each in rated]
    return float(np.mean(seen)) if seen else 0.0


def verdict_of(found: Investigation, scatters: Sequence[Scatter], foreign: Sequence[Scatter] = ()) -> Verdict:
    """Return the verdict.

    Args:
        found: the weighed sets.
        scatters: effects that the log shows by itself.
        foreign: such effects that are not considered.
    """
    logged = tuple(_scatter_claim(scatter) for scatter in scatters)
    best = found.best
    longest = float(np.max(best.system.times))
    claims = tuple(
        claim
        for claim in (_claim(found, suspect) for suspect in best.suspects)
        if not (_is_convention(claim, longest) or _is_slight(claim))
    )
    sure = tuple(
        claim for claim in claims if claim.group_probability >= RULES.claimed and claim.key not in found.resembling
    )
    unknown = _unknown(found)
    nothing = found.evident < RULES.evident or not claims
    reason = ""
    if foreign or unknown > 0.5:
        verdict = "unknown"
    elif nothing:
        verdict = "parameters" if _strained(found) and found.retuning_helps >= RULES.helps else "no_gap"
        if power(found.screened) < RULES.power and not logged:
            verdict, reason = "cannot_tell", "power"
    elif sure:
        verdict = "effect"
    else:
        verdict, reason = "cannot_tell", "several"
    if logged and verdict in ("no_gap", "parameters"):
        verdict = "effect"
        sure = ()
    told = (*(sure if verdict == "effect" else ()), *(logged if verdict == "effect" else ()))
    chosen = best if verdict == "effect" and sure else None
    probabilities = {
        key: p * (RULES.resembles if unknown > 0.5 or key in found.resembling else 1.0)
        for key, p in found.inclusion.items()
    }
    rest = tuple(
        replace(claim, probability=probabilities[claim.key]) for claim in claims if claim not in told and not nothing
    )
    for claim in logged:
        probabilities[claim.key] = max(probabilities.get(claim.key, 0.0), claim.probability)
    return Verdict(
        verdict=verdict,
        claims=told,
        chosen=chosen,
        probabilities=probabilities,
        none=found.p_none if not logged else 0.0,
        unknown=unknown,
        resembles=rest,
        reason=reason,
    )


def _is_convention(claim: Claim, longest: float) -> bool:
    """Tell whether a time is no more than simulators and loggers disagree about within a step.

    Of a clock that gains: by the end of the longest run [s]. Any two quartzes do a hundred-thousandth.
    """
    size = next(iter(claim.sizes.values()))
    late = {"s": 1.0, "s/s": longest}.get(size.unit, np.inf)
    return abs(size.value) * late < RULES.conventional


def _is_slight(claim: Claim) -> bool:
    """Tell whether an effect is so small that any model is off by as much."""
    largest = LIBRARY[claim.effect].parameters[0]
    size = next(iter(claim.sizes.values()))
    return np.isfinite(largest.neutral) and abs(size.value - largest.neutral) < RULES.slight * abs(largest.upper)


def _unknown(found: Investigation) -> float:
    """Return the probability that something without a name is at work which does not belong to the named effects.

    What evidence there must be for it is the logarithm of how many functions were tried (`RULES.nameless`).
    """
    best = found.best
    held = np.max(np.abs(best.fitted.x[: len(best.system.names)])) > RULES.held
    resembling = found.evident >= RULES.evident and sum(found.resembling.values()) > 1.0 - RULES.named
    if held or _beyond(best) or (resembling and found.unnamed > RULES.nameless):
        return 1.0 - RULES.resembles
    significant = float(expit((found.unexplained.evidence - RULES.nameless) / RULES.tempered))
    if best.suspects and found.named_share >= RULES.named:
        return significant * (1.0 - found.named_share)
    return significant


def _beyond(found: Hypothesis) -> bool:
    """Tell whether the data want more of an effect than is plausible: then what is at work only resembles it."""
    fitted, problem = found.fitted, found.system
    for k, slot in enumerate(problem.slots, start=problem.nuisances):
        end = slot.upper if fitted.pull[k] > 0.0 else slot.lower
        at_end = abs(fitted.x[k] * slot.width - end) < 1e-6 * slot.width
        if at_end and end != 0.0 and slot.lower < slot.upper:
            gain = fitted.pull[k] ** 2 * fitted.covariance[k, k]  # the others re-tuned beside it
            if gain > RULES.pressed**2:
                return True
    return False


def _strained(found: Investigation) -> bool:
    """Tell whether parameters as stated predict worse than re-tuned ones, beyond what so many of them do by chance."""
    none = found.none
    x = none.fitted.x.copy()
    count = len(none.system.names)
    x[:count] = 0.0
    white = none.noise.whiten(none.system.residuals(x))
    prior = none.fitted.prior
    cost = float(white @ white + prior @ x[: prior.size] ** 2)
    information = none.fitted.jacobian[:, :count].T @ none.fitted.jacobian[:, :count] + np.diag(prior[:count])
    chance = float(np.linalg.slogdet(information)[1]) - float(np.sum(np.log(prior[:count])))
    return cost - none.fitted.cost > chance


def _claim(found: Investigation, suspect: Suspect) -> Claim:
    best = found.best
    others = set(best.keys) - {suspect.key}
    alike = []
    for keys, other in found.search.weighed.items():
        (new,) = keys - others if len(keys - others) == 1 and others <= keys else ("",)
        if not new or new == suspect.key or len(keys) != len(best.keys):
            continue
        if best.evidence - other.evidence < RULES.alike and _distance(best, other) < RULES.apart:
            alike.append(new)
    twins = [*LIBRARY[suspect.effect].twins, *(t for t, each in LIBRARY.items() if suspect.key in each.twins)]
    alike += [twin for twin in twins if twin not in alike]
    group = {suspect.key, *alike}
    probability = sum(p for keys, p in found.probabilities.items() if group & set(keys))
    return Claim(
        effect=suspect.effect,
        channel=suspect.channel,
        probability=found.inclusion.get(suspect.key, 0.0),
        group_probability=min(probability, 1.0),
        sizes=sizes_of(best.fitted, best.noise, suspect),
        kind=class_of(*found.imitated[suspect.key]),
        alike=tuple(dict.fromkeys(alike)),
    )


def _distance(first: Hypothesis, second: Hypothesis) -> float:
    """Return the squared distance between the predictions of two fits, in standard deviations of the noise."""
    apart = first.noise.whiten(first.fitted.residuals - second.fitted.residuals)
    return float(apart @ apart)


def class_of(left: float, whole: float) -> str:
    """Return "parametric" where parameters that imitate an effect of energy `whole` leave as good as nothing of it."""
    return "parametric" if left < max(RULES.pulled * whole, RULES.apart) else "structural"


def _scatter_claim(scatter: Scatter) -> Claim:
    parameter = next(p for p in LIBRARY[scatter.effect].parameters if p.name == scatter.parameter)
    probability = probability_at(scatter.log_odds)
    return Claim(
        effect=scatter.effect,
        channel="",
        probability=probability,
        group_probability=probability,
        sizes={scatter.parameter: Size(value=scatter.size, std=scatter.deviation, unit=parameter.unit)},
        kind="structural",
        scatters=True,
    )
