"""Numbers and noises found in turn, until neither moves."""

from collections.abc import Mapping, Sequence

import numpy as np

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared, log_likelihood
from gap_diagnosis.vehicle.learning import learned_from, prepared
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.unknowns import Key

__all__ = ["likelihood", "log_evidence", "settled", "settled_from_believed", "settled_with"]


def settled(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared],
    accepted: Sequence[Refined], values: Mapping[Key, float], *, anew: bool = False,
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return the recordings with gains for noises learned where nuisances and accepted effects fit best, and that fit.

    Noises and numbers are found in turn: numbers fitted with noises that had to explain what the numbers do not are
    too near to what was believed, and noises learned there too large. anew: also with effects on, learn noises from the
    beginning, not from those of the recordings.
    """
    effects = tuple(a.hypothesis for a in accepted)
    moved = np.array([values.get(k, 0.0) / d for k, d in free.items()])
    sizes = [a.sizes for a in accepted]

    def asked(runs: list[Prepared]) -> Problem:
        return Problem(screen=Screen(model=model, runs=runs, values={}), nuisances=free, effects=effects)

    problem, nearby = asked(runs), None
    for turn in range(rules.TURNS):
        before = problem.score(moved, sizes)
        moved, sizes, columns = problem.most_likely(moved, sizes, nearby)
        after = problem.score(moved, sizes)
        if turn > 0 and after - before < rules.SETTLED:
            break
        afresh = turn == 0 and (anew or not accepted)
        nearby = None if afresh else columns  # noises that are learned anew change too much
        start = None if afresh else learned_from(runs)
        there = {k: float(s) * d for (k, d), s in zip(free.items(), moved, strict=True)}
        on = [h.active(s) for h, s in zip(effects, sizes, strict=True)]
        runs = prepared(model, logs, there, on, start=start, rounds=4 if afresh else rules.LEARNED)
        problem = asked(runs)
    # screening compares columns: those of the numbers must be as good as those of what is tried
    return runs, problem.fit(moved, sizes, exact=True)


def settled_with(
    effects: Sequence[Refined], model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared],
    values: Mapping[Key, float],
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit as `settled` does with these effects on, noises learned from those of the runs."""
    on = [a.active for a in effects]
    again = prepared(model, logs, values, on, start=learned_from(runs), rounds=rules.LEARNED)
    return settled(model, logs, free, again, effects, values)


def settled_from_believed(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], on: Sequence[Refined]
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit as `settled` does with effects on, from the believed numbers."""
    first = prepared(model, logs, {}, [a.active for a in on], start=None, rounds=0)
    return settled(model, logs, free, first, on, {}, anew=True)


def likelihood(runs: Sequence[Prepared], fit: Fit) -> float:
    """Return the log likelihood of recordings where a fit ended, with the prior of its numbers."""
    return sum(log_likelihood(p) for p in runs) - 0.5 * float(fit.moved @ fit.moved)


def log_evidence(runs: Sequence[Prepared], fit: Fit) -> float:
    """Return that of recordings with what a fit has on, comparable over noises."""
    return fit.log_evidence - 0.5 * sum(p.gains.log_determinant for p in runs)
