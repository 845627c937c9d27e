"""Record, diagnose and keep the cases of a scoreboard, in several processes; what is kept is not run again."""

import math
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import as_completed
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.blind_check.opened import scored_part
from gap_diagnosis.kept_lines_io import keep_line, kept_lines
from gap_diagnosis.scoreboard.answers import Answer
from gap_diagnosis.scoreboard.case import SyntheticRun, Truth
from gap_diagnosis.scoreboard.generators import GENERATORS
from gap_diagnosis.scoreboard.plans import Planned
from gap_diagnosis.scoreboard.truths import distances, shares
from rov_sim.study.worker_processes_io import worker_processes
from run_bag import Topic, write_run

__all__ = ["answer_of", "diagnosed", "read_answers", "recorded", "run_cases", "write_synthetic_run"]

_SIGN_MEASURED = 1  # thruster_msgs/msg/ThrusterState.SIGN_MEASURED
_FILE = "answers.jsonl"


def write_synthetic_run(run: SyntheticRun, folder: Path) -> Path:
    """Write a recording as the run `folder`/<name>; return that."""
    topics = [Topic.of_thruster(0, "throttle", run.throttle.time, {"commanded": run.throttle.values})]
    speed = run.signals["speed"]
    sign = np.full(speed.values.size, _SIGN_MEASURED)
    topics.append(Topic.of_thruster(0, "state", speed.time, {"n": speed.values, "sign_source": sign}))
    flow = run.signals["ambient"]
    topics.append(Topic.of_thruster(0, "flow", flow.time, {"ambient": flow.values}))
    load = {"wrench.force.x": run.signals["thrust"].values, "wrench.torque.x": run.signals["torque"].values}
    topics.append(Topic.of_thruster(0, "load", run.signals["thrust"].time, load))
    about: dict[str, Any] = {"run": run.name}
    if run.hold is not None:
        about["hold"] = {"throttle": run.hold}
    return write_run(folder / run.name, topics, about)


def diagnosed(planned: Planned) -> tuple[dict[str, Any], float]:
    """Return what a case's diagnosis says of its files, as far as it is scored, and how long it took [s]."""
    from gap_diagnosis.diagnose_io import diagnose_paths  # kernels load once a process

    with recorded(planned) as (paths, model):
        began = time.process_time()
        told = scored_part(diagnose_paths(paths, model))
        return told, time.process_time() - began


@contextmanager
def recorded(planned: Planned) -> Iterator[tuple[list[Path], str]]:
    """Yield the case's runs and the name of the diagnosed set."""
    truth = _truth(planned)
    with tempfile.TemporaryDirectory() as folder:
        runs = GENERATORS[planned.generator].record(truth)
        yield [write_synthetic_run(run, Path(folder)) for run in runs], truth.model


def _truth(planned: Planned) -> Truth:
    return GENERATORS[planned.generator].draw(planned.kind, planned.index, planned.whole)


def answer_of(planned: Planned, diagnosis: Mapping[str, Any], seconds: float, *, measured: bool = True) -> Answer:
    """Return a case with its answer; `measured`: with distances and shares, which take some ten seconds."""
    truth, generator = _truth(planned), GENERATORS[planned.generator]
    return Answer(
        case=truth.name,
        generator=truth.generator,
        kind=truth.kind,
        model=truth.model,
        effects={name: dict(sizes) for name, sizes in truth.effects.items()},
        outside={name: dict(sizes) for name, sizes in truth.outside.items()},
        distances=distances(generator, truth) if measured else {},
        shares=shares(generator, truth) if measured else {},
        diagnosis=diagnosis,
        seconds=seconds,
    )


def read_answers(folder: Path) -> list[Answer]:
    """Return what a folder holds; a last line that was cut off counts as not there."""
    return [Answer(**content) for content in kept_lines(folder / _FILE)]


def run_cases(
    plans: Sequence[Planned], folder: Path, processes: int, progress: Callable[[Answer], None] = lambda _: None
) -> list[Answer]:
    """Diagnose the cases that the folder does not hold yet, and keep each as it ends; return all of them.

    Args:
        plans: the cases.
        folder: made where it is not there.
        processes: how many diagnose.
        progress: called with each new answer.
    """
    folder.mkdir(parents=True, exist_ok=True)
    found = {answer.case: answer for answer in read_answers(folder)}
    missing = [planned for planned in plans if planned.name not in found]
    with worker_processes(processes) as pool:
        waiting = {pool.submit(diagnosed, planned): planned for planned in missing}
        for future in as_completed(waiting):
            error = future.exception()
            # A diagnosis that breaks off is an answer, and a wrong one.
            broken = {"verdict": "failed", "reason": f"{type(error).__name__}: {error}"}
            told, seconds = future.result() if error is None else (broken, math.nan)
            answer = answer_of(waiting[future], told, seconds)
            keep_line(folder / _FILE, asdict(answer))
            found[answer.case] = answer
            progress(answer)
    return [found[planned.name] for planned in plans]
