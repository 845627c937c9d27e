"""The likeliest further effects, each fitted with all that is on from wherever its fit may begin."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.descent import product_of
from gap_diagnosis.vehicle.gram import solution
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.onset_search import begun_nearby
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.stage import Stage, log_prior
from gap_diagnosis.vehicle.unknowns import Key

__all__ = ["may_stand_for_more", "refined_ones"]

Array = NDArray[np.float64]
_Start = tuple[Array, list[tuple[float, ...]]]


def refined_ones(stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]) -> list[tuple[float, Fit]]:
    """Return the best hypotheses, fitted with all that is on, with log odds against nothing more, best first."""
    quick = [_quickly(stage, h, free) for _, h in stage.offered[: rules.REFINED]]
    quick += _from_believed(stage, free, tried)
    quick.sort(key=lambda each: -each[0].log_evidence)
    fits: list[Fit] = []
    for fit, problem in quick:
        if any(fit.effects[-1].hypothesis == each.effects[-1].hypothesis for each in fits):
            continue
        if len(fits) < rules.FITTED_ANEW and fit.log_evidence > quick[0][0].log_evidence - rules.FAR_BEHIND:
            fit = problem.fit(fit.moved, [e.sizes for e in fit.effects])
        fits.append(fit)
    nothing = _without_them(stage, free, fits)
    found = []
    for fit in fits:
        gain, prior = fit.log_evidence - nothing, log_prior(fit.effects[-1].hypothesis, tried)
        found.append((max(gain, 0.0) / fit.scatter + min(gain, 0.0) + prior, fit))
    return sorted(found, key=lambda each: -each[0])


def may_stand_for_more(stage: Stage, free: dict[Key, float]) -> bool:
    """Return whether a number of the vehicle, or of one thruster, is so far off that it may stand for an effect."""
    return any(_furthest(stage, free, whose) is not None for whose in ("own", "vehicle"))


def _furthest(stage: Stage, free: dict[Key, float], whose: str) -> int | None:
    """Return which number is furthest off, of a thruster ("own") or of the vehicle; None where none is far off."""
    off = np.where([key[0] == whose for key in free], np.abs(stage.moved), 0.0)
    return int(np.argmax(off)) if np.max(off) >= rules.SHIFTED else None


def _quickly(stage: Stage, h: Hypothesis, free: dict[Key, float]) -> tuple[Fit, Problem]:
    """Return the best fit of a hypothesis along the columns of a stage, with all that is on, and its problem."""
    names, on = stage.gram.names, stage.fit.effects
    known = range(stage.fit.columns[0].shape[1])
    product = stage.gram.A[: len(known), : len(known)]
    problem = Problem(screen=stage.screen, nuisances=free, effects=(*(a.hypothesis for a in on), h))
    at = [j for j, name in enumerate(names) if isinstance(name, tuple) and name[0] == h]
    x, _ = solution(stage.gram, known, on=at) if h.switch else solution(stage.gram, [*known, *at])
    starts = [_start(stage, h, problem, share * x) for share in (1.0, 0.5, 0.0)]
    starts = [max(starts, key=lambda there: problem.score(*there))]
    starts += _handed_over(stage, h, problem, free, x)
    if h.carrier:  # no start tells by itself where it leads
        starts += [_start(stage, h, problem, _beside(stage, known, at, size[0] / h.scale[0])) for size in h.further]
    found = max((problem.fit(*start, stage.fit.columns, product) for start in starts), key=lambda fit: fit.log_evidence)
    if h.carrier:
        again = problem.fit(*_mirrored(problem, found), stage.fit.columns, product)
        found = max(found, again, key=lambda fit: fit.log_evidence)
    if h.since is not None:
        there = found.moved, [e.sizes for e in found.effects]
        problem = begun_nearby(problem, *there)
        found = problem.fit(*there, stage.fit.columns, product)
    return found, problem


def _from_believed(stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]) -> list[tuple[Fit, Problem]]:
    """Return quick fits of effects that numbers far off may stand for, from where these numbers are as believed.

    Such numbers may have taken over all that an effect does, and what both do is bent: where the numbers have it all no
    column of the effect leads to it. Which effects are worth a fit is told by that at their best size there.
    """
    on, sizes = tuple(a.hypothesis for a in stage.fit.effects), [a.sizes for a in stage.fit.effects]
    found = []
    for far, offered in _stood_for(stage, free, tried):
        starts = []
        moved = np.where(far, 0.0, stage.moved)
        for h in offered:
            if h.place not in {each.place for each in on}:
                problem = Problem(screen=stage.screen, nuisances=free, effects=(*on, h))
                start = _sized(problem, h, moved, sizes)
                starts.append((problem.score(*start), start, problem))
        if not starts:
            continue
        starts.sort(key=lambda each: -each[0])
        columns = Problem(screen=stage.screen, nuisances=free, effects=on).columns(moved, sizes)
        product = product_of(columns)
        found += [
            (problem.fit(*start, columns, product), problem) for _, start, problem in starts[: rules.REFINED_BACK]
        ]
    return found


def _stood_for(
    stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]
) -> Iterator[tuple[list[bool], list[Hypothesis]]]:
    """Yield the numbers of the thruster of which one is furthest off, with its effects; and the vehicle's number that
    is, with the effects of no thruster that act most like it."""
    q = _furthest(stage, free, "own")
    if q is not None:
        i = list(free)[q][2]
        yield [key[0] == "own" and key[2] == i for key in free], [h for h in tried if i in (h.thruster, h.other)]
    q = _furthest(stage, free, "vehicle")
    if q is not None:
        yield [k == q for k in range(len(free))], _most_like(stage, q, tried)


def _most_like(stage: Stage, q: int, tried: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the effects of no thruster whose columns are most like that of a number, the likest first."""
    A = stage.gram.A
    alike: dict[Hypothesis, float] = {}
    for j, name in enumerate(stage.gram.names):
        if isinstance(name, tuple) and isinstance(name[0], Hypothesis) and name[0].thruster is None:
            cosine = abs(A[q, j]) / np.sqrt(max(A[q, q] * A[j, j], 1e-300))
            alike[name[0]] = max(alike.get(name[0], 0.0), float(cosine))
    return sorted((h for h in tried if h in alike), key=lambda h: -alike[h])[: rules.REFINED]


