"""The scoreboard's figures per class and generator, with Wilson's intervals."""

import math
from collections.abc import Callable, Sequence

import numpy as np

from gap_diagnosis.blind_check.statistics import Share, calibration_error, share
from gap_diagnosis.scoreboard.answers import ABOVE, Answer
from gap_diagnosis.scoreboard.case import KINDS

__all__ = ["FIGURES", "differences", "table"]

_CONFIDENT = 0.8
Figure = Callable[[Sequence[Answer]], str]


def _of(kind: str, test: Callable[[Answer], bool], *, above: bool = False) -> Figure:
    return lambda answers: _told(share([test(a) for a in answers if a.kind == kind and (not above or a.above)]))


def _told(found: Share) -> str:
    if not found.of:
        return "-"
    low, high = found.interval
    return f"{100 * found.value:.0f} % ({found.hits}/{found.of}; {100 * low:.0f} to {100 * high:.0f})"


def _claims_right(answers: Sequence[Answer]) -> str:
    many = [a for a in answers if a.kind == "many"]
    good = sum(a.claimed - len(a.wrong(0.0)) for a in many)
    return _told(Share(good, sum(a.claimed for a in many)))


def _worthy_named(answers: Sequence[Answer], least: float = 0.0) -> str:
    many = [(a, name) for a in answers if a.kind == "many" for name in a.worthy]
    return _told(share([a.named(name) for a, name in many if a.distances.get(name, math.inf) >= least]))


def _calibration(answers: Sequence[Answer]) -> str:
    pairs = [pair for a in answers for pair in a.candidates()]
    return (
        f"{calibration_error([p for p, _ in pairs], [hit for _, hit in pairs])[0]:.2f} ({len(pairs)})" if pairs else "-"
    )


def _median(values: Sequence[float], form: str) -> str:
    return f"{np.median(values):{form}} ({len(values)})" if values else "-"


FIGURES: dict[str, Figure] = {
    "one effect: right": _of("one", lambda a: a.right),
    "one effect above its limit: right": _of("one", lambda a: a.right, above=True),
    "two effects: both": _of("two", lambda a: a.right),
    "two effects above their limits: both": _of("two", lambda a: a.right, above=True),
    "none: right": _of("none", lambda a: a.right),
    "none: an effect is claimed": _of("none", lambda a: a.claimed > 0),
    "many: claims right": _claims_right,
    "many: causes worth > 5 % of the gap named": _worthy_named,
    "many: of these, above their limits": lambda answers: _worthy_named(answers, ABOVE),
    "outside: flagged": _of("outside", lambda a: a.right),
    "wrong name with 0.8 or more": lambda answers: _told(share([bool(a.wrong(_CONFIDENT)) for a in answers])),
    "calibration error of candidates": _calibration,
    "size: median error": lambda answers: _median([e for a in answers for _, e, _ in a.sizes()], ".3f"),
    "size: 90 % intervals cover": lambda answers: _told(share([c for a in answers for *_, c in a.sizes()])),
    "share: median error": lambda answers: _median([e for a in answers for e, _ in a.share_errors()], ".3f"),
    "share: 90 % intervals cover": lambda answers: _told(share([c for a in answers for _, c in a.share_errors()])),
    "seconds, median": lambda answers: _median([a.seconds for a in answers], ".1f"),
    "diagnosis broke off": lambda answers: _told(share([a.diagnosis.get("verdict") == "failed" for a in answers])),
}


def table(answers: Sequence[Answer]) -> list[list[str]]:
    """Return rows: a header, then each figure for every generator and for all together."""
    generators = list(dict.fromkeys(a.generator for a in answers))
    rows = [["figure", *generators, "all"]]
    for title, figure in FIGURES.items():
        parts = [figure([a for a in answers if a.generator == name]) for name in generators]
        rows.append([title, *parts, figure(answers)])
    return rows


def differences(before: Sequence[Answer], after: Sequence[Answer]) -> list[list[str]]:
    """Return rows: the cases whose answer is right in one of two runs and not in the other, and what each says."""
    former = {a.case: a for a in before}
    rows = [["case", "hidden", "before", "after", ""]]
    for kind in KINDS:
        for a in after:
            b = former.get(a.case)
            if a.kind == kind and b is not None and (a.right, _says(a)) != (b.right, _says(b)):
                change = "better" if a.right > b.right else "worse" if a.right < b.right else "other"
                rows.append([a.case, ", ".join({**a.effects, **a.outside}) or "nothing", _says(b), _says(a), change])
    return rows


def _says(answer: Answer) -> str:
    named = ", ".join(str(each["id"]) for each in answer.diagnosis.get("effects") or [])
    return f"{answer.diagnosis.get('verdict')}{': ' if named else ''}{named}"
