"""Cases diagnosed, and judged anew with one rule of judgement changed at a time, in several processes."""

import math
from collections.abc import Callable, Sequence
from concurrent.futures import as_completed

from gap_diagnosis.diagnosis import diagnose
from gap_diagnosis.diagnosis_json import effects_of
from gap_diagnosis.recording_io import read_recordings
from gap_diagnosis.scoreboard.ablation import Judged, judged_anew
from gap_diagnosis.scoreboard.plans import Planned
from gap_diagnosis.scoreboard.running_io import answer_of, recorded
from rov_sim.study.worker_processes_io import worker_processes
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["judged_cases"]


def judged_cases(plans: Sequence[Planned], processes: int, progress: Callable[[], None]) -> list[list[Judged]]:
    """Return of each case what changes with each rule; `progress` is called after each."""
    found = []
    with worker_processes(processes) as pool:
        for future in as_completed([pool.submit(_judged, planned) for planned in plans]):
            found.append(future.result())
            progress()
    return found


def _judged(planned: Planned) -> list[Judged]:
    with recorded(planned) as (paths, model):
        found = diagnose(read_recordings(paths), load_parameter_set(model))
    told = {"verdict": found.verdict.verdict, "effects": effects_of(found.verdict)}
    return judged_anew(found, answer_of(planned, told, math.nan, measured=False))
