"""Recorded signals through observers, and how well each did: errors, consistency, refusals, logged estimates."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_estimation.belief import Belief, Level, level
from thruster_estimation.consistency import nis_interval
from thruster_estimation.errors import EstimationError
from thruster_estimation.offline import History, observe
from thruster_estimation.online import first_belief
from thruster_estimation.reference import REFERENCES, look_back
from thruster_estimation.settings import BENCH
from thruster_model.equations.thruster import ThrusterCoefficients

__all__ = ["UNITS", "Job", "Outcome", "Score", "Signals", "problem_with", "replay", "start_of"]

Array = NDArray[np.float64]
UNITS = {"n": "rad/s", "v": "m/s", "U": "m/s"}
_FEWEST = 10


@dataclass(frozen=True, kw_only=True, eq=False)
class Signals:
    """What one run gives to observers, at N instants.

    Attributes:
        name: of the run.
        time: instants [s] since the start of the run, (N,), increasing.
        y_n, y_U: measured rotor speed [rad/s] and ambient flow [m/s], NaN where there is none, (N,).
        y_v: measured axial flow [m/s], which no observer sees, (N,).
        u_before: throttle that acted over the period up to each instant [V], u_after: that of each instant, (N,).
        dt: period up to each instant [s], (N,), 0 for the first.
        unsigned: the speed is a magnitude.
        truth: true states of a simulated run by "n", "v", "U", (N,).
        logged: estimates in the run by "n", "v", "U": (instants [s], values), each (M,).
        logged_by: name of the observer that made them.
        notes: what was done to the recording, one sentence each.
    """

    name: str
    time: Array
    y_n: Array
    y_U: Array
    y_v: Array
    u_before: Array
    u_after: Array
    dt: Array
    unsigned: bool
    truth: Mapping[str, Array] = field(default_factory=dict)
    logged: Mapping[str, tuple[Array, Array]] = field(default_factory=dict)
    logged_by: str = ""
    notes: tuple[str, ...] = ()


class Job(NamedTuple):
    """One observer with one model: names, settings and coefficients."""

    estimator: str
    model: str
    settings: Any
    coefficients: ThrusterCoefficients


class Score(NamedTuple):
    """Root mean square and largest error of an estimate against a signal, over `samples` values."""

    against: str
    state: str
    unit: str
    rmse: float
    largest: float
    samples: int


@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What one observer made of one run.

    Attributes:
        instants: of the estimates in `history` [s], (N,): in the bench's form one period after the measurements.
        scores: against "measured, one step ahead", "measured", "truth" and "logged".
        nis: mean of the joint NIS per degree of freedom, None where none was computed.
        nis_interval: where 95 % of consistent filters have it.
        gated_n, gated_U: share of the usable measurements that was refused, None where there were none.
        valid: share of the steps whose status is not INVALID.
    """

    job: Job
    signals: Signals
    history: History
    instants: Array
    scores: tuple[Score, ...]
    nis: float | None
    nis_interval: tuple[float, float] | None
    gated_n: float | None
    gated_U: float | None
    valid: float

    @property
    def states(self) -> tuple[str, ...]:
        """States that the observer estimates."""
        return states_of(self.job.estimator)


def states_of(estimator: str) -> tuple[str, ...]:
    """Return the states that an observer estimates."""
    return ("n",) if estimator == "speed-ekf" else ("n", "v", "U")


def problem_with(job: Job) -> str:
    """Return why an observer cannot work with a model, "" where it can."""
    if type(job.coefficients) is not ThrusterCoefficients:
        expected = "expected a model of the simplified, HL or HQ form; found another class"
        return f"{job.estimator} with {job.model}: {expected}"
    if job.estimator != "speed-ekf" and job.coefficients.k_Uv == 0.0:
        return f"{job.estimator} with {job.model}: the model has no axial flow; only speed-ekf can work with it"
    if job.estimator in REFERENCES and (job.settings.form == BENCH or job.settings.gate < inf):
        return f"{job.estimator} with {job.model}: expected the proper form without a gate, as references have no other"
    return ""


