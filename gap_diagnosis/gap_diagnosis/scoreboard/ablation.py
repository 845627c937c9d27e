"""What each rule of judgement is worth: cases judged anew with one rule changed at a time."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, fields, replace
from typing import Any, NamedTuple

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.diagnosis_json import effects_of
from gap_diagnosis.investigation import Investigation, weighed_up
from gap_diagnosis.rules import RULES, Rules
from gap_diagnosis.scoreboard.answers import Answer
from gap_diagnosis.verdict import verdict_of

__all__ = ["FACTORS", "Judged", "judged_anew", "rows_of"]

FACTORS = (0.0, 0.8, 1.2, math.inf)
"""By which a rule is multiplied; at 0 and at infinity it says always or never."""
_HEALTHY = ("healthy_sensor", "healthy_colour", "healthy_push")
_FINITE = (*_HEALTHY, "tempered")
"""Rules that are scales: neither 0 nor infinity is one."""
_WEIGHED = (*_HEALTHY, "noteworthy")
"""Rules by which it is told what a set leaves."""


class Judged(NamedTuple):
    """One case under one changed rule: whether its verdict or claims changed, and what that was right before and now,
    and how many wrong names there are now.
    """

    rule: str
    factor: float
    changed: bool
    before: bool
    right: bool
    wrong: int


@contextmanager
def _changed(rule: str, value: float) -> Iterator[None]:
    held = getattr(RULES, rule)
    object.__setattr__(RULES, rule, value)
    try:
        yield
    finally:
        object.__setattr__(RULES, rule, held)


def judged_anew(found: Diagnosis, answer: Answer) -> list[Judged]:
    """Judge a diagnosis with each rule changed in turn; `answer`: the case, with what it says now."""
    investigation, log = found.investigation, found.scatters
    if investigation is None:
        return []
    out = []
    for rule in (each.name for each in fields(Rules)):
        for factor in FACTORS:
            if rule in _FINITE and (factor == 0.0 or math.isinf(factor)):
                continue
            with _changed(rule, getattr(RULES, rule) * factor):
                anew = _afresh(investigation, rule)
                verdict = verdict_of(anew, log)
                told = {"verdict": verdict.verdict, "effects": effects_of(verdict)}
            now = replace(answer, diagnosis={**answer.diagnosis, **told})
            out.append(Judged(rule, factor, _says(now) != _says(answer), answer.right, now.right, len(now.wrong(0.8))))
    return out


def _afresh(found: Investigation, rule: str) -> Investigation:
    """Return the weighed sets without what was concluded from them, but for fits in which no rule has a part."""
    weighed = weighed_up(found.search, found.offer) if rule in _WEIGHED else found
    anew = replace(weighed, _held=found._held)
    anew.__dict__["imitated"] = found.imitated
    return anew


def _says(answer: Answer) -> tuple[Any, ...]:
    told = answer.diagnosis
    return told.get("verdict"), sorted(str(each["id"]) for each in told.get("effects") or [])


def rows_of(cases: Sequence[Sequence[Judged]]) -> list[list[str]]:
    """Return a table by rule: what changes, and how many are right and wrongly named, for each factor."""
    head = ["rule", "value", *(f"x {factor:g}" for factor in FACTORS)]
    rows = [head]
    for rule, value in asdict(RULES).items():
        cells = []
        for factor in FACTORS:
            judged = [each for case in cases for each in case if (each.rule, each.factor) == (rule, factor)]
            cells.append(_cell(judged))
        rows.append([rule, f"{value:g}", *cells])
    return rows


def _cell(judged: Sequence[Judged]) -> str:
    def count(of: Callable[[Judged], bool]) -> int:
        return sum(map(of, judged))

    changed = count(lambda each: each.changed)
    if not changed:
        return "–"
    gained, lost = count(lambda e: e.right and not e.before), count(lambda e: e.before and not e.right)
    return f"{changed}: +{gained} −{lost}, wrong {sum(each.wrong for each in judged)}"
