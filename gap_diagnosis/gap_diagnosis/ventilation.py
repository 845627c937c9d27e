"""Air drawn in random stretches: when the thrust collapses is hidden, and found from the thrust itself.

A chain of two states (water, air) changes at random; in air thrust is a share s less. The most probable sequence
(Viterbi 1967, at one change per second) becomes the gates with which the plant is simulated and fitted like any other
effect. How often it changes is not known: k changes within T seconds, sampled every h, have the probability
        h^k int_0^inf r^k exp(-r T) dr / (r ln 100) = h^k (k - 1)! / (T^k ln 100),
rates r between 0.1 and 10 per second being likely alike. So few changes in a long time are no excuse for a slow
disturbance.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.special import gammaln

from gap_diagnosis.lost_thrust import falls_of
from gap_diagnosis.problem import Problem
from gap_diagnosis.suspects import found_by, slots_of
from system_identification.fitting import Fitted, fit
from system_identification.hypothesis import Hypothesis
from system_identification.suspects import Suspect
from system_identification.system import Series
from thruster_model.compilation import compiled

__all__ = ["AIR", "RATE", "air_beside"]

Array = NDArray[np.float64]
(AIR,) = found_by("gates")
RATE = 1.0
"""Of changes between water and air [1/s], where one is needed."""
LEAST_GAIN = 8.0
"""Logarithm of evidence for the gates alone below which air is not considered."""
_SHARES = (0.08, 0.15, 0.25, 0.4, 0.6, 0.8)
_ONSETS = tuple(np.arange(20.0, 140.0, 6.0))
_SINGLE = 1.9  # changes that one reading may pay for
_ROUNDS = 3
_RATES = float(np.log(np.log(100.0)))  # what the choice of a rate between 0.1 and 10 per second costs


class _Decoded(NamedTuple):
    gain: float
    share: float
    onset: float
    gates: tuple[Array, ...]
    changes: int
    seconds: float


def air_beside(beside: Hypothesis) -> Suspect | None:
    """Return air as a suspect beside a hypothesis, with the stretches in which thrust is lost as air would take it.

    None without thrust or losses, and where the states foresee the stretches: then it is not air. Thrust that is gained
    in stretches, which no air does, is taken off: noise with outliers to either side has both.
    """
    problem = beside.system
    series = [each for each in problem.series if each.signal == "thrust"]
    speeds = {each.recording: each for each in problem.series if each.signal == "speed"}
    if not series or any(each.recording not in speeds for each in series):
        return None
    slots = slots_of(AIR)
    deviation = beside.noise.level("thrust")
    base, unknowns, found, sizes = beside.fitted, beside.fitted.x, None, np.empty(0)
    shares: tuple[float, ...] = _SHARES
    for _ in range(_ROUNDS):
        in_water = problem.predicted(unknowns)
        falls = falls_of(problem, AIR, 0.0, unknowns, in_water)
        decoded = _decoded(problem, series, speeds, in_water, falls, deviation, shares, _ONSETS)
        if decoded is None or decoded.gain < LEAST_GAIN:
            break
        if _foreseeable(problem, series, base, decoded.gates):
            return None
        posed = problem.with_effects((*problem.slots, *slots), decoded.gates)
        start = [decoded.share / slots[0].width, decoded.onset / slots[1].width]
        fitted = fit(posed, beside.noise, np.concatenate((unknowns, start)), near=base, iterations=6, polish=False)
        found, sizes = decoded, fitted.x[base.x.size :]
        # With what the fit says the thrust would be in water, gates are decoded again.
        unknowns = fitted.x[: base.x.size]
        share = float(sizes[0]) * slots[0].width
        shares = tuple(share * factor for factor in (0.8, 0.9, 1.0, 1.1, 1.25))
    if found is None:
        return None
    gained = _decoded(problem, series, speeds, in_water, -falls, deviation, _SHARES, _ONSETS)
    chance = found.changes * np.log(_period(problem) / found.seconds) + float(gammaln(max(found.changes, 1))) - _RATES
    price = -float(chance) + (gained.gain if gained is not None else 0.0)
    return Suspect(effect=AIR, channel="", slots=slots, grid=sizes[None, :].copy(), price=price, gates=found.gates)


def _foreseeable(problem: Problem, series: list[Series], fitted: Fitted, gates: tuple[Array, ...]) -> bool:
    """Tell whether speed, its rate, its sign, the flow or what was before foresee the gates: air comes at random.

    Gates shifted round their recording know nothing of the states: what they seem to know is chance.
    """
    closed: list[NDArray[np.bool_]] = []
    fast: list[NDArray[np.bool_]] = []
    seen: list[Array] = []
    everything = fitted.problem.happened(fitted.x)
    for each in series:
        happened = everything[each.recording]
        n, v = happened.outputs["speed"][1:], happened.outputs["axial"][1:]
        rate = np.abs(np.diff(happened.outputs["speed"]))
        size = min(n.size, gates[each.recording].size)
        here = gates[each.recording][:size] < 0.5
        if not np.any(here):
            continue
        able = np.abs(n[:size]) >= np.percentile(np.abs(n[:size][here]), 10.0)
        dt = problem.recordings[each.recording].experiment.dt
        before = [_largest_of_late(rate, round(past / dt)) for past in _PASTS]
        closed.append(here)
        fast.append(able)
        seen.append(np.array([rate, np.abs(n), n, n * v, *before])[:, :size][:, able])
    if not closed:
        return False
    features = np.hstack(seen)
    ranks = np.argsort(np.argsort(features, axis=1), axis=1) + 1.0

    def known(shut: list[NDArray[np.bool_]]) -> float:
        """Return the area under the curve of the feature that foresees best, beyond one half."""
        taken = np.concatenate([mask[able] for mask, able in zip(shut, fast, strict=True)])
        count = float(np.sum(taken))
        if not 10 < count < taken.size - 10:
            return 0.0
        area = (ranks[:, taken].sum(axis=1) - 0.5 * count * (count + 1.0)) / (count * (taken.size - count))
        return float(np.max(np.abs(area - 0.5)))

    rng = np.random.default_rng(0)
    chance = [known([np.roll(mask, rng.integers(mask.size)) for mask in closed]) for _ in range(_SHIFTS)]
    return known(closed) > max(_FORESEEN, float(np.quantile(chance, 0.95)))


def _largest_of_late(values: Array, samples: int) -> Array:
    """Return at each sample the largest of the last ones."""
    return np.asarray(maximum_filter1d(values, max(samples, 1), origin=(max(samples, 1) - 1) // 2))


_FORESEEN = 0.2
"""Area under the curve of a foreseeing feature, beyond one half, and beyond what chance gives."""
_PASTS = (0.3, 0.6, 1.2)
"""How long ago [s] what closes the gates may have happened."""
_SHIFTS = 200


def _period(problem: Problem) -> float:
    """Return the time between readings of the thrust [s]."""
    first = next(each.recording for each in problem.series if each.signal == "thrust")
    return float(np.median(np.diff(problem.recordings[first].experiment.measurements["thrust"].time)))


def _decoded(
    problem: Problem,
    series: list[Series],
    speeds: dict[int, Series],
    in_water: Array,
    falls: Array,
    deviation: float,
    shares: tuple[float, ...],
    onsets: tuple[float, ...],
) -> _Decoded | None:
    """Return the most probable gates over all shares and onsets; None where water alone is more probable."""
    best: _Decoded | None = None
    empty = tuple(np.empty(0) for _ in problem.recordings)
    prepared = []
    for each in series:
        experiment = problem.recordings[each.recording].experiment
        time = experiment.measurements["thrust"].time
        speed = np.interp(time, experiment.measurements["speed"].time, in_water[speeds[each.recording].rows])
        known = problem.known[each.rows]
        period = float(np.median(np.diff(time)))
        grid = experiment.dt * np.arange(experiment.throttle.size)
        place = np.clip(np.searchsorted(time - 0.5 * period, grid, side="right") - 1, 0, time.size - 1)
        residual = np.where(known, problem.measured[each.rows] - in_water[each.rows], 0.0)
        fall = np.where(known, falls[each.rows], 0.0)
        prepared.append((each.recording, np.abs(speed), fall, residual, period, place))
    for share, onset in product(shares, onsets):
        gates, gain, changes, seconds = list(empty), 0.0, 0, 0.0
        for recording, speed, fall, residual, period, place in prepared:
            drop = np.where(speed > onset, share * fall, 0.0)
            odds, change = (residual * drop - 0.5 * drop**2) / deviation**2, np.log(RATE * period)
            # A single reading, however far off, does not pay for two changes: it is an outlier, not air.
            capped = np.minimum(odds, _SINGLE * abs(change))
            states, worth, switched = _viterbi(capped, change)
            gain += worth + float(np.sum((odds - capped)[states == 1]))
            changes += switched
            seconds += float(np.sum(speed > onset)) * period
            gates[recording] = 1.0 - states[place].astype(np.float64)
        if gain > (best.gain if best else 0.0):
            best = _Decoded(gain, share, onset, tuple(gates), changes, seconds)
    return best


@compiled
def _viterbi(odds, change):  # type: ignore[no-untyped-def]
    """Return (states, log odds of the best path against all water, number of changes); `odds`: of air, per sample."""
    size = odds.size
    came_water = np.zeros(size, dtype=np.int8)
    came_air = np.zeros(size, dtype=np.int8)
    water, air = 0.0, change
    for k in range(size):
        if air + change > water:
            next_water, came_water[k] = air + change, 1
        else:
            next_water, came_water[k] = water, 0
        if water + change > air:
            next_air, came_air[k] = water + change + odds[k], 0
        else:
            next_air, came_air[k] = air + odds[k], 1
        water, air = next_water, next_air
    states = np.zeros(size, dtype=np.int8)
    state = 1 if air > water else 0
    best = max(air, water)
    changes = 0
    for k in range(size - 1, -1, -1):
        states[k] = state
        before = came_air[k] if state == 1 else came_water[k]
        if before != state:
            changes += 1
        state = before
    return states, best, changes + state  # a run that begins in air has changed before it
