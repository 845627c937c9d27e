"""From runs to the signals that observers take, and results into files."""

import json
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from run_bag import Run, RunError, read_run
from thruster_estimation.errors import EstimationError
from thruster_estimation.replay import Outcome, Signals
from thruster_model.identification.experiment_io import throttle_channel

__all__ = ["PERIOD", "dump_outcomes", "read_signals", "signals_of"]

Array = NDArray[np.float64]
PERIOD = 0.04
"""Least period at which a run is replayed, unless asked for [s]."""
_SIGN_MEASURED = 1
_STATES = {"n": "n", "v": "v", "U": "ambient"}
_TRUTHS = {"n": "n", "v": "axial", "U": "ambient"}


def read_signals(paths: Sequence[Path], thruster: int = 0, period: float | None = None) -> list[Signals]:
    """Read runs.

    Raises:
        EstimationError: with a sentence for each run that cannot be read or lacks throttle or speed.
    """
    found, problems = [], []
    for path in paths:
        try:
            found.append(signals_of(read_run(path), thruster, period))
        except (RunError, OSError) as error:
            problems.append(str(error))
        except EstimationError as error:
            problems += error.problems
    if problems:
        raise EstimationError(problems)
    return found


def signals_of(run: Run, thruster: int = 0, period: float | None = None) -> Signals:
    """Return a run's signals at the instants of its tachometer, thinned to `period` [s] where that is faster.

    A flow counts at the first instant at or after it. The throttle is held between its messages; over a period its
    mean acts. Outside its messages it is not known.

    Raises:
        EstimationError: no throttle or no speed of this thruster.
    """
    prefix = f"thruster_{thruster}"
    speed = f"{prefix}/state.n"
    throttle = throttle_channel(run, prefix)
    missing = [name for name, there in ((speed, speed in run), (f"{prefix}/throttle.commanded", throttle)) if not there]
    if missing or throttle is None:
        raise EstimationError([f"{run.name}: expected a channel {m}; found {', '.join(run)}" for m in missing])
    time, n = run.time(speed), run[speed].values
    chosen = _thinned(time, period if period is not None else PERIOD)
    if chosen.size < 2:
        raise EstimationError([f"{run.name}: expected at least two speeds a period apart; found {chosen.size}"])
    time, n = time[chosen], n[chosen]
    source = f"{prefix}/state.sign_source"
    signed = source in run and bool(np.all(run[source].values == _SIGN_MEASURED))
    dt = np.diff(time, prepend=time[0])
    u_before, u_after = _held(run.time(throttle), run[throttle].values, time)
    notes = [f"{time.size} instants, {np.median(dt[1:]):.4g} s apart; throttle from {throttle}"]
    notes.append(f"speed is {'signed' if signed else 'taken as a magnitude'} and not tared")
    logged = {}
    for state, field in _STATES.items():
        name = f"{prefix}/estimate.{field}"
        if name in run:
            logged[state] = (run.time(name), run[name].values)
    truths = {s: f"{prefix}/truth.{f}" for s, f in _TRUTHS.items()}
    return Signals(
        name=run.name, time=time, y_n=n if signed else abs(n), dt=dt, unsigned=not signed,
        y_U=_flow(run, prefix, "ambient", time), y_v=_flow(run, prefix, "axial", time),
        u_before=u_before, u_after=u_after, logged=logged, logged_by=_logged_by(run), notes=tuple(notes),
        truth={state: _sampled(run, name, time) for state, name in truths.items() if name in run},
    )  # fmt: skip


def _logged_by(run: Run) -> str:
    """Return the name of the observer whose estimates an imported run holds, "" where nothing says it."""
    imported = run.metadata.get("import")
    decisions = imported.get("decisions", ()) if isinstance(imported, dict) else ()
    told = (d.get("value") for d in decisions if isinstance(d, dict) and d.get("what") == "estimator")
    return str(next(told, ""))


def _thinned(time: Array, period: float) -> NDArray[np.int64]:
    """Return the indices of instants that are a period apart or, where they come more slowly, of all."""
    kept, last = [], -np.inf
    for k, t in enumerate(time):
        if t - last >= period * (1.0 - 1e-6) - 1e-6:
            kept.append(k)
            last = t
    return np.array(kept, dtype=np.int64)


def _held(stamps: Array, values: Array, time: Array) -> tuple[Array, Array]:
    """Return the mean of the held signal over the period up to each instant, and its value at the instant."""
    known = np.isfinite(values)
    stamps, values = stamps[known], values[known]
    index = np.searchsorted(stamps, time + 1e-9, side="right") - 1
    after = np.where(index >= 0, values[np.maximum(index, 0)], np.nan)
    area = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(stamps))])
    integral = np.where(index >= 0, area[np.maximum(index, 0)] + after * (time - stamps[np.maximum(index, 0)]), np.nan)
    before = np.append(np.nan, np.diff(integral) / np.diff(time))
    held = np.append(False, index[1:] == index[:-1])
    before = np.where(held, after, before)
    before[0] = after[0]
    return before, after


def _flow(run: Run, prefix: str, field: str, time: Array) -> Array:
    """Return the last flow in each period, NaN where there was none or the instrument called it an outlier."""
    name, out = f"{prefix}/flow.{field}", np.full(time.size, np.nan)
    if name not in run:
        return out
    values, when = run[name].values.copy(), run.time(name)
    if f"{prefix}/flow.spike" in run and len(run[f"{prefix}/flow.spike"]) == values.size:
        values[run[f"{prefix}/flow.spike"].values > 0] = np.nan
    index = np.searchsorted(time, when - 1e-6)
    usable = np.isfinite(values) & (index < time.size)
    out[index[usable]] = values[usable]
    return out


def _sampled(run: Run, name: str, time: Array) -> Array:
    """Return the sample nearest to each instant."""
    when = run.time(name)
    index = np.clip(np.searchsorted(when, time), 1, max(when.size - 1, 1))
    nearest = np.where(time - when[index - 1] < when[np.minimum(index, when.size - 1)] - time, index - 1, index)
    return np.asarray(run[name].values[np.minimum(nearest, when.size - 1)])


def dump_outcomes(outcomes: Sequence[Outcome], provenance: dict[str, Any]) -> str:
    """Return the results as JSON."""
    return json.dumps({"provenance": provenance, "results": [_summary(o) for o in outcomes]}, indent=1, allow_nan=False)


def _summary(o: Outcome) -> dict[str, Any]:
    settings = {k: x if isfinite(x) else None for k, x in o.job.settings._asdict().items()}
    return {
        "run": o.signals.name,
        "estimator": o.job.estimator,
        "model": o.job.model,
        "settings": settings,
        "samples": int(o.instants.size),
        "scores": [score._asdict() for score in o.scores],
        "nis_per_degree": o.nis,
        "nis_interval_95": o.nis_interval,
        "share_gated": {"n": o.gated_n, "U": o.gated_U},
        "share_valid": o.valid,
        "logged_by": o.signals.logged_by or None,
    }
