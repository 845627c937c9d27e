"""Onsets, numbers and noises found in turn, until none moves."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared
from gap_diagnosis.vehicle.learning import learned_from, prepared, unlearned
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.onset_search import begun_nearby
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.unknowns import Key, in_deviations, in_units
from gap_diagnosis.vehicle.whitening import log_determinant, log_likelihood

__all__ = ["likelihood", "log_evidence", "settled", "settled_with"]


def settled(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], on: Sequence[Refined] = (),
    values: Mapping[Key, float] = MappingProxyType({}),
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return the recordings with gains for noises learned where nuisances and effects fit best, and that fit.

    It begins with these numbers, the believed ones where none are given, with what is typical of noises, and with these
    effects on.
    """
    believed = unlearned(model, logs, {}, [a.active for a in on])
    return _settled(model, logs, free, believed, on, values, afresh=True)


def settled_with(
    effects: Sequence[Refined], model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared],
    values: Mapping[Key, float],
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit as `settled` does with these effects on, from these numbers and the runs' noises."""
    near = prepared(model, logs, values, [a.active for a in effects], runs)
    return _settled(model, logs, free, near, effects, values, afresh=False)


def _settled(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared], on: Sequence[Refined],
    values: Mapping[Key, float], afresh: bool,
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit where noises and numbers have settled; afresh: learn noises anew after the first fit.

    Numbers fitted with noises that had to explain what the numbers do not are too near to what was believed, and
    noises learned there too large. So where numbers of the whole vehicle are far from it, and the random wrench is
    larger than that of calm water, both are found again from there in water that is calm, as long as that is likelier.
    """
    found = _in_turn(model, logs, free, runs, on, values, afresh)
    whole, water = np.array([k[0] in ("vehicle", "shared") for k in free]), model.wrench_of_water(rules.CALM_WRENCH)
    while np.abs(found[1].moved[whole]).max(initial=0.0) >= rules.SHIFTED:
        noises, there, on = learned_from(found[0]), found[1].values, found[1].effects
        if np.all(noises.wrench <= water):
            break
        calm = noises._replace(wrench=rules.CALMED * noises.wrench, time=1.0)
        runs = unlearned(model, logs, there, [a.active for a in on], calm, found[0])
        again = _in_turn(model, logs, free, runs, on, there, afresh=False)
        if log_evidence(*again) < log_evidence(*found) + rules.SETTLED:
            break
        found = again
    return found


def _in_turn(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared],
    accepted: Sequence[Refined], values: Mapping[Key, float], afresh: bool,
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit where onsets, numbers and noises, in turn, have settled; afresh: learn noises anew at
    first."""
    effects = tuple(a.hypothesis for a in accepted)
    moved = in_deviations(values, free)
    sizes = [a.sizes for a in accepted]

    def asked(runs: list[Prepared]) -> Problem:
        return Problem(screen=Screen(model=model, runs=runs, values={}), nuisances=free, effects=effects)

    problem, nearby = asked(runs), None
    for turn in range(rules.TURNS):
        problem = begun_nearby(problem, moved, sizes)
        if problem.effects != effects:
            effects, nearby = problem.effects, None
        before = problem.score(moved, sizes)
        moved, sizes, columns = problem.most_likely(moved, sizes, nearby)
        after = problem.score(moved, sizes)
        if turn > 0 and after - before < rules.SETTLED:
            break
        anew = turn == 0 and afresh
        nearby = None if anew else columns  # noises that are learned anew change too much
        on = [h.active(s) for h, s in zip(effects, sizes, strict=True)]
        runs = prepared(model, logs, in_units(moved, free), on, runs, afresh=anew)
        problem = asked(runs)
    # screening compares columns: those of the numbers must be as good as those of what is tried
    return runs, problem.fit(moved, sizes, exact=True)


def likelihood(runs: Sequence[Prepared], fit: Fit) -> float:
    """Return the log likelihood of recordings where a fit ended, with the prior of its numbers."""
    return sum(log_likelihood(p) for p in runs) - 0.5 * float(fit.moved @ fit.moved)


def log_evidence(runs: Sequence[Prepared], fit: Fit) -> float:
    """Return that of recordings with what a fit has on, comparable over noises."""
    return fit.log_evidence - 0.5 * sum(map(log_determinant, runs))
