"""Programmes keep their limits, or are refused."""

from pathlib import Path

import numpy as np
import pytest

from gap_diagnosis.vehicle.cli_pulses import main
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.programmes import Limits, pulses, sweeps
from gap_diagnosis.vehicle.programmes_io import TABLE, write_programme
from run_bag import read_run


def test_each_thruster_is_alone_both_ways_and_within_the_limits() -> None:
    limits = Limits(throttle=2.5, tilt=0.4, depth=0.5, speed=0.5)
    programme = pulses(load_model("ngs"), limits)
    u = programme.throttles
    assert np.all((u != 0.0).sum(axis=1) <= 1)
    assert np.all(u.max(axis=0) > 0.86) and np.all(u.min(axis=0) < -0.86)
    assert u.sum(axis=0) == pytest.approx(np.zeros(6), abs=1e-9)
    run = programme.dry_run
    assert run.level <= 2.5 and run.tilt < 0.4 and run.depth < 0.5 and run.speed < 0.5


def test_a_programme_is_written_as_a_run_and_as_a_table_of_the_same_throttles(tmp_path: Path) -> None:
    model = load_model("ngs")
    programme = pulses(model, Limits())
    folder = write_programme(programme, model, tmp_path / "pulses")
    table = np.genfromtxt(folder / TABLE, delimiter=",", names=True)
    assert table.dtype.names == ("time_s", *(f"thruster_{i}_V" for i in range(6)))
    np.testing.assert_allclose(table["thruster_3_V"], programme.throttles[:, 3], atol=1e-5)
    assert np.all(np.diff(table["time_s"]) > 0.0)
    np.testing.assert_allclose(read_run(folder)["thruster_3/throttle.commanded"].values, programme.throttles[:, 3])


def test_limits_that_no_pulse_keeps_are_refused_with_what_was_found() -> None:
    with pytest.raises(ValueError, match=r"expected a tilt below 0\.001 rad.*the smallest throttle"):
        pulses(load_model("ngs"), Limits(tilt=0.001))


def test_sweeps_move_one_axis_each_and_keep_the_limits() -> None:
    model = load_model("ngs")
    limits = Limits(throttle=2.5, tilt=0.4, depth=0.5, speed=0.5)
    found = sweeps(model, limits)
    assert [p.words for p in found][:3] == ["a sweep of surge", "a sweep of sway", "a sweep of heave"]
    for each in found:
        run = each.dry_run
        assert run.level <= 2.5 and run.tilt < 0.4 and run.depth < 0.5 and run.speed < 0.5
        assert np.abs(each.throttles).max() == pytest.approx(run.level, rel=1e-2)


@pytest.mark.parametrize(
    ("option", "given", "expected"),
    [
        ("--pulse", "-1", "0.2 to 30"),
        ("--pulse", "nan", "0.2 to 30"),
        ("--pulse", "0", "0.2 to 30"),
        ("--pulse", "long", "0.2 to 30"),
        ("--throttle", "-2", "0.001 to 100"),
        ("--tilt", "inf", "0.001 to 1.5"),
        ("--depth", "0", "0.001 to 100"),
        ("--speed", "-0.1", "0.001 to 10"),
    ],
)
def test_what_is_no_length_or_no_limit_is_refused(
    option: str, given: str, expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["--vehicle", "ngs", f"{option}={given}"])
    assert f"argument {option}: expected {expected}; found {given}" in capsys.readouterr().err


def test_a_throttle_within_the_dead_zone_moves_nothing_and_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--vehicle", "ngs", "--throttle", "0.3"]) == 1
    assert "largest throttle: expected 1.2 V or more, beyond the dead zones; found 0.3" in capsys.readouterr().err
