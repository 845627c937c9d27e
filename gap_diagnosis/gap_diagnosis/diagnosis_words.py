"""The verdict as a paragraph of plain words, what to do next, and what the log shows."""

from collections.abc import Sequence

import numpy as np

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.prediction import Sizes
from gap_diagnosis.verdict import Claim, power
from thruster_model.effects.stages import LIBRARY

__all__ = ["in_words", "log_in_words", "next_step"]

_AS_MUCH = 0.8  # of the largest share of a block, from which on another one is named beside it
_NEXT = {
    "no_gap": "Leave the simulator as it is.",
    "parameters": "Take the re-tuned parameters (with_effect.yaml); add no effect.",
    "unknown": "Look at the block and the regime in which the gap lies: something is missing there that the library "
    "does not have. Record more in that regime, with all channels, and see what the residuals depend on.",
    "not_enough_data": "Record what the warnings ask for.",
    "several": "Leave the simulator as it is for now, and record what tells these explanations apart: diagnose "
    "--experiment designs the throttle programme that does so best, or says that none can.",
    "power": "Leave the simulator as it is for now, and record runs that show more: steps up to the largest throttle, "
    "both directions, reversals, with all channels.",
}
_HELD = (
    "nothing states how commands act between their samples (hold.throttle in a run's metadata): each is taken as held "
    "until the next one, as straight lines between them suit the readings no better"
)
_STRAIGHT = (
    "commands are taken as straight lines between their samples, which suits the readings better than held ones; "
    "nothing states it (hold.throttle in a run's metadata)"
)


def in_words(diagnosis: Diagnosis) -> str:
    """Return the verdict as a paragraph of plain words; what to do next follows by itself, see `next_step`."""
    verdict = diagnosis.verdict
    said = {
        "no_gap": lambda _: (
            "No gap: the simulator, as its parameters are stated, predicts these recordings to within noise."
        ),
        "parameters": _parameters_in_words,
        "cannot_tell": _cannot_tell_in_words,
        "unknown": _unknown_in_words,
        "not_enough_data": lambda _: "Not enough data: " + "; ".join(diagnosis.reasons) + ".",
        "effect": lambda _: _claims_in_words(verdict.claims, diagnosis.parameter_set.effects.sizes),
    }[verdict.verdict](diagnosis)
    return " ".join(part for part in (said, _errors_in_words(diagnosis), _log_in_words(diagnosis)) if part)


def _claims_in_words(claims: Sequence[Claim], stated: Sizes) -> str:
    if len(claims) == 1:
        return f"The gap is explained by {_claim_in_words(claims[0], stated)}."
    listed = "; and by ".join(_claim_in_words(claim, stated) for claim in claims)
    return f"The gap is explained by {len(claims)} effects together: by {listed}."


def _claim_in_words(claim: Claim, stated: Sizes) -> str:
    told = []
    for name, size in claim.sizes.items():
        unit = "" if size.unit == "1" else f" {size.unit}"
        own = stated.get(claim.effect, {}).get(name)
        in_set = "" if own is None else f" (in the set: {own:.3g}{unit})"
        told.append(f"{name.replace('_', ' ')} {size.value:.3g} ± {size.std:.2g}{unit}{in_set}")
    sizes = ", ".join(told)
    name = f"{claim.effect}{' of ' + claim.channel if claim.channel else ''} ({LIBRARY[claim.effect].title})"
    text = f"{name}: {sizes}; probability {claim.group_probability:.2f}"
    if claim.alike:
        text += f", shared with {', '.join(claim.alike)}, which these recordings cannot tell apart from it"
    if claim.kind == "parametric":
        text += (
            "; it lies in the span of the nominal parameters: a re-tuning far beyond their stated deviations would do"
        )
    return text


def _parameters_in_words(diagnosis: Diagnosis) -> str:
    moved = []
    fitted = diagnosis.retuned
    if fitted is not None and diagnosis.problem is not None:
        deviations = np.sqrt(np.diag(fitted.covariance))
        for k, name in enumerate(diagnosis.problem.names):
            if abs(fitted.x[k]) > 2.0 * deviations[k] and abs(fitted.x[k]) > 0.5:
                nominal = diagnosis.problem.parameter_set.values[name]
                value = fitted.problem.values(fitted.x)[name]
                moved.append(f"{name} {nominal:.4g} → {value:.4g}")
    names = f" ({'; '.join(moved)})" if moved else ""
    return f"Re-tuned parameters suffice: {_how_far_off(diagnosis)} they close the gap{names}. No effect is needed."


def _how_far_off(diagnosis: Diagnosis) -> str:
    found = diagnosis.investigation
    wider = 1.0 if found is None else found.none.noise.levels.parameters
    if wider == 1.0:
        return "within their stated deviations"
    return f"if they scatter {wider:.2g} times as widely as stated,"


