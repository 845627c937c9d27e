"""Scores of a recorded experiment: where it begins, what is scored, what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

from rov_sim.cli_score_experiment import main
from rov_sim.experiment_scores import Recorded, experiment_of, period_means
from run_bag import Topic, write_run
from thruster_control.references import REFERENCES

PERIOD = 0.04


def recording(kind: str, begin: int, after: int = 20) -> Recorded:
    """Return 0 N for `begin` periods, the set point's 10 s, 0 N again; stamps begin at 100 s."""
    wanted = np.zeros(begin + 250 + after)
    wanted[begin : begin + 250] = REFERENCES[kind].thrust(PERIOD * np.arange(250))
    return Recorded(time=100.0 + PERIOD * np.arange(wanted.size), values=wanted)


@pytest.mark.parametrize("kind", ["step", "sine", "ramp"])
@pytest.mark.parametrize("begin", [0, 26, 113])
def test_the_run_begins_where_the_set_point_does(kind: str, begin: int) -> None:
    wanted = recording(kind, begin)
    found = experiment_of(kind, wanted, wanted, None, None)
    assert found.begin == pytest.approx(100.0 + PERIOD * begin)
    assert found.time.size == 250 and found.period == pytest.approx(PERIOD)
    assert found.scores.samples == 0, "there is no load cell"


def test_the_score_is_the_root_mean_square_over_the_windows_by_hand() -> None:
    wanted = recording("step", 10)
    off = np.where(np.arange(wanted.time.size) - 10 < 30, 50.0, 0.5)  # 50 N off in the 1.2 s that are left out
    load = Recorded(time=wanted.time + 0.5 * PERIOD, values=wanted.values + off)
    throttle = Recorded(time=wanted.time, values=np.where(np.arange(wanted.time.size) % 2, 1.0, -1.0))
    found = experiment_of("step", wanted, throttle, load, None)
    assert found.scores.rmse == pytest.approx(0.5)
    assert found.scores.samples == 250 - 60
    assert found.scores.chatter == pytest.approx(2.0 * 249)


def test_thrust_is_the_mean_of_the_samples_of_each_period() -> None:
    time = np.arange(0.0, 1.0, 0.001)
    means = period_means(Recorded(time=time, values=time), np.array([0.1, 0.14, 0.18, 5.0, 5.1]))
    assert means[:2] == pytest.approx([0.1195, 0.1595])
    assert np.isnan(means[3])


def test_the_truth_is_scored_by_the_trapezium() -> None:
    wanted = recording("sine", 5)
    fine = np.arange(99.0, 115.0, PERIOD)
    true = Recorded(time=fine, values=REFERENCES["sine"].thrust(fine - (100.0 + 5 * PERIOD)) + 0.3)
    found = experiment_of("sine", wanted, wanted, None, true)
    assert found.true_scores.rmse == pytest.approx(np.sqrt(0.3**2 + (5 * 1.88 * PERIOD / 2) ** 2 / 2), rel=0.05)


@pytest.mark.parametrize(
    ("kind", "of", "said"),
    [("sine", "step", "expected the set point of a sine"), ("square", "step", "reference: expected one of")],
)
def test_another_set_point_is_refused(kind: str, of: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        experiment_of(kind, recording(of, 3), recording(of, 3), None, None)


def test_a_recording_that_ends_early_is_refused() -> None:
    wanted = recording("sine", 3)
    short = Recorded(time=wanted.time[:200], values=wanted.values[:200])
    with pytest.raises(ValueError, match="found none"):
        experiment_of("sine", short, short, None, None)


def topic(name: str, kind: str, recorded: Recorded, **fields: np.ndarray) -> Topic:
    stamps = np.round(1e9 * recorded.time).astype(np.int64)
    return Topic(name=name, type=kind, stamps=stamps, fields=fields, frame="thruster_0")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    wanted = recording("sine", 7)
    topics = [
        topic("thruster_0/thrust_setpoint", "thruster_msgs/msg/ThrustSetpoint", wanted, thrust=wanted.values),
        topic("thruster_0/throttle", "thruster_msgs/msg/Throttle", wanted, commanded=0.1 * wanted.values),
        topic(
            "daq/thruster_0/load", "geometry_msgs/msg/WrenchStamped",
            Recorded(time=wanted.time + 0.02, values=wanted.values), **{"wrench.force.x": wanted.values + 0.25},
        ),
    ]  # fmt: skip
    write_run(tmp_path / "run", topics, {})
    return tmp_path / "run"


def test_the_command_prints_the_score_and_the_reports_path(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--reference", "sine", "--strategy", "hl-ekf"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "hl-ekf" in lines[0] and "RMSE  0.250 N (load cell)" in lines[0]
    report = Path(lines[-1])
    assert report == run.with_name("run_scores") / "report.html"
    assert "Thrust tracking: sine, hl-ekf" in report.read_text("utf-8")
    scores = json.loads((report.parent / "scores.json").read_text("utf-8"))
    assert scores["scores"]["load_cell"]["rmse"] == pytest.approx(0.25)
    assert scores["scores"]["truth"]["rmse"] is None


def test_the_command_overwrites_nothing_and_says_what_is_missing(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), "--reference", "sine"]) == 0
    assert main([str(run), "--reference", "sine"]) == 1
    assert "expected a new or empty folder" in capsys.readouterr().err
    assert main([str(run), "--reference", "step", "--out", str(run.parent / "other")]) == 1
    assert "expected the set point of a step" in capsys.readouterr().err
    assert main([str(run), "--reference", "sine", "--thruster", "3", "--out", str(run.parent / "other")]) == 1
    assert not (run.parent / "other").exists()
