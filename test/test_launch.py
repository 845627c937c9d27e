"""The graphs by `ros2 launch`, tuned by `ros2 param`: with the stock command, where there is one."""

import os
import shutil
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from run_bag.reader import read_recording, read_run

LONGEST = 300.0
"""[s] Deadline of what takes a tenth of that on a machine of its own."""
DOMAIN = os.environ["ROS_DOMAIN_ID"]


@pytest.fixture(scope="module", autouse=True)
def stock() -> None:
    """Skip without the stock command, of which the stand-in for the wheels knows little."""
    if shutil.which("ros2") is None:
        pytest.skip("no ros2 command here")
    done = subprocess.run(["ros2", "launch", "--help"], capture_output=True, timeout=60.0, check=False)
    if done.returncode != 0:
        pytest.skip("ros2 launch is not here: it comes with an installation of ROS 2, not with the wheels")


@contextmanager
def launched(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    environment = {**os.environ, "ROS_DOMAIN_ID": DOMAIN, "PYTHONUNBUFFERED": "1"}
    command = ["ros2", "launch", "rov_sim", *arguments]
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    ) as process:
        try:
            yield process
        finally:
            process.send_signal(signal.SIGINT)


def test_a_bench_experiment_is_started_recorded_and_ended(tmp_path: Path) -> None:
    with launched("bench.launch.py", "strategy:=lookup", f"out:={tmp_path / 'out'}") as process:
        said, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 0, said
    assert "discovery: this machine alone" in said
    assert f"the scores: ros2 run rov_sim score_experiment {tmp_path / 'out' / 'run'} --reference step" in said
    throttles = read_run(tmp_path / "out" / "run")["thruster_0/throttle_sent.sent"].values
    assert np.ptp(throttles[np.isfinite(throttles)]) > 1.0


def test_a_dive_of_a_vehicle_is_started_recorded_and_ended(tmp_path: Path) -> None:
    script, out = tmp_path / "short.yaml", tmp_path / "out"
    script.write_text("moves:\n  - {time: 0.5, shape: quintic, duration: 1.5, size: {surge: 0.2}}\nend: 3.0\n", "utf-8")
    with launched("vehicle.launch.py", f"script:={script}", "strategy:=lookup", "rates:=25", f"out:={out}") as process:
        said, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 0, said
    assert "argument rates: not one of this launch file's, passed over; the nearest is rate" in said
    assert f"the scores: ros2 run rov_sim score_vehicle {out / 'run'}" in said
    run = read_run(out / "run")
    surge = run["rov/odometry.twist.twist.linear.x"]
    assert surge.values.max() > 0.1 and surge.stamps[-1] - surge.stamps[0] > 3e9
    assert run["thruster_0/throttle.commanded"].values[-1] == 0.0


@pytest.mark.parametrize(
    ("graph", "wrong", "said"),
    [
        ("bench", "seed:=x", "seed: expected a whole number from 0; found 'x'"),
        ("vehicle", "real_time:=maybe", "real_time: expected true or false; found 'maybe'"),
        ("vehicle", "strategy:=best", "strategy: expected one of lookup"),
        ("vehicle", "network:=all", "network: expected one of machine, network; found 'all'"),
        ("bench", "out:={there}", "out: expected a new folder; found"),
    ],
)
def test_a_wrong_argument_starts_nothing_and_is_named(graph: str, wrong: str, said: str, tmp_path: Path) -> None:
    arguments = [f"out:={tmp_path / 'out'}", wrong.format(there=tmp_path)]
    with launched(f"{graph}.launch.py", *arguments) as process:
        told, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 1 and said in told and "Traceback" not in told
    assert "process started" not in told and not (tmp_path / "out").exists()


def test_a_parameter_is_tuned_while_the_bench_runs_and_the_run_keeps_it(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with launched("bench.launch.py", "strategy:=simplified", "real_time:=true", f"out:={out}") as process:
        assert process.stdout is not None
        for line in process.stdout:
            if "emulated_bench]: port:" in line:
                break

        def tune(*words: str) -> str:
            command = ["ros2", "param", "set", *words]
            environment = {**os.environ, "ROS_DOMAIN_ID": DOMAIN, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
            )
            return done.stdout + done.stderr

        for _ in range(30):
            if "successful" in (said := tune("/inner_loop", "k_P", "6")):
                break
        else:
            pytest.fail(said)
        assert "expected a finite number from 0" in tune("/inner_loop", "hysteresis", "-1.0")
        assert "strategy: fixed at start" in tune("/inner_loop", "strategy", "lookup")
        process.communicate(timeout=LONGEST)
    kept = read_recording(out / "run").metadata
    # A recorder that asks for the parameters after the change finds the new value.
    values = [kept["nodes"]["/inner_loop"], *(each["values"] for each in kept.get("parameter_changes", []))]
    assert 6.0 in [each.get("k_P") for each in values]
