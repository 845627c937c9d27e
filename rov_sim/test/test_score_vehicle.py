"""The report of a vehicle's run: known errors are found, what was not recorded is said, nothing is overwritten."""

import json
from pathlib import Path

import pytest
from vehicle_run import PITCH_ERROR, SURGE_ERROR, THRUSTERS, Circle, topics, write_circle

from rov_sim.vehicle.cli_score_vehicle import _names, main
from run_bag import write_run
from run_bag.report.browser_check import check_report, missing_browser


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_circle(tmp_path_factory.mktemp("circle") / "circle")


@pytest.fixture(scope="module")
def scored(run: Path) -> Path:
    out = run.with_name("found")
    assert main([str(run), "--out", str(out)]) == 0
    return out


def scores_in(folder: Path) -> dict[str, dict[str, dict[str, float]]]:
    (one,) = json.loads((folder / "scores.json").read_text("utf-8"))["runs"]
    return dict(one)


def test_errors_of_the_set_points_are_found_in_their_degrees_of_freedom_alone(scored: Path) -> None:
    tracking = scores_in(scored)["tracking"]
    assert tracking["surge"]["rmse"] == pytest.approx(SURGE_ERROR)
    assert tracking["pitch"]["rmse"] == pytest.approx(PITCH_ERROR)
    others = [one["rmse"] for name, one in tracking.items() if name not in ("surge", "pitch")]
    assert others == pytest.approx([0.0] * 7, abs=1e-12)
    assert tracking["roll"]["normalised"] is None and tracking["pitch"]["normalised"] > 0.0


def test_odometry_and_estimates_are_scored_against_the_truth(scored: Path) -> None:
    found = scores_in(scored)
    assert found["odometry"]["sway"]["rmse"] == pytest.approx(0.003)
    assert found["v"]["rmse"] == pytest.approx(0.05)
    assert len(found["thrusters"]) == THRUSTERS
    assert found["thrusters"]["2"]["thrust"]["rmse"] == pytest.approx(0.3)  # type: ignore[index]
    assert found["thrusters"]["2"]["n"]["rmse"] == pytest.approx(1.0)  # type: ignore[index]


def test_a_part_of_a_run_can_be_scored(run: Path, tmp_path: Path) -> None:
    assert main([str(run), "--out", str(tmp_path / "part"), "--begin", "5", "--end", "9.98"]) == 0
    found = scores_in(tmp_path / "part")
    assert (found["begin"], found["end"]) == (5.0, 9.96)
    assert found["tracking"]["surge"]["samples"] == 125


def test_several_runs_stand_side_by_side(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(run), str(run), "--out", str(tmp_path / "both")]) == 0
    names = [one["name"] for one in json.loads((tmp_path / "both/scores.json").read_text("utf-8"))["runs"]]
    assert names == ["circle", "circle (2)"]
    assert capsys.readouterr().out.splitlines()[-1].endswith("both/report.html")


def test_runs_of_one_name_are_told_apart_by_their_folders() -> None:
    paths = [Path("a/one/run"), Path("a/two/run"), Path("b/dive")]
    assert _names(paths) == ["one/run", "two/run", "b/dive"]
    assert _names(paths[1:]) == ["run", "dive"]
    assert _names([paths[2], paths[2]]) == ["dive", "dive (2)"]


def test_without_truth_and_set_points_the_report_says_so(tmp_path: Path) -> None:
    run = write_circle(tmp_path / "bare", truth=False, set_points=False)
    assert main([str(run)]) == 0
    page = (tmp_path / "bare_scores/report.html").read_text("utf-8")
    assert "no set point was recorded" in page and "no truth was recorded" in page
    found = scores_in(tmp_path / "bare_scores")
    assert found["judged_by"] == "rov/odometry" and found["tracking"] == {}  # type: ignore[comparison-overlap]


def test_a_run_of_something_else_is_refused_and_a_full_folder_is_kept(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = write_run(tmp_path / "other", [one for one in topics(Circle(1.0)) if one.name == "thruster_0/state"])
    assert main([str(other), "--out", str(tmp_path / "new")]) == 1
    assert "expected a vehicle's run, with rov/truth or rov/odometry" in capsys.readouterr().err
    (tmp_path / "full").mkdir()
    (tmp_path / "full/precious").write_text("kept")
    assert main([str(run), "--out", str(tmp_path / "full")]) == 1
    assert "expected a new or empty folder" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "full").iterdir()] == ["precious"]
    assert main([str(run), "--out", str(tmp_path / "late"), "--begin", "50"]) == 1
    assert "found no sample" in capsys.readouterr().err
    assert not (tmp_path / "late").exists()


@pytest.mark.skipif(bool(missing_browser()), reason=missing_browser() or "browser present")
def test_the_report_draws_in_a_browser(scored: Path) -> None:
    findings = check_report(scored / "report.html", sizes=((1366, 768),))
    assert findings.plots == 14 and findings.ok, findings
