"""scripts/rov_experiment.sh: one dive in lockstep, recorded and scored, that leaves no process behind."""

import json
import os
import shutil
import subprocess
import uuid
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from rov_sim.vehicle.recording_io import read_vehicle, signal
from rov_sim.vehicle.run_failures_io import failures_of
from run_bag.reader import read_run

ROOT = Path(__file__).resolve().parents[1]
LONGEST = 280.0
"""[s] Deadline of a dive; 5 s in the water take a tenth of that on a machine of its own."""
MOVES = """moves:
  - {time: 0.5, shape: quintic, duration: 2.0, size: {surge: 0.25, pitch: 0.2}}
  - {time: 4.0, shape: quintic, duration: 3.0, size: {pitch: -0.2, yaw: 0.5}}
  - {time: 9.0, shape: quintic, duration: 3.0, size: {pitch: 0.2, yaw: -0.5}}
end: 16.0
"""
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


class Done(NamedTuple):
    """What a script that has ended has printed, and the variable by which its processes are found."""

    status: int
    printed: str
    errors: str
    mark: str


def dived(script: Path, out: Path, how: list[str], moves: str = SCRIPT) -> Done:
    """Run a dive in this run's domain."""
    mark = f"EXPERIMENT_MARK={uuid.uuid4().hex}"
    script.write_text(moves, "utf-8")
    return ran(["scripts/rov_experiment.sh", "--script", str(script), "--out", str(out), *how], mark)


def ran(command: list[str], mark: str) -> Done:
    """Run a script whose workspace is ready, marked; it stops what it has started."""
    domain = os.environ["ROS_DOMAIN_ID"]
    name, _, value = mark.partition("=")
    environment = {**os.environ, "ROS_DOMAIN_ID": domain, "ROV_EXPERIMENT_READY": "1", name: value}
    with subprocess.Popen(
        command, env=environment, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        try:
            printed, errors = process.communicate(timeout=LONGEST)
        finally:
            process.terminate()  # it stops what it has started; leaving the block waits for it
    return Done(process.returncode, printed, errors, mark)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        (["--fail", "T9 dead at 3 s"], "failures: expected T1 to T6; found T9"),
        (["--effects", "barnacles.size=1"], "barnacles"),
        (["--watch", "no/such/run"], "watch: expected a run of the healthy vehicle; "),
        (
            ["--hardware", "T2=/dev/no_such_port"],
            "hardware: T2: expected a serial port; found nothing at /dev/no_such_port",
        ),
        (["--hardware", "T2=/etc/passwd"], "hardware: T2: expected a serial port; found no device at /etc/passwd"),
        (["--vehicle", "submarine"], "submarine"),
    ],
)
def test_what_is_refused_starts_nothing_and_leaves_no_folder(tmp_path: Path, how: list[str], said: str) -> None:
    done = dived(tmp_path / "short.yaml", tmp_path / "dive", how)
    assert done.status != 0 and said in done.errors
    assert len(done.errors.splitlines()) == 1 and not (tmp_path / "dive").exists()


@pytest.mark.parametrize(
    "how",
    [
        pytest.param(["--composed"], id="composed", marks=pytest.mark.long),
        pytest.param(["--feedback", "estimator"], id="process per node"),
    ],
)
def test_a_dive_is_recorded_and_scored_and_leaves_no_process_behind(tmp_path: Path, how: list[str]) -> None:
    out = tmp_path / "dive"
    done = dived(tmp_path / "short.yaml", out, how)
    assert done.status == 0, done.printed + done.errors
    assert processes_with(done.mark) == []
    report = Path(done.printed.splitlines()[-1])
    assert report == out / "scores" / "report.html" and report.stat().st_size > 10_000
    scores = json.loads((out / "scores" / "scores.json").read_text(encoding="utf-8"))
    assert scores["runs"][0]["tracking"]["surge"]["rmse"] < 0.02
    run = read_run(out / "run")
    throttles = run["thruster_0/throttle.commanded"].values
    assert np.ptp(throttles) > 0.5 and throttles[-1] == 0.0
    if "--composed" in how:
        again = ran(["scripts/rov_replay.sh", str(out), "--out", str(tmp_path / "again")], done.mark)
        assert again.status == 0, again.printed + again.errors
        assert again.printed.splitlines()[-1] == "equal" and "thruster_5/estimate" in again.printed
        assert processes_with(done.mark) == []


