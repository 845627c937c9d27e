r"""Which recording next: what best tells apart what these recordings cannot, or shows most of what is hidden.

A programme's recording is foreseen: what the sensors at hand would read of the vehicle as it was found, without noise.
Its columns add to those of the recordings at hand. With S what is left of the columns of an effect h once numbers and
the columns of a rival are projected out, and x its size in its deviations,

    d^2 = x^T S x

is the distance of the two. It says what recordings should tell by their noise. Pairs that are asked about are those
that the recordings at hand did not decide, whatever their distance there. So what counts is what a programme adds,

    d_added^2 = d_both^2 - d_now^2

and from d_added = 5 on it tells the two apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import foreseen, prepared_with
from gap_diagnosis.vehicle.gram import Gram
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.learning import learned_from
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.programmes import Limits, Programme, pulses, sweeps
from gap_diagnosis.vehicle.refining import Fit, Problem
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.search import Found
from gap_diagnosis.vehicle.stage import Stage, least_shown, stage_at
from gap_diagnosis.vehicle.unknowns import acts_in, in_deviations
from gap_diagnosis.vehicle.verdict import Verdict

__all__ = ["NextExperiment", "Separation", "next_experiment"]

Array = NDArray[np.float64]
_PULSES = (1.0, 0.5, 0.25)
"""[s] Tried until one keeps the limits: the longest tells most."""


_HELPS = 2.0
"""Deviations that a programme must add to a pair, to be worth a dive: by chance 1 in 20."""


@dataclass(frozen=True, kw_only=True)
class Separation:
    """Two hypotheses and their distance, by the recordings at hand and with the programme's beside them."""

    first: Hypothesis
    second: Hypothesis
    now: float
    then: float

    @property
    def added(self) -> float:
        """What the programme adds to their distance, see the module."""
        return max(self.then**2 - self.now**2, 0.0) ** 0.5

    @property
    def told(self) -> bool:
        """Whether the programme tells them apart."""
        return self.added >= rules.TOLD_APART


@dataclass(frozen=True, kw_only=True, eq=False)
class NextExperiment:
    """The programme, what it separates, and how many effects could not have been shown at any size, now and with it."""

    programme: Programme
    separates: tuple[Separation, ...]
    hidden_now: int
    hidden_then: int

    @property
    def helps(self) -> bool:
        """Whether it brings two candidates apart by more than chance, or shows what was hidden."""
        return self.hidden_then < self.hidden_now or any(s.added >= _HELPS for s in self.separates)


def next_experiment(
    found: Found, verdict: Verdict, logs: Sequence[VehicleLog], limits: Limits
) -> NextExperiment | None:  # fmt: skip
    """Return the best programme within limits; None where none is within them or helps, or nothing is to be settled.

    Best is the one that adds most to the pair to which it adds least, of programmes that are equal there (5 and more
    is enough) the one that leaves least hidden.
    """
    last = found.stages[-1]
    model = last.screen.model
    pairs, hidden_now = _undecided(verdict), _hidden(last.gram)
    if not pairs and hidden_now == 0:
        return None
    tried = sweeps(model, limits, period=logs[0].period)
    for length in _PULSES:
        try:
            tried.append(pulses(model, limits, pulse=length, period=logs[0].period))
        except ValueError:
            continue
        break
    judged = []
    for programme in tried:
        both = _together(last.gram, _with_recording(found, logs, programme).gram)
        separates = tuple(
            Separation(first=a, second=b, now=_distance(last.gram, last, a, b), then=_distance(both, last, a, b))
            for a, b in pairs
        )
        judged.append(
            NextExperiment(programme=programme, separates=separates, hidden_now=hidden_now, hidden_then=_hidden(both))
        )
    return max((each for each in judged if each.helps), key=_worth, default=None)


def _worth(each: NextExperiment) -> tuple[float, int, float]:
    least = min((min(s.added, rules.TOLD_APART) for s in each.separates), default=0.0)
    return least, -each.hidden_then, -each.programme.duration


