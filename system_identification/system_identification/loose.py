r"""What moves at random from run to run, and by how much effects may differ from their equations.

Groups of columns, each with a level learned from the rows: rows move along column k by tau_g u_k, u_k ~ N(0, 1). As
parameters differ a little in each run, sensors rest elsewhere, and an effect's equation is an idealisation, what these
could do is no evidence for anything else. Clocks, which move what is steep by much, are unknowns of each run instead,
and how widely they scatter is learned beside.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from system_identification.fitting import Fitted, reweighed
from system_identification.moves import Moves, TakenOff, rows_of_runs
from system_identification.noise import Whitener
from system_identification.suspects import Suspect
from system_identification.system import System
from system_identification.traces import traces_of

__all__ = ["CAPS", "Groups", "Loose", "groups_of", "learned_levels", "rests_of", "unsteady"]

Array = NDArray[np.float64]
CAPS = {"parameters": 0.4, "rest": 1.0, "shape": 0.1}
"""Largest level by group: of parameters from run to run in their stated deviations, of rest values in deviations of a
single reading's noise, of an effect's trace in shares of it."""
_REST_OF_ONE = CAPS["rest"] / 3.0
"""Level of rest values where there is one run: how they differ is learned from several, and the largest level is as far
as a rest value goes. Three deviations reach it. A level learned from the run would be the effect itself: as large."""
_STEPS = 7
_WIDER = (1.0, 1.25, 1.6, 2.0, 2.5, 3.2, 4.0)
"""By how much parameters may scatter more widely than stated: a stated deviation is often a guess."""
_LEAST = 0.02
_CONVENTIONS = (0.1, 0.25, 0.5, 1.0, 1.4, 2.0, 2.8)
"""By how much conventions may scatter from run to run more widely than stated."""
_ANY = 100.0
"""By how much more widely than stated what conventions have in common may scatter while it is asked how they differ."""
_NEAR, _FAR = (0.0, 0.03, 0.07, 0.1, 0.15, 0.2), (0.35, 0.6, 1.0)
"""Shares by which an effect's size may vary because its equation is off, and by which one does that is not one size."""


class Loose(NamedTuple):
    """Levels by group, and what the columns most probably do to the rows, (R,)."""

    levels: Mapping[str, float]
    explained: Array


class Groups(NamedTuple):
    """Moves of rows in the signals' units, and which group each is of, (J,), by its place among the names."""

    names: tuple[str, ...]
    moves: Moves
    of: NDArray[np.int64]


def groups_of(fitted: Fitted, suspects: Sequence[Suspect], *, apart: bool = False) -> Groups:
    """Return what may move the rows, by group.

    `suspects`: all of the fit; `apart`: each is a group by its key. The first columns are the sensitivities to the
    parameters. In a single run parameters, and an effect's size as a whole, are unknowns already; rest values are not.
    """
    system = fitted.problem
    runs = rows_of_runs(system)
    count, shared = len(runs), system.parameters
    columns = [fitted.sensitivities[:, :shared]]
    mixed: list[Array] = []
    of: list[str] = []
    every = shared

    def move(group: str, by_run: Array) -> None:
        """Add moves of the columns added last, (runs, columns, moves)."""
        padded = np.zeros((count, every, by_run.shape[2]))
        padded[:, every - by_run.shape[1] :] = by_run
        mixed.append(padded)
        of.extend([group] * by_run.shape[2])

    def each_run(width: int) -> Array:
        """Return moves of so many columns in each run by itself."""
        return np.einsum("rs,bc->rbsc", np.eye(count), np.eye(width)).reshape(count, width, count * width)

    if count > 1:
        move("parameters", each_run(shared))
    rest = rests_of(system)
    there = np.zeros((count, len(system.signal_names)), dtype=np.bool_)
    numbers = {recording: run for run, recording in enumerate(dict.fromkeys(s.recording for s in system.series))}
    for each in system.series:
        there[numbers[each.recording], system.signal_names.index(each.signal)] = True
    columns.append(rest)
    every += rest.shape[1]
    move("rest", each_run(rest.shape[1])[:, :, there.ravel()])
    for suspect, trace in zip(suspects, traces_of(fitted, suspects).values(), strict=True):
        shapes = np.column_stack((_as_large(fitted, suspect, trace), _modulated(fitted, trace)))
        columns.append(shapes)
        every += shapes.shape[1]
        alike = np.tile(np.eye(shapes.shape[1])[:, 1:], (count, 1, 1))
        by_run = np.zeros((count, shapes.shape[1], count if count > 1 else 0))
        by_run[:, :1] = each_run(1)[:, :, : by_run.shape[2]]
        move(suspect.key if apart else "shape", np.concatenate((by_run, alike), axis=2))
    names = tuple(dict.fromkeys(of))
    whole = [np.pad(each, ((0, 0), (0, every - each.shape[1]), (0, 0))) for each in mixed]
    return Groups(
        names,
        Moves(runs, np.hstack(columns), np.concatenate([np.zeros((count, every, 0)), *whole], axis=2)),
        np.array([names.index(group) for group in of], dtype=np.int64),
    )


def rests_of(system: System) -> Array:
    """Return what a rest value that is off by a deviation of a reading's noise moves, by signal, (R, signals).

    Of a single reading's: how fast a sensor is read says nothing of where it rests.
    """
    rest = np.zeros((system.known.size, len(system.signal_names)))
    for each in system.series:
        rest[each.rows, system.signal_names.index(each.signal)] = system.single[each.signal]
    return rest


