"""Failures in a vehicle's run: when they began, when they were told, what the report says of it."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from vehicle_run import SECOND, Circle, topics

from rov_sim.vehicle.cli_score_vehicle import main
from rov_sim.vehicle.live import FailureKind
from rov_sim.vehicle.recording_io import read_vehicle
from rov_sim.vehicle.run_failures_io import failures_of
from rov_sim.vehicle.run_report_io import verdict
from rov_sim.vehicle.scores import Score
from run_bag import Topic, write_run
from run_bag.known_topics import KNOWN_VEHICLE


def written(folder: Path, told: float | None) -> Path:
    """Write a run in which thruster 1 was made to lose half its thrust at 8 s, and that was told or not."""
    found = topics(Circle())
    if told is not None:
        fields = {"thruster": 1, "kind": int(FailureKind.WEAK), "effectiveness": 0.52, "stuck_thrust": np.nan}
        stamps = np.array([SECOND + round(told * SECOND)])
        name = "rov/thruster_failure"
        columns = {key: np.array([value]) for key, value in fields.items()}
        found.append(Topic(name=name, type=KNOWN_VEHICLE[name], stamps=stamps, fields=columns))
    return write_run(folder, found, {"failures": "T2 weak 0.5 at 8 s; velocity lost at 3 s"})


def test_a_failure_is_what_was_hidden_beside_what_was_told(tmp_path: Path) -> None:
    (found,) = failures_of(read_vehicle(written(tmp_path / "told", 11.0)))
    assert (found.thruster, found.hidden, found.kind) == (1, "T2 weak 0.5 at 8 s", "weak")
    assert found.begun == pytest.approx(8.0) and found.told == pytest.approx(11.0)
    assert found.effectiveness == 0.52
    (silent,) = failures_of(read_vehicle(written(tmp_path / "silent", None)))
    assert silent.told == np.inf and silent.begun == pytest.approx(8.0)


def test_verdict_terminal_and_scores_tell_of_each_failure(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    weak = "Thruster 1 (T2) was made to fail (weak 0.5) at 8.0 s; "
    says = f"{weak}reported after 3.0 s as weak, 0.52 left."
    silent = "The sensor velocity was made to fall silent at 3.0 s."
    assert main([str(written(tmp_path / "told", 11.0)), "--out", str(tmp_path / "scores")]) == 0
    printed = capsys.readouterr().out
    assert says in printed and silent in printed
    assert f"{says} {silent}" in (tmp_path / "scores" / "report.html").read_text("utf-8")
    (run,) = json.loads((tmp_path / "scores" / "scores.json").read_text("utf-8"))["runs"]
    assert run["silent"] == {"velocity": 3.0}
    (failure,) = run["failures"]
    assert (failure["thruster"], failure["kind"], failure["effectiveness"]) == (1, "weak", 0.52)
    assert failure["told"] - failure["begun"] == pytest.approx(3.0)
    assert main([str(written(tmp_path / "silent", None)), "--out", str(tmp_path / "other")]) == 0
    assert f"{weak}never reported." in capsys.readouterr().out
    (run,) = json.loads((tmp_path / "other" / "scores.json").read_text("utf-8"))["runs"]
    assert run["failures"][0]["told"] is None


def test_a_share_of_more_than_a_hundred_percent_is_written_out() -> None:
    one = Score(rmse=1.53, set_point=1.0, normalised=1.53, largest=3.0, samples=9)
    scores = SimpleNamespace(tracking={"surge": one._replace(normalised=0.054), "yaw": one})
    assert "Surge follows best, RMSE 5.4 % of the mean set point; Yaw worst, 153 %" in verdict("run", scores)  # type: ignore[arg-type]


def test_the_report_says_how_long_it_took_and_what_it_changed(tmp_path: Path) -> None:
    assert main([str(written(tmp_path / "told", 11.0)), "--out", str(tmp_path / "scores")]) == 0
    page = (tmp_path / "scores" / "report.html").read_text("utf-8")
    assert "when rov/thruster_failure told of them" in page and "failed, not told" in page
    assert main([str(written(tmp_path / "silent", None)), "--out", str(tmp_path / "other")]) == 0
    assert "never told" in (tmp_path / "other" / "report.html").read_text("utf-8")
