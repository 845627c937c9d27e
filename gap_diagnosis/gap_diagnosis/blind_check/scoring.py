"""All figures of a blind check from opened cases."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap_diagnosis.blind_check.catalogue import EFFECTS
from gap_diagnosis.blind_check.judging import (
    FOREIGN,
    accepts,
    block_right,
    claims,
    is_named,
    named_claim,
    quiet,
    right,
    silent,
    size_of,
    size_parameter,
    true_label,
    true_names,
    wrong_names,
)
from gap_diagnosis.blind_check.limits import (
    STANDARD,
    detection_limits,
    limit_name,
    limits_without_own,
    never_found,
    sizes_above,
    sizes_above_targets,
)
from gap_diagnosis.blind_check.opened import Opened
from gap_diagnosis.blind_check.statistics import Limit, Share, calibration_error, share

__all__ = ["HEADLINE", "Scores", "score"]

HEADLINE = ("effect", "none", "nuisance", "outside", "left_out")
"""Kinds of case in the rate of right verdicts, with sweeps above the limit; others are reported by themselves."""
Sized = tuple[str, str, float, float, float]

_NORMAL_90 = 1.645
_LARGE = 4.0  # times the detection limit


@dataclass(frozen=True, kw_only=True)
class Scores:
    """The figures; shares carry their Wilson intervals. Sizes and shrinks: (case, effect, true, estimated[, std])."""

    shares: Mapping[str, Share]
    by_effect: Mapping[str, Share]
    by_effect_above: Mapping[str, Share]
    by_kind: Mapping[str, Share]
    limits: Mapping[str, Limit]
    numbers: Mapping[str, float]
    reliability: Sequence[Mapping[str, float]]
    sizes: Sequence[Sized]
    shrinks: Sequence[tuple[str, str, float, float]]
    confusion: Mapping[tuple[str, str], int]
    wrong: Sequence[tuple[str, str, str]]


def score(cases: Sequence[Opened], rng: np.random.Generator) -> Scores:
    """Return the figures of opened cases; `rng` is that of the bootstrap of the detection limits."""
    given = [(case.key, case.diagnosis) for case in cases]
    limits = detection_limits(given, rng)
    own = limits_without_own(given, limits)
    clear = [case for case, without in zip(cases, own, strict=True) if sizes_above(case.key, without)]
    without = [case for case in cases if not true_names(case.key)]
    pairs = [case for case in cases if case.key["kind"] == "pair"]
    targeted = [case for case in cases if case.single and _standard(case) and sizes_above_targets(case.key)]
    hidden = [case for case in clear if true_names(case.key) and case.key["excitation"] == "rich"]
    foreign = [case for case in cases if case.key["kind"] in FOREIGN]
    sizes = _sizes(cases)
    shrinks = _shrinks(cases)
    ranked = [case for case in cases if case.key["kind"] != "pair" and "candidates" in case.diagnosis]
    tops = [_top(case) for case in ranked]
    error, bins = calibration_error([p for p, _ in tops], [hit for _, hit in tops]) if tops else (float("nan"), [])
    shares = {
        "right verdict, above the limit": share([_right(c) for c in clear if c.key["kind"] in (*HEADLINE, "sweep")]),
        "right verdict, above the target of the limit": share([_right(c) for c in targeted]),
        "right verdict, all sizes": share([_right(c) for c in cases if c.key["kind"] in HEADLINE]),
        "wrong effect named with probability 0.8 or more": share([bool(_wrong(c)) for c in cases]),
        "effect claimed where there is none": share([bool(claims(c.diagnosis)) for c in without]),
        "cannot tell where there is none": share([silent(c.diagnosis) for c in without]),
        "no gap said, or parameters, where an effect above the limit is hidden": share(
            [quiet(c.diagnosis) for c in hidden if c.key["kind"] not in FOREIGN]
        ),
        "outside the library: unknown, or right block": share([_right(c) for c in foreign]),
        "outside the library, what was taken out above its limit": share(
            [_right(c) for c in clear if c.key["kind"] in FOREIGN]
        ),
        "both effects of a pair named": share([_right(c) for c in pairs]),
        "both effects of a pair named, above their limits": share(
            [_right(c) for c in clear if c.key["kind"] == "pair"]
        ),
        "block right, above the limit": share([block_right(c.key, c.diagnosis) for c in hidden]),
        "90 % intervals of sizes cover": share([abs(e - t) <= _NORMAL_90 * std for _, _, t, e, std in sizes]),
    }
    by_effect, by_effect_above = _by_effect(cases), _by_effect(clear)
    kinds = dict.fromkeys(case.key["kind"] for case in cases)
    return Scores(
        shares=shares,
        by_effect=by_effect,
        by_effect_above=by_effect_above,
        by_kind={kind: share([_right(c) for c in cases if c.key["kind"] == kind]) for kind in kinds},
        limits=limits,
        numbers={
            "median size error": _median_size_error(cases, sizes, limits),
            "median difference of stated and actual shrink": _median([abs(s - a) for _, _, s, a in shrinks]),
            "calibration error": error,
            "log score": _log_score(ranked),
            "log score of base rates": _base_rates(ranked),
            "mean group size": _mean_group_size(cases),
            "limits beyond the sizes tried": float(sum(never_found(name, found) for name, found in limits.items())),
        },
        reliability=bins,
        sizes=sizes,
        shrinks=shrinks,
        confusion=_confusion(cases),
        wrong=[(c.key["case"], "+".join(true_names(c.key)), name) for c in cases for name in _wrong(c)],
    )


def _right(case: Opened) -> bool:
    return right(case.key, case.diagnosis)


def _wrong(case: Opened) -> list[str]:
    return wrong_names(case.key, case.diagnosis)


def _standard(case: Opened) -> bool:
    return case.key["kind"] in STANDARD


def _by_effect(cases: Sequence[Opened]) -> dict[str, Share]:
    named = {name: [c for c in cases if _standard(c) and c.single == name] for name in EFFECTS}
    return {name: share([_right(c) for c in found]) for name, found in named.items() if found}


def _sizes(cases: Sequence[Opened]) -> list[Sized]:
    """Return sizes of single effects that are claimed under their own identifier."""
    found = []
    for case in cases:
        name = case.single
        claim = named_claim(case.key, name, case.diagnosis) if name else None
        if name is None or claim is None or claim["id"] != name:
            continue
        estimate = (claim.get("parameters") or {}).get(size_parameter(case.key, name))
        if estimate is not None and estimate.get("std") is not None:
            true = size_of(case.key, name)
            found.append((str(case.key["case"]), name, true, float(estimate["value"]), float(estimate["std"])))
    return found


def _median_size_error(cases: Sequence[Opened], sizes: Sequence[Sized], limits: Mapping[str, Limit]) -> float:
    keys = {case.key["case"]: case.key for case in cases}
    errors = []
    for case, name, true, estimate, _ in sizes:
        limit, kind = limits.get(limit_name(keys[case], name)), EFFECTS[name]
        if limit is None or not kind.structural:
            continue
        ratio = limit.value / abs(true) if kind.size.falls else abs(true) / max(limit.value, 1e-300)
        if ratio >= _LARGE:
            errors.append(abs(estimate - true) / abs(true))
    return _median(errors)


def _shrinks(cases: Sequence[Opened]) -> list[tuple[str, str, float, float]]:
    """Return (case, effect, stated, actual) where a single effect is rightly named and predictions were kept."""
    found = []
    for case in cases:
        name = case.single
        claim = named_claim(case.key, name, case.diagnosis) if name else None
        if name and claim is not None and claim.get("shrink") is not None and case.shrink is not None:
            found.append((str(case.key["case"]), name, float(claim["shrink"]), case.shrink))
    return found


def _labels(case: Opened) -> dict[str, float]:
    """Return the probability of each candidate, of "none" and "unknown"."""
    given = {name: float(case.diagnosis.get(f"p_{name}") or 0.0) for name in ("none", "unknown")}
    return given | {each["id"]: float(each["probability"]) for each in case.diagnosis["candidates"]}


def _top(case: Opened) -> tuple[float, bool]:
    labels = _labels(case)
    best = max(labels, key=lambda name: labels[name])
    return labels[best], accepts(case.key, best)


def _log_score(cases: Sequence[Opened]) -> float:
    """Return the mean logarithm of the probability given to the truth (its exact twins included), at least 1e-6."""
    given = [sum(p for label, p in _labels(c).items() if accepts(c.key, label)) for c in cases]
    return float(np.mean(np.log(np.clip(given, 1e-6, 1.0)))) if given else float("nan")


def _base_rates(cases: Sequence[Opened]) -> float:
    """Return the log score of one who knows how often each truth occurs, and nothing else."""
    truths = [true_label(c.key) for c in cases]
    counts = {name: truths.count(name) for name in truths}
    return float(np.mean([np.log(counts[name] / len(truths)) for name in truths])) if truths else float("nan")


def _mean_group_size(cases: Sequence[Opened]) -> float:
    sizes = [1 + len(claim.get("indistinguishable_from") or ()) for c in cases for claim in claims(c.diagnosis)]
    return float(np.mean(sizes)) if sizes else float("nan")


def _confusion(cases: Sequence[Opened]) -> dict[tuple[str, str], int]:
    """Return counts by (truth, what was said): the truth itself where it is named, else the first name or verdict."""
    counts: dict[tuple[str, str], int] = {}
    for case in cases:
        names = true_names(case.key)
        if len(names) > 1 or case.key["excitation"] != "rich":
            continue
        truth = "none" if not names else "outside" if case.key["kind"] in FOREIGN else names[0]
        found = claims(case.diagnosis)
        if names and truth != "outside" and is_named(case.key, truth, case.diagnosis):
            said = truth
        elif found:
            said = str(max(found, key=lambda claim: float(claim.get("probability") or 0.0))["id"])
        else:
            said = str(case.diagnosis.get("verdict"))
        counts[truth, said] = counts.get((truth, said), 0) + 1
    return counts


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if values else float("nan")
