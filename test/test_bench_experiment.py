"""scripts/bench_experiment.sh: one experiment in lockstep, from the emulated device to the report."""

import json
import os
import shutil
import subprocess
import uuid
from pathlib import Path

import numpy as np
import pytest

from run_bag.reader import read_run

ROOT = Path(__file__).resolve().parents[1]
LONGEST = 600.0
"""[s] From then on an experiment hangs; it takes a fortieth of that on a machine of its own."""


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


@pytest.mark.parametrize("device", [[], ["--firmware"]], ids=["python", "firmware"])
def test_an_experiment_is_recorded_and_scored_and_leaves_no_process_behind(tmp_path: Path, device: list[str]) -> None:
    if device and not (shutil.which("avr-gcc") and Path("/usr/include/simavr/sim_avr.h").exists()):
        pytest.skip("the firmware needs gcc make gcc-avr avr-libc libsimavr-dev libelf-dev")
    mark = uuid.uuid4().hex
    domain = os.environ["ROS_DOMAIN_ID"]
    environment = {**os.environ, "ROS_DOMAIN_ID": domain, "BENCH_EXPERIMENT_READY": "1", "EXPERIMENT_MARK": mark}
    out = tmp_path / "experiment"
    command = ["scripts/bench_experiment.sh", "--strategy", "hl-ekf", "--reference", "step", "--out", str(out), *device]
    with subprocess.Popen(
        command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            printed, errors = process.communicate(timeout=LONGEST)
        finally:
            process.terminate()  # it stops what it has started; leaving the block waits for it
    assert (process.returncode, errors) == (0, ""), printed
    assert processes_with(f"EXPERIMENT_MARK={mark}") == []

    report = Path(printed.splitlines()[-1])
    assert report == out / "scores" / "report.html"
    assert report.stat().st_size > 10_000
    scores = json.loads((out / "scores" / "scores.json").read_text(encoding="utf-8"))
    assert "hl-ekf" in json.dumps(scores)

    run = read_run(out / "run")
    state, estimate = (np.unique(run[f"thruster_0/{name}.n"].stamps) for name in ("state", "estimate"))
    assert len(state) > 270  # 1 s of rest, 10 s of steps and 0.5 s more at 25 Hz
    assert len(np.setdiff1d(state, estimate)) <= 1  # lockstep: every state has its estimate, but perhaps the last
    throttles = run["thruster_0/throttle_sent.sent"].values
    assert np.ptp(throttles[np.isfinite(throttles)]) > 1.0
    assert throttles[-1] == 0.0


def test_the_emulated_firmware_and_a_real_device_at_once_are_refused() -> None:
    command = ["scripts/bench_experiment.sh", "--strategy", "hl-ekf", "--reference", "step", "--firmware"]
    done = subprocess.run([*command, "--port", "/dev/null"], cwd=ROOT, capture_output=True, text=True, timeout=20.0)
    assert done.returncode == 2
    assert "--firmware: expected the emulated bench; found the device at /dev/null" in done.stderr
