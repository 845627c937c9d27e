"""The content of diagnosis.json: stable, other programs read it."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.diagnosis_words import in_words, log_in_words, next_step
from gap_diagnosis.how_far import ChannelErrors
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.linear import PUSHED
from gap_diagnosis.problem import Problem
from gap_diagnosis.verdict import Claim, Verdict
from gap_diagnosis.waterfall import channels_left_out, floors_of
from system_identification.budget import PARAMETERS
from system_identification.hypothesis import Hypothesis
from system_identification.left_out import FEWEST_RUNS
from system_identification.noise import Whitener

__all__ = ["as_json", "effects_of"]

Array = NDArray[np.float64]


def as_json(
    diagnosis: Diagnosis, *, runs: Sequence[str], parameter_set: str, version: str, seed: int,
    next_experiment: Mapping[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return the content of diagnosis.json as plain dictionaries, lists, strings, numbers and None."""
    verdict = diagnosis.verdict
    thruster = diagnosis.problem.recordings[0].thruster if diagnosis.problem else 0
    total = diagnosis.errors.total if diagnosis.errors else None
    channels = diagnosis.errors.channels if diagnosis.errors else {}
    step = next_step(diagnosis, str(next_experiment["sentence"]) if next_experiment else "")
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
            told
            | {
                "shrink": shrink.value,
                "shrink_interval": list(shrink.interval) if shrink.interval else None,
            }
            for told, shrink in zip(effects_of(verdict, thruster), diagnosis.shrinks, strict=True)
        ],
        "resembles": [_effect(claim, thruster) for claim in verdict.resembles],
        "budget": _budget(diagnosis),
        "candidates": [
            {"id": key, "probability": probability}
            for key, probability in sorted(verdict.probabilities.items(), key=lambda each: -each[1])
        ],
        "p_none": verdict.none,
        "p_unknown": verdict.unknown,
        "retuned_parameters": _retuned(diagnosis),
        "unexplained": _unexplained(diagnosis),
        "next_experiment": dict(next_experiment) if next_experiment else None,
        "log": log_in_words(diagnosis),
        "warnings": [*diagnosis.warnings, *diagnosis.reasons],
        "summary": f"{in_words(diagnosis)} Next: {step}" if verdict.verdict == "cannot_tell" else in_words(diagnosis),
        "next_step": step,
        "provenance": {"runs": list(runs), "parameter_set": parameter_set, "version": version, "seed": seed},
    }
    return _plain(content)  # type: ignore[no-any-return]


def effects_of(verdict: Verdict, thruster: int = 0) -> list[dict[str, Any]]:
    """Return what a verdict claims."""
    return [_effect(claim, thruster) for claim in verdict.claims]


def _effect(claim: Claim, thruster: int) -> dict[str, Any]:
    return {
        "id": claim.effect,
        "thruster": thruster,
        "channel": claim.channel or None,
        "axis": None,
        "other": None,
        "sensor": None,
        "kind": None,
        "class": claim.kind,
        "probability": claim.probability,
        "group_probability": claim.group_probability,
        "parameters": {
            name: {"value": size.value, "std": size.std, "unit": size.unit} for name, size in claim.sizes.items()
        },
        "indistinguishable_from": list(claim.alike),
    }


