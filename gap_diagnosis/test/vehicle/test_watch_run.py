"""The watch over recorded dives of the sealed cases' own world, from recordings to what is said."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.cli_watch_run import main
from gap_diagnosis.vehicle.diagnosis_io import load_model
from run_bag import write_run

LOSS: Any = (("thrust_loss", {"thruster": 2}, {"share": 0.5}),)


@pytest.fixture(scope="module")
def dives(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return dives of a healthy vehicle, of the same one when it is sound still, and with a weak thruster 2."""
    model, folder = load_model("ngs"), tmp_path_factory.mktemp("dives")
    found = {}
    for name, seed, hidden in (("healthy", 31, ()), ("sound", 32, ()), ("weak", 33, LOSS)):
        draw = Draw(seed=seed, vehicle="ngs", effects=hidden, deviations=0.0, kinds=("steps",), duration=30.0)
        (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
        found[name] = write_run(folder / name, topics)
    return found


def said(dives: dict[str, Path], run: str, baseline: str, capsys: pytest.CaptureFixture[str]) -> list[str]:
    assert main([str(dives[run]), "--vehicle", "ngs", "--baseline", str(dives[baseline])]) == 0
    return capsys.readouterr().out.splitlines()


def test_a_thruster_that_has_lost_half_its_thrust_is_said_to_have(
    dives: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    alarm, end = said(dives, "weak", "healthy", capsys)
    assert "thruster 2: loses" in alarm and float(alarm.split(" s:")[0]) < 15.0
    assert end.startswith("30 s watched, 1 alarms")


def test_a_sound_vehicle_is_silent(dives: dict[str, Path], capsys: pytest.CaptureFixture[str]) -> None:
    (end,) = said(dives, "sound", "healthy", capsys)
    assert end.startswith("30 s watched, 0 alarms")


@pytest.mark.parametrize("after", ["same", "none"])
def test_a_depth_sensor_that_tells_nothing_new_is_named_and_not_used(
    after: str, dives: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    draw = Draw(seed=32, vehicle="ngs", deviations=0.0, kinds=("steps",), duration=30.0)
    model = load_model("ngs")
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    spoiled = []
    for topic in topics:
        if topic.name == "rov/depth":
            begun = np.asarray(topic.stamps) - topic.stamps[0] < 14e9
            depth = np.asarray(topic.fields["depth"])
            if after == "none":
                topic = replace(topic, stamps=topic.stamps[begun], fields={"depth": depth[begun]})
            else:
                topic = replace(topic, fields={"depth": np.where(begun, depth, depth[begun][-1])})
        spoiled.append(topic)
    dives = {**dives, "spoiled": write_run(tmp_path / "spoiled", spoiled)}
    (line, end) = said(dives, "spoiled", "healthy", capsys)
    assert "depth: nothing new for" in line and 18.5 < float(line.split(" s:")[0]) < 21.0
    assert end.startswith("30 s watched, 0 alarms")


def test_a_baseline_of_a_vehicle_that_was_not_healthy_is_doubted(
    dives: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    doubt, *_ = said(dives, "weak", "weak", capsys)
    assert doubt.startswith("Baseline: Farther from what was stated") and "of thruster 2 by -" in doubt
    assert "Was the vehicle healthy?" in doubt


def test_a_run_that_is_not_there_is_refused_in_a_sentence(
    dives: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(tmp_path / "none"), "--vehicle", "ngs", "--baseline", str(dives["healthy"])]) == 1
    assert "none" in capsys.readouterr().err
