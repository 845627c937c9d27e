"""The content of diagnosis.json: stable, other programs read it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gap_diagnosis.candidate import Candidate
from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.how_far import ChannelErrors
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.verdict import Claim, power
from thruster_model.effects.stages import LIBRARY

__all__ = ["as_json", "best_of", "in_words"]

_AS_MUCH = 0.8  # of the largest share of a block, from which on another one is named beside it


def as_json(
    diagnosis: Diagnosis, *, runs: Sequence[str], parameter_set: str, version: str, seed: int,
    next_experiment: Mapping[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return the content of diagnosis.json as plain dictionaries, lists, strings, numbers and None."""
    verdict = diagnosis.verdict
    thruster = diagnosis.problem.recordings[0].thruster if diagnosis.problem else 0
    total = diagnosis.errors.total if diagnosis.errors else None
    channels = diagnosis.errors.channels if diagnosis.errors else {}
    content = {
        "verdict": verdict.verdict,
        "gap": {
            "total": _errors(total) if total else None,
            "shrink": diagnosis.shrink.value if diagnosis.shrink else None,
            "channels": {name: {"unit": e.unit, **_errors(e)} for name, e in channels.items()},
        },
        "where": [
            {"block": block, "thruster": thruster, "share": share, "regime": diagnosis.regime}
            for block, share in diagnosis.where
        ],
        "effects": [
            {
                "id": claim.effect,
                "thruster": thruster,
                "channel": claim.channel or None,
                "class": claim.kind,
                "probability": claim.probability,
                "group_probability": claim.group_probability,
                "parameters": {
                    name: {"value": size.value, "std": size.std, "unit": size.unit}
                    for name, size in claim.sizes.items()
                },
                "shrink": shrink.value,
                "shrink_interval": list(shrink.interval) if shrink.interval else None,
                "indistinguishable_from": list(claim.alike),
            }
            for claim, shrink in zip(verdict.claims, diagnosis.shrinks, strict=True)
        ],
        "candidates": [
            {"id": key, "probability": probability}
            for key, probability in sorted(verdict.probabilities.items(), key=lambda each: -each[1])
        ],
        "p_none": verdict.none,
        "p_unknown": verdict.unknown,
        "retuned_parameters": _retuned(diagnosis),
        "unexplained": _unexplained(diagnosis),
        "next_experiment": dict(next_experiment) if next_experiment else None,
        "log": [scatter.sentence for scatter in diagnosis.scatters],
        "warnings": [*diagnosis.warnings, *diagnosis.reasons],
        "summary": in_words(diagnosis),
        "provenance": {"runs": list(runs), "parameter_set": parameter_set, "version": version, "seed": seed},
    }
    return _plain(content)  # type: ignore[no-any-return]


def _errors(errors: ChannelErrors) -> dict[str, float | None]:
    return {
        "as_is": errors.as_is,
        "retuned": errors.retuned,
        "with_effect": errors.with_effect,
        "noise_floor": errors.noise_floor,
    }


def _retuned(diagnosis: Diagnosis) -> dict[str, dict[str, float]]:
    if diagnosis.investigation is None or diagnosis.problem is None:
        return {}
    chosen = diagnosis.verdict.chosen or diagnosis.investigation.none
    fitted, problem = chosen.fitted, diagnosis.problem
    values = fitted.problem.values(fitted.x)
    deviations = np.sqrt(np.diag(fitted.covariance))
    return {
        name: {
            "nominal": problem.parameter_set.values[name],
            "value": values[name],
            "std": float(deviations[k]) * problem.deviations[name],
        }
        for k, name in enumerate(problem.names)
    }


def best_of(diagnosis: Diagnosis) -> Candidate | None:
    """Return the hypothesis after which it is asked what stays unexplained; None where nothing was weighed."""
    if diagnosis.investigation is None:
        return None
    if diagnosis.verdict.verdict in ("no_gap", "parameters"):
        return diagnosis.investigation.none
    if diagnosis.verdict.verdict == "unknown":
        return _nearest(diagnosis.investigation)
    chosen = diagnosis.verdict.chosen or (diagnosis.posterior.leading if diagnosis.posterior else None)
    return chosen or diagnosis.investigation.none


