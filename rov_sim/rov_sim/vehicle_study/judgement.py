"""From the findings of a claim in many cases to one verdict, and what it depends on."""

from collections.abc import Mapping
from dataclasses import fields
from typing import NamedTuple

from rov_sim.study.results import Results
from rov_sim.vehicle_study.assumptions import Assumptions
from rov_sim.vehicle_study.claims import CLAIMS, CONFIRMED, IN_PART, NOT_TESTED, REFUTED, Claim, Finding, found
from rov_sim.vehicle_study.plan import Case

__all__ = ["Judgement", "judged"]

_WORDS = {
    "vehicle": "vehicle", "hull": "hull", "layout": "places of the thrusters", "truth": "true thrusters",
    "gain": "gains", "speed_gain": "k_u", "rate": "rate", "feedback": "feedback",
    "observers": "what observers are told", "inflow": "inflow told or not", "beliefs": "parameters believed",
    "current_north": "current", "current_east": "current", "deviation": "deviations",
    "largest_throttle": "limit of the throttle", "attitude_error": "form of the attitude error",
    "speed_noise": "noise of the speed",
}  # fmt: skip


class Judgement(NamedTuple):
    """A claim's verdict over all cases.

    verdict: "confirmed", "not confirmed", "in part" or "depends"; depends: on what, in words; findings: of the cases in
    which it was tested.
    """

    claim: Claim
    verdict: str
    depends: tuple[str, ...]
    findings: Mapping[str, Finding]

    def share(self, cases: Mapping[str, Case], group: str) -> tuple[int, int]:
        """Return in how many cases of a group the claim was confirmed, and of how many."""
        here = [f.verdict for name, f in self.findings.items() if cases[name].group == group]
        return here.count(CONFIRMED), len(here)


def judged(study: Results, cases: Mapping[str, Case]) -> list[Judgement]:
    """Return the judgement of each claim over the cases that the study has."""
    by_case = {name: found(study, name) for name in study.references}
    out = []
    for claim in CLAIMS:
        tested = {name: each[claim.key] for name, each in by_case.items() if each[claim.key].verdict != NOT_TESTED}
        verdicts = {f.verdict for f in tested.values()}
        if not tested:
            out.append(Judgement(claim, NOT_TESTED, (), tested))
        elif len(verdicts) == 1:
            out.append(Judgement(claim, verdicts.pop(), (), tested))
        else:
            verdict = "depends" if CONFIRMED in verdicts else (IN_PART if IN_PART in verdicts else REFUTED)
            out.append(Judgement(claim, verdict, _what_decides(tested, cases), tested))
    return out


def _what_decides(tested: Mapping[str, Finding], cases: Mapping[str, Case]) -> tuple[str, ...]:
    """Return what differs between neighbouring cases of different verdicts.

    Neighbours are two cases between which no third lies: none that differs from the first in a part only of what the
    second differs in.
    """
    names = list(tested)
    apart = {(a, b): _differences(cases[a].assumptions, cases[b].assumptions) for a in names for b in names}
    reasons: dict[str, None] = {}
    for a in names:
        for b in names[names.index(a) + 1 :]:
            if tested[a].verdict == tested[b].verdict or any(
                apart[a, c] < apart[a, b] and apart[c, b] < apart[a, b] for c in names if c not in (a, b)
            ):
                continue
            told = dict.fromkeys(_WORDS.get(name, name.replace("_", " ")) for name in sorted(apart[a, b]))
            reasons[" with ".join(told)] = None
    return tuple(reasons)


def _differences(one: Assumptions, other: Assumptions) -> frozenset[str]:
    return frozenset(f.name for f in fields(Assumptions) if getattr(one, f.name) != getattr(other, f.name))
