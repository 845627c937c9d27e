r"""What can be known about a case: how far off its effects are to see, and what share of the gap each makes.

Distance of an effect (Fisher): what is left of the readings y with it, in units of their noise, once the parameters of
a simulation m without it are re-tuned, theta stated deviations (5 %) each, and random pushes c are allowed for,

    D^2 = min |y - m(theta) - P c|^2 + |theta|^2 + |c|^2

where P P^T is the covariance of what pushes of rotor and water do, from `_PUSHES` draws. To first order that is
d^T (I + J J^T + P P^T)^-1 d for what the effect moves, d; but an effect that moves readings by a hundred times their
noise is not small: what a parameter does exactly, as k_n does viscous friction, would seem far from it.

Share of a cause: Shapley value of "squared gap removed" for the traces t_i of the causes alone (all parameters are one
cause), to which their interactions (full gap less sum of traces) are given in equal parts: <t_i, g> / |g|^2.
"""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.scoreboard.case import Generator, Truth

__all__ = ["PARAMETERS", "SCATTERS", "distances", "shares"]

Array = NDArray[np.float64]
PARAMETERS = "parameters"
"""Name of all parameters together as one cause."""
SCATTERS = ("timestamp_jitter", "dropped_samples", "flow_spikes")
"""Effects that move no reading in the mean: no distance is stated for them."""
_PUSHES = 24
_DEVIATION, _STEP = 0.05, 0.01
_RETUNINGS, _FURTHER = 12, 0.98
"""Steps of a re-tuning, and share of what is left that a step must go below for another one."""
_STUCK = 1e4
"""Damping at which no step leads on."""


def distances(generator: Generator, truth: Truth) -> dict[str, float]:
    """Return the distance of every effect of a case, known or not, that moves the readings of `clean`."""
    hidden = {**truth.effects, **truth.outside}
    if not hidden:
        return {}

    def clean(effects: dict, outside: dict, factors: Mapping[str, float], push: int | None = None) -> Array:  # type: ignore[type-arg]
        return generator.clean(truth, effects, outside, factors, push)

    effects, outside, factors = dict(truth.effects), dict(truth.outside), dict(truth.factors)
    here = clean(effects, outside, factors)
    tuned = [
        name
        for name, factor in factors.items()
        if np.any(clean(effects, outside, {**factors, name: factor * (1.0 + _STEP)}) != here)
    ]
    drawn = [clean(effects, outside, factors, 10_000 + seed) - here for seed in range(_PUSHES)]
    pushes = np.reshape([each for each in drawn if np.any(each)], (-1, here.size)).T / np.sqrt(_PUSHES)
    found = {}
    for name in hidden:
        if name in SCATTERS:
            continue
        rest, others = ({k: s for k, s in table.items() if k != name} for table in (effects, outside))
        left = here - clean(rest, others, factors)
        if not np.any(left):  # an effect of the log, or another class of model, which `clean` does not know
            continue

        def without(theta: Array) -> Array:
            moved = {k: factors[k] * max(1.0 + _DEVIATION * t, _STEP) for k, t in zip(tuned, theta, strict=True)}
            return here - clean(rest, others, {**factors, **moved})  # noqa: B023

        found[name] = float(np.sqrt(_left_after_retuning(without, pushes, len(tuned))))
    return found


def _left_after_retuning(without: Callable[[Array], Array], pushes: Array, count: int) -> float:
    """Return the least of |without(theta) - P c|^2 + |theta|^2 + |c|^2, by Levenberg and Marquardt.

    Slopes are found anew at each step: what moves readings by a thousand times their noise is not linear.

    Args:
        without: what is left of the readings for parameters theta, (count,).
        pushes: P, (R, C).
        count: number of parameters.
    """
    theta, damping = np.zeros(count), 1e-3
    left = without(theta)
    least = _cost(left, theta, pushes)
    for _ in range(_RETUNINGS):
        slopes = np.array([without(theta + _STEP / _DEVIATION * unit) - left for unit in np.eye(count)]).T
        both = np.hstack((-slopes * (_DEVIATION / _STEP), pushes))
        information, pull = both.T @ both, both.T @ left
        pull[:count] -= theta
        information[np.diag_indices(both.shape[1])] += 1.0
        before = least
        while damping < _STUCK:
            damped = information.copy()
            damped[np.arange(count), np.arange(count)] *= 1.0 + damping
            step = np.linalg.solve(damped, pull)[:count]
            there = without(theta + step)
            cost = _cost(there, theta + step, pushes)
            if cost < least:
                theta, left, least, damping = theta + step, there, cost, 0.1 * damping
                break
            damping *= 10.0
        if least > _FURTHER * before:
            break
    return least


def _cost(left: Array, theta: Array, pushes: Array) -> float:
    """Return |left - P c|^2 + |c|^2 + |theta|^2 at its best c."""
    along = pushes.T @ left
    taken = along @ np.linalg.solve(np.eye(pushes.shape[1]) + pushes.T @ pushes, along)
    return float(left @ left - taken + theta @ theta)


def shares(generator: Generator, truth: Truth) -> dict[str, float]:
    """Return the share of the gap that parameters and every effect make; empty where there is no gap."""
    plain: dict[str, float] = {}
    stated = generator.clean(truth, {}, {}, plain, None)
    gap = generator.clean(truth, truth.effects, truth.outside, truth.factors, None) - stated
    size = float(gap @ gap)
    if size == 0.0:
        return {}
    traces = {PARAMETERS: generator.clean(truth, {}, {}, truth.factors, None) - stated}
    for name, sizes in truth.effects.items():
        traces[name] = generator.clean(truth, {name: sizes}, {}, plain, None) - stated
    for name, sizes in truth.outside.items():
        traces[name] = generator.clean(truth, {}, {name: sizes}, plain, None) - stated
    together = (gap - np.sum(list(traces.values()), axis=0)) / len(traces)
    return {name: float((trace + together) @ gap) / size for name, trace in traces.items()}
