r"""What can be known about a case: how far off its effects are to see, and what share of the gap each makes.

Distance of an effect (Fisher): what is left of the readings y with it, in units of their noise, once the parameters of
a simulation m without it are re-tuned, theta stated deviations (5 %) each, and random pushes c are allowed for,

    D^2 = min |y - m(theta) - P c|^2 + |theta|^2 + |c|^2

where P P^T is the covariance of what pushes of rotor and water do, complete for paths of instants `_SPACING` apart. A
sample of paths would not do: what none of its few has by chance would count as if nothing could push it. To first order
D^2 is d^T (I + J J^T + P P^T)^-1 d for what the effect moves, d; but an effect that moves readings by a hundred times
their noise is not small: what a parameter does exactly, as k_n does viscous friction, would seem far from it.

Share of a cause: Shapley value of "squared gap removed" for the traces t_i of the causes alone (all parameters are one
cause), to which their interactions (full gap less sum of traces) are given in equal parts: <t_i, g> / |g|^2.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.scoreboard.case import Generator, Push, Truth

__all__ = ["PARAMETERS", "SCATTERS", "distances", "pushed", "shares"]

Array = NDArray[np.float64]
PARAMETERS = "parameters"
"""Name of all parameters together as one cause."""
SCATTERS = ("timestamp_jitter", "dropped_samples", "flow_spikes")
"""Effects that move no reading in the mean: no distance is stated for them."""
_SPACING = 0.1
"""Of the instants [s] of a path of pushes."""
_APART, _EARLY = 30, 5
"""Instants after which the rotor has forgotten a push, so that others may follow in the same simulation; by how many a
stamp may be early."""
_MODES = 96
"""Modes of the path of the water (Karhunen and Loeve), which forgets later; faster ones hardly move its inertia."""
_DEVIATION, _STEP = 0.05, 0.01
_RETUNINGS, _FURTHER = 12, 0.98
"""Steps of a re-tuning, and share of what is left that a step must go below for another one."""
_STUCK = 1e4
"""Damping at which no step leads on."""


def distances(generator: Generator, truth: Truth) -> dict[str, float]:
    """Return the distance of every effect of a case, known or not, that moves the readings of `clean`."""
    hidden = [name for name in {**truth.effects, **truth.outside} if name not in SCATTERS]
    if not hidden:
        return {}

    def clean(effects: dict, outside: dict, factors: Mapping[str, float], push: Push | None = None) -> Array:  # type: ignore[type-arg]
        return generator.clean(truth, effects, outside, factors, push)

    effects, outside, factors = dict(truth.effects), dict(truth.outside), dict(truth.factors)
    here = clean(effects, outside, factors)
    tuned = [
        name
        for name, factor in factors.items()
        if np.any(clean(effects, outside, {**factors, name: factor * (1.0 + _STEP)}) != here)
    ]
    whitened = _whitening(pushed(generator, truth, lambda push: clean(effects, outside, factors, push) - here))
    found = {}
    for name in hidden:
        rest, others = ({k: s for k, s in table.items() if k != name} for table in (effects, outside))
        if not np.any(here - clean(rest, others, factors)):
            continue  # an effect of the log, or another class of model, which `clean` does not know

        def left(theta: Array) -> Array:
            moved = {k: factors[k] * max(1.0 + _DEVIATION * t, _STEP) for k, t in zip(tuned, theta, strict=True)}
            return whitened(here - clean(rest, others, {**factors, **moved}))  # noqa: B023

        found[name] = float(np.sqrt(_left_after_retuning(left, len(tuned))))
    return found


def pushed(generator: Generator, truth: Truth, moved: Callable[[Push], Array]) -> Array:
    """Return what each deviation of what pushes a case moves its readings by, (runs, R, C).

    `moved`: what a path moves them by, (runs, R).
    """
    seen: dict[int, tuple[float, float]] = {}

    def still(row: int, at: Array, memory: float) -> Array:
        seen[row] = (float(at[-1]), memory)
        return np.zeros(at.size)

    none = moved(still)
    if not seen:
        return none[:, :, None][:, :, :0]

    def along(of: int, values: Array) -> Array:
        """Return what a path of these values every `_SPACING` moves the readings by."""
        return moved(lambda row, at, _: np.interp(at, _SPACING * np.arange(values.size), values * (row == of)))

    (length, memory), (_, of_water) = seen[0], seen[1]
    count = int(np.ceil(length / _SPACING)) + 1
    # Stamps are those of `record`, where nothing is lost.
    runs = generator.record(replace(truth, effects={}, outside={}))
    stamps = np.array([np.concatenate([signal.time for signal in run.signals.values()]) for run in runs])
    nearest = np.rint((stamps + length - stamps.max()) / _SPACING).astype(int) + _EARLY
    by_instant = np.zeros((*stamps.shape, count))
    for first in range(_APART):
        answers = along(0, (np.arange(count) % _APART == first).astype(float))
        by = nearest - (nearest - first) % _APART
        run, row = np.nonzero((by >= 0) & (by < count))
        by_instant[run, row, by[run, row]] = answers[run, row]
    rotor = by_instant @ np.linalg.cholesky(_together(count, memory) + 1e-9 * np.eye(count))
    values, vectors = np.linalg.eigh(_together(count, of_water))
    modes = (vectors * np.sqrt(np.maximum(values, 0.0)))[:, : -_MODES - 1 : -1]
    return np.concatenate((rotor, np.stack([along(1, mode) for mode in modes.T], axis=2)), axis=2)


def _together(count: int, memory: float) -> Array:
    """Return the covariance of a path of deviation 1 and a memory [s] at so many instants."""
    at = _SPACING * np.arange(count)
    return np.asarray(np.exp(-np.abs(at[:, None] - at) / memory))


def _whitening(pushes: Array) -> Callable[[Array], Array]:
    """Return the map that makes readings (runs, R) white, which have noise of deviation 1 and are pushed along columns
    (runs, R, C) of their own in each run; (runs R,).
    """
    maps = []
    for columns in pushes:
        values, vectors = np.linalg.eigh(columns.T @ columns)
        values, vectors = values[values > 1e-9], vectors[:, values > 1e-9]
        maps.append((columns, (vectors * ((1.0 - 1.0 / np.sqrt(1.0 + values)) / values)) @ vectors.T))

    def white(readings: Array) -> Array:
        pairs = zip(readings, maps, strict=True)
        return np.concatenate([own - columns @ (core @ (columns.T @ own)) for own, (columns, core) in pairs])

    return white


def _left_after_retuning(left: Callable[[Array], Array], count: int) -> float:
    """Return the least of |left(theta)|^2 + |theta|^2, by Levenberg and Marquardt.

    Slopes are found anew at each step: what moves readings by a thousand times their noise is not linear.

    Args:
        left: what is left of the readings, white, for parameters theta, (count,).
        count: number of parameters.
    """
    theta, damping = np.zeros(count), 1e-3
    here = left(theta)
    least = float(here @ here)
    for _ in range(_RETUNINGS):
        slopes = np.array([left(theta + _STEP / _DEVIATION * unit) - here for unit in np.eye(count)]).T
        slopes = slopes.reshape(here.size, count) * (_DEVIATION / _STEP)
        information, pull = slopes.T @ slopes + np.eye(count), -slopes.T @ here - theta
        before = least
        while damping < _STUCK:
            step = np.linalg.solve(information + damping * np.diag(np.diag(information)), pull)
            there = left(theta + step)
            cost = float(there @ there + (theta + step) @ (theta + step))
            if cost < least:
                theta, here, least, damping = theta + step, there, cost, 0.1 * damping
                break
            damping *= 10.0
        if least > _FURTHER * before:
            break
    return least


def shares(generator: Generator, truth: Truth) -> dict[str, float]:
    """Return the share of the gap that parameters and every effect make; empty where there is no gap."""
    plain: dict[str, float] = {}
    stated = generator.clean(truth, {}, {}, plain, None)
    gap = generator.clean(truth, truth.effects, truth.outside, truth.factors, None) - stated
    size = float(np.vdot(gap, gap))
    if size == 0.0:
        return {}
    traces = {PARAMETERS: generator.clean(truth, {}, {}, truth.factors, None) - stated}
    for name, sizes in truth.effects.items():
        traces[name] = generator.clean(truth, {name: sizes}, {}, plain, None) - stated
    for name, sizes in truth.outside.items():
        traces[name] = generator.clean(truth, {}, {name: sizes}, plain, None) - stated
    together = (gap - np.sum(list(traces.values()), axis=0)) / len(traces)
    return {name: float(np.vdot(trace + together, gap)) / size for name, trace in traces.items()}
