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
_WIDER = (1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0)
"""By how much parameters may scatter more widely than stated: a stated deviation is often a guess."""
_LEAST = 0.02
_FAR = (0.35, 0.6, 1.0)
"""Shares by which an effect's size may vary that is not one size."""


class Loose(NamedTuple):
    """Levels by group, what the columns most probably do to the rows (R,), and how widely parameters scatter."""

    levels: Mapping[str, float]
    columns: Array
    explained: Array
    wider: float = 1.0


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
        self.raw = np.hstack((np.zeros((system.known.size, 0)), *groups))
        self.of = np.repeat(np.arange(len(groups)), [group.shape[1] for group in groups]).astype(np.int64)
        jacobian = bare.whiten(np.nan_to_num(fitted.sensitivities))
        everything = np.hstack((jacobian, bare.whiten(self.raw)))
        self.gram = everything.T @ everything
        self.slope = everything.T @ bare.whiten(np.nan_to_num(fitted.residuals))
        self.unknowns, self.parameters, self.levels = jacobian.shape[1], system.parameters, noise.levels
        self.nuisances = fitted.x[: system.nuisances]

    def score(self, levels: Array, wider: float) -> tuple[float, Array]:
        """Return the logarithm of the rows' probability at levels, up to a constant, and how far columns are moved.

        `wider`: how many times wider than stated the parameters scatter.
        """
        weights = np.concatenate((np.ones(self.unknowns), levels[self.of]))
        precision = np.ones(self.nuisances.size)
        precision[: self.parameters] /= wider**2
        prior = np.concatenate((precision, np.zeros(self.unknowns - precision.size), np.ones(self.of.size)))
        pull = weights * self.slope
        pull[: precision.size] -= precision * self.nuisances
        information = self.gram * weights[:, None] * weights
        information[np.diag_indices_from(information)] += prior + 1e-6
        factor = np.linalg.cholesky(information)
        solved = solve_triangular(factor, pull, lower=True)
        moved = solve_triangular(factor.T, solved) * weights
        cost = float(precision @ self.nuisances**2) - float(np.sum(np.log(precision)))
        cost -= 2.0 * replace(self.levels, parameters=wider).log_prior
        return float(0.5 * (solved @ solved - cost) - np.sum(np.log(np.diag(factor)))), moved[self.unknowns :]


def learned_levels(fitted: Fitted, noise: Whitener, groups: Mapping[str, Array]) -> Loose:
    """Return the levels under which the rows are most likely, the other unknowns re-tuned beside them."""
    names = list(groups)
    beside = _Beside(fitted, noise, list(groups.values()))
    levels, wider = np.array([0.1 * CAPS[name] for name in names]), noise.levels.parameters
    for _ in range(2):
        wider = max(_WIDER, key=lambda factor: beside.score(levels, factor)[0])
        for g, name in enumerate(names):
            tried = np.concatenate(([0.0], np.geomspace(_LEAST * CAPS[name], CAPS[name], _STEPS)))
            found = [beside.score(np.where(np.arange(len(names)) == g, level, levels), wider)[0] for level in tried]
            levels[g] = tried[int(np.argmax(found))]
    moved = beside.score(levels, wider)[1]
    by_name = dict(zip(names, levels.tolist(), strict=True))
    return Loose(by_name, beside.raw * levels[beside.of], beside.raw @ moved, wider)


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
            max(beside.score(np.where(own, level, usual), loose.wider)[0] for level in levels)
            for levels in (np.linspace(0.0, CAPS["shape"], 4), _FAR)
        )
        found[key] = far - near
    return found