def _sized(problem: Problem, h: Hypothesis, moved: Array, sizes: Sequence[tuple[float, ...]]) -> _Start:
    """Return the point with a further effect at its most likely size, up to twice the expected one, all else as is."""
    if h.switch or h.grid:
        return moved, [*sizes, problem.grid_start(moved, sizes)]
    ways = (1.0, -1.0) if h.lower[0] < 0.0 else (1.0,)
    found = [problem.resized(moved, [*sizes, (way * h.scale[0], *h.scale[1:])]) for way in ways]
    return max(found, key=lambda there: problem.score(*there))


def _handed_over(
    stage: Stage, h: Hypothesis, problem: Problem, free: dict[Key, float], x: Array
) -> list[_Start]:  # fmt: skip
    """Return where to fit from if a thruster's numbers give back what they took over before the effect was there.

    They are those which move by a deviation or more to first order, x in deviations; the effect takes as much as that
    is. Number and effect are multiplied: no step along columns that were made where one had it all leads there.
    """
    m, count = len(stage.moved), len(h.scale)
    own = np.array([key[0] == "own" and key[2] in (h.thruster, h.other) for key in free])
    back = own & (np.abs(x[:m]) > 1.0) & (x[:m] * stage.moved < 0.0)
    if not back.any():
        return []
    on = [a.sizes for a in stage.fit.effects]
    moved = np.where(back, 0.0, stage.moved)
    if h.switch:
        return [(moved, [*on, ()])]
    if h.grid or not np.any(x[-count:]):
        return []
    expected = x[-count:] / np.max(np.abs(x[-count:])) * np.array(h.scale)
    return [problem.resized(moved, [*on, tuple(map(float, expected))])]


def _beside(stage: Stage, known: Sequence[int], at: Sequence[int], size: float) -> Array:
    """Return what moves, in deviations, where the first parameter of a hypothesis, a mass or a length, is of that size.

    What it makes at its place is known far better than itself: to first order one stands for the other's error.
    """
    gram = replace(stage.gram, b=stage.gram.b - size * stage.gram.A[:, at[0]])
    x, _ = solution(gram, [*known, *at[1:]])
    return np.insert(x, len(known), size)


def _mirrored(problem: Problem, fit: Fit) -> _Start:
    """Return what is on the other side of the origin from where a fit has put it, all else moved so as to undo that.

    A mass at a place is known by its first moment, of which the vehicle's own centre may take any part, and by its
    second, which is the same on both sides: two most likely places, and no step leads from one to the other.
    """
    H = product_of(fit.columns) + np.diag(problem.weight)
    carried = fit.effects[-1]
    place = np.arange(len(H) - len(carried.sizes) + 1, len(H))
    rest = np.setdiff1d(np.arange(len(H)), place)
    over = np.array(carried.sizes[1:]) / np.array(carried.hypothesis.scale[1:])
    x = np.zeros(len(H))
    x[place] = -2.0 * over
    x[rest] = np.linalg.solve(H[np.ix_(rest, rest)], H[np.ix_(rest, place)] @ (2.0 * over))
    return _moved(fit.moved, fit.effects, x)


def _moved(moved: Array, effects: Sequence[Refined], x: Array) -> _Start:
    """Return a point of numbers and sizes moved by x in deviations."""
    at, sizes = len(moved), []
    for a in effects:
        own = zip(a.sizes, x[at:], a.hypothesis.scale, strict=False)
        sizes.append(tuple(s + float(v) * d for s, v, d in own))
        at += len(a.sizes)
    return moved + x[: len(moved)], sizes


def _without_them(stage: Stage, free: dict[Key, float], fits: Sequence[Fit]) -> float:
    """Return the log evidence for nothing more, wherever one of the fits has led its uncertain numbers.

    What a hypothesis gains because its fit went on where the one before had stopped is no evidence for it.
    """
    on = stage.fit.effects
    alone = Problem(screen=stage.screen, nuisances=free, effects=tuple(a.hypothesis for a in on))
    best = stage.fit
    reached = alone.score(best.moved, [a.sizes for a in on])
    for fit in fits:
        there = fit.moved, [a.sizes for a in fit.effects[:-1]]
        if alone.score(*there) > reached:
            again = alone.fit(*there)
            if again.log_evidence > best.log_evidence:
                best, reached = again, alone.score(again.moved, [a.sizes for a in again.effects])
    return best.log_evidence


def _start(stage: Stage, h: Hypothesis, problem: Problem, x: Array) -> _Start:
    """Return (nuisances, sizes) to fit from: the stage's point, moved by x in deviations."""
    moved, sizes = _moved(stage.moved, stage.fit.effects, x)
    at = len(moved) + sum(map(len, sizes))
    if h.switch:
        return moved, [*sizes, ()]
    if h.grid:
        return stage.moved, [*sizes, problem.grid_start(stage.moved, sizes)]
    own_sizes = x[at:] * np.array(h.scale)
    if h.carrier and abs(own_sizes[0]) > 1e-9:
        own_sizes[1:] = own_sizes[1:] * h.scale[0] / own_sizes[0]
    return moved, [*sizes, tuple(map(float, own_sizes))]
