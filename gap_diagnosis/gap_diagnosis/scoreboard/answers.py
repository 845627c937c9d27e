"""A case with its answer, and what the answer got right."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gap_diagnosis.blind_check.judging import accepts, claims, is_named, named_claim, quiet, size_parameter, wrong_names

__all__ = ["ABOVE", "Answer"]

ABOVE = 5.0
"""Distance from which on an effect counts as above its limit."""
_CLAIMED = 0.5
_WORTH = 0.05  # of the gap
_Z90 = 1.645


@dataclass(frozen=True, kw_only=True)
class Answer:
    """One case, diagnosed.

    Attributes:
        case, generator, kind, model: which one.
        effects, outside: what was hidden, sizes by identifier and parameter.
        distances, shares: see `truths`.
        diagnosis: what is scored of diagnosis.json; verdict "failed" with a "reason" where it broke off.
        seconds: that the diagnosis took, of the processor.
    """

    case: str
    generator: str
    kind: str
    model: str
    effects: Mapping[str, Mapping[str, float]]
    outside: Mapping[str, Mapping[str, float]]
    distances: Mapping[str, float]
    shares: Mapping[str, float]
    diagnosis: Mapping[str, Any]
    seconds: float

    @property
    def key(self) -> dict[str, Any]:
        """The truth as the blind check's judging reads it."""
        kind = "outside" if self.outside else "pair" if len(self.effects) > 1 else "effect"
        return {"kind": kind, "effects": self.effects, "outside": self.outside, "excitation": "rich"}

    @property
    def above(self) -> bool:
        """Whether all that is hidden and moves readings is above its limit."""
        return all(distance >= ABOVE for distance in self.distances.values())

    @property
    def right(self) -> bool:
        """Whether it is right: all named and nothing else, nothing claimed, or "unknown" for what is outside."""
        if self.kind == "none":
            return quiet(self.diagnosis)
        if self.kind == "outside":
            return self.diagnosis.get("verdict") == "unknown"
        return all(self.named(name) for name in self.effects) and not self.wrong(_CLAIMED)

    def named(self, name: str) -> bool:
        """Whether an effect of the case is named, alone or in a group."""
        return is_named(self.key, name, self.diagnosis)

    def wrong(self, least: float) -> list[str]:
        """Return the effects claimed with at least that probability that are not in the case."""
        return wrong_names(self.key, self.diagnosis, least)

    @property
    def claimed(self) -> int:
        """How many effects are claimed."""
        return len(claims(self.diagnosis))

    @property
    def worthy(self) -> list[str]:
        """The effects that make more than a twentieth of the gap."""
        return [name for name in self.effects if self.shares.get(name, 0.0) > _WORTH]

    def candidates(self) -> list[tuple[float, bool]]:
        """Return the stated probability of every candidate above 0.05, and whether it is in the case."""
        told = self.diagnosis.get("candidates") or []
        return [
            (float(each["probability"]), accepts(self.key, str(each["id"])))
            for each in told
            if each["probability"] >= 0.05 and each["id"] not in ("none", "unknown")
        ]

    def sizes(self) -> list[tuple[float, float, bool]]:
        """Return (true size, error over it, whether the 90 % interval covers) of claims under their own name."""
        found = []
        for name, sizes in self.effects.items():
            claim = named_claim(self.key, name, self.diagnosis)
            if claim is None or claim["id"] != name:
                continue
            parameter = size_parameter(self.key, name)
            told = (claim.get("parameters") or {}).get(parameter)
            if told is not None and told.get("std"):
                error = float(told["value"]) - float(sizes[parameter])
                found.append((sizes[parameter], abs(error / sizes[parameter]), abs(error) <= _Z90 * float(told["std"])))
        return found

    def share_errors(self) -> list[tuple[float, bool]]:
        """Return (|error| of the stated share, whether its interval covers) of every cause that is in the case."""
        causes = (self.diagnosis.get("budget") or {}).get("causes") or []
        known = [(each, self.shares[each["id"]]) for each in causes if each["id"] in self.shares]
        return [(abs(each["share"] - true), each["interval"][0] <= true <= each["interval"][1]) for each, true in known]
