"""What is wrong with recordings before they are diagnosed: short, slow, idle, constant, clipped, in other units."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.recording import Recording
from gap_diagnosis.scatter import masks_of
from gap_diagnosis.suspects import ROUNDED
from gap_diagnosis.unit_check import unit_problems
from thruster_model.identification.experiment import SIGNALS, Measurement
from thruster_model.parameter_set import ParameterSet

__all__ = ["Checked", "checked", "problem_of", "unit_problems"]

Array = NDArray[np.float64]
SHORTEST = 5.0  # [s] altogether
SLOWEST = 0.2  # [s] between samples


class Checked(NamedTuple):
    """Recordings without what cannot be used, what was left out, and why nothing can be said (empty: it can)."""

    recordings: list[Recording]
    warnings: list[str]
    reasons: list[str]


def checked(recordings: Sequence[Recording]) -> Checked:
    """Return recordings without constant channels and clipped samples."""
    kept, warnings, reasons = [], [], []
    for recording in recordings:
        measurements: dict[str, Measurement] = {}
        warnings += [f"{recording.name}: {sentence}" for sentence in recording.experiment.warnings]
        repeated = dict(recording.log.repeated)
        moves = float(np.ptp(recording.experiment.throttle)) > 0.0
        for name, m in recording.experiment.measurements.items():
            where = f"{recording.name}: {recording.channel(name)}"
            values = m.values[np.isfinite(m.values)]
            period = float(np.median(np.diff(m.time))) if m.time.size > 1 else np.inf
            if values.size < 20:
                warnings.append(f"{where}: expected at least 20 samples, found {values.size}; left out")
            elif float(np.ptp(m.time)) == 0.0:
                warnings.append(
                    f"{where}: expected stamps that advance, found {m.time[0]:g} s on all samples; left out"
                )
            elif period > SLOWEST:
                found = f"expected samples at least every {SLOWEST:g} s, found one every {period:.2g} s"
                warnings.append(f"{where}: {found}; left out")
            elif moves and float(np.ptp(values)) == 0.0:
                still = f"{values[0]:g} {SIGNALS[name].unit}" if abs(values[0]) > 1e-9 else "its rest value"
                warnings.append(f"{where}: constant at {still} while the throttle moves; left out")
            else:
                clipped = _clipped(m.values)
                free = int(np.sum(np.isfinite(m.values) & ~clipped))
                if free < 20:
                    expected = "expected at least 20 samples between its limits"
                    warnings.append(f"{where}: {expected}, found {free}; left out")
                    continue
                if np.any(clipped):
                    share, level = 100.0 * np.mean(clipped), float(np.nanmax(np.abs(m.values[clipped])))
                    warnings.append(f"{where}: {share:.0f} % of the samples stand at a limit of {level:g}; masked")
                    if name in repeated:  # a limit repeats samples, not the log
                        repeated[name] = repeated[name] & ~clipped
                gap = float(np.max(np.diff(m.time))) if m.time.size > 1 else 0.0
                if gap > max(10.0 * period, 0.5):
                    at = float(m.time[int(np.argmax(np.diff(m.time)))])
                    warnings.append(f"{where}: no samples for {gap:.1f} s from {at:.1f} s on")
                measurements[name] = replace(m, values=np.where(clipped, np.nan, m.values))
        if measurements:
            experiment = replace(recording.experiment, measurements=measurements)
            log = replace(recording.log, repeated=repeated).of(measurements)
            kept.append(replace(recording, experiment=experiment, log=log))
    duration = sum(recording.experiment.duration for recording in recordings)
    if not kept:
        reasons.append("no channel is left that a model of the thruster predicts")
    if duration < SHORTEST:
        reasons.append(f"expected at least {SHORTEST:g} s of recordings, found {duration:.1f} s")
    return Checked(kept, warnings, reasons)


def _clipped(values: Array, least_share: float = 0.03, least_run: int = 8) -> NDArray[np.bool_]:
    """Return which samples stand still at the largest or smallest value while others scatter, shape (M,)."""
    known = values[np.isfinite(values)]
    mask = np.zeros(values.size, dtype=bool)
    between = known[(known != np.max(known)) & (known != np.min(known))]
    if between.size > 1 and np.mean(np.diff(between) == 0.0) > 0.2:
        return mask  # a coarse converter repeats all values, not only the extreme ones
    for limit in (float(np.max(known)), float(np.min(known))):
        at = values == limit
        if limit == 0.0 or np.mean(at) < least_share:
            continue
        edges = np.flatnonzero(np.diff(np.concatenate(([False], at, [False])).astype(np.int8)))
        longest = int(np.max(edges[1::2] - edges[::2], initial=0))
        if longest >= least_run:
            mask |= at
    return mask


def problem_of(usable: Sequence[Recording], parameter_set: ParameterSet) -> tuple[Problem, list[str]]:
    """Return checked recordings and a parameter set as a problem, and why nothing can be said of it (empty: it can).

    Readings that a set rounds are compared as they are before: rounded twice, they would be off by more than the steps
    of one converter, and a finer step would always fit better.
    """
    problem = Problem(
        recordings=tuple(usable),
        parameter_set=parameter_set,
        deviations=deviations_of(parameter_set),
        fixed={name: sizes for name, sizes in parameter_set.effects.sizes.items() if name != ROUNDED},
        masks=masks_of(usable),
    )
    if not problem.series:
        return problem, [f"model {parameter_set.model_name} predicts none of the channels in the recordings"]
    return problem, _excitation_problems(problem)


def _excitation_problems(problem: Problem) -> list[str]:
    """Return why the throttle tells nothing: it never leaves the dead zone, or is not there."""
    values = problem.parameter_set.values
    upper, lower = values.get("delta_u2", 0.0), values.get("delta_u1", 0.0)
    outside = [np.mean((r.experiment.throttle > upper) | (r.experiment.throttle < lower)) for r in problem.recordings]
    if max(outside) < 0.01:
        top = max(float(np.max(np.abs(r.experiment.throttle))) for r in problem.recordings)
        zone = f"the dead zone ({lower:g} to {upper:g} V)"
        if max(outside) > 0.0:
            return [
                f"the throttle leaves {zone} in {100 * max(outside):.1f} % of the time only; expected steps beyond it"
            ]
        return [f"the throttle never leaves {zone}: found at most {top:.3g} V; expected steps beyond it, in volts"]
    return []
