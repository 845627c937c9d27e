"""A vehicle's diagnosis as content for `diagnosis.json`, which other programs read."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.conventions import Conventions
from gap_diagnosis.vehicle.how_far import FORESEEN, Errors, Share
from gap_diagnosis.vehicle.hypotheses import Hypothesis, described, hypotheses
from gap_diagnosis.vehicle.log import VehicleLog, told_in
from gap_diagnosis.vehicle.next_experiment import NextExperiment
from gap_diagnosis.vehicle.oddities import Logged
from gap_diagnosis.vehicle.screening import READINGS
from gap_diagnosis.vehicle.search import Found
from gap_diagnosis.vehicle.verdict import Claim, Verdict
from rov_sim.vehicle.effects.body_axes import BODY_AXES

__all__ = ["PROGRAMME", "content_of", "where_of"]

PROGRAMME = "next_experiment"
"""Folder of the run whose throttles are to be played next."""


def place_of(h: Hypothesis) -> dict[str, Any]:
    """Return identifier and place of a hypothesis, and its name in words."""
    since = h.since and {
        "recording": h.since.name, "time_s": round(h.since.time, 3),
        "interval_s": [round(end, 3) for end in h.since.interval], "lasts": h.since.lasts,
    }  # fmt: skip
    return {
        "id": h.effect, "thruster": h.thruster, "other": h.other, "axis": h.axis,
        "sensor": h.sensor or h.read_by or None, "kind": h.kind, "since": since, "words": h.words,
    }  # fmt: skip


def _class(h: Hypothesis, shrink: Share | None, told: Errors | None) -> str | None:
    """Return whether numbers far beyond their deviations do as well (parametric); None where free runs show no gap."""
    if h.switch:
        return "structural"
    if told is None or not told.budget:
        return None
    return "structural" if shrink is not None and shrink.low > 0.0 else "parametric"


def _effect(claim: Claim, shrink: Share | None, told: Errors | None) -> dict[str, Any]:
    h = claim.refined.hypothesis
    rows = zip(h.parameters, claim.refined.told, claim.refined.deviations, strict=True)
    return {
        **place_of(h),
        "channel": None,
        "class": _class(h, shrink, told),
        "probability": round(claim.probability, 4),
        "group_probability": round(claim.group, 4),
        "parameters": {n: {"value": s, "std": d, "unit": h.units[n]} for n, s, d in rows},
        "indistinguishable_from": [{**place_of(r), "probability": round(p, 4)} for p, r in claim.rivals],
        "nameless": [{"axis": k[1], "regime": k[2], "probability": round(p, 4)} for p, k in claim.nameless],
        "shrink": None if shrink is None else shrink.share,
        "shrink_interval": None if shrink is None else [shrink.low, shrink.high],
    }


def _logged(found: Logged) -> dict[str, Any]:
    return {
        "id": found.effect, "thruster": found.thruster, "other": None, "axis": None, "sensor": found.sensor,
        "kind": None, "since": None,
        "channel": None, "class": "structural",
        "words": found.words,
        "probability": round(found.probability, 4),
        "group_probability": round(found.probability, 4),
        "parameters": {found.parameter: {"value": found.size, "std": found.deviation, "unit": found.unit}},
        "indistinguishable_from": [],
        "nameless": [],
        "shrink": None,
        "shrink_interval": None,
    }  # fmt: skip


def where_of(verdict: Verdict) -> list[dict[str, Any]]:
    """Return blocks with shares that sum to 1: of each claim, or of what is nearest, or of a nameless dependence."""
    rows: list[dict[str, Any]] = []
    for claim in verdict.claims:
        h = claim.refined.hypothesis
        rows.append({"block": described(h.effect).block, "thruster": h.thruster, "axis": h.axis, "weight": 1.0})
    rows += [
        {"block": described(each.effect).block, "thruster": each.thruster, "axis": None, "weight": 1.0}
        for each in verdict.logged
    ]
    for gain, (_, axis, feature) in verdict.left[:2]:
        rows.append(
            {
                "block": "sensor" if axis in READINGS else "body",
                "thruster": None,
                "axis": axis,
                "regime": feature,
                "weight": min(gain / 50.0, 1.0),
            }
        )
    if not rows and verdict.name == "unknown":
        worst = int(np.argmax(verdict.wrench / np.array([1.0, 1.0, 1.0, 0.2, 0.2, 0.2])))
        rows.append({"block": "body", "thruster": None, "axis": BODY_AXES[worst], "regime": "random", "weight": 1.0})
    total = sum(row["weight"] for row in rows) or 1.0
    return [
        {**{k: v for k, v in row.items() if k != "weight"}, "share": round(row["weight"] / total, 3)} for row in rows
    ]


def content_of(
    verdict: Verdict, found: Found | None, errors: Sequence[Errors], conventions: Conventions | None,
    logs: Sequence[VehicleLog], provenance: dict[str, Any], proposed: NextExperiment | None = None,
    asked: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Return the content of diagnosis.json; keys as those of a single thruster's, beside `wiring` and `hidden`.

    asked: whether a programme was asked for: then there is no other advice where none helps.
    """
    channels: dict[str, Any] = {}
    for each in errors:
        for name, unit in FORESEEN.items():
            steps = {"as_is": each.as_is, "retuned": each.retuned, "with_effect": each.with_effect}
            values = {k: _number(v[name]) for k, v in {**steps, "noise_floor": each.foreseen}.items()}
            if not np.isnan(each.as_is[name]):
                channels[f"rov/{name} after {each.horizon:g} s"] = {"unit": unit, **values}
    told = next((each for each in errors if each.budget), errors[0] if errors else None)
    shrinks: dict[Hypothesis, Share | None] = {}
    if found is not None and told is not None:
        shrinks = {a.hypothesis: s for a, s in zip(found.stages[-1].accepted, told.shrinks, strict=True)}
    claims = [_effect(c, shrinks.get(c.refined.hypothesis), told) for c in verdict.claims]
    effects = claims + [_logged(each) for each in verdict.logged]
    return {
        "verdict": verdict.name,
        "summary": verdict.summary,
        "gap": {**_gap(told), "channels": channels},
        "where": where_of(verdict),
        "effects": effects if verdict.name != "unknown" else [],
        "suspected": effects if verdict.name == "unknown" else [],
        "resembles": claims if verdict.name == "unknown" else [],
        "candidates": [
            {**place_of(h), "probability": round(float(1.0 / (1.0 + np.exp(-np.clip(o, -50, 50)))), 4)}
            for o, h in verdict.candidates
        ],
        "p_none": verdict.p_none,
        "p_unknown": verdict.p_unknown,
        "budget": {
            "horizons": [each.horizon for each in errors],
            **_budget(found, told),
            "unexplained_wrench": verdict.wrench.tolist(),
        },
        "retuned_parameters": {
            ".".join(map(str, key[1:])): {"deviations": moved, "std": left} for key, moved, left in verdict.shifted
        },
        "unexplained": [{"signal": axis, "depends_on": on, "gain": gain} for gain, (_, axis, on) in verdict.left],
        "hidden": [{**place_of(h), "least": size, "unit": h.units[h.parameters[0]]} for h, size in _hidden(verdict)],
        "not_tried": _not_tried(found, told_in(logs)),
        "wiring": None if conventions is None else conventions.content(),
        "sensors": told_in(logs),
        "log": [each.sentence for each in verdict.logged],
        "warnings": list(dict.fromkeys(note for log in logs for note in (*log.notes, log.left_out) if note)),
        "next_experiment": None if asked and proposed is None else _next(verdict, conventions, proposed),
        "provenance": provenance,
    }