@pytest.mark.long
def test_a_thruster_that_fails_in_mid_dive_is_found_by_the_watch_and_its_share_given_to_others(tmp_path: Path) -> None:
    how = ["--composed", "--vehicle", "ngs", "--strategy", "lookup"]
    healthy = dived(tmp_path / "moves.yaml", tmp_path / "healthy", how, MOVES)
    assert healthy.status == 0, healthy.printed + healthy.errors
    how += ["--watch", str(tmp_path / "healthy" / "run"), "--fail", "T2 weak 0.4 at 7 s"]
    done = dived(tmp_path / "moves.yaml", tmp_path / "weak", how, MOVES)
    assert done.status == 0, done.printed + done.errors
    recording = read_vehicle(tmp_path / "weak" / "run")
    (found,) = failures_of(recording)
    assert (found.thruster, found.kind) == (1, "weak") and 7.0 < found.told < 14.0
    assert abs(found.effectiveness - 0.4) < 0.15
    asked = signal(recording.run, "thruster_1/thrust_setpoint.thrust")
    true = signal(recording.run, "thruster_1/truth.thrust")
    assert asked is not None and true is not None
    late = asked[0] > found.told + 1.0
    given = np.interp(asked[0][late], *true)
    moving = np.abs(asked[1][late]) > 1.0
    assert np.median(given[moving] / asked[1][late][moving]) < 0.55, "it is weak, and asked for what its share gives"
    assert "failed, not told" in (tmp_path / "weak" / "scores" / "report.html").read_text("utf-8")
    assert processes_with(done.mark) == []


@pytest.mark.parametrize("device", [pytest.param("emulated", marks=pytest.mark.long), "firmware"])
def test_one_of_six_thrusters_may_be_a_driver_and_its_device(tmp_path: Path, device: str) -> None:
    if device == "firmware" and not (shutil.which("avr-gcc") and shutil.which("make")):
        pytest.skip("the firmware needs gcc make gcc-avr avr-libc libsimavr-dev libelf-dev")
    out = tmp_path / "dive"
    done = dived(tmp_path / "short.yaml", out, ["--composed", "--hardware", f"T1={device}"])
    if device == "firmware" and done.status == 2 and "simavr" in done.errors:
        pytest.skip("the firmware needs libsimavr-dev libelf-dev")
    assert done.status == 0, done.printed + done.errors
    assert processes_with(done.mark) == []
    assert (out / "firmware" / "emulator").exists() == (device == "firmware")
    run = read_run(out / "run")
    sent = run["thruster_0/throttle_sent.sent"].values
    assert np.nanmax(np.abs(sent)) > 0.5 and sent[-1] == 0.0, "the device was driven, and left at rest"
    told, true = run["thruster_0/state.n"].values, run["thruster_0/truth.n"].values
    assert np.nanmax(np.abs(told)) > 20.0 and np.nanmax(np.abs(true)) > 20.0, "its speed is the vehicle's thruster's"
    assert "thruster_1/throttle_sent.sent" not in run, "the others are simulated"


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


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ([], "expected a folder of scripts/rov_experiment.sh; found none"),
        (["test"], "test: expected a run/ and nodes/allocator.yaml in it"),
        (["test", "docs"], "expected one dive; found 'test' and 'docs'"),
        (["test", "--node", "allocator"], "--node: expected NAME=FILE.yaml; found 'allocator'"),
        (["DIVE", "--tolerance", "abc"], "--tolerance: expected a number, 0 or larger; found 'abc'"),
    ],
)
def test_what_cannot_be_replayed_is_refused_with_a_sentence(given: list[str], said: str) -> None:
    done = subprocess.run(
        ["scripts/rov_replay.sh", *given], cwd=ROOT, capture_output=True, text=True, timeout=20.0, check=False
    )
    assert done.returncode == 2 and said in done.stderr
