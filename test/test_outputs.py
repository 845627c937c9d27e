"""Where programs cannot write, or are ended: nothing is left that looks whole, a sentence is, inputs are as before."""

import hashlib
import importlib
import os
import re
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from runpy import run_path
from typing import Any, NamedTuple

import numpy as np
import pytest

from gap_diagnosis.vehicle.hypotheses import VEHICLE_LIBRARY
from run_bag import Topic, write_run
from safe_files import whole_files_io
from thruster_control.references import REFERENCES
from thruster_model.effects.stages import LIBRARY

ROOT = Path(__file__).resolve().parents[1]
DT = 0.04
BUT_ONE, BUT_ONE_OF_A_VEHICLE = (
    sorted({*known} - {"thrust_loss"}) for known in (LIBRARY, [*LIBRARY, *VEHICLE_LIBRARY])
)
LIMIT = 2048
"""Bytes that a file may have on the full disk."""


class Program(NamedTuple):
    """A module with a `main`, its arguments for inputs and output, whether the output is a folder.

    once: functions of the module that compute for long; what they return is kept for the next calls.
    """

    module: str
    arguments: Callable[[Path, Path], list[str]]
    folder: bool = True
    once: tuple[str, ...] = ()


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
    "new-vehicle": Program(
        "thruster_model.cli_new_vehicle", lambda given, out: ["--vehicle", "ngs", "-o", str(out)], False
    ),
    "diagnose": Program(
        "gap_diagnosis.cli_diagnose",
        lambda given, out: [str(given / "bench"), "--set", "hl", "--out", str(out), "--without", *BUT_ONE],
        once=("diagnose",),
    ),
    "load_cell": Program(
        "thruster_model.cli_load_cell",
        lambda given, out: [str(given / "gauges"), "--calibrate-only", "--out", str(out)],
    ),
    "log_effects": Program(
        "thruster_model.cli_log_effects",
        lambda given, out: [str(given / "bench"), "--effects", "log_alignment.throttle=0.05", "--out", str(out)],
    ),
    "force_table": Program(
        "thruster_model.cli_force_table",
        lambda given, out: [str(given / "sheet.csv"), "--map", str(given / "columns.yaml"), "--out", str(out)],
        False,
    ),
    "score_vehicle": Program(
        "rov_sim.vehicle.cli_score_vehicle", lambda given, out: [str(given / "dive"), "--out", str(out)]
    ),
    "pulses": Program(
        "gap_diagnosis.vehicle.cli_pulses",
        lambda given, out: ["--vehicle", "ngs", "--out", str(out)],
        once=("pulses",),
    ),
}
AT_LENGTH = {
    "diagnose_vehicle": Program(
        "gap_diagnosis.vehicle.cli_diagnose_vehicle",
        lambda given, out: [
            str(given / "dive"),
            "--vehicle",
            "ngs",
            "--out",
            str(out),
            "--without",
            *BUT_ONE_OF_A_VEHICLE,
        ],
        once=("diagnosed",),
    ),
    "fit_vehicle": Program(
        "gap_diagnosis.vehicle.cli_fit_vehicle",
        lambda given, out: [str(given / "dive"), "--vehicle", "ngs", "--out", str(out)],
        once=("fitted_vehicle",),
    ),
    "trend": Program(
        "gap_diagnosis.vehicle.cli_trend",
        lambda given, out: [*[str(given / "dive")] * 3, "--vehicle", "ngs", "--thruster", "0", "--out", str(out)],
        once=("followed", "size_in"),
    ),
}
"""Programs that compute for up to a minute: in the long tests."""
ALL = PROGRAMS | AT_LENGTH
NAMES = [*PROGRAMS, *(pytest.param(name, marks=pytest.mark.long) for name in AT_LENGTH)]


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
    gauges, legs = rng.normal(2.5, 0.3, (time_.size, 6)), rng.normal(0.0, 5.0, (time_.size, 6))
    wrench = legs @ rng.normal(0.0, 0.5, (6, 6))
    parts = zip([f"wrench.{kind}.{axis}" for kind in ("force", "torque") for axis in "xyz"], wrench.T, strict=True)
    cell = topic("gauges", "thruster_msgs/LoadCellGauges", voltage=gauges, force=legs)
    write_run(folder / "gauges", [cell, topic("load", "geometry_msgs/WrenchStamped", **dict(parts))])
    run_path(str(ROOT / "rov_sim/test/vehicle_run.py"))["write_circle"](folder / "dive")
    example = run_path(str(ROOT / "docs/examples/t200.py"))
    example["sheet"](folder / "sheet.csv")
    (folder / "columns.yaml").write_text(example["COLUMNS"])
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


@pytest.fixture(scope="module")
def kept() -> Iterator[None]:
    """What the programs compute for long they compute once."""
    with pytest.MonkeyPatch.context() as patch:
        for program in ALL.values():
            for name in program.once:
                function = getattr(importlib.import_module(program.module), name)
                patch.setattr(f"{program.module}.{name}", once(function))
        yield


def once(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that calls another one the first time alone."""
    results: list[Any] = []

    def call(*arguments: Any, **named: Any) -> Any:
        if not results:
            results.append(function(*arguments, **named))
        return results[0]

    return call


def started(program: Program, given: Path, out: Path) -> int:
    """Run a program in this process; return its status."""
    interrupt = signal.getsignal(signal.SIGINT)
    try:
        return int(importlib.import_module(program.module).main(program.arguments(given, out)))
    finally:
        signal.signal(signal.SIGINT, interrupt)


@pytest.mark.parametrize("name", NAMES)
def test_where_it_cannot_write_a_program_says_so_and_leaves_all_as_it_was(
    name: str, given: Path, kept: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    program, before, out = ALL[name], fingerprint(given), tmp_path / "out"
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


def begun(program: Program, given: Path, out: Path, told: Path) -> int:
    """Start a program in a copy of this process, which writes slowly and tells when it begins to; return its id."""
    sys.stdout.flush()
    sys.stderr.flush()
    if pid := os.fork():
        return pid
    status = 99
    try:
        output = os.open(told, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        os.dup2(output, 1)
        os.dup2(output, 2)
        sys.stdout = sys.stderr = os.fdopen(output, "a", buffering=1)
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
        whole_files_io._to_disk = slowly
        status = int(importlib.import_module(program.module).main(program.arguments(given, out)))
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 98
    finally:
        os._exit(status)  # nothing of the tests' own is to end twice


def slowly(path: Path) -> None:
    os.write(1, b"writing\n")
    time.sleep(120)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=["SIGTERM", "SIGKILL"])
@pytest.mark.parametrize("name", NAMES)
def test_ended_while_it_writes_a_program_leaves_nothing_that_looks_whole(
    name: str, number: signal.Signals, given: Path, kept: None, tmp_path: Path
) -> None:
    program, before, told = ALL[name], fingerprint(given), tmp_path / "told"
    (tmp_path / "here").mkdir()
    pid = begun(program, given, tmp_path / "here" / "out", told)
    ended, status = 0, 0
    while not (ended or (told.exists() and "writing\n" in told.read_text())):
        ended, status = os.waitpid(pid, os.WNOHANG)
        time.sleep(0.01)
    assert not ended, told.read_text()
    os.kill(pid, number)
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    left = [path.name for path in (tmp_path / "here").iterdir()]
    if number == signal.SIGTERM:
        assert status == 128 + number and "interrupted by SIGTERM; nothing was left there" in told.read_text()
        assert left == []
    else:
        assert status == -number
        assert len(left) == 1 and left[0].startswith(".out.") and ".part" in left[0]
    assert fingerprint(given) == before