def _gap(told: Errors | None) -> dict[str, Any]:
    """Return the error of free runs over what is foreseen, the share that effects close, and of whose numbers it is."""
    if told is None or not told.steps:
        return {"total": None, "shrink": None, "left_out": None if told is None else told.left_out}
    as_is, retuned, *_ = told.steps
    total = {"as_is": as_is, "retuned": retuned, "with_effect": told.steps[-1], "noise_floor": 1.0}
    closed = [share.share for share in told.shrinks if share is not None]
    return {"total": total, "shrink": sum(closed) if closed else None, "left_out": told.left_out}


def _budget(found: Found | None, first: Errors | None) -> dict[str, Any]:
    """Return where the gap goes over the shortest horizon at which there is one, or why it cannot be said."""
    if found is None or first is None:
        nothing = "No recording is long enough for a free run." if found else "Nothing was fitted."
        return {"horizon": None, "parameters": None, "causes": [], "unexplained": None, "left_out": [],
                "why_not": nothing}  # fmt: skip
    accepted = found.stages[-1].accepted
    tuned, *causes, rest = first.budget or (None,) * (len(accepted) + 2)
    named = [place_of(a.hypothesis) for a in accepted]
    steps = ["as_is", "retuned", *(a.hypothesis.words for a in accepted[len(accepted) + 2 - len(first.steps) :])]
    return {
        "horizon": first.horizon,
        "parameters": _share(tuned),
        "causes": [{**place, **(_share(c) or {})} for place, c in zip(named, causes, strict=True)],
        "unexplained": _share(rest),
        "why_not": None
        if first.budget
        else "Errors of free runs of the model as it is are not surely above what "
        "noise and the random wrench of calm water make: there is no gap to share out.",
        "left_out": [{"step": name, "rms": size} for name, size in zip(steps, first.steps, strict=False)],
    }


