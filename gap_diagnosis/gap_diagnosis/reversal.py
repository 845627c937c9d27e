"""Thrust that is lost after a reversal until the water follows: when it does is read from the thrust itself.

The axial flow is not measured. What pushes it at random moves the instant at which it turns by as much as turning
takes, so that what is simulated jumps elsewhere than what was recorded. Each stretch between two reversals of the rotor
may begin with a loss, and that ends when the thrust says so. Every end was searched among all samples of its stretch,
which is its price.
"""

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.lost_thrust import falls_of
from gap_diagnosis.problem import Problem
from gap_diagnosis.suspects import found_by, slots_of
from system_identification.fitting import fit, fit_past_jumps
from system_identification.hypothesis import Hypothesis
from system_identification.noise import whitener
from system_identification.rating import rated, tried
from system_identification.suspects import Suspect
from thruster_model.effects.effect import AGAINST, WITH

__all__ = ["REVERSAL", "turns_beside"]

Array = NDArray[np.float64]
(REVERSAL,) = found_by("turns")
_SHARES = (0.1, 0.2, 0.35, 0.55, 0.75)
_ROUNDS, _STEPS = 4, 6
_LITTLE = 0.01  # of the share, over its range


class _Read(NamedTuple):
    """Stretches of loss for one share, their price, and what they explain beyond that, nats."""

    gain: float
    share: float
    price: float
    gates: tuple[Array, ...]


def turns_beside(beside: Hypothesis) -> Suspect | None:
    """Return the loss as a suspect beside a hypothesis, with the stretches that the thrust tells.

    None where it tells none, or none better than the flow as it is simulated.
    """
    problem = beside.system
    if all(each.signal != "thrust" for each in problem.series):
        return None
    deviation, (slot,) = beside.noise.level("thrust"), slots_of(REVERSAL)
    stated = beside.fitted.x.copy()
    stated[: len(problem.names)] = 0.0
    # Parameters that had to make up for the loss may have moved far: it may be plainer beside those as stated.
    both = [(_first(problem, x, deviation), x) for x in (beside.fitted.x, stated)]
    read, x = max(both, key=lambda one: one[0].gain)
    told = [_suspect(each, np.array([[each.share / slot.width]])) for each, _ in both if each.gain > 0.0]
    rates = rated(beside.fitted, beside.noise, tried(beside.fitted, told, partial(problem.tried, beside.fitted.x)))
    if not rates or rates[0].promise <= 0.0:  # to first order it is not worth its price
        return None
    for _ in range(_ROUNDS):
        posed = problem.with_effects((*problem.slots, slot), read.gates)
        start = np.append(x, read.share / slot.width)
        fitted = fit(posed, whitener(posed, start), start, near=beside.fitted, iterations=_STEPS, polish=False)
        x = fitted.x[:-1]
        again = _again(posed, fitted.x, deviation)
        if all(np.array_equal(a, b) for a, b in zip(again.gates, read.gates, strict=True)):
            break
        read = again
    posed = problem.with_effects((*problem.slots, slot), read.gates)
    ended = fit(posed, beside.noise, fitted.x, near=beside.fitted, iterations=_STEPS, polish=False)
    worth = ended.evidence - read.price
    if worth <= beside.fitted.evidence:
        return None
    simulated = problem.with_effects((*problem.slots, slot))
    starts = ended.x, np.append(stated, ended.x[-1])
    if any(worth <= fit_past_jumps(simulated, beside.noise, each).evidence for each in starts):
        return None
    return _suspect(read, fitted.x[-1:][None].copy())


def _suspect(read: _Read, grid: Array) -> Suspect:
    """Return the loss in the stretches that were read, at sizes (G, 1) over their range."""
    return Suspect(effect=REVERSAL, channel="", slots=slots_of(REVERSAL), grid=grid, price=read.price, gates=read.gates)


def _first(problem: Problem, x: Array, deviation: float) -> _Read:
    """Return the likeliest stretches over several shares."""
    without = problem.predicted(x)
    falls = falls_of(problem, REVERSAL, AGAINST, x, without)
    found = [_read(problem, x, share, without, share * falls, deviation) for share in _SHARES]
    return max(found, key=lambda each: each.gain)


def _again(posed: Problem, x: Array, deviation: float) -> _Read:
    """Return the likeliest stretches of a loss that was fitted with others: its share, and what flowed, are known."""
    (slot,) = slots_of(REVERSAL)
    share = float(x[-1]) * slot.width
    lost = posed.predicted(x)
    less = x.copy()
    less[-1] -= _LITTLE
    without = lost + (posed.predicted(less) - lost) * share / (_LITTLE * slot.width)
    return _read(posed, x, share, without, -share * without, deviation)


def _read(problem: Problem, x: Array, share: float, without: Array, drop: Array, deviation: float) -> _Read:
    """Return the likeliest stretches, by predictions without the loss (R,) and what it would take off them (R,)."""
    left = np.where(problem.known, problem.measured - without, 0.0)
    odds = np.where(problem.known, left * drop - 0.5 * drop**2, 0.0) / deviation**2
    gain, price = 0.0, 0.0
    gates = [np.full(recording.experiment.throttle.size, WITH) for recording in problem.recordings]
    speeds = [happened.outputs["speed"] for happened in problem.happened(x)]
    for each in problem.series:
        if each.signal != "thrust":
            continue
        gate, dt = gates[each.recording], problem.recordings[each.recording].experiment.dt
        at = problem.times[each.rows] / dt
        turned = np.flatnonzero(np.diff(np.sign(speeds[each.recording][: gate.size])) != 0.0) + 1
        for first, last in zip([0, *turned], [*turned, gate.size], strict=True):
            inside = np.flatnonzero((at >= first) & (at < last))
            worth = np.cumsum(odds[each.rows][inside])
            if not inside.size or np.max(worth) <= 0.0:
                continue
            end = int(np.argmax(worth))
            gain, price = gain + float(worth[end]), price + float(np.log(inside.size))
            until = last if end + 1 == inside.size else 0.5 * (at[inside[end]] + at[inside[end + 1]])
            gate[first : round(until)] = AGAINST
    return _Read(gain - price, share, price, tuple(gates))