def _unexplained(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    candidate = best_of(diagnosis)
    if candidate is None or candidate.unexplained is None:
        return []
    return [{"signal": f.signal, "depends_on": f.name, "gain": f.gain} for f in candidate.unexplained.features]


def _nearest(found: Investigation) -> Candidate:
    """Return the effects that are the most probable with something unknown beside them; none where none was weighed."""
    most, nearest = -np.inf, found.none
    for candidate in found.candidates:
        beside = candidate.unexplained.evidence if candidate.unexplained is not None else 0.0
        if (candidate.unexplained is not None or candidate.pressed) and candidate.evidence + beside > most:
            most, nearest = candidate.evidence + beside, candidate
    return nearest


def in_words(diagnosis: Diagnosis) -> str:
    """Return the verdict as a paragraph of plain words."""
    verdict = diagnosis.verdict
    said = {
        "no_gap": "No gap: the simulator, as its parameters are stated, predicts these recordings to within noise.",
        "parameters": _parameters_in_words(diagnosis),
        "cannot_tell": _cannot_tell_in_words(diagnosis),
        "unknown": _unknown_in_words(diagnosis),
        "not_enough_data": "Not enough data: " + "; ".join(diagnosis.reasons) + ".",
        "effect": _claims_in_words(verdict.claims),
    }[verdict.verdict]
    return " ".join(part for part in (said, _errors_in_words(diagnosis), _log_in_words(diagnosis)) if part)


def _claims_in_words(claims: Sequence[Claim]) -> str:
    if len(claims) == 1:
        return f"The gap is explained by {_claim_in_words(claims[0])}."
    listed = "; and by ".join(_claim_in_words(claim) for claim in claims)
    return f"The gap is explained by {len(claims)} effects together: by {listed}."


def _claim_in_words(claim: Claim) -> str:
    units = {name: "" if size.unit == "1" else f" {size.unit}" for name, size in claim.sizes.items()}
    sizes = ", ".join(
        f"{name.replace('_', ' ')} {size.value:.3g} ± {size.std:.2g}{units[name]}" for name, size in claim.sizes.items()
    )
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
    if diagnosis.investigation is not None and diagnosis.problem is not None:
        fitted = diagnosis.investigation.none.fitted
        deviations = np.sqrt(np.diag(fitted.covariance))
        for k, name in enumerate(diagnosis.problem.names):
            if abs(fitted.x[k]) > 2.0 * deviations[k] and abs(fitted.x[k]) > 0.5:
                nominal = diagnosis.problem.parameter_set.values[name]
                value = fitted.problem.values(fitted.x)[name]
                moved.append(f"{name} {nominal:.4g} → {value:.4g}")
    names = f" ({'; '.join(moved)})" if moved else ""
    return (
        f"Re-tuned parameters suffice: within their stated deviations they close the gap{names}. No effect is needed."
    )


def _cannot_tell_in_words(diagnosis: Diagnosis) -> str:
    found, verdict = diagnosis.investigation, diagnosis.verdict
    if found is not None and verdict.reason == "power":
        share = power(found.screened)
        return (
            "This data cannot tell: no effect is needed to explain it, but only "
            f"{100 * share:.0f} % of the effects would have shown at a third of their plausible size."
        )
    if found is not None and verdict.reason == "noise":
        return (
            "This data cannot tell: what no effect explains had to be taken for noise, and that is "
            f"{found.beyond_sensors:.1f} times what the samples themselves show of the sensors."
        )
    leading = diagnosis.posterior.leading if diagnosis.posterior is not None else None
    if leading is not None and verdict.reason == "parameters":
        return (
            f"This data cannot tell: {' and '.join(leading.keys)} together explain it, but parameters beyond their "
            "stated deviations can imitate both."
        )
    ranked = sorted(verdict.probabilities.items(), key=lambda each: -each[1])[:4]
    listed = [f"{name} {p:.2f}" for name, p in ranked if p > 0.02]
    return f"This data cannot tell: several explanations remain ({', '.join([*listed, f'none {verdict.none:.2f}'])})."


def _unknown_in_words(diagnosis: Diagnosis) -> str:
    unexplained = _unexplained(diagnosis)
    depends = "; ".join(f"{each['signal']} on {each['depends_on']}" for each in unexplained[:3])
    pressed = _nearest(diagnosis.investigation).pressed if diagnosis.investigation is not None else ()
    if pressed:
        why = f"{' and '.join(pressed)} would have to be larger than is plausible"
    else:
        why = "after the best of them residuals still depend on states and inputs"
    return (
        f"None of the known effects explains the gap: {why}"
        + (f" ({depends})." if depends else ".")
        + _stretches_in_words(diagnosis)
        + _nearest_in_words(diagnosis)
    )


def _stretches_in_words(diagnosis: Diagnosis) -> str:
    """Return in which stretches thrust is lost, where that says more than anything else."""
    found = diagnosis.investigation
    lost = found.stretches if found is not None else None
    if found is None or lost is None or lost.evidence < max([0.0, *(c.evidence for c in found.candidates)]):
        return ""
    share = lost.fitted.problem.sizes(lost.fitted.x)["ventilation"]["share"]
    why = "that speed, its rate, the flow or the last second foresee: not air" if lost.nameless else "as by drawn air"
    return f" In stretches {why}, {100.0 * share:.0f} % of the thrust is lost."


def _nearest_in_words(diagnosis: Diagnosis) -> str:
    """Return what comes nearest, and how much of the cost beyond the noise it takes off."""
    if diagnosis.investigation is None:
        return ""
    leading = _nearest(diagnosis.investigation)
    if not leading.suspects or leading.evidence <= 0.0:
        return ""
    none, known = diagnosis.investigation.none.fitted, float(np.sum(leading.fitted.problem.known))
    beyond = none.cost - known
    if beyond <= 0.0:
        return ""
    share = min(max((none.cost - leading.fitted.cost) / beyond, 0.0), 1.0)
    sizes = leading.fitted.problem.sizes(leading.fitted.x)
    named = " with ".join(
        f"{s.key} ({', '.join(f'{n} {v:.3g}' for n, v in sizes[s.effect].items())})" for s in leading.suspects
    )
    part = f"{100 * share:.0f}" if share < 0.995 else "more than 99"
    return f" Nearest comes {named}, which takes off {part} % of what lies beyond the noise; it is not claimed."


def _errors_in_words(diagnosis: Diagnosis) -> str:
    if diagnosis.errors is None:
        return ""
    total = diagnosis.errors.total
    text = f"Error on held-out data, in units of the noise: {total.as_is:.2f} as stated, {total.retuned:.2f} re-tuned"
    if total.with_effect is not None:
        text += f", {total.with_effect:.2f} with the effect"
    text += "; noise alone gives 1."
    if diagnosis.shrink is not None and diagnosis.shrink.value is not None:
        text += f" The effect closes {100 * min(diagnosis.shrink.value, 1.0):.0f} % of what re-tuning leaves."
    if diagnosis.where:
        most = diagnosis.where[0][1]
        blocks = [f"'{block}'" for block, share in diagnosis.where if share > _AS_MUCH * most]
        text += f" It lies in the block{'s' if len(blocks) > 1 else ''} {' and '.join(blocks)}"
        text += f", mostly in the regime '{diagnosis.regime}'." if diagnosis.regime not in ("", "all alike") else "."
    return text


def _log_in_words(diagnosis: Diagnosis) -> str:
    sentences = [s.sentence for s in diagnosis.scatters]
    return f"In the log: {'; '.join(sentences)}." if sentences else ""


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    if isinstance(value, np.integer):
        return int(value)
    return value
