"""Accepted effects weighed again beside those that came later: what is spare goes, what is likelier takes its place."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.descent import product_of
from gap_diagnosis.vehicle.filtering import Prepared
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.settling import settled_with
from gap_diagnosis.vehicle.stage import log_prior
from gap_diagnosis.vehicle.unknowns import Key

__all__ = ["Rivals", "exchanged", "spare_of"]

Rivals = tuple[tuple[float, Refined], ...]
"""Of an accepted effect, with their log odds against it, best first."""
_BETTER = float(np.log(rules.SUSPECTED))
"""Log odds from which on a rival takes the place of an accepted effect."""


def spare_of(
    model: Model, runs: list[Prepared], fit: Fit, free: dict[Key, float], tried: Sequence[Hypothesis]
) -> int | None:  # fmt: skip
    """Return the place of an accepted effect that is no longer worth its odds beside the last one; None: all are.

    The last one may explain all that an earlier one stood for, as a weight at a place does the shift of the centre.
    """
    on, numbers = fit.effects, len(free)
    screen = Screen(model=model, runs=runs, values={})
    odds = {}
    for k, a in enumerate(on[:-1]):
        if a.hypothesis.switch:
            continue
        rest, columns = _all_but(fit, k, numbers)
        less = Problem(screen=screen, nuisances=free, effects=tuple(each.hypothesis for each in rest))
        again = less.fit(fit.moved, [each.sizes for each in rest], columns, product_of(columns))
        odds[k] = fit.log_evidence - again.log_evidence + log_prior(a.hypothesis, tried)
    least = min(odds, key=lambda k: odds[k], default=None)
    return least if least is not None and odds[least] < np.log(rules.CLAIM) else None


def exchanged(
    model: Model, logs: Sequence[VehicleLog], runs: list[Prepared], fit: Fit, free: dict[Key, float],
    tried: Sequence[Hypothesis], rivals: Sequence[Rivals], told: Callable[[str], None],
) -> tuple[tuple[list[Prepared], Fit], list[Rivals]]:  # fmt: skip
    """Return recordings and fit with the rival in place of an accepted effect that is likelier beside all that is on
    now, and rivals of each, weighed again; as they are where none is."""
    rivals = _weighed_again(model, runs, fit, free, tried, rivals)
    k = max(range(len(rivals)), key=lambda k: rivals[k][0][0] if rivals[k] else -np.inf)
    if not rivals[k] or rivals[k][0][0] < _BETTER:
        return (runs, fit), rivals
    (gain, better), *others = rivals[k]
    told(f"in place of {fit.effects[k].hypothesis.words}, by {gain:.1f}: {better.hypothesis.words}")
    rivals[k] = tuple((odds - gain, each) for odds, each in ((0.0, fit.effects[k]), *others))
    effects = [better if j == k else a for j, a in enumerate(fit.effects)]
    return settled_with(effects, model, logs, free, runs, fit.values), rivals


def _weighed_again(
    model: Model, runs: list[Prepared], fit: Fit, free: dict[Key, float], tried: Sequence[Hypothesis],
    rivals: Sequence[Rivals],
) -> list[Rivals]:  # fmt: skip
    """Return the rivals of each accepted effect with their log odds against it beside all that is on now, best first.

    When one is accepted the next ones are still missing, and numbers and noises make up for them: a shift of the centre
    of mass was a payload, by 400, while the IMU's delay was not settled.
    """
    on, screen = fit.effects, Screen(model=model, runs=runs, values={})
    found = []
    for k, own in enumerate(on):
        rest, columns = _all_but(fit, k, len(free))
        product, again, taken = product_of(columns), [], {a.hypothesis.place for a in rest}
        for _, rival in rivals[k][: rules.REFINED_BACK]:
            if rival.hypothesis.place in taken or rival.hypothesis.error == own.hypothesis.error:
                continue
            effects = (*(a.hypothesis for a in rest), rival.hypothesis)
            problem = Problem(screen=screen, nuisances=free, effects=effects)
            there = problem.fit(fit.moved, [*(a.sizes for a in rest), rival.sizes], columns, product)
            if there.log_evidence > fit.log_evidence - rules.FAR_BEHIND:
                there = problem.fit(there.moved, [a.sizes for a in there.effects])
            prior = log_prior(rival.hypothesis, tried) - log_prior(own.hypothesis, tried)
            again.append((there.log_evidence - fit.log_evidence + prior, there.effects[-1]))
        found.append(tuple(sorted(again, key=lambda each: -each[0])))
    return found


def _all_but(fit: Fit, k: int, numbers: int) -> tuple[list[Refined], tuple[NDArray[np.float32], ...]]:
    """Return the effects of a fit but the k-th, and the columns of so many uncertain numbers and of these effects."""
    ends = np.cumsum([numbers, *(len(a.sizes) for a in fit.effects)])
    kept = np.delete(np.arange(ends[-1]), np.arange(ends[k], ends[k + 1]))
    return [a for j, a in enumerate(fit.effects) if j != k], tuple(c[:, kept] for c in fit.columns)
