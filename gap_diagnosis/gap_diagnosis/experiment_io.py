"""The next experiment as a file that a rig or a simulator plays, and as content of diagnosis.json."""

from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.experiment_design import NextExperiment, design
from gap_diagnosis.recording import Recording
from run_bag import Topic, write_run
from safe_files.whole_files_io import write_whole

__all__ = ["FILE", "LARGEST", "command_period", "experiment_content", "propose", "write_experiment"]

FILE = "next_experiment.csv"
"""Columns time_s and throttle_V: a command holds until the next one."""
LARGEST = 5.0
"""Throttle [V] where recordings show none and nothing else is said."""
USUAL_PERIOD = 0.04
SLOWEST_PERIOD = 0.1


def propose(
    found: Diagnosis, recordings: list[Recording], *, largest: float | None, duration: float, seed: int
) -> NextExperiment | None:
    """Return the next experiment at the recordings' command period, at most as strong as they were or as told [V]."""
    seen = max((float(np.max(np.abs(r.experiment.throttle), initial=0.0)) for r in recordings), default=0.0)
    return design(
        found,
        duration=duration,
        period=command_period(recordings),
        largest=(seen or LARGEST) if largest is None else largest,
        seed=seed,
    )


def command_period(recordings: list[Recording]) -> float:
    """Return the time between commands [s]; the usual one where they change too seldom to tell."""
    periods = []
    for recording in recordings:
        experiment = recording.experiment
        changes = np.flatnonzero(np.abs(np.diff(experiment.throttle)) > 1e-6)
        if changes.size > 10:
            periods.append(experiment.dt * float(np.median(np.diff(changes))))
    quick = [period for period in periods if period <= SLOWEST_PERIOD]
    return min(quick, default=USUAL_PERIOD)


def experiment_content(proposed: NextExperiment | None) -> dict[str, Any] | None:
    """Return the content of "next_experiment" in diagnosis.json; None where there is nothing to tell apart."""
    if proposed is None:
        return None
    programme = proposed.programme
    return {
        "sentence": proposed.sentence,
        "file": FILE if programme else None,
        "separates": [
            {"candidates": list(each.candidates), "distance": each.distance, "distance_now": each.distance_now}
            for each in proposed.separates
        ],
        "inseparable": list(proposed.inseparable),
        "programme": None
        if programme is None
        else {"time": np.round(programme.time, 6).tolist(), "throttle": np.round(programme.throttle, 6).tolist()},
        "duration_s": None if programme is None else programme.period * programme.throttle.size,
        "seed": proposed.seed,
    }


def write_experiment(proposed: NextExperiment | None, folder: Path, thruster: int = 0) -> list[Path]:
    """Write the programme to the folder, as a table and as a run that `run_bag play` plays to a thruster.

    Returns:
        The paths of both; none where there is no programme.
    """
    if proposed is None or proposed.programme is None:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    programme, file = proposed.programme, folder / FILE
    rows = [f"{t:.6g},{u:.6g}" for t, u in zip(programme.time, programme.throttle, strict=True)]
    write_whole(file, "\n".join(["time_s,throttle_V", *rows]) + "\n")
    throttle = Topic.of_thruster(thruster, "throttle", programme.time, {"commanded": programme.throttle})
    return [file, write_run(folder / file.stem, [throttle], {"what": f"throttle programme: {programme.title}"})]
