"""scripts/rov_experiment.sh: one dive in lockstep, recorded and scored, that leaves no process behind."""

import json
import os
import subprocess
import uuid
from pathlib import Path

import numpy as np
import pytest

from run_bag.reader import read_run

ROOT = Path(__file__).resolve().parents[1]
LONGEST = 280.0
"""[s] Deadline of a dive; 5 s in the water take a tenth of that on a machine of its own."""
SCRIPT = "moves:\n  - {time: 0.5, shape: quintic, duration: 2.0, size: {surge: 0.2, pitch: 0.2}}\nend: 4.0\n"


def processes_with(variable: str) -> list[int]:
    """Return the processes that have `NAME=value` in their environment."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if variable.encode() in (folder / "environ").read_bytes().split(b"\0"):
                found.append(int(folder.name))
        except OSError:  # it has ended, or is not ours to look at
            continue
    return found


@pytest.mark.parametrize("how", [["--composed"], ["--feedback", "estimator"]], ids=["composed", "process per node"])
def test_a_dive_is_recorded_and_scored_and_leaves_no_process_behind(tmp_path: Path, how: list[str]) -> None:
    mark = uuid.uuid4().hex
    domain = os.environ.get("ROS_DOMAIN_ID", str(os.getpid() % 101 + 1))
    environment = {**os.environ, "ROS_DOMAIN_ID": domain, "ROV_EXPERIMENT_READY": "1", "EXPERIMENT_MARK": mark}
    out, script = tmp_path / "dive", tmp_path / "short.yaml"
    script.write_text(SCRIPT, "utf-8")
    command = ["scripts/rov_experiment.sh", "--script", str(script), "--out", str(out), *how]
    with subprocess.Popen(
        command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            printed, errors = process.communicate(timeout=LONGEST)
        finally:
            process.terminate()  # it stops what it has started; leaving the block waits for it
    assert process.returncode == 0, printed + errors
    assert processes_with(f"EXPERIMENT_MARK={mark}") == []
    report = Path(printed.splitlines()[-1])
    assert report == out / "scores" / "report.html" and report.stat().st_size > 10_000
    scores = json.loads((out / "scores" / "scores.json").read_text(encoding="utf-8"))
    assert scores["runs"][0]["tracking"]["surge"]["rmse"] < 0.02
    run = read_run(out / "run")
    throttles = run["thruster_0/throttle.commanded"].values
    assert np.ptp(throttles) > 0.5 and throttles[-1] == 0.0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--strategy", "best"], "--strategy: expected one of lookup"),
        (["--compare", "--strategy", "lookup"], "--compare runs strategies and truths of its own"),
        (["--fail"], "--fail: expected a value"),
        (["--sink"], "unknown option '--sink'"),
    ],
)
def test_what_makes_no_sense_is_refused_with_a_sentence(given: list[str], said: str) -> None:
    done = subprocess.run(
        ["scripts/rov_experiment.sh", *given], cwd=ROOT, capture_output=True, text=True, timeout=20.0, check=False
    )
    assert done.returncode == 2 and said in done.stderr
