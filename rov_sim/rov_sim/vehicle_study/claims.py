"""The claims of section 5.2, each held against every case: confirmed or not, with the numbers that say so.

Where a claim has no number, the limit is ours and stands in the text. Intervals are 90 %, over vehicles drawn.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rov_sim.study.results import BASELINE, Results
from rov_sim.study.statistics import Interval

__all__ = ["CLAIMS", "Claim", "Finding", "found"]

CONFIRMED, REFUTED, IN_PART, NOT_TESTED = "confirmed", "not confirmed", "in part", "not tested"
_HALF, _COMPARABLE, _WELL, _SLIGHT = 0.40, 0.20, 0.10, 0.10
_DIVERGED = 1.0  # m/s
_MODELS, _OBSERVERS = ("hl", "hq"), ("ekf", "nlo", "kfnlo")
_SEEING = tuple(f"{model}-{observer}" for model in _MODELS for observer in _OBSERVERS)
_BLIND = (BASELINE, "simplified")
_TURNING = ("pitch_rate", "pitch")


class Finding(NamedTuple):
    """Verdict of a claim in one case, and its numbers in words."""

    verdict: str
    numbers: str


class Claim(NamedTuple):
    """A claim of the thesis: number and line, in words, and how it is tested on the results of one case."""

    key: str
    statement: str
    test: Callable[[Results, str], Finding]


def found(study: Results, case: str) -> dict[str, Finding]:
    """Return the finding of each claim in a case."""
    return {claim.key: claim.test(study, case) for claim in CLAIMS}


def _of(study: Results, case: str, names: tuple[str, ...]) -> list[str]:
    return [name for name in names if (name, case) in study.scores]


def _verdict(good: list[bool]) -> str:
    if not good:
        return NOT_TESTED
    return CONFIRMED if all(good) else (IN_PART if any(good) else REFUTED)


def _errors_halved(study: Results, case: str) -> Finding:
    if len(_of(study, case, (BASELINE, "dead-zone"))) < 2:
        return Finding(NOT_TESTED, "")
    ratios = {name: study.normalised("dead-zone", case, name) for name in _TURNING}
    down = all(x.high < 1.0 for x in ratios.values())
    reached = min(x.value for x in ratios.values()) <= 1.0 - _HALF
    told = ", ".join(f"{name.replace('_', ' ')} {_change(x)}" for name, x in ratios.items())
    return Finding(CONFIRMED if down and reached else (IN_PART if down else REFUTED), f"against the table: {told}")


def _velocity_comparable(study: Results, case: str) -> Finding:
    if len(_of(study, case, (BASELINE, "dead-zone"))) < 2:
        return Finding(NOT_TESTED, "")
    x = study.normalised("dead-zone", case, "surge")
    good = abs(x.value - 1.0) <= _COMPARABLE
    return Finding(CONFIRMED if good else REFUTED, f"surge against the table: {_change(x)}")


def _velocity_tracked(study: Results, case: str) -> Finding:
    here = _of(study, case, (*_BLIND, *_SEEING))
    if not set(_SEEING) & set(here):
        return Finding(NOT_TESTED, "")
    errors = {s: study.mean(s, case, "surge") for s in here}
    told = ", ".join(f"{s} {_percent(x)}" for s, x in errors.items())
    return Finding(_verdict([x.high <= _WELL for x in errors.values()]), f"error of surge: {told}")


def _less(study: Results, case: str, pairs: list[tuple[str, str]], name: str) -> tuple[list[Interval], str]:
    """Return the differences of a score over pairs of strategies that are there, and in words."""
    here = [(a, b) for a, b in pairs if len(_of(study, case, (a, b))) == 2]
    d = [study.difference(a, b, case, name) for a, b in here]
    told = "; ".join(f"{a} less {b} {_points(x)}" for (a, b), x in zip(here, d, strict=True))
    return d, told


_EKF_PAIRS = [(f"{m}-ekf", f"{m}-{o}") for m in _MODELS for o in ("nlo", "kfnlo")]
_KFNLO_PAIRS = [(f"{m}-kfnlo", f"{m}-nlo") for m in _MODELS]


def _ekf_best(study: Results, case: str) -> Finding:
    d, told = _less(study, case, _EKF_PAIRS, "pitch")
    return Finding(_verdict([x.high < 0.0 for x in d]), f"error of pitch: {told}" if d else "")


def _kfnlo_no_better(study: Results, case: str) -> Finding:
    d, told = _less(study, case, _KFNLO_PAIRS, "pitch")
    return Finding(_verdict([x.high >= 0.0 for x in d]), f"error of pitch: {told}" if d else "")


def _hq_slightly_better(study: Results, case: str) -> Finding:
    d, told = _less(study, case, [(f"hq-{o}", f"hl-{o}") for o in _OBSERVERS], "pitch")
    if not d or not _of(study, case, (BASELINE,)):
        return Finding(NOT_TESTED, "")
    table = study.mean(BASELINE, case, "pitch").value
    good = [x.high < 0.0 and x.value > -_SLIGHT * table for x in d]
    return Finding(_verdict(good), f"error of pitch: {told}; table {100 * table:.1f} %")


def _compensation_pays(study: Results, case: str) -> Finding:
    seeing, blind = _of(study, case, _SEEING), _of(study, case, _BLIND)
    if not seeing or not blind:
        return Finding(NOT_TESTED, "")
    good = [study.difference(s, b, case, "pitch").high < 0.0 for s in seeing for b in blind]
    told = ", ".join(f"{s} {_percent(study.mean(s, case, 'pitch'))}" for s in (*blind, *seeing))
    return Finding(_verdict(good), f"error of pitch: {told}")


def _simplified_beats_table(study: Results, case: str) -> Finding:
    if len(_of(study, case, _BLIND)) < 2:
        return Finding(NOT_TESTED, "")
    d = study.difference("simplified", BASELINE, case, "pitch")
    told = ", ".join(f"{s} {_percent(study.mean(s, case, 'pitch'))}" for s in _BLIND)
    return Finding(CONFIRMED if d.high < 0.0 else REFUTED, f"error of pitch: {told}")


def _ekf_sees_best(study: Results, case: str) -> Finding:
    d, told = _less(study, case, _EKF_PAIRS, "v_hat")
    means = ", ".join(f"{s} {_percent(study.mean(s, case, 'v_hat'))}" for s in _of(study, case, _SEEING))
    return Finding(_verdict([x.high < 0.0 for x in d]), f"error of v̂: {means}; {told}" if d else "")


def _none_diverges(study: Results, case: str) -> Finding:
    seeing = _of(study, case, _SEEING)
    largest = {s: float(np.max(study.of(s, case, "v_largest"))) for s in seeing}  # NaN: a run that left the numbers
    lost = {s: float(study.of(s, case, "lost").mean()) for s in seeing}
    told = ", ".join(f"{s} {largest[s]:.2f} m/s ({100 * lost[s]:.1f} %)" for s in seeing)
    words = f"largest error of v̂ of all runs (runs in which an angle was off by 1 rad): {told}"
    return Finding(_verdict([x <= _DIVERGED for x in largest.values()]), words if seeing else "")


def _ekf_suffices(study: Results, case: str) -> Finding:
    d, told = _less(study, case, _EKF_PAIRS, "pitch")
    if not d or not _of(study, case, (BASELINE,)):
        return Finding(NOT_TESTED, "")
    limit = _SLIGHT * study.mean(BASELINE, case, "pitch").value
    return Finding(_verdict([x.high < limit for x in d]), f"error of pitch: {told}; limit {100 * limit:.2f} %")


def _change(ratio: Interval) -> str:
    value, low, high = (100.0 * (x - 1.0) for x in ratio)
    return f"{value:+.0f} % ({low:+.0f} to {high:+.0f})"


def _percent(x: Interval) -> str:
    return f"{100 * x.value:.2g} % ({100 * x.low:.2g} to {100 * x.high:.2g})"


def _points(x: Interval) -> str:
    return f"{100 * x.value:+.2g} % ({100 * x.low:+.2g} to {100 * x.high:+.2g})"


CLAIMS = (
    Claim(
        "1",
        "Compensation of the dead zone lowers the errors of attitude and rate by up to 50 % (l. 747; here: both lower "
        f"than the table's, one by {100 * _HALF:.0f} % or more)",
        _errors_halved,
    ),
    Claim(
        "2a",
        f"… and tracks linear velocity comparably (l. 747; here: {100 * _COMPARABLE:.0f} % about the table's error)",
        _velocity_comparable,
    ),
    Claim(
        "2b",
        f"Linear velocity is well tracked by all (l. 777-783; here: error of surge of {100 * _WELL:.0f} % at most)",
        _velocity_tracked,
    ),
    Claim(
        "3a", "Output feedback with the EKF tracks better than any NLO or KFNLO (l. 769-776; here: pitch)", _ekf_best
    ),
    Claim("3b", "KFNLO is no better than NLO (l. 769-776; here: pitch)", _kfnlo_no_better),
    Claim(
        "4",
        "HQ is slightly better than HL (l. 783; here: in pitch, by less than "
        f"{100 * _SLIGHT:.0f} % of the table's error)",
        _hq_slightly_better,
    ),
    Claim(
        "5",
        "Flow compensation pays (l. 767; here: pitch, each of six against table and simplified)",
        _compensation_pays,
    ),
    Claim(
        "6", "Compensation beats the table with the HQ truth too (here: simplified in pitch)", _simplified_beats_table
    ),
    Claim("7", "The EKF estimates v best (l. 785-792)", _ekf_sees_best),
    Claim(
        "8a",
        f"No observer diverges (l. 792; here: error of v̂ of {_DIVERGED:g} m/s at most in every run)",
        _none_diverges,
    ),
    Claim(
        "8b",
        f"The EKF suffices (l. 792; here: no worse than NLO and KFNLO by {100 * _SLIGHT:.0f} % of the table's error)",
        _ekf_suffices,
    ),
)
"""In the order of the text."""
