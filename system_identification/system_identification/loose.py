r"""What moves at random from run to run, and by how much effects may differ from their equations.

Groups of columns, each with a level learned from the rows: rows move along column k by tau_g u_k, u_k ~ N(0, 1). As
parameters differ a little in each run, sensors rest elsewhere, and an effect's equation is an idealisation, what these
could do is no evidence for anything else.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted
from system_identification.noise import Whitener

__all__ = ["CAPS", "Loose", "columns_of", "learned_levels"]

Array = NDArray[np.float64]
CAPS = {"parameters": 0.4, "rest": 1.0, "shape": 0.1}
"""Largest level by group: of parameters from run to run in their stated deviations, of rest values in deviations of the
sensor's noise, of an effect's trace in shares of it."""
_STEPS = 7
_LEAST = 0.02


class Loose(NamedTuple):
    """Levels by group, and what the columns most probably do to the rows (R,)."""

    levels: Mapping[str, float]
    columns: Array
    explained: Array


def columns_of(fitted: Fitted, traces: Mapping[str, Array]) -> dict[str, Array]:
    """Return the columns (R, J) by group; `traces`: what each effect does to the rows (R,), by any name."""
    system = fitted.problem
    runs = np.zeros(system.known.size, dtype=np.int64)
    for each in system.series:
        runs[each.rows] = each.recording
    count = int(runs.max()) + 1 if runs.size else 0
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


def learned_levels(fitted: Fitted, noise: Whitener, groups: Mapping[str, Array]) -> Loose:
    """Return the levels under which the rows are most likely, the other unknowns re-tuned beside them."""
    system = fitted.problem
    if not groups:
        nothing = np.zeros(system.known.size)
        return Loose({}, nothing[:, None][:, :0], nothing)
    bare = noise if noise.loose is None else noise.loosened(np.zeros((system.known.size, 0)))
    white = bare.whiten(np.nan_to_num(fitted.residuals))
    jacobian = bare.whiten(np.nan_to_num(fitted.sensitivities))
    names = list(groups)
    sizes = [groups[name].shape[1] for name in names]
    of = np.repeat(np.arange(len(names)), sizes)
    raw = np.hstack([groups[name] for name in names])
    loose = bare.whiten(raw)
    everything = np.hstack((jacobian, loose))
    gram, slope = everything.T @ everything, everything.T @ white
    k = jacobian.shape[1]
    prior = np.zeros(k)
    prior[: system.nuisances] = 1.0
    pulled = np.zeros(gram.shape[0])
    pulled[: system.nuisances] = fitted.x[: system.nuisances]

    def scores(levels: Array) -> tuple[float, Array]:
        weights = np.concatenate((np.ones(k), levels[of]))
        information = gram * weights[:, None] * weights + np.diag(np.concatenate((prior + 1e-6, np.ones(of.size))))
        pull = weights * slope - pulled
        factor = np.linalg.cholesky(information)
        solved = np.linalg.solve(factor, pull)
        moved = np.linalg.solve(factor.T, solved)
        return float(0.5 * solved @ solved - np.sum(np.log(np.diag(factor)))), moved * weights

    levels = np.array([0.1 * CAPS[name] for name in names])
    for _ in range(2):
        for g, name in enumerate(names):
            tried = np.concatenate(([0.0], np.geomspace(_LEAST * CAPS[name], CAPS[name], _STEPS)))
            found = [scores(np.where(np.arange(len(names)) == g, level, levels))[0] for level in tried]
            levels[g] = tried[int(np.argmax(found))]
    moved = scores(levels)[1][k:]
    return Loose(dict(zip(names, levels.tolist(), strict=True)), raw * levels[of], np.asarray(raw @ moved))
