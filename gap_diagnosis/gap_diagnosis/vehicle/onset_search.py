"""When a failure may have begun: of each that a watch follows, the likeliest onset, to first order.

With a column v of an effect that is there all along, one that begins at an instant has about that column from there on
and nothing before, as a filter forgets within seconds. So the products of v with all columns and with the residual,
over blocks of time, tell all onsets at once, uncertain numbers averaged over their deviations.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.descent import normal
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.onset import Onset
from gap_diagnosis.vehicle.refining import Fit, Problem
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.side_by_side import side_by_side

__all__ = ["begun_nearby", "likeliest_onsets"]

Array = NDArray[np.float64]
_REACH = 3
"""Blocks to either side in which the likeliest onset lies. Where a thrust changes its sign what columns say cancels:
one was found 1.6 s before another that is likelier by 20 in log likelihood (seed 2328)."""
_PARTS = 5
"""Of a block, that are looked at first. A filter takes in a wrong step of thrust within some tenths of a second: so
narrow is the peak of an onset's log likelihood, among others made by chance."""
_CLIMBED = 3
"""How many of these peaks are looked at instant by instant. The highest of the coarse look alone was once 1.1 s before
another that is likelier by 270 (seed 2323)."""


def likeliest_onsets(failures: Sequence[Hypothesis], screen: Screen, fit: Fit) -> list[Hypothesis]:
    """Return failures of one parameter or none that begin where each explains most; screen: where the fit ended."""
    rows = range(len(screen.runs))
    r = [screen.residual(k).ravel() for k in rows]
    H, slope = normal(list(fit.columns), r, fit.unknowns, np.ones(len(fit.unknowns)))
    inverse = np.linalg.inv(H + np.eye(len(H)))
    found = []
    for h in map(_as_it_fails, failures):
        (column,) = screen.of_hypothesis(h)
        changes = side_by_side(column.change, rows)
        sums = [_to_the_end(*of_run, _instants(screen)) for of_run in zip(changes, fit.columns, r, strict=True)]
        onset = _best(h, sums, np.asarray(inverse), np.asarray(-inverse @ slope), screen)
        if onset is not None:
            found.append(replace(h, since=onset))
    return found


def _as_it_fails(h: Hypothesis) -> Hypothesis:
    """Return a failure with no sizes on the side on which no watch follows it: nothing gains thrust in mid-run."""
    return replace(h, lower=(0.0,)) if h.watched and min(h.watched) > 0.0 else h


def _instants(screen: Screen) -> int:
    """Return how many instants a block has."""
    return round(rules.ONSET / screen.runs[0].log.period)


def _to_the_end(v: Array, J: NDArray[np.float32], r: Array, instants: int) -> Array:
    """Return v J, v r and v v of a column (K, M), (blocks, n + 2), each from the beginning of a block to the end."""
    width, flat = instants * v.shape[1], v.ravel()
    parts = [slice(at, at + width) for at in range(0, len(flat), width)]
    thin = flat.astype(np.float32)
    by_block = np.array([[*(thin[at] @ J[at]), flat[at] @ r[at], flat[at] @ flat[at]] for at in parts])
    return np.asarray(np.cumsum(by_block[::-1], axis=0)[::-1])


def _best(h: Hypothesis, sums: Sequence[Array], inverse: Array, x: Array, screen: Screen) -> Onset | None:
    """Return the onset with the largest log evidence, of all blocks of all recordings, in that one alone or in all
    later ones too; None: there is none but the beginning of all."""
    later = np.zeros(len(x) + 2)
    products, places = [], []
    for k in reversed(range(len(sums))):
        for last, more in {k: np.zeros_like(later), len(sums) - 1: later}.items():
            first = 1 if k == 0 else 0
            products.append(sums[k][first:] + more)
            places += [(k, block, last) for block in range(first, len(sums[k]))]
        later = later + sums[k][0]
    table = np.concatenate(products)
    J = table[:, :-2]
    b = -table[:, -2] - J @ x
    left = np.maximum(table[:, -1] - np.einsum("ij,jk,ik->i", J, inverse, J), 0.0)
    gains = b - 0.5 * left if h.switch else 0.5 * (b**2 / (1.0 + left) - np.log1p(left))
    if h.lower and h.lower[0] >= 0.0:
        gains[b < 0.0] = -np.inf
    if not np.isfinite(gains).any():
        return None
    k, block, last = places[int(np.argmax(gains))]
    log = screen.runs[k].log
    at = log.cut + block * _instants(screen)
    return Onset(k, log.name, at, log.period, last, len(places), at, at)


def begun_nearby(problem: Problem, moved: Array, sizes: Sequence[tuple[float, ...]]) -> Problem:
    """Return the problem with the onset of each failure at the likeliest instant near where it is, at a point."""
    for j, h in enumerate(problem.effects):
        if h.since is not None:
            problem = _nearby(problem, j, h.since, moved, sizes)
    return problem


def _nearby(problem: Problem, j: int, onset: Onset, moved: Array, sizes: Sequence[tuple[float, ...]]) -> Problem:
    log, block = problem.screen.runs[onset.run].log, _instants(problem.screen)

    def begun(instant: int, *about: int) -> Problem:
        later = onset._replace(instant=instant, earliest=min((instant, *about)), latest=max((instant, *about)))
        effects = list(problem.effects)
        effects[j] = replace(effects[j], since=later)
        return replace(problem, effects=tuple(effects), _points={}, _made={})

    @cache
    def score(instant: int) -> float:
        return begun(instant).score_of(onset.run, moved, sizes) if log.cut <= instant < end else -np.inf

    end, step = log.cut + log.count, max(round(block / _PARTS), 1)
    coarse = [onset.instant + way * step for way in range(-_REACH * _PARTS, _REACH * _PARTS + 1)]
    peaks = [at for at in coarse if score(at) == max(score(at - step), score(at), score(at + step))]
    peaks = sorted(peaks, key=score)[-_CLIMBED:]
    found = max((near for at in peaks for near in range(at - step, at + step + 1)), key=score)
    least, ends = score(found) - rules.ABOUT_AS_LIKELY, []
    for way in (-step, step):
        at = found
        while score(at + way) > least:
            at += way
        ends.append(at)
    return begun(found, *ends)
