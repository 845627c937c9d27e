"""Opened cases: what was hidden against what was said, and the table of them all."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gap_diagnosis.blind_check.statistics import Share, calibration_error
from gap_diagnosis.vehicle.hypotheses import described

__all__ = ["TWINS", "differences", "scored", "table"]

TWINS: tuple[frozenset[str], ...] = (
    frozenset({"thrust_loss", "propeller_fouling", "water_unloaded"}),
    frozenset({"throttle_gain", "viscous_friction"}),
    frozenset({"thruster_polarity", "throttle_gain"}),
)
"""Effects that these models cannot tell apart: on the same thruster either name counts."""


BLOCKS = {
    "lift": ("body",), "leak": ("body",), "breathing_thrust": ("body", "thrusters"), "sliding_water": ("body",),
    "moving_arm": ("body",), "vibration": ("sensor",),
}  # fmt: skip
"""Where what is hidden from outside the library acts."""
_NEAR = 1.0
"""[s] Beyond its interval within which an onset is right."""
ALWAYS = ("thruster_swap", "thruster_polarity", "thruster_failure")


def _same(hidden: Mapping[str, Any], said: Mapping[str, Any]) -> bool:
    place = all(said.get(k) == hidden.get(k) for k in ("thruster", "other", "axis") if hidden.get(k) is not None)
    name = said["id"] == hidden["id"] or any({said["id"], hidden["id"]} <= twins for twins in TWINS)
    return name and place and _same_onset(hidden.get("since"), said.get("since"))


def _same_onset(hidden: Mapping[str, Any] | None, said: Mapping[str, Any] | None) -> bool:
    """Return whether what was there all along is said to be so, or what began to be so within its interval, `_NEAR`."""
    if hidden is None or said is None:
        return hidden is said
    where, (first, last) = all(said[k] == hidden[k] for k in ("recording", "lasts")), said["interval_s"]
    return where and first - _NEAR <= hidden["time_s"] <= last + _NEAR


def scored(hidden: Sequence[Mapping[str, Any]], outside: str, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the marks of one case; hidden: id, place and sizes of each effect, and
    `since` as diagnosis.json has it where it begins in mid-run."""
    said = content["effects"] if content["verdict"] == "effect" else []
    sure = [e for e in said if e["probability"] >= 0.8]
    hits = [h for h in hidden if any(_same(h, e) for e in said)]
    within = [
        h for h in hidden if any(_same(h, e) or any(_same(h, r) for r in e["indistinguishable_from"]) for e in said)
    ]
    wrong = [e for e in sure if not any(_same(h, e) for h in hidden)]
    marks: dict[str, Any] = {
        "kind": "outside" if outside else ("none", "one", "pair")[min(len(hidden), 2)],
        "verdict": content["verdict"],
        "right": len(hits) == len(hidden) and len(said) == len(hidden) and not outside,
        "within": len(within) == len(hidden),
        "hits": len(hits),
        "wrong_sure": len(wrong),
        "claims": len(said),
        "said": [{k: e.get(k) for k in ("id", "thruster", "other", "axis", "since", "probability")} for e in said],
        "thruster": None,
        "sizes": [],
    }
    for h in hidden:
        for e in said:
            if e["id"] == h["id"] and h.get("thruster") is not None:
                marks["thruster"] = e["thruster"] == h["thruster"]
            if _same(h, e) and e["id"] == h["id"]:
                for name, value in h["sizes"].items():
                    if name in e["parameters"] and abs(value) > 0.0:
                        found = e["parameters"][name]
                        marks["sizes"].append([value, found["value"], found["std"]])
    if not hidden and not outside:
        marks["right"] = content["verdict"] in ("no_gap", "parameters")
    marks["block"] = False
    if outside:
        marks["right"] = content["verdict"] == "unknown"
        marks["block"] = marks["right"] or (
            bool(said) and all(described(e["id"]).block in BLOCKS[outside] for e in said)
        )
    return marks


def _share(hits: int, of: int) -> str:
    """Return a share with its 95 % interval (Wilson)."""
    if of == 0:
        return "– (0 cases)"
    found = Share(hits, of)
    low, high = found.interval
    return f"{100 * found.value:.0f} % ({hits}/{of}; {100 * low:.0f} to {100 * high:.0f})"