def _cannot_tell_in_words(diagnosis: Diagnosis) -> str:
    found, verdict = diagnosis.investigation, diagnosis.verdict
    if found is not None and verdict.reason == "power":
        share = power(found.screened)
        return (
            "This data cannot tell: no effect is needed to explain it, but only "
            f"{100 * share:.0f} % of the effects would have shown at a middle size."
        )
    ranked = sorted(verdict.probabilities.items(), key=lambda each: -each[1])[:4]
    listed = [f"{name} {p:.2f}" for name, p in ranked if p > 0.02]
    text = f"This data cannot tell: several explanations remain ({', '.join([*listed, f'none {verdict.none:.2f}'])})."
    return text if found is None else text + _doubts_in_words(found)


def _unknown_in_words(diagnosis: Diagnosis) -> str:
    found = diagnosis.investigation
    if found is None:
        return ""
    depends = "; ".join(f"{each.signal} on {each.name}" for each in found.unexplained.features[:3])
    text = "The known effects do not explain the gap"
    text += f": residuals still depend on states and inputs ({depends})." if depends else "."
    if diagnosis.nearest and diagnosis.budget is not None:
        last = diagnosis.nearest[-1].found
        sizes = last.system.sizes(last.fitted.x)
        named = ", ".join(
            f"{each.key} ({', '.join(f'{s.parameter} {sizes[each.effect][s.parameter]:.3g}' for s in each.slots)})"
            for each in last.suspects
        )
        said = f"these bring it nearer, one after the other: {named}" if named else "no effect brings it nearer"
        rest = 100.0 * diagnosis.budget.unexplained.value
        text += f" On runs left out {said}; {rest:.0f} % of the squared gap has no name."
    elif diagnosis.verdict.resembles:
        named = " with ".join(
            f"{c.key} ({', '.join(f'{n} {s.value:.3g}' for n, s in c.sizes.items())})"
            for c in diagnosis.verdict.resembles
        )
        share = 100.0 * found.named_share
        part = f"{share:.0f}" if share < 99.5 else "more than 99"
        text += f" What is at work resembles {named}, which takes off {part} % of what re-tuning leaves."
        text += _doubts_in_words(found)
    return text


def _doubts_in_words(found: Investigation) -> str:
    doubts = [f"{key} {' and '.join(reasons)}" for key, reasons in found.doubts.items()]
    return f" Not claimed: {'; '.join(doubts)}." if doubts else ""


def _errors_in_words(diagnosis: Diagnosis) -> str:
    if diagnosis.errors is None:
        return ""
    total = diagnosis.errors.total
    text = f"Error on held-out data, in units of the noise: {total.as_is:.2f} as stated, {total.retuned:.2f} re-tuned"
    if total.with_effect is not None:
        text += f", {total.with_effect:.2f} with the effect"
    text += "; noise alone gives 1."
    if not diagnosis.improves:
        text += " Re-tuning does not help on runs that were left out: the set is no worse as it is stated."
    if diagnosis.shrink is not None and diagnosis.shrink.value is not None:
        text += f" The effect closes {100 * min(diagnosis.shrink.value, 1.0):.0f} % of what re-tuning leaves."
    if diagnosis.where:
        most = diagnosis.where[0][1]
        blocks = [f"'{block}'" for block, share in diagnosis.where if share > _AS_MUCH * most]
        text += f" It lies in the block{'s' if len(blocks) > 1 else ''} {' and '.join(blocks)}"
        text += f", mostly in the regime '{diagnosis.regime}'." if diagnosis.regime not in ("", "all alike") else "."
    return text


def _log_in_words(diagnosis: Diagnosis) -> str:
    sentences = log_in_words(diagnosis) if diagnosis.straight else [s.sentence for s in diagnosis.scatters]
    return f"In the log: {'; '.join(sentences)}." if sentences else ""


def log_in_words(diagnosis: Diagnosis) -> list[str]:
    """Return what the log shows, and how commands act between samples where that was not stated, as sentences."""
    held = [] if diagnosis.straight is None else [_STRAIGHT if diagnosis.straight else _HELD]
    return [*(scatter.sentence for scatter in diagnosis.scatters), *held]


def next_step(diagnosis: Diagnosis, designed: str = "") -> str:
    """Return what to do next in words; `designed`: the sentence of a next experiment, "" where none was designed."""
    verdict = diagnosis.verdict
    if verdict.verdict == "effect":
        return _switch_on(verdict.claims)
    if verdict.verdict == "cannot_tell":
        return designed or _NEXT[verdict.reason or "several"]
    text = _NEXT[verdict.verdict]
    if verdict.verdict == "unknown" and diagnosis.improves:
        text += " The re-tuned set (with_effect.yaml) predicts new runs better, and still lacks it."
    return text


def _switch_on(claims: Sequence[Claim]) -> str:
    text = f"Switch on {' and '.join(claim.effect for claim in claims)}: with_effect.yaml does it."
    if any(claim.kind == "parametric" for claim in claims):
        text += " Or correct the nominal parameters that imitate it: the effect lies in their span."
    if any(claim.alike for claim in claims):
        text += " Its look-alikes predict the same here, but not elsewhere: settle that first where it matters; "
        text += "diagnose --experiment designs the throttle programme that does so best, or says that none can."
    return text