def _share(share: Share | None) -> dict[str, Any] | None:
    return None if share is None else {"share": share.share, "interval": [share.low, share.high]}


def _not_tried(found: Found | None, there: Mapping[str, bool]) -> list[str]:
    """Return the effects that were not looked for: their sensor is missing, or they were left out."""
    if found is None:
        return []
    every = hypotheses(found.stages[-1].screen.model, dict.fromkeys(there, True))
    return sorted({h.effect for h in every} - {h.effect for h in found.tried})


def _hidden(verdict: Verdict) -> list[tuple[Hypothesis, float]]:
    return [(h, size) for h, size in verdict.hidden if size > h.most]


def _number(value: float) -> float | None:
    return None if not np.isfinite(value) else float(value)


def _next(
    verdict: Verdict, conventions: Conventions | None, proposed: NextExperiment | None
) -> dict[str, Any] | None:  # fmt: skip
    if proposed is not None:
        return _proposed(proposed)
    unsure = verdict.name in ("cannot_tell", "unknown", "not_enough_data") or any(c.rivals for c in verdict.claims)
    silent = conventions is not None and bool({*conventions.wiring.silent} - {*conventions.wiring.dead})
    if not (unsure or silent):
        return None
    return {
        "kind": "pulses",
        "why": "each thruster alone, both ways, tells thrusters from the hull and from each other",
    }


def _proposed(proposed: NextExperiment) -> dict[str, Any]:
    programme = proposed.programme
    apart, pairs = sum(s.told for s in proposed.separates), len(proposed.separates)
    told = f"it tells {apart} of {pairs} pairs apart"
    most = max((s.added for s in proposed.separates), default=0.0)
    if most == 0.0:
        told = "it tells no pair apart" if pairs else ""
    elif not apart:
        times = int(np.ceil((rules.TOLD_APART / most) ** 2))
        told = f"it adds {most:.1f} of the {rules.TOLD_APART:g} σ that tell a pair apart: played {times} times it does"
    now, then = proposed.hidden_now, proposed.hidden_then
    shown = f"of {now} effects that could not be shown at any size it leaves {then}" if now else ""
    return {
        "kind": programme.words,
        "why": "; ".join(filter(None, (told, shown))),
        "file": PROGRAMME,
        "separates": [
            {
                "candidates": [place_of(s.first), place_of(s.second)], "distance": round(s.then, 2),
                "distance_now": round(s.now, 2), "added": round(s.added, 2),
            }
            for s in proposed.separates
        ],
        "hidden": proposed.hidden_then,
        "hidden_now": proposed.hidden_now,
        "duration_s": round(programme.duration, 3),
        "dry_run": asdict(programme.dry_run),
    }  # fmt: skip
