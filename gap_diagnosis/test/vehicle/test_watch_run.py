"""The watch over recorded dives of the sealed cases' own world, from recordings to what is said."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle.baseline import baseline
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.cli_watch_run import main
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.watching import Watch
from run_bag import Topic, write_run

LOSS: Any = (("thrust_loss", {"thruster": 2}, {"share": 0.5}),)
WEAK = Draw(seed=33, vehicle="ngs", effects=LOSS, deviations=0.0, kinds=("steps",), duration=30.0)


@pytest.fixture(scope="module")
def dives(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return dives of a healthy vehicle, of the same one when it is sound still, and with a weak thruster 2."""
    model, folder = load_model("ngs"), tmp_path_factory.mktemp("dives")
    found = {}
    for name, seed, hidden in (("healthy", 31, ()), ("sound", 32, ()), ("weak", 33, LOSS)):
        draw = replace(WEAK, seed=seed, effects=hidden)
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


def spoiled(topics: Sequence[Topic], after: str, begin: float) -> list[Topic]:
    """Return topics whose depth tells the same, or none, from an instant [s] on."""
    out = []
    for topic in topics:
        if topic.name == "rov/depth":
            begun = np.asarray(topic.stamps) - topic.stamps[0] < 1e9 * begin
            depth = np.asarray(topic.fields["depth"])
            if after == "none":
                topic = replace(topic, stamps=topic.stamps[begun], fields={"depth": depth[begun]})
            else:
                topic = replace(topic, fields={"depth": np.where(begun, depth, depth[begun][-1])})
        out.append(topic)
    return out


@pytest.mark.parametrize("after", ["same", "none"])
def test_a_depth_sensor_that_tells_nothing_new_is_named_and_not_used(
    after: str, dives: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    draw = Draw(seed=32, vehicle="ngs", deviations=0.0, kinds=("steps",), duration=30.0)
    model = load_model("ngs")
    (topics,) = recorded(draw, model.vehicle, model.sets, model.sensors)
    dives = {**dives, "spoiled": write_run(tmp_path / "spoiled", spoiled(topics, after, 14.0))}
    (line, end) = said(dives, "spoiled", "healthy", capsys)
    assert "depth: nothing new for" in line and 18.5 < float(line.split(" s:")[0]) < 21.0
    assert end.startswith("30 s watched, 0 alarms")


@pytest.mark.parametrize("after", ["same", "none"])
def test_what_was_told_of_a_thruster_stays_when_a_sensor_tells_nothing_new(
    after: str, dives: dict[str, Path], tmp_path: Path
) -> None:
    model = load_model("ngs")
    healthy, model = read_logs([dives["healthy"]], model)
    watch = Watch(model, baseline(model, healthy))
    (topics,) = recorded(WEAK, model.vehicle, model.sets, model.sensors)
    (log,), _ = read_logs([write_run(tmp_path / "run", spoiled(topics, after, 20.0))], model)
    told = [[a.failure.thruster for a in watch.step(log.part(k, k + 25))] for k in range(0, log.count - 24, 25)]
    assert "depth" in watch.stuck and watch.time > 28.0
    first = next(k for k, alarms in enumerate(told) if alarms)
    assert first < 19 and all(2 in alarms for alarms in told[first:])


def test_what_lies_behind_the_last_reading_of_the_motion_is_said_not_to_be_watched(
    dives: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = load_model("ngs")
    (topics,) = recorded(replace(WEAK, seed=32, effects=()), model.vehicle, model.sets, model.sensors)
    silent = []
    for topic in topics:
        if topic.name in ("rov/imu", "rov/odometry"):
            told = np.asarray(topic.stamps) - topic.stamps[0] < 18e9
            fields = {name: np.asarray(values)[told] for name, values in topic.fields.items()}
            topic = replace(topic, stamps=np.asarray(topic.stamps)[told], fields=fields)
        silent.append(topic)
    dives = {**dives, "silent": write_run(tmp_path / "silent", silent)}
    note, end = said(dives, "silent", "healthy", capsys)
    assert note == "silent: throttles go on for 12 s after the last reading of rates: they are left out"
    assert end.startswith("18 s watched, 0 alarms")


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


def test_a_threshold_that_is_none_is_refused_before_anything_is_read(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", "--vehicle", "ngs", "--baseline", "healthy", "--threshold=-3"])
    assert "argument --threshold: expected 1 to 1e+06; found -3" in capsys.readouterr().err


def test_a_baseline_of_two_seconds_is_refused(
    dives: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = load_model("ngs")
    (topics,) = recorded(replace(WEAK, duration=2.0), model.vehicle, model.sets, model.sensors)
    short = write_run(tmp_path / "short", topics)
    assert main([str(dives["sound"]), "--vehicle", "ngs", "--baseline", str(short)]) == 1
    assert "baseline: recordings: expected one of 10 s or more; the longest has 1.9 s" in capsys.readouterr().err
