r"""What moves at random from run to run, and by how much effects may differ from their equations.

Groups of columns, each with a level learned from the rows: rows move along column k by tau_g u_k, u_k ~ N(0, 1). As
parameters differ a little in each run, sensors rest elsewhere, and an effect's equation is an idealisation, what these
could do is no evidence for anything else.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from system_identification.fitting import Fitted
from system_identification.noise import Whitener

__all__ = ["CAPS", "Loose", "columns_of", "learned_levels", "unsteady"]

Array = NDArray[np.float64]
CAPS = {"parameters": 0.4, "rest": 1.0, "shape": 0.1}
"""Largest level by group: of parameters from run to run in their stated deviations, of rest values in deviations of the
sensor's noise, of an effect's trace in shares of it."""
_STEPS = 7
_LEAST = 0.02
_FAR = (0.35, 0.6, 1.0)
"""Shares by which an effect's size may vary that is not one size."""


class Loose(NamedTuple):
    """Levels by group, and what the columns most probably do to the rows (R,)."""

    levels: Mapping[str, float]
    columns: Array
    explained: Array


def columns_of(fitted: Fitted, traces: Mapping[str, Array]) -> dict[str, Array]:
    """Return the columns (R, J) by group; `traces`: what each effect does to the rows (R,), by any name."""
    system = fitted.problem
    runs, count = _runs(fitted)
    groups: dict[str, list[Array]] = {"parameters": [], "rest": [], "shape": []}
    if count > 1:
        own = np.nan_to_num(fitted.sensitivities[:, : system.parameters])
        groups["parameters"] = [own * (runs == run)[:, None] for run in range(count)]
        for each in system.series:
            column = np.zeros((runs.size, 1))
            column[each.rows] = system.levels[each.signal]
            groups["rest"].append(column)
    for trace in traces.values():
        groups["shape"].append(_modulated(fitted, trace, runs, count))
    return {name: np.hstack(found) for name, found in groups.items() if found}


def _runs(fitted: Fitted) -> tuple[NDArray[np.int64], int]:
    """Return which run each row is of (R,), and how many there are."""
    runs = np.zeros(fitted.problem.known.size, dtype=np.int64)
    for each in fitted.problem.series:
        runs[each.rows] = each.recording
    return runs, int(runs.max()) + 1 if runs.size else 0


def _modulated(fitted: Fitted, trace: Array, runs: NDArray[np.int64], count: int) -> Array:
    """Return what a trace would be if its size changed by run, with time, sign or strength, or if it came late."""
    columns = [trace * (runs == run) for run in range(count)] if count > 1 else []
    for part in range(3):
        columns.append(np.zeros(trace.size))
        for each in fitted.problem.series:
            time = fitted.problem.times[each.rows]
            share = (time - time[0]) / max(time[-1] - time[0], 1e-9)
            columns[-1][each.rows] = trace[each.rows] * ((share >= part / 3) & (share < (part + 1) / 3 + 1e-9))
    signs, strengths, rates, powers = (np.zeros(trace.size) for _ in range(4))
    for each in fitted.problem.series:
        own, at = trace[each.rows], fitted.problem.times[each.rows]
        largest = max(float(np.max(np.abs(own))), 1e-300)
        strength = np.abs(own) / largest
        signs[each.rows] = np.abs(own)
        strengths[each.rows] = own * np.log(np.maximum(strength, 1e-3))
        powers[each.rows] = own * np.minimum(strength, 1.0)
        if own.size > 2:
            rates[each.rows] = np.gradient(own, np.maximum.accumulate(at + 1e-9 * np.arange(at.size))) * 0.1
    return np.stack([*columns, signs, strengths, powers, rates], axis=1)


class _Beside:
    """White rows, moved by groups of columns at levels, beside all unknowns re-tuned."""

    def __init__(self, fitted: Fitted, noise: Whitener, groups: Sequence[Array]) -> None:
        system = fitted.problem
        bare = replace(noise, loose=None)
        self.raw = np.hstack(groups)
        self.of = np.repeat(np.arange(len(groups)), [group.shape[1] for group in groups])
        jacobian = bare.whiten(np.nan_to_num(fitted.sensitivities))
        everything = np.hstack((jacobian, bare.whiten(self.raw)))
        self.gram = everything.T @ everything
        self.slope = everything.T @ bare.whiten(np.nan_to_num(fitted.residuals))
        self.unknowns = jacobian.shape[1]
        self.prior = np.full(self.unknowns, 1e-6)
        self.prior[: system.nuisances] += 1.0
        self.pulled = np.zeros(self.gram.shape[0])
        self.pulled[: system.nuisances] = fitted.x[: system.nuisances]

    def score(self, levels: Array) -> tuple[float, Array]:
        """Return the logarithm of the rows' probability at levels, up to a constant, and how far columns are moved."""
        weights = np.concatenate((np.ones(self.unknowns), levels[self.of]))
        information = self.gram * weights[:, None] * weights
        information[np.diag_indices_from(information)] += np.concatenate((self.prior, np.ones(self.of.size)))
        factor = np.linalg.cholesky(information)
        solved = solve_triangular(factor, weights * self.slope - self.pulled, lower=True)
        moved = solve_triangular(factor.T, solved) * weights
        return float(0.5 * solved @ solved - np.sum(np.log(np.diag(factor)))), moved[self.unknowns :]


def learned_levels(fitted: Fitted, noise: Whitener, groups: Mapping[str, Array]) -> Loose:
    """Return the levels under which the rows are most likely, the other unknowns re-tuned beside them."""
    if not groups:
        nothing = np.zeros(fitted.problem.known.size)
        return Loose({}, nothing[:, None][:, :0], nothing)
    names = list(groups)
    beside = _Beside(fitted, noise, list(groups.values()))
    levels = np.array([0.1 * CAPS[name] for name in names])
    for _ in range(2):
        for g, name in enumerate(names):
            tried = np.concatenate(([0.0], np.geomspace(_LEAST * CAPS[name], CAPS[name], _STEPS)))
            found = [beside.score(np.where(np.arange(len(names)) == g, level, levels))[0] for level in tried]
            levels[g] = tried[int(np.argmax(found))]
    moved = beside.score(levels)[1]
    return Loose(dict(zip(names, levels.tolist(), strict=True)), beside.raw * levels[beside.of], beside.raw @ moved)


def unsteady(fitted: Fitted, noise: Whitener, loose: Loose, traces: Mapping[str, Array]) -> dict[str, float]:
    """Return by effect the evidence, nats, that its size is not one size: that it changes with run, time or state.

    By more than an equation may be off, up to as much as the effect itself: then another one is at work, which this one
    resembles.
    """
    if not traces:
        return {}
    groups = columns_of(fitted, {})
    runs, count = _runs(fitted)
    shapes = {key: _modulated(fitted, trace, runs, count) for key, trace in traces.items()}
    names = [*groups, *shapes]
    beside = _Beside(fitted, noise, [*groups.values(), *shapes.values()])
    usual = np.array([loose.levels.get(name, loose.levels.get("shape", 0.0)) for name in names])
    found = {}
    for key in shapes:
        own = np.array([name == key for name in names])
        near, far = (
            max(beside.score(np.where(own, level, usual))[0] for level in levels)
            for levels in (np.linspace(0.0, CAPS["shape"], 4), _FAR)
        )
        found[key] = far - near
    return found
