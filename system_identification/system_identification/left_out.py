"""How well a hypothesis predicts what it was not fitted to: runs left out in turn, or parts of them where runs are few.

A hypothesis is fitted to the rest and simulated freely over the whole run; what is particular to the run (its clocks,
rest values, state at the start) is taken from a fit to all, for every hypothesis alike.

It is fitted for free runs too: residuals count as white noise as large as they are. Where a model is wrong in a way
that has no name, a fit by innovations follows what changes fast, and leaves what lasts to pushes and colour; what it
predicts without them is worse than it need be.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted, fit
from system_identification.hypothesis import Hypothesis
from system_identification.loose import rests_of
from system_identification.noise import Whitener, white_noise
from system_identification.system import System

__all__ = ["FEWEST_RUNS", "LeftOut", "fit_to_free_runs", "folds_of", "foreseen", "foretold", "helps_by", "left_out"]

Array = NDArray[np.float64]
FEWEST_RUNS = 3
"""Runs from which on whole ones are left out; fewer are cut into quarters."""
_QUARTERS = 4
_WEIGHINGS, _STEPS = 3, 4
_DRAWS = 4000


class LeftOut(NamedTuple):
    """Predictions of all rows by fits that have not seen them (R,), and the unknowns of each of these fits (F, K)."""

    predicted: Array
    unknowns: Array


def folds_of(system: System) -> NDArray[np.int64]:
    """Return which fold each row belongs to, shape (R,): its run, or another quarter in each run."""
    folds = np.zeros(system.known.size, dtype=np.int64)
    runs = {each.recording for each in system.series}
    ends = {run: max(float(system.times[s.rows].max()) for s in system.series if s.recording == run) for run in runs}
    for each in system.series:
        if len(runs) >= FEWEST_RUNS:
            folds[each.rows] = each.recording
        else:
            share = system.times[each.rows] / max(ends[each.recording], 1e-9)
            part = np.clip(share * _QUARTERS, 0, _QUARTERS - 1).astype(np.int64)
            folds[each.rows] = (part + each.recording) % _QUARTERS
    return folds


def fit_to_free_runs(fitted: Fitted, noise: Whitener) -> tuple[Fitted, Whitener]:
    """Return a fitted hypothesis as it predicts free runs best, and the noise by which these count."""
    system, own, near = fitted.problem, dict(noise.system.levels), None
    for _ in range(_WEIGHINGS):
        for signal in own:
            rows = np.concatenate([fitted.residuals[s.rows] for s in system.series if s.signal == signal])
            own[signal] = max(system.levels[signal], float(np.sqrt(np.nanmean(rows**2))))
        noise = white_noise(system, own).scattering_as(noise.levels)
        noise = noise.tamed(fitted.residuals)
        fitted = near = fit(system, noise, fitted.x, iterations=_STEPS, near=near, polish=False)
    return fitted, noise


def left_out(fitted: Fitted, noise: Whitener) -> LeftOut:
    """Return what a hypothesis, as it was fitted under a noise, predicts for rows that it was not fitted to."""
    system = fitted.problem
    folds, local = folds_of(system), system.local
    predicted = np.full(folds.size, np.nan)
    unknowns = []
    for k in np.unique(folds):
        kept = folds != k
        if not np.any(system.known & ~kept) or not np.any(system.known & kept):
            continue
        again = fit(system, noise, fitted.x, iterations=3, rows=kept, near=fitted, polish=False, anew=False)
        x = np.where(local, fitted.x, again.x)
        predicted[~kept] = system.predicted(x)[~kept]
        unknowns.append(x)
    return LeftOut(predicted, np.array(unknowns).reshape(len(unknowns), fitted.x.size))


def foreseen(noise: Whitener, predicted: Array) -> Array:
    """Return the logarithm of the probability, nats up to a constant, of each run or part that was left out, (F,).

    By innovations: what pushes a system in one run is no failing of a model. `predicted`: by fits that have not seen
    the rows, (R,).
    """
    system = noise.system
    folds = folds_of(system)
    bare = replace(noise, loose=None)
    white = bare.whiten(system.measured - predicted)
    return np.array([-0.5 * float(np.sum(white[folds == k] ** 2)) for k in range(int(folds.max()) + 1)])


def foretold(found: Hypothesis) -> Array:
    """Return the logarithm of the probability of each run or part by what the others tell, nats up to a constant, (F,).

    Under the set's own noise, and to first order about the fit to all rows, for a linear system exactly: unknowns
    have the distribution that the other runs leave them, and parameters and rest values differ from run to run as they
    do. What the others leave open counts as open; a single refit would guess it, and be wrong by hundreds
    of nats where pushes hide it.
    """
    fitted, system, levels = found.fitted, found.fitted.problem, found.loose.levels
    bare, folds = replace(found.noise, loose=None), folds_of(system)
    white = bare.whiten(fitted.residuals)
    columns = np.hstack((bare.filtered(fitted.sensitivities), bare.filtered(rests_of(system))))
    unknowns, nuisances, width = fitted.x.size, system.nuisances, columns.shape[1]
    # Of what is common to all runs: a rest value is of one run alone.
    prior = np.concatenate((bare.prior(system), np.full(unknowns - nuisances, 1e-9), np.full(width - unknowns, 1e12)))
    mean = np.append(fitted.x[:nuisances], np.zeros(width - nuisances))
    differs = np.zeros(width)
    if len({each.recording for each in system.series}) >= FEWEST_RUNS:
        differs[: system.parameters] = levels.get("parameters", 0.0) ** 2
    # A part stands for a new run, which rests elsewhere.
    differs[unknowns:] = levels.get("rest", 0.0) ** 2
    runs = [np.flatnonzero(folds == k) for k in range(int(folds.max()) + 1)]
    grams = [columns[run].T @ columns[run] for run in runs]
    pulls = [columns[run].T @ white[run] for run in runs]
    # What a run tells of the unknowns in common, its own differences beside them.
    told = [
        np.linalg.solve(np.eye(width) + gram * differs, np.column_stack((gram, pull)))
        for gram, pull in zip(grams, pulls, strict=True)
    ]
    whole = np.sum(told, axis=0)
    logs = np.zeros(len(runs))
    for k, run in enumerate(runs):
        others = whole - told[k]
        spread = np.linalg.inv(np.diag(prior) + others[:, :-1])
        off = white[run] - columns[run] @ (spread @ (others[:, -1] - prior * mean))
        onto, spread = columns[run].T @ off, spread + np.diag(differs)
        factor = np.eye(width) + spread @ grams[k]
        own = run[system.known[run]]
        logs[k] = -0.5 * (off @ off - onto @ np.linalg.solve(factor, spread @ onto))
        logs[k] -= 0.5 * np.linalg.slogdet(factor)[1] + np.sum(np.log(bare.deviations[own]))
    return logs


def helps_by(gained: Array, seed: int = 0) -> float:
    """Return the probability that what made these runs more probable by so many nats, (F,), does so to a new one.

    By the Bayesian bootstrap over runs (Rubin 1981, Ann. Stat. 9:130).
    """
    weights = np.random.default_rng(seed).dirichlet(np.ones(gained.size), _DRAWS)
    return float(np.mean(weights @ gained > 0.0))