def start_of(signals: Signals, form: int) -> Belief:
    """Return the belief before the first instant: the bench's, or the first measurements with wide deviations."""
    n, U = (y[np.isfinite(y)][:1] for y in (signals.y_n, signals.y_U))
    first_n, first_U = (float(y[0]) if y.size else np.nan for y in (n, U))
    return first_belief(first_n, first_U, float(signals.u_before[0]), signals.unsigned, form)


def replay(signals: Signals, job: Job) -> Outcome:
    """Run one observer over one run and score it.

    Raises:
        EstimationError: the observer cannot work with the model.
    """
    if problem := problem_with(job):
        raise EstimationError([problem])
    s, euler = signals, job.settings.form == BENCH
    settings = job.settings._replace(unsigned=int(s.unsigned))
    start = start_of(s, job.settings.form)
    if euler:
        dt = np.append(s.dt[1:], np.median(s.dt[1:]))
        history, instants = observe(s.y_n, s.y_U, s.u_after, dt, start, settings, job.coefficients), s.time + dt
    elif job.estimator in REFERENCES:
        history = look_back(job.estimator, s.y_n, s.y_U, s.u_before, s.dt, start, settings, job.coefficients)
        instants = s.time
    else:
        history = observe(s.y_n, s.y_U, s.u_before, s.dt, start, settings, job.coefficients)
        instants = s.time
    statuses = history.status.astype(int)
    valid = np.mean([level(status) != Level.INVALID for status in statuses])
    nis, interval = _consistency(history)
    return Outcome(
        job=job, signals=s, history=history, instants=instants, scores=tuple(_scores(s, job, history, instants)),
        nis=nis, nis_interval=interval, gated_n=_share(history.gated_n, history.y_n),
        gated_U=_share(history.gated_U, history.y_U), valid=float(valid),
    )  # fmt: skip


def _scores(s: Signals, job: Job, history: History, instants: Array) -> list[Score]:
    found, states = [], states_of(job.estimator)
    for state in ("n", "U"):
        if state in states:
            found.append(_score("measured, one step ahead", state, getattr(history, f"y_{state}")))
    if "v" in states:
        found.append(_score("measured", "v", history.v - _at(s.time, s.y_v, instants)))
    for state, values in s.truth.items():
        if state in states:
            found.append(_score("truth", state, getattr(history, state) - _at(s.time, values, instants)))
    for state, (when, values) in s.logged.items():
        if state in states:
            found.append(_score("logged", state, getattr(history, state) - _at(when, values, instants)))
    return [score for score in found if score.samples > 0]


def _at(when: Array, values: Array, instants: Array) -> Array:
    """Return the values at the instants, NaN where none lies within a tenth of a period."""
    if when.size < 2:
        return np.full(instants.size, np.nan)
    index = np.clip(np.searchsorted(when, instants), 1, when.size - 1)
    nearest = np.where(instants - when[index - 1] < when[index] - instants, index - 1, index)
    tolerance = 0.1 * np.median(np.diff(when))
    return np.where(abs(when[nearest] - instants) <= tolerance, values[nearest], np.nan)


def _score(against: str, state: str, error: Array) -> Score:
    kept = error[np.isfinite(error)]
    if not kept.size:
        return Score(against, state, UNITS[state], np.nan, np.nan, 0)
    return Score(against, state, UNITS[state], sqrt(np.mean(kept**2)), float(np.max(abs(kept))), kept.size)


def _consistency(history: History) -> tuple[float | None, tuple[float, float] | None]:
    known = np.isfinite(history.nis)
    degrees = float(np.sum(history.dof[known]))
    if np.count_nonzero(known) < _FEWEST:
        return None, None
    return float(np.sum(history.nis[known]) / degrees), nis_interval(round(degrees))


def _share(gated: Array, innovation: Array) -> float | None:
    usable = np.isfinite(innovation)
    return float(np.mean(gated[usable])) if np.any(usable) else None