def _undecided(verdict: Verdict) -> list[tuple[Hypothesis, Hypothesis]]:
    """Return claims with their rivals, or the nearest hypotheses where nothing is claimed but something suspected."""
    pairs = [(c.refined.hypothesis, rival) for c in verdict.claims for _, rival in c.rivals[:4]]
    if not pairs and verdict.name in ("cannot_tell", "unknown") and not verdict.claims:
        near = [h for odds, h in verdict.candidates if odds > -np.log(rules.CLAIM)][:3]
        pairs = [(a, b) for i, a in enumerate(near) for b in near[i + 1 :]]
    return pairs


def _with_recording(found: Found, logs: Sequence[VehicleLog], programme: Programme) -> Stage:
    """Return what a programme's recording alone would tell where the last stage ended."""
    last = found.stages[-1]
    model, fit = last.screen.model, last.fit
    effects = [a.active for a in fit.effects]
    log, states = foreseen(model, logs[0], programme.throttles, fit.values, effects)
    run = len(logs)
    prepared = prepared_with(model, log, run, learned_from(last.screen.runs), fit.values, effects, states)
    free = {k: d for k, d in nuisances(model, [*logs, log]).items() if acts_in(k, run)}
    moved = in_deviations(fit.values, free)
    sizes = [a.sizes for a in fit.effects]
    problem = Problem(
        screen=Screen(model=model, runs=[prepared], values={}), nuisances=free,
        effects=tuple(a.hypothesis for a in fit.effects),
    )  # fmt: skip
    there = Fit(
        effects=fit.effects, values=dict(fit.values), moved=moved, log_evidence=0.0, scatter=1.0,
        columns=problem.columns(moved, sizes),
    )  # fmt: skip
    return stage_at(model, [prepared], there, free, found.tried, ())


def _together(first: Gram, second: Gram) -> Gram:
    """Return the products of both; what one of them does not know moves nothing in it."""
    names = tuple(dict.fromkeys((*first.names, *second.names)))
    at = {name: j for j, name in enumerate(names)}
    deviations, A = np.ones(len(names)), np.zeros((len(names), len(names)))
    scatter = np.ones(len(names))
    for gram in (second, first):
        rows = [at[name] for name in gram.names]
        A[np.ix_(rows, rows)] += gram.A
        deviations[rows], scatter[rows] = gram.deviations, gram.scatter
    return replace(first, names=names, deviations=deviations, A=A, b=np.zeros(len(names)), scatter=scatter)


def _numbers(gram: Gram) -> list[int]:
    """Return the columns of the numbers that are uncertain."""
    return [j for j, name in enumerate(gram.names) if not _place(name) and name[:1] != ("nameless",)]  # type: ignore[index]


def _place(name: object) -> Hypothesis | None:
    """Return the hypothesis that a column is of, None for a number's."""
    if not isinstance(name, tuple):
        return None
    return next((part for part in name if isinstance(part, Hypothesis)), None)


def _distance(gram: Gram, last: Stage, h: Hypothesis, rival: Hypothesis) -> float:
    own = [j for j, name in enumerate(gram.names) if _place(name) == h]
    beside = [j for j, name in enumerate(gram.names) if _place(name) == rival]
    fitted = {a.hypothesis: a for a in last.fit.effects}
    x = np.ones(len(own))
    if h in fitted and not h.switch and not h.grid:
        x = np.array(fitted[h].sizes) / np.array(h.scale)
    # an effect that is on keeps its columns at its size; those of the others stand beside
    others = [j for j, name in enumerate(gram.names) if _place(name) in fitted and j not in own]
    base = sorted({*_numbers(gram), *beside, *others})
    if not own:
        return 0.0
    S = _left(gram, own, base)
    return max(float(x @ S @ x), 0.0) ** 0.5


def _left(gram: Gram, own: Sequence[int], base: Sequence[int]) -> Array:
    """Return the products of columns, (n, n), once those of the base are projected out, with their deviations."""
    deviations = gram.deviations[base]
    weight = np.where(deviations > 0.0, 1.0 / np.where(deviations > 0.0, deviations, 1.0) ** 2, 1e-6)  # 0: a switch
    inner = gram.A[np.ix_(base, base)] + np.diag(weight)
    across = gram.A[np.ix_(base, own)]
    return np.asarray(gram.A[np.ix_(own, own)] - across.T @ np.linalg.solve(inner, across))


def _hidden(gram: Gram) -> int:
    """Return how many effects of one size could not be shown at any size within their range."""
    return sum(size > h.most for h, size in least_shown(gram, _numbers(gram)))
