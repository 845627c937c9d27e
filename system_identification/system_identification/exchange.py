"""Which other sets would explain the rows about as well, two effects exchanged at a time, by the linearised model.

Effects imitate each other in pairs: an exchange of one at a time passes through sets that are far worse. One effect may
stand for two as well: it is exchanged for both. On one Gram
matrix of all traces, the nuisances projected out, some ten thousand sets are rated in a moment; the likeliest are to be
fitted.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.hypothesis import Hypothesis
from system_identification.rating import DIVERGED, Trial
from system_identification.suspects import Suspect
from system_identification.traces import traces_of

__all__ = ["Proposal", "exchanges"]

Array = NDArray[np.float64]
_SIZES = 3
"""Sizes of a suspect whose trace changes with its size."""
_BENT = (0.5, 2.0)
"""By how much such a trace may be scaled."""
_WORSE = 150.0
"""Evidence by which a set may seem to be behind to be worth a look: what is large is not linear."""
_ONE_MORE_WORSE = 60.0
"""The same for a set with one effect more, which is the more likely to be ahead by chance."""
_MATTERS = 8.0
"""Cost that each effect of a set must take off beside the others: else a smaller set stands for it."""


class Proposal(NamedTuple):
    """A set to be fitted: its suspects, unknowns to start from, and its evidence over the present one, linearised."""

    suspects: tuple[Suspect, ...]
    start: Array
    ahead: float


class _Column(NamedTuple):
    suspect: Suspect
    sizes: Array
    low: float
    high: float


def exchanges(found: Hypothesis, trials: Sequence[Trial], most: int, one_more: float | None = None) -> list[Proposal]:
    """Return sets in which one or two effects of a set are exchanged, the likeliest first, at most so many.

    Args:
        found: the set, fitted.
        trials: of all other suspects beside it.
        most: how many are returned, and half as many with one effect more.
        one_more: what that costs before the data, nats; None: no set has more.
    """
    fitted, count = found.fitted, len(found.suspects)
    traces = traces_of(fitted, found.suspects)
    own = [_own(found, each) for each in found.suspects]
    others = [(column, change) for trial in trials for column, change in _columns(trial)]
    rows = np.column_stack([*(traces[each.key] for each in found.suspects), *(change for _, change in others)])
    columns = [*own, *(column for column, _ in others)]
    nuisances = fitted.problem.nuisances
    jacobian = fitted.jacobian[:, :nuisances]
    white = found.noise.whiten(rows)
    target = fitted.white + np.sum(white[:, :count], axis=1)
    information = jacobian.T @ jacobian + np.diag(fitted.prior)
    cross, pull = jacobian.T @ white, jacobian.T @ target - fitted.prior * fitted.x[:nuisances]
    retuning = np.linalg.solve(information, np.column_stack((cross, pull)))
    gram = white.T @ white - cross.T @ retuning[:, :-1]
    slope = white.T @ target - cross.T @ retuning[:, -1]
    here = _rated(gram, slope, np.arange(count)[None, :])[0][0]
    low, high = np.array([c.low for c in columns]), np.array([c.high for c in columns])
    proposals: list[Proposal] = []
    # Sets with one effect more are the likelier to be ahead: they do not crowd out the others.
    for swapped, price, worse, wanted in (
        (((1, 1), (2, 2)), 0.0, _WORSE, most),
        (((1, 2),), one_more, _ONE_MORE_WORSE, most // 2),
    ):
        sets = _sets(columns, count, swapped) if price is not None else np.zeros((0, count), dtype=np.int64)
        if price is None or not sets.size:
            continue
        gains, shares, least = _rated(gram, slope, sets)
        inside = np.all((shares >= low[sets]) & (shares <= high[sets]), axis=1) & (least > _MATTERS)
        ahead = np.where(inside, 0.5 * (gains - here) - price, -np.inf)
        chosen: dict[frozenset[str], Proposal] = {}
        for k in np.argsort(-ahead):
            if len(chosen) == wanted or ahead[k] < -worse:
                break
            members = [columns[i] for i in sets[k]]
            keys = frozenset(each.suspect.key for each in members)
            if keys in chosen:
                continue
            moved = retuning[:, -1] - retuning[:, sets[k]] @ shares[k]
            sizes = [
                c.sizes * np.append(share, np.ones(c.sizes.size - 1))
                for c, share in zip(members, shares[k], strict=True)
            ]
            start = np.concatenate((fitted.x[:nuisances] + moved, *sizes))
            chosen[keys] = Proposal(tuple(each.suspect for each in members), start, float(ahead[k]))
        proposals += chosen.values()
    return proposals


def _own(found: Hypothesis, suspect: Suspect) -> _Column:
    sizes = found.fitted.x[found.sizes_of(suspect)]
    return _Column(suspect, sizes, *_range(suspect, sizes))


def _columns(trial: Trial) -> list[tuple[_Column, Array]]:
    """Return a trial's columns: at a middle size, or at several where its trace changes with its size."""
    suspect, largest = trial.suspect, np.max(np.abs(trial.changes), axis=1)
    order = np.argsort(np.abs(suspect.grid[:, 0]), kind="stable")
    order = order[(largest[order] > 0.0) & (largest[order] < DIVERGED)]
    if not order.size:
        return []
    places = [len(order) // 2] if suspect.scalable else np.unique(np.linspace(0, len(order) - 1, _SIZES).astype(int))
    return [
        (_Column(suspect, suspect.grid[g], *_range(suspect, suspect.grid[g])), trial.changes[g].astype(np.float64))
        for g in order[places]
    ]


def _range(suspect: Suspect, sizes: Array) -> tuple[float, float]:
    """Return by which shares a trace at these sizes may be scaled."""
    slot = suspect.slots[0]
    if slot.lower == slot.upper:
        return 1.0 / _BENT[1], _BENT[1]  # as far as it is linear
    if not suspect.scalable:
        return _BENT
    ends = sorted((slot.lower / slot.width / sizes[0], slot.upper / slot.width / sizes[0])) if sizes[0] else (0.0, 0.0)
    return ends[0], ends[1]


def _sets(columns: Sequence[_Column], count: int, swapped: Sequence[tuple[int, int]]) -> NDArray[np.int64]:
    """Return sets (S, members) of columns, so many of the first `count` exchanged for so many others, (gone, come)."""
    others = np.arange(count, len(columns))
    keys = np.array([each.suspect.key for each in columns])
    pairs = np.array(list(combinations(others, 2)), dtype=np.int64).reshape(-1, 2)
    pairs = pairs[keys[pairs[:, 0]] != keys[pairs[:, 1]]]
    found = []
    for away, come in swapped:
        comers = others[:, None] if come == 1 else pairs
        for gone in combinations(range(count), away) if count >= away else ():
            kept = [k for k in range(count) if k not in gone]
            found.append(np.hstack((np.tile(kept, (len(comers), 1)).astype(np.int64), comers)))
    return np.vstack(found) if found else np.zeros((0, count), dtype=np.int64)


def _rated(gram: Array, slope: Array, sets: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Return the cost that each set takes off (S,), its columns' shares (S, count), the least cost of one (S,)."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(gram), 1e-9))
    unit = gram * scale[:, None] * scale + 1e-6 * np.eye(len(scale))
    pull = (slope * scale)[sets]
    inverse = np.linalg.inv(unit[sets[:, :, None], sets[:, None, :]])
    shares = np.einsum("sij,sj->si", inverse, pull)
    least = np.min(shares**2 / np.einsum("sii->si", inverse), axis=1)
    return np.sum(shares * pull, axis=1), shares * scale[sets], least
