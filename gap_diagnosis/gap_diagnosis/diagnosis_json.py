"""The content of diagnosis.json: stable, other programs read it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.diagnosis_words import in_words
from gap_diagnosis.how_far import ChannelErrors
from gap_diagnosis.nearest import best_of

__all__ = ["as_json"]


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


def _unexplained(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    candidate = best_of(diagnosis)
    if candidate is None or candidate.unexplained is None:
        return []
    return [{"signal": f.signal, "depends_on": f.name, "gain": f.gain} for f in candidate.unexplained.features]


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
