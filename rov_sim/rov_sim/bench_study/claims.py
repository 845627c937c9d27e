"""The statements of section 5.1, each held against a study: confirmed or not, with the numbers that say so.

Where a statement has no number, the limit is ours and stands in the text. Intervals are 90 %, over thrusters drawn.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rov_sim.study.results import BASELINE, Results
from rov_sim.study.statistics import Interval, mean_interval

__all__ = ["CLAIMS", "Claim", "judged"]

_NOMINAL, _TENTH, _ONLY_EVER = 10.0, 0.1, 0.95  # N, 1, share of the runs
_LITTLE = 0.10  # of the lookup table's error
_FLOW = ("hl-ekf", "hl-nlo", "hl-kfnlo", "hq-ekf", "hq-nlo", "hq-kfnlo")


class Claim(NamedTuple):
    """What the thesis says, what the study says ("confirmed", "not confirmed", "in part", "not tested"), and why."""

    statement: str
    verdict: str
    numbers: str


def judged(study: Results, without_spikes: Results | None = None) -> list[Claim]:
    """Return all statements for a study; `without_spikes`: the same study without spikes of the velocimeter."""
    return [Claim(statement, *test(study, without_spikes)) for statement, test in CLAIMS.items()]


def _verdict(good: int, count: int) -> str:
    if count == 0:
        return "not tested"
    return "confirmed" if good == count else ("not confirmed" if good == 0 else "in part")


def _within_a_tenth(study: Results, _: Results | None) -> tuple[str, str]:
    shares, medians = {}, {}
    for s in study.strategies:
        largest = np.concatenate([study.of(s, r, "largest") for r in study.references]) / _NOMINAL
        shares[s], medians[s] = float(np.mean(largest <= _TENTH)), float(np.median(largest))
    good = sum(share >= _ONLY_EVER for share in shares.values())
    told = ", ".join(f"{s} {100 * share:.0f} % ({100 * medians[s]:.0f} %)" for s, share in shares.items())
    return _verdict(good, len(shares)), f"runs whose largest error stays below 1 N (median largest error): {told}"


def _overshoot(study: Results, _: Results | None) -> tuple[str, str]:
    if "step" not in study.references:
        return "not tested", ""
    blind = [s for s in (BASELINE, "simplified") if s in study.strategies]
    seeing = [s for s in _FLOW if s in study.strategies]
    pairs = [study.difference(b, s, "step", "overshoot").low > 0.0 for b in blind for s in seeing]
    told = ", ".join(f"{s} {_percent(study.mean(s, 'step', 'overshoot'))}" for s in (*blind, *seeing))
    return _verdict(sum(pairs), len(pairs)), f"overshoot beyond the end value, of the step: {told}"


def _ekf_best(study: Results, _: Results | None) -> tuple[str, str]:
    good, told = [], []
    for model in ("hl", "hq"):
        for other in ("nlo", "kfnlo"):
            for r in study.references:
                one, two = f"{model}-ekf", f"{model}-{other}"
                if one in study.strategies and two in study.strategies:
                    d = study.difference(one, two, r)
                    good.append(d.high < 0.0)
                    told.append(f"{model} {r} {_newton(d)} against {other}")
    return _verdict(sum(good), len(good)), "EKF less the other: " + "; ".join(told)


def _spikes(study: Results, without: Results | None) -> tuple[str, str]:
    if without is None:
        return "not tested", "needs the same study without spikes"
    good, told = [], []
    for model in ("hl", "hq"):
        added = {}
        for observer in ("ekf", "nlo", "kfnlo"):
            s = f"{model}-{observer}"
            if s in study.strategies and s in without.strategies:
                more = [study.of(s, r, "v_hat") - without.of(s, r, "v_hat") for r in study.references]
                added[observer] = np.mean(more, axis=0)
        if "ekf" not in added:
            continue
        means = {o: mean_interval(x, np.random.default_rng(study.seed)) for o, x in added.items()}
        good += [mean_interval(x - added["ekf"], np.random.default_rng(study.seed)).low > 0.0
                 for o, x in added.items() if o != "ekf"]  # fmt: skip
        told += [
            f"{model}-{o} {1e3 * m.value:.1f} mm/s ({1e3 * m.low:.1f} to {1e3 * m.high:.1f})" for o, m in means.items()
        ]
    return _verdict(sum(good), len(good)), "what the spikes add to the error of v̂: " + ", ".join(told)


def _kfnlo_no_better(study: Results, _: Results | None) -> tuple[str, str]:
    good, told = [], []
    for model in ("hl", "hq"):
        for r in study.references:
            if f"{model}-kfnlo" in study.strategies and f"{model}-nlo" in study.strategies:
                d = study.difference(f"{model}-kfnlo", f"{model}-nlo", r)
                good.append(d.high >= 0.0)
                told.append(f"{model} {r} {_newton(d)}")
    return _verdict(sum(good), len(good)), "KFNLO less NLO: " + "; ".join(told)


def _hq_little_better(study: Results, _: Results | None) -> tuple[str, str]:
    good, told = [], []
    for observer in ("ekf", "nlo", "kfnlo"):
        for r in study.references:
            one, two = f"hq-{observer}", f"hl-{observer}"
            if one in study.strategies and two in study.strategies and BASELINE in study.strategies:
                by = float(np.mean(study.of(BASELINE, r, "rmse")))
                d = Interval(*(x / by for x in study.difference(one, two, r)))
                good.append(d.high < 0.0 and d.value > -_LITTLE)
                told.append(f"{observer} {r} {100 * d.value:+.1f} % ({100 * d.low:+.1f} to {100 * d.high:+.1f})")
    return _verdict(sum(good), len(good)), "HQ less HL, of the lookup table's error: " + "; ".join(told)


def _modest(study: Results, _: Results | None) -> tuple[str, str]:
    ratios = {
        (s, r): study.normalised(s, r)
        for s in _FLOW if s in study.strategies and BASELINE in study.strategies for r in study.references
    }  # fmt: skip
    better = [x.high < 1.0 for x in ratios.values()]
    best = min(ratios.items(), key=lambda item: item[1].value, default=None)
    worst = max(ratios.items(), key=lambda item: item[1].value, default=None)
    if best is None or worst is None:
        return "not tested", ""
    ends = [f"{' '.join(k)} {x.value:.2f} ({x.low:.2f} to {x.high:.2f})" for k, x in (best, worst)]
    return _verdict(sum(better), len(better)), f"error over the lookup table's, best and worst: {ends[0]}; {ends[1]}"


def _percent(x: Interval) -> str:
    return f"{100 * x.value:.1f} % ({100 * x.low:.1f} to {100 * x.high:.1f})"


def _newton(x: Interval) -> str:
    return f"{x.value:+.2f} N ({x.low:+.2f} to {x.high:+.2f})"


CLAIMS: dict[str, Callable[[Results, Results | None], tuple[str, str]]] = {
    "Errors reach 10 % of the nominal thrust at most (here: below 1 N in 95 % of a strategy's runs)": _within_a_tenth,
    "Controllers that do not account for the flow overshoot (here: more than each that does)": _overshoot,
    "Output feedback with the EKF tracks best (here: better than NLO and KFNLO of the same model)": _ekf_best,
    "The EKF resists spikes of the velocimeter, NLO and KFNLO do not (here: the EKF's v̂ suffers less)": _spikes,
    "KFNLO is no better than NLO": _kfnlo_no_better,
    "HQ is a little better than HL (here: better, by less than 10 % of the lookup table's error)": _hq_little_better,
    "Flow compensation improves on the lookup table": _modest,
}
