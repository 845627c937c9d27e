"""Trends: the line's numbers by hand and by scatter of many draws; the command on dives of a vehicle that fouls."""

import json
from pathlib import Path

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.cli_trend import main
from gap_diagnosis.vehicle.diagnosis_io import load_model, names_of
from gap_diagnosis.vehicle.trend import Size, followed, line_of
from run_bag import write_run


def sizes(values: list[float], deviation: float = 0.1) -> list[Size]:
    return [Size(time=float(k), size=v, deviation=deviation) for k, v in enumerate(values)]


def test_a_line_through_points_on_a_line_is_that_line_with_the_deviations_of_least_squares() -> None:
    line = line_of(sizes([0.0, 0.2, 0.4]))
    assert (line.slope, line.level, line.middle) == pytest.approx((0.2, 0.2, 1.0))
    assert line.slope_deviation == pytest.approx(0.1 / np.sqrt(2.0)) and line.level_deviation == pytest.approx(
        0.1 / np.sqrt(3.0)
    )
    assert line.rises and line.reaches(0.6) == pytest.approx(3.0) and line.reaches(-1.0) is None


def test_slopes_of_no_trend_are_called_none_as_often_as_two_deviations_say() -> None:
    rng = np.random.default_rng(5)
    called = sum(line_of(sizes(list(0.1 * rng.normal(size=8)))).rises for _ in range(1000))
    assert called < 65  # 46 by a normal distribution; less where scatter counts


def test_sizes_that_scatter_more_than_they_should_make_a_slope_less_sure() -> None:
    calm, wild = line_of(sizes([0.0, 0.1, 0.2, 0.3])), line_of(sizes([0.0, 0.5, -0.2, 0.3]))
    assert calm.scatter == 1.0 and wild.scatter > 2.0
    assert wild.slope_deviation == pytest.approx(wild.scatter * calm.slope_deviation)


def test_two_dives_are_too_few(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["a", "b", "--vehicle", "ngs", "--out", str(tmp_path / "out")]) == 1
    assert "three dives or more; found 2" in capsys.readouterr().err


def test_an_effect_of_thrusters_is_followed_on_the_one_that_is_named_or_on_all() -> None:
    model = load_model("ngs")
    assert followed(model, [], "thrust_loss", 2, None).thruster == 2
    assert followed(model, [], "thrust_loss", None, None, every=True).thruster is None
    ways = ", ".join(["--thruster all", *(f"--thruster {i}" for i in range(6))])
    for thruster in (None, 9):
        with pytest.raises(ValueError, match=rf"^--effect thrust_loss: expected {ways}$"):
            followed(model, [], "thrust_loss", thruster, None)
    with pytest.raises(ValueError, match=r"^--effect water_density: expected neither --thruster nor --axis$"):
        followed(model, [], "water_density", 2, None)
    with pytest.raises(ValueError, match=r"^--effect water_density: expected neither --thruster nor --axis$"):
        followed(model, [], "water_density", None, None, every=True)


def test_dives_of_one_name_are_told_apart_by_the_folders_they_are_in(tmp_path: Path) -> None:
    runs = [tmp_path / "may" / "run", tmp_path / "june" / "run", tmp_path / "last"]
    assert names_of(runs) == ["may/run", "june/run", "last"]


def test_a_propeller_that_wears_shows_its_slope_and_an_unknown_effect_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    believed, paths = load_model("ngs"), []
    for k, share in enumerate((0.05, 0.2, 0.35)):
        draw = Draw(
            seed=30 + k, vehicle="ngs", effects=(("thrust_loss", {"thruster": 4}, {"share": share}),), deviations=0.0,
            wrench=0.05, kinds=("pulses",), duration=12.0,
        )  # fmt: skip
        topics = recorded(draw, believed.vehicle, believed.sets, believed.sensors)[0]
        paths.append(str(write_run(tmp_path / f"dive_{k}", topics)))
    out = tmp_path / "out"
    of = ["--vehicle", "ngs", "--out", str(out)]
    assert main([*paths, *of, "--effect", "barnacles"]) == 1
    assert "found barnacles" in capsys.readouterr().err and not out.exists()
    assert main([*paths, *of]) == 1
    assert "expected --thruster all, --thruster 0" in capsys.readouterr().err and not out.exists()
    assert main([*paths, *of, "--thruster", "4", "--limit", "0.5"]) == 0
    content = json.loads((out / "trend.json").read_text("utf-8"))
    line = content["line"]
    assert content["rises"] and abs(line["slope"] - 0.15) < 3.0 * line["slope_deviation"] < 0.12
    assert "0.5 at dive" in content["summary"] and (out / "report.html").exists()
