"""Where programs cannot write, or are ended: nothing is left that looks whole, a sentence is, inputs are as before."""

import hashlib
import importlib
import os
import re
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from run_bag import Topic, write_run
from thruster_control.references import REFERENCES

DT = 0.04
LIMIT = 2048
"""Bytes that a file may have on the full disk."""


class Program(NamedTuple):
    """A module with a `main`, its arguments for inputs and output, whether the output is a folder."""

    module: str
    arguments: Callable[[Path, Path], list[str]]
    folder: bool = True


PROGRAMS = {
    "show": Program("run_bag.cli_show", lambda given, out: [str(given / "bench"), "--out", str(out)], False),
    "recover": Program("run_bag.cli_recover", lambda given, out: [str(given / "bench"), "--out", str(out)]),
    "import": Program(
        "run_bag.importers.cli_recording",
        lambda given, out: [str(given / "log.csv"), "--map", str(given / "map.yaml"), "--out", str(out)],
    ),
    "fit": Program(
        "thruster_model.cli_fit",
        lambda given, out: [str(given / "bench"), "--model", "simplified", "--stages", "thesis", "--out", str(out)],
    ),
    "replay": Program(
        "thruster_estimation.cli_replay",
        lambda given, out: [str(given / "bench"), "--estimator", "ekf", "--out", str(out)],
    ),
    "simulate": Program(
        "rov_sim.cli_bench_campaign",
        lambda given, out: ["--set", "hl", "--programme", str(given / "programme.csv"), "--out", str(out)],
    ),
    "score": Program(
        "rov_sim.cli_score_experiment",
        lambda given, out: [str(given / "step"), "--reference", "step", "--out", str(out)],
    ),
    "new-set": Program("thruster_model.cli_new_set", lambda given, out: ["hl", "-o", str(out)], False),
}


@pytest.fixture(scope="module")
def given(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the programs read."""
    folder = tmp_path_factory.mktemp("given")
    time_ = 100.0 + DT * np.arange(400)
    stamps = np.round(1e9 * time_).astype(np.int64)
    rng = np.random.default_rng(3)
    throttle = np.where(time_ > 102.0, 2.0 * np.sin(time_ - 102.0), 0.0)
    speed = 60.0 * throttle + rng.normal(0.0, 0.5, time_.size)
    thrust = 4.0 * throttle * np.abs(throttle) + rng.normal(0.0, 0.1, time_.size)

    def topic(name: str, kind: str, **fields: np.ndarray) -> Topic:
        return Topic(name=f"thruster_0/{name}", type=kind, stamps=stamps, fields=fields)

    commanded = topic("throttle", "thruster_msgs/Throttle", commanded=throttle)
    load = topic("load", "geometry_msgs/WrenchStamped", **{"wrench.force.x": thrust})
    state = topic("state", "thruster_msgs/ThrusterState", n=speed)
    write_run(folder / "bench", [commanded, load, state])
    wanted = np.zeros(time_.size)
    wanted[30:280] = REFERENCES["step"].thrust(DT * np.arange(250))
    setpoint = topic("thrust_setpoint", "thruster_msgs/ThrustSetpoint", thrust=wanted)
    write_run(folder / "step", [setpoint, commanded, load])
    rows = "".join(f"{t:.3f},{u:.6f},{n:.4f}\n" for t, u, n in zip(time_, throttle, speed, strict=True))
    (folder / "log.csv").write_text(f"t,u,n\n{rows}")
    channels = "thruster_0/throttle.commanded: {column: u, unit: V}\nthruster_0/state.n: {column: n, unit: rad/s}\n"
    (folder / "map.yaml").write_text("time: {column: t}\n" + channels)
    steps = "".join(f"{0.04 * k:.2f},{2.0 * (k > 5):g}\n" for k in range(50))
    (folder / "programme.csv").write_text("time_s,throttle_V\n" + steps)
    return folder


def fingerprint(folder: Path) -> dict[str, str]:
    """Return the hash of every file in a folder, hidden ones too, by its path in it."""
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


@contextmanager
def full_disk() -> Iterator[None]:
    """No file of this process can grow beyond LIMIT."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (LIMIT, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """Nothing can be made in a folder."""
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "ro,size=64k", "tmpfs", str(folder)]
    if os.geteuid() != 0:
        folder.chmod(0o555)
        yield
        folder.chmod(0o755)
    elif subprocess.run(mount, capture_output=True).returncode == 0:
        yield
        subprocess.run(["umount", str(folder)], check=True)
    else:
        pytest.skip("this user writes everywhere and may not mount")


def started(program: Program, given: Path, out: Path) -> int:
    """Run a program in this process; return its status."""
    interrupt = signal.getsignal(signal.SIGINT)
    try:
        return int(importlib.import_module(program.module).main(program.arguments(given, out)))
    finally:
        signal.signal(signal.SIGINT, interrupt)


@pytest.mark.parametrize("name", PROGRAMS)
def test_where_it_cannot_write_a_program_says_so_and_leaves_all_as_it_was(
    name: str, given: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, before, out = PROGRAMS[name], fingerprint(given), tmp_path / "out"
    assert started(program, given, out) == 0, capsys.readouterr().err
    assert out.is_dir() == program.folder
    whole = fingerprint(tmp_path)
    assert whole and not [file for file in whole if ".part" in file]
    capsys.readouterr()

    assert started(program, given, out) != 0
    told = capsys.readouterr().err
    assert re.search(r"exists|expected a new or empty folder", told) and "Traceback" not in told
    assert fingerprint(tmp_path) == whole

    with full_disk():
        status = started(program, given, tmp_path / "full")
    told = capsys.readouterr().err
    assert status != 0 and "cannot be written: File too large" in told and "Traceback" not in told
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]

    with read_only(tmp_path / "closed"):
        status = started(program, given, tmp_path / "closed" / "out")
        assert list((tmp_path / "closed").iterdir()) == []
    told = capsys.readouterr().err
    assert status != 0 and re.search(r"cannot be written: (Read-only file system|Permission denied)", told)
    assert fingerprint(given) == before


SLOW = """
import importlib, sys, time
from safe_files import whole_files_io
def slow(path):
    print("writing", flush=True)
    time.sleep(120)
whole_files_io._to_disk = slow
sys.exit(importlib.import_module(sys.argv[1]).main(sys.argv[2:]))
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=["SIGTERM", "SIGKILL"])
@pytest.mark.parametrize("name", PROGRAMS)
def test_ended_while_it_writes_a_program_leaves_nothing_that_looks_whole(
    name: str, number: signal.Signals, given: Path, tmp_path: Path
) -> None:
    program, before = PROGRAMS[name], fingerprint(given)
    command = [sys.executable, "-c", SLOW, program.module, *program.arguments(given, tmp_path / "out")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        assert "writing\n" in iter(process.stdout.readline, "")
        process.send_signal(number)
        status, told = process.wait(60), process.stderr.read()
    left = [path.name for path in tmp_path.iterdir()]
    if number == signal.SIGTERM:
        assert status == 128 + number and "interrupted by SIGTERM; nothing was left there" in told
        assert left == []
    else:
        assert status == -number
        assert len(left) == 1 and left[0].startswith(".out.") and ".part" in left[0]
    assert fingerprint(given) == before