def table(cases: Sequence[Mapping[str, Any]]) -> list[tuple[str, str]]:
    """Return (figure, value) rows over opened cases."""

    def of(kind: str) -> list[Mapping[str, Any]]:
        return [c["marks"] for c in cases if c["marks"]["kind"] == kind]

    one, none, pair, outside = of("one"), of("none"), of("pair"), of("outside")
    every = [c["marks"] for c in cases]
    shown = [c["marks"] for c in cases if c["marks"]["kind"] == "one" and all(c.get("shown", ()))]
    poor = [c["marks"] for c in cases if "tachometer" in c["missing"] and c["marks"]["kind"] == "one"]
    named = [(e["probability"], _is_hidden(e, c["hidden"])) for c in cases for e in c["marks"]["said"]]
    wired = [c["marks"] for c in cases if len(c["hidden"]) == 1 and c["hidden"][0]["id"] in ALWAYS]
    places = [m["thruster"] for m in every if m["thruster"] is not None]
    sizes = np.array([s for m in every for s in m["sizes"]]).reshape(-1, 3)
    errors = np.abs(sizes[:, 1] - sizes[:, 0]) / np.abs(sizes[:, 0]) if len(sizes) else np.zeros(0)
    covered = int(np.sum(np.abs(sizes[:, 1] - sizes[:, 0]) <= 1.645 * sizes[:, 2])) if len(sizes) else 0
    return [
        ("one effect hidden: it alone is named, in its place", _share(sum(m["right"] for m in one), len(one))),
        (
            "the same, of those large enough to be claimed beside what is uncertain",
            _share(sum(m["right"] for m in shown), len(shown)),
        ),
        (
            "one effect hidden: it is among what is named or what that cannot be told from",
            _share(sum(m["within"] for m in one), len(one)),
        ),
        (
            "a wrong effect or place named with p of 0.8 or more, all cases",
            _share(sum(m["wrong_sure"] > 0 for m in every), len(every)),
        ),
        ("thruster right, given the effect", _share(sum(places), len(places))),
        ("an effect claimed where there is none", _share(sum(m["claims"] > 0 for m in none), len(none))),
        ("outside the library: unknown", _share(sum(m["right"] for m in outside), len(outside))),
        (
            "outside: unknown, or all that is named is in the right block",
            _share(sum(m["block"] for m in outside), len(outside)),
        ),
        ("swap, polarity, dead thruster: right", _share(sum(m["right"] for m in wired), len(wired))),
        ("both of a pair", _share(sum(m["hits"] == 2 for m in pair), len(pair))),
        ("no velocity log, tachometer, battery: right", _share(sum(m["right"] for m in poor), len(poor))),
        (
            "median error of a size",
            f"{100 * float(np.median(errors)):.1f} % ({len(errors)} sizes)" if len(errors) else "–",
        ),
        ("90 % intervals that hold the size", _share(covered, len(sizes))),
        (
            "calibration error of what is named",
            f"{calibration_error([p for p, _ in named], [hit for _, hit in named])[0]:.2f} ({len(named)} names)"
            if named
            else "–",
        ),
    ]


def _is_hidden(said: Mapping[str, Any], hidden: Sequence[Mapping[str, Any]]) -> bool:
    return any(_same(h, said) for h in hidden)


def differences(before: Sequence[Mapping[str, Any]], after: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return rows (seed, hidden, before, after, better, worse or other) of cases that are answered otherwise."""
    former = {c["seed"]: c for c in before if "marks" in c}
    rows = []
    for case in after:
        old = former.get(case["seed"])
        if old is None or "marks" not in case:
            continue
        says = [_says(each["marks"]) for each in (old, case)]
        right = [bool(each["marks"]["right"]) for each in (old, case)]
        if says[0] != says[1] or right[0] != right[1]:
            change = "better" if right[1] > right[0] else "worse" if right[1] < right[0] else "other"
            hidden = ", ".join(_words(h) for h in case["hidden"]) or case["outside"] or "nothing"
            rows.append((str(case["seed"]), hidden, *says, change))
    return rows


def _words(effect: Mapping[str, Any]) -> str:
    place = [str(effect[k]) for k in ("thruster", "other", "axis") if effect.get(k) is not None]
    return " ".join((effect["id"], *place))


def _says(marks: Mapping[str, Any]) -> str:
    named = ", ".join(_words(e) for e in marks["said"])
    return f"{marks['verdict']}: {named}" if named else str(marks["verdict"])