def _budget(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """Return where the gap goes: shares with intervals, and the waterfall on runs left out."""
    budget, found = diagnosis.budget, diagnosis.investigation
    if budget is None or found is None:
        return None
    levels = found.noise.levels
    claims = {claim.key: claim for claim in (*diagnosis.verdict.claims, *diagnosis.verdict.resembles)}
    if diagnosis.nearest:
        last = diagnosis.nearest[-1]
        whole, unknowns, retuned = last.found, last.out.unknowns, diagnosis.nearest[0].out.unknowns
        helps = {each.found.keys[-1]: each.helps for each in diagnosis.nearest[1:]}
        chosen = {each.found.keys[-1]: each.chosen for each in diagnosis.nearest[1:]}
    else:
        whole, unknowns = found.best, found.held_out(found.best).unknowns
        retuned = found.held_out(found.none).unknowns
        helps, chosen = {**found.helps}, {}
    causes = []
    for suspect in whole.suspects:
        share, claim = budget.shares[suspect.key], claims.get(suspect.key)
        by_fold = unknowns[:, whole.sizes_of(suspect)] * [slot.width for slot in suspect.slots]
        causes.append(
            {
                "id": suspect.effect,
                "channel": suspect.channel or None,
                "probability": diagnosis.verdict.probabilities.get(suspect.key, 0.0),
                "helps": helps[suspect.key],
                "best_without_each_run": chosen.get(suspect.key),
                "share": share.value,
                "interval": [share.low, share.high],
                "sizes_by_run_left_out": {
                    slot.parameter: by_fold[:, k].tolist() for k, slot in enumerate(suspect.slots)
                },
                "class": None if claim is None else claim.kind,
                "could_as_well_be": [] if claim is None else list(claim.alike),
            }
        )
    parameters = budget.shares[PARAMETERS]
    steps = [
        {"step": step.name, "rms": step.rms, "by_run": list(step.by_fold), "helps": step.helps, "channels": channels}
        for step, channels in zip(diagnosis.waterfall, channels_left_out(diagnosis, found), strict=True)
    ]
    floors = _floors(found)
    return {
        "gap": {
            "rms_as_is": budget.gap,
            "unit": "noise",
            "disturbance_share": _disturbance_share(diagnosis.waterfall[0].rms, floors[0]["rms"]),
        },
        "causes": causes,
        "parameters": {"share": parameters.value, "interval": [parameters.low, parameters.high]},
        "unexplained": {
            "share": budget.unexplained.value,
            "interval": [budget.unexplained.low, budget.unexplained.high],
            "significant": found.nameless,
            "block": diagnosis.where[0][0] if diagnosis.where and diagnosis.verdict.verdict == "unknown" else None,
            "depends_on": [f"{f.signal}: {f.name}" for f in found.unexplained.features[:3]] if found.nameless else [],
        },
        "nameless": {"share": budget.unexplained.value, "level": _nameless(found)},
        "disturbance": dict(zip(PUSHED, levels.pushes, strict=False)),
        "process_noise": {**_rates(found.noise), "memory": levels.memory},
        "retuned_without_each_run": _by_run_left_out(found.none, retuned),
        "with_causes_without_each_run": _by_run_left_out(whole, unknowns),
        "left_out": steps,
        "floors": floors,
    }


def _floors(found: Investigation) -> list[dict[str, Any]]:
    """Return what a right model would be off by: with random pushes, and by the sensors' noise alone."""
    return [
        {
            "step": name,
            "rms": float(np.sqrt(np.mean([over**2 for over, _ in channels.values()]))),
            "channels": {channel: level for channel, (_, level) in channels.items()},
        }
        for name, channels in floors_of(found).items()
    ]


def _disturbance_share(as_is: float, pushed: float) -> float | None:
    """Return the share of the squared error beyond the noise that random pushes make; None: there is no such error."""
    return min((pushed**2 - 1.0) / (as_is**2 - 1.0), 1.0) if as_is > 1.0 else None


def _nameless(found: Investigation) -> dict[str, float]:
    """Return how large what has no name is, over the noise of its signal; of rotor and flows: what pushes them."""
    explained = found.unexplained.explained
    of_signals = {
        signal: float(np.sqrt(np.mean(explained[rows] ** 2))) / found.left.noise.level(signal)
        for signal, rows in found.none.system.signal_rows.items()
    }
    return of_signals | dict(zip(PUSHED, found.noise.levels.pushes, strict=False))


def _rates(noise: Whitener) -> dict[str, float]:
    """Return the standard deviations of what pushes rotor [rad/s^2] and water [m/s^2] at random."""
    pushed = zip(noise.levels.pushes, noise.units, strict=False)
    return dict(zip(PUSHED, (level * float(unit) for level, unit in pushed), strict=False))


def _by_run_left_out(found: Hypothesis, unknowns: Array) -> dict[str, Any] | None:
    """Return parameters [SI] and sizes of effects as fitted without each run, by name; None: parts were left out."""
    problem: Problem = found.system
    names = [recording.name for recording in problem.recordings]
    if len(names) < FEWEST_RUNS or len(unknowns) != len(names) or len(set(names)) != len(names):
        return None
    return {
        name: {"parameters": problem.values(x), "effects": problem.sizes(x)}
        for name, x in zip(names, unknowns, strict=True)
    }


def _errors(errors: ChannelErrors) -> dict[str, float | None]:
    return {
        "as_is": errors.as_is,
        "retuned": errors.retuned,
        "with_effect": errors.with_effect,
        "noise_floor": errors.noise_floor,
    }


def _retuned(diagnosis: Diagnosis) -> dict[str, dict[str, float]]:
    fitted, problem = diagnosis.retuned, diagnosis.problem
    if fitted is None or problem is None:
        return {}
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
    found = diagnosis.investigation
    if found is None:
        return []
    features = found.unexplained.features
    return [{"signal": f.signal, "depends_on": f.name, "gain": f.gain} for f in features]


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