def _as_large(fitted: Fitted, suspect: Suspect, trace: Array) -> Array:
    """Return what a suspect does to the rows (R,) by as much of its size as all of it; its trace, where it has none.

    A rotor that dry friction holds does not feel a little more of it: such a trace does not grow with the size.
    """
    at = fitted.problem.nuisances + list(fitted.problem.slots).index(suspect.slots[0])
    return np.asarray(fitted.sensitivities[:, at] * fitted.x[at] if suspect.scalable else trace)


def _modulated(fitted: Fitted, trace: Array) -> Array:
    """Return what a trace were if its size changed with time, sign or strength, or if it came late, (R, 7)."""
    columns = []
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

    def __init__(self, fitted: Fitted, noise: Whitener, groups: Groups) -> None:
        system, (_, moves, self.of) = fitted.problem, groups
        bare = replace(noise, loose=None)
        self.jacobian = bare.filtered(fitted.sensitivities)
        shared = system.parameters
        rest = bare.filtered(moves.columns[:, shared:])
        self.moves = moves._replace(columns=np.asfortranarray(np.hstack((self.jacobian[:, :shared], rest))))
        # Unknowns are moves too, alike in every run.
        unknowns = self.jacobian.shape[1]
        others = moves.mixed[:, shared:]
        mixed = np.zeros((len(moves.runs), unknowns + others.shape[1], unknowns + self.of.size))
        mixed[:, :unknowns, :unknowns] = np.eye(unknowns)
        mixed[:, :shared, unknowns:] = moves.mixed[:, :shared]
        mixed[:, unknowns:, unknowns:] = others
        everything = Moves(moves.runs, np.asfortranarray(np.hstack((self.jacobian, rest))), mixed)
        self.gram = everything.gram
        self.slope = everything.onto(bare.whiten(fitted.residuals)[:, None])[:, 0]
        self.unknowns, self.parameters, self.levels = unknowns, system.parameters, noise.levels
        self.conventions, self.shared = system.conventions, system.shared_conventions
        self.nuisances = fitted.x[: system.nuisances]

    def score(self, levels: Array, wider: float, conventions: float, shared: float = 1.0) -> tuple[float, Array]:
        """Return the logarithm of the rows' probability at levels, up to a constant, and how far columns are moved.

        `wider`, `conventions`, `shared`: how many times wider than stated the parameters, conventions of runs, and
        those of all runs, scatter.
        """
        weights = np.concatenate((np.ones(self.unknowns), levels[self.of]))
        precision = np.ones(self.nuisances.size)
        precision[: self.parameters] /= wider**2
        precision[self.conventions] /= conventions**2
        precision[self.shared] /= shared**2
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

    def taken_off(self, levels: Array) -> TakenOff:
        """Return the map that takes moves at these levels off white rows."""
        by = levels[self.of]
        gram = self.gram[self.unknowns :, self.unknowns :] * by[:, None] * by
        return TakenOff.of(self.moves.scaled(by), gram[np.ix_(by != 0.0, by != 0.0)])


def _tried(name: str, runs: int) -> Array:
    """Return the levels of a group among which the likeliest is taken."""
    if name == "rest" and runs == 1:
        return np.array([_REST_OF_ONE])
    return np.concatenate(([0.0], np.geomspace(_LEAST * CAPS[name], CAPS[name], _STEPS)))


def learned_levels(fitted: Fitted, noise: Whitener, groups: Groups) -> tuple[Loose, Fitted, Whitener]:
    """Return the levels under which the rows are most likely, the other unknowns re-tuned beside them.

    And the fit as it is, with its evidence, under the noise that has them; and that noise, whose levels say how widely
    parameters and conventions scatter.
    """
    count = len(groups.names)
    beside = _Beside(fitted, noise, groups)
    levels = np.array([0.1 * CAPS[name] for name in groups.names])
    wider, conventions = noise.levels.parameters, noise.levels.conventions
    for _ in range(2):
        wider = max(_WIDER, key=lambda factor: beside.score(levels, factor, conventions)[0])
        if np.any(beside.conventions):
            # By how much they differ: what they have in common is a delay's.
            conventions = max(_CONVENTIONS, key=lambda factor: beside.score(levels, wider, factor, _ANY)[0])
        for g, name in enumerate(groups.names):
            tried = _tried(name, len(groups.moves.runs))
            found = [
                beside.score(np.where(np.arange(count) == g, level, levels), wider, conventions)[0] for level in tried
            ]
            levels[g] = tried[int(np.argmax(found))]
    moved = beside.score(levels, wider, conventions)[1]
    scatter = replace(noise.levels, parameters=wider, conventions=conventions)
    whole = replace(noise, levels=scatter, loose=beside.taken_off(levels))
    loose = Loose(dict(zip(groups.names, levels.tolist(), strict=True)), groups.moves.along(moved))
    return loose, reweighed(fitted, whole, beside.jacobian), whole


def unsteady(fitted: Fitted, noise: Whitener, loose: Loose, suspects: Sequence[Suspect]) -> dict[str, float]:
    """Return by effect the evidence, nats, that its size is not one size: that it changes with run, time or state.

    By more than an equation may be off, up to as much as the effect itself: then another one is at work, which this one
    resembles.
    """
    if not suspects:
        return {}
    groups = groups_of(fitted, suspects, apart=True)
    beside = _Beside(fitted, noise, groups)
    usual = np.array([loose.levels.get(name, loose.levels.get("shape", 0.0)) for name in groups.names])
    found, scatter = {}, noise.levels
    for key in (each.key for each in suspects):
        own = np.array([name == key for name in groups.names])
        near, far = (
            max(
                beside.score(np.where(own, level, usual), scatter.parameters, scatter.conventions)[0]
                for level in levels
            )
            for levels in (_NEAR, _FAR)
        )
        found[key] = far - near
    return found
