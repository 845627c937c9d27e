"""Which hypotheses the next experiment has to tell apart, and what each says would happen in it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.experiment_inputs import Programme
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.preparing import CELL, DT, held_on_grid
from gap_diagnosis.problem import Problem
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import RULES
from gap_diagnosis.ventilation import AIR, RATE
from system_identification.fitting import Fitted
from system_identification.hypothesis import Hypothesis
from system_identification.rating import Rated
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import Experiment, Measurement

__all__ = ["NONE", "Rival", "in_experiment", "recording_of_programme", "rivals_of"]

Array = NDArray[np.float64]
NONE = "none"
PROBABLE = 0.02
"""Probability from which on a hypothesis is still in play."""
MOST = 5
_FEW = 2  # nearest rivals of a hypothesis that is alone in play
_SURE = 2.0  # standard deviations by which a size differs from neutral


@dataclass(frozen=True, kw_only=True)
class Rival:
    """A hypothesis as it stands after the present recordings.

    Attributes:
        keys: of its suspects; empty for re-tuned parameters alone.
        problem: of the present recordings.
        x: unknowns there, shape (K,).
        fitted: the fit behind it: its sensitivities to the present recordings are the rival's.
        covariance: of parameters and sizes, shape (len(names) + len(slots),) squared.
    """

    keys: tuple[str, ...]
    problem: Problem
    x: Array
    fitted: Fitted
    covariance: Array

    @property
    def name(self) -> str:
        """For readers."""
        return " + ".join(self.keys) or NONE

    def is_twin_of(self, other: "Rival") -> bool:
        """Tell whether both differ by one effect each, of which one is declared to do what the other does."""
        own, others = ([key for key in a.keys if key not in b.keys] for a, b in ((self, other), (other, self)))
        if len(own) != 1 or len(others) != 1:
            return False
        return any(b in LIBRARY[a.split(":")[0]].twins for a, b in ((own[0], others[0]), (others[0], own[0])))

    def imitates(self, other: "Rival") -> bool:
        """Tell whether this one can pass for another one, re-tuned; not where it holds all of the other and more."""
        return not set(other.keys) < set(self.keys)


def rivals_of(found: Diagnosis) -> tuple[list[Rival], list[tuple[int, int]]]:
    """Return the hypotheses that remain and which of them are to be told apart, by place.

    A claimed effect and its look-alikes stand against each other, one without look-alikes against its nearest rivals.
    Where none is the likeliest it stands against what else is probable and what the recordings would not show. Else
    all that are probable stand against each other.
    """
    investigation, verdict = found.investigation, found.verdict
    if investigation is None:
        return [], []
    leading = verdict.chosen if verdict.verdict == "effect" else None
    if leading is not None:
        remaining = [leading, *_lookalikes(found, leading)][:MOST]
    else:
        remaining = _probable(found)
    quiet = leading is None and not investigation.best.suspects
    if quiet:
        remaining = [investigation.none, *(each for each in remaining if each is not investigation.none)][:MOST]
    rivals = [_rival(each) for each in remaining]
    if quiet:
        known = {rival.keys for rival in rivals}
        hidden = [s for s in _hidden(investigation) if (s.suspect.key,) not in known]
        rivals += [_unseen(investigation, each) for each in hidden[: MOST - len(rivals)]]
    elif len(rivals) > 1:
        return rivals, [(i, k) for i in range(len(rivals)) for k in range(i + 1, len(rivals))]
    if len(rivals) == 1:
        rivals += [_rival(each) for each in _nearest(investigation, remaining[0])]
    return rivals, [(0, k) for k in range(1, len(rivals))]


def _lookalikes(found: Diagnosis, leading: Hypothesis) -> list[Hypothesis]:
    assert found.investigation is not None
    by_keys = found.investigation.search.weighed
    result = []
    for claim in found.verdict.claims:
        if claim.scatters:
            continue
        own = f"{claim.effect}:{claim.channel}" if claim.channel else claim.effect
        for key in claim.alike:
            other = by_keys.get(frozenset((set(leading.keys) - {own}) | {key}))
            if other is not None and other not in result:
                result.append(other)
    return result


def _probable(found: Diagnosis) -> list[Hypothesis]:
    assert found.investigation is not None
    looked = found.investigation
    probable = [each for each in looked.ranked if looked.probabilities[each.keys] >= PROBABLE]
    return probable[:MOST] or [looked.none]


def _nearest(investigation: Investigation, alone: Hypothesis) -> list[Hypothesis]:
    others = [c for c in investigation.ranked if c is not alone]
    # What holds the lone one and more always costs less, and is no rival.
    others = [c for c in others if not set(alone.keys) < set(c.keys) or not alone.keys]
    return sorted(others, key=lambda c: c.fitted.cost)[:_FEW]


def _hidden(investigation: Investigation) -> list[Rated]:
    """Return suspects that would not have been seen at a third of their plausible size: the likeliest of each block."""
    best: dict[str, Rated] = {}
    for each in sorted(investigation.screened, key=lambda s: -s.visibility):
        if each.visibility <= RULES.visible:
            best.setdefault(LIBRARY[each.suspect.effect].block, each)
    return list(best.values())[:MOST]


def _unseen(investigation: Investigation, rated: Rated) -> Rival:
    """Return a suspect at a third of its plausible size, nuisances re-tuned to first order to what was recorded."""
    none, noise = investigation.none.fitted, investigation.none.noise
    suspect = rated.suspect
    problem = none.problem.with_effects(suspect.slots, tuple(suspect.gates))
    middle = int(np.argmin(np.abs(suspect.grid[:, 0] - 0.35 * np.max(suspect.grid[:, 0]))))
    sizes = suspect.grid[middle if len(suspect.slots) == 1 else len(suspect.grid) // 2]
    known = none.covariance
    change = problem.predicted(np.concatenate((none.x, sizes))) - none.problem.predicted(none.x)
    white = noise.whiten(change)
    x = np.concatenate((none.x - known @ (none.jacobian.T @ white), sizes))
    covariance = np.zeros((len(problem.names) + len(problem.slots),) * 2)
    own = len(problem.names)
    covariance[:own, :own] = known[:own, :own]
    covariance[own:, own:] = np.eye(len(problem.slots)) / 12.0
    return Rival(keys=(suspect.key,), problem=problem, x=problem.bounded(x), fitted=none, covariance=covariance)


def _rival(candidate: Hypothesis) -> Rival:
    """Return a fitted hypothesis; a size that may as well be neutral is taken as large as the recordings allow.

    It is moved to two standard deviations from neutral, at most to a third of the plausible range, and what else is
    unknown goes along as the fit's covariance says: at its neutral size an effect could not be told from none.
    """
    fitted, problem = candidate.fitted, candidate.fitted.problem
    covariance, x = fitted.covariance, fitted.x.copy()
    for place, slot in enumerate(problem.slots):
        definition = LIBRARY[slot.effect].parameters[0]
        if slot.parameter != definition.name and not LIBRARY[slot.effect].apart:
            continue
        neutral = next(p.neutral for p in LIBRARY[slot.effect].parameters if p.name == slot.parameter)
        k = problem.nuisances + place
        if not slot.lower <= neutral <= slot.upper or slot.lower == slot.upper:
            continue
        deviation, away = float(np.sqrt(covariance[k, k])), float(x[k]) - neutral / slot.width
        target = min(_SURE * deviation, slot.upper / slot.width / 3.0)
        if abs(away) < target:
            moved = (-target if away < 0.0 else target) - away
            x = x + covariance[:, k] / covariance[k, k] * moved
    kept = [*range(len(problem.names)), *range(problem.nuisances, x.size)]
    return Rival(
        keys=candidate.keys,
        problem=problem,
        x=problem.bounded(x),
        fitted=fitted,
        covariance=covariance[np.ix_(kept, kept)],
    )


def recording_of_programme(problem: Problem, programme: Programme) -> Recording:
    """Return the experiment as a recording without readings (zeros), with the channels that the present ones have."""
    duration = programme.period * programme.throttle.size
    present: dict[str, list[Measurement]] = {}
    for each in problem.series:
        measurement = problem.recordings[each.recording].experiment.measurements[each.signal]
        present.setdefault(each.signal, []).append(measurement)
    measurements = {}
    for signal, given in present.items():
        period = float(np.median([np.median(np.diff(m.time)) if m.time.size > 1 else CELL for m in given]))
        time = np.asarray(0.5 * given[0].width + period * np.arange(int(duration / period)), dtype=np.float64)
        measurements[signal] = Measurement(
            signal=signal,
            time=time,
            values=np.zeros(time.size),
            width=given[0].width,
            readings=given[0].readings,
            noise=float(np.median([m.noise for m in given])),
            shift_std=max(m.shift_std for m in given),
            offset_std=max(m.offset_std for m in given),
        )
    experiment = Experiment(
        name="next_experiment",
        dt=DT,
        throttle=held_on_grid(programme.time, programme.throttle, DT, round(duration / DT)),
        measurements=measurements,
        throttle_shift_std=max(r.experiment.throttle_shift_std for r in problem.recordings),
    )
    return Recording(experiment=experiment, thruster=problem.recordings[0].thruster)


def in_experiment(rival: Rival, recording: Recording) -> tuple[Problem, Array, Array]:
    """Return (hypothesis in a new experiment, unknowns there (K,), a square root of their covariance (K, K))."""
    gates = (_air(recording),) if any(slot.effect == AIR for slot in rival.problem.slots) else ()
    problem = replace(rival.problem, recordings=(recording,), masks={}, observed=None, gates=gates)
    names, slots = len(problem.names), len(problem.slots)
    x = np.concatenate((rival.x[:names], np.zeros(len(problem.situations)), rival.x[rival.x.size - slots :]))
    covariance = np.eye(x.size)
    kept = [*range(names), *range(problem.nuisances, x.size)]
    covariance[np.ix_(kept, kept)] = rival.covariance
    values, vectors = np.linalg.eigh(covariance)
    return problem, x, np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))


def _air(recording: Recording) -> Array:
    """Return gates of an experiment in which air is drawn now and then, the same ones for each experiment."""
    experiment = recording.experiment
    rng = np.random.default_rng(0)
    changes = np.cumsum(rng.exponential(1.0 / RATE, size=4 * int(RATE * experiment.duration) + 8))
    time = experiment.dt * np.arange(experiment.throttle.size)
    return np.asarray(1.0 - np.searchsorted(changes, time) % 2, dtype=np.float64)
