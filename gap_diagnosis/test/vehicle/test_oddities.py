"""What a vehicle's log shows before any physics: healthy recordings, spoiled as loggers and sensors spoil them."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import diagnosed, load_model
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.oddities import Oddity, cleaned, common_to
from run_bag import Topic, write_run

Array = NDArray[np.float64]
Spoil = Callable[[Topic, np.random.Generator], Topic]
DRAW = Draw(seed=12, vehicle="ngs", kinds=("steps",), duration=40.0)
MODEL = load_model(DRAW.vehicle)


@pytest.fixture(scope="module")
def healthy() -> list[Topic]:
    return recorded(DRAW, MODEL.vehicle, MODEL.sets, MODEL.sensors)[0]


def read(topics: Sequence[Topic], folder: Path) -> VehicleLog:
    return read_logs([write_run(folder / "run", list(topics))], MODEL)[0][0]


def spoiled(topics: Sequence[Topic], name: str, how: Spoil) -> list[Topic]:
    return [how(topic, np.random.default_rng(3)) if topic.name == name else topic for topic in topics]


def lost(topic: Topic, rng: np.random.Generator) -> Topic:
    kept = rng.random(len(topic.stamps)) >= 0.15
    kept[0] = True
    last = np.maximum.accumulate(np.where(kept, np.arange(kept.size), 0))
    return replace(topic, fields={name: np.asarray(values)[last] for name, values in topic.fields.items()})


def jittered(topic: Topic, rng: np.random.Generator) -> Topic:
    stamps = np.asarray(topic.stamps) + 1e9 * 0.008 * rng.standard_normal(len(topic.stamps))
    return replace(topic, stamps=np.sort(stamps.astype(np.int64)))


def blind(topic: Topic, rng: np.random.Generator, below: float = 25.0) -> Topic:
    n = np.asarray(topic.fields["n"])
    return replace(topic, fields={**topic.fields, "n": np.where(np.abs(n) < below, 0.0, n)})


def coarse(topic: Topic, rng: np.random.Generator) -> Topic:
    return replace(topic, fields={**topic.fields, "n": 6.0 * np.round(np.asarray(topic.fields["n"]) / 6.0)})


def stopped(topic: Topic, rng: np.random.Generator) -> Topic:
    whole = 2.0 * np.pi / 60.0  # rpm
    noise = 0.3 * rng.standard_normal(len(topic.stamps))
    return replace(topic, fields={**topic.fields, "n": whole * np.round(noise / whole)})


CASES = [
    ("rov/imu", lost, "dropped_samples", "imu", None, 0.15, 0.02),
    ("rov/imu", jittered, "timestamp_jitter", "imu", None, 0.008, 0.002),
    ("thruster_1/state", blind, "tach_dropout", "tachometer", 1, 25.0, 1.0),
    ("thruster_2/state", coarse, "tach_quantization", "tachometer", 2, 6.0, 0.01),
]


@pytest.mark.parametrize(("topic", "how", "effect", "sensor", "thruster", "size", "within"), CASES)
def test_what_spoils_a_log_is_named_with_its_size(
    topic: str, how: Spoil, effect: str, sensor: str, thruster: int | None, size: float, within: float,
    healthy: list[Topic], tmp_path: Path,
) -> None:  # fmt: skip
    found = common_to([read(spoiled(healthy, topic, how), tmp_path).oddities])
    assert [(each.effect, each.sensor, each.thruster) for each in found] == [(effect, sensor, thruster)]
    assert abs(found[0].size - size) < within and found[0].probability > 0.99


def test_a_healthy_log_shows_nothing(healthy: list[Topic], tmp_path: Path) -> None:
    assert read(healthy, tmp_path).oddities == ()


def test_lost_samples_are_not_measured(healthy: list[Topic], tmp_path: Path) -> None:
    there = np.isfinite(read(healthy, tmp_path / "whole").told[:, 10]).sum()
    seen = np.isfinite(read(spoiled(healthy, "rov/velocity", lost), tmp_path / "lost").told[:, 10]).sum()
    assert 0.75 * there < seen < 0.95 * there


def test_what_a_slower_sensor_repeats_on_purpose_is_no_loss() -> None:
    time = np.arange(0.0, 40.0, 0.02)
    values = np.random.default_rng(5).normal(size=(time.size, 3))
    twice = values[np.floor(np.arange(time.size) * 0.8).astype(int)]  # 40 Hz in messages of 50 Hz
    kept, _, found = cleaned(time, twice, "imu")
    assert found == [] and kept.size == pytest.approx(0.8 * time.size, abs=2)


def test_readings_at_scattered_instants_are_left_where_they_were_taken() -> None:
    rng = np.random.default_rng(6)
    time = np.sort(np.arange(0.0, 40.0, 0.02) + 0.006 * rng.standard_normal(2000))
    values = np.sin(3.0 * time)[:, None] + 0.001 * rng.normal(size=(time.size, 1))
    kept, _, found = cleaned(time, values, "depth")
    assert found == [] and np.array_equal(kept, time)


@pytest.mark.parametrize(("scatter", "told"), [(0.001, False), (0.006, True)])
def test_stamps_that_scatter_are_put_right_and_told_of_beyond_a_drivers(scatter: float, told: bool) -> None:
    rng = np.random.default_rng(7)
    taken = np.arange(0.0, 40.0, 0.02)
    values = np.sin(3.0 * taken)[:, None] + 0.001 * rng.normal(size=(taken.size, 1))
    given = np.sort(taken + scatter * rng.standard_normal(taken.size))
    kept, _, found = cleaned(given, values, "imu")
    assert [each.effect for each in found] == ["timestamp_jitter"] * told
    assert np.std(np.diff(kept)) < 0.2 * np.std(np.diff(given))


def test_a_thruster_that_has_stopped_has_no_coarse_tachometer(healthy: list[Topic], tmp_path: Path) -> None:
    assert read(spoiled(healthy, "thruster_2/state", stopped), tmp_path).oddities == ()


def test_what_one_of_three_recordings_shows_is_not_said_of_all() -> None:
    one = Oddity("dropped_samples", "imu", None, 0.1, 0.01, 40.0)
    assert common_to([[one], [], []]) == () and len(common_to([[one], [one], []])) == 1


def test_a_diagnosis_names_what_the_log_shows_and_no_physics_beside_it(healthy: list[Topic], tmp_path: Path) -> None:
    log = read(spoiled(healthy, "thruster_2/state", partial(blind, below=10.0)), tmp_path)
    few = ("thrust_loss", "dead_zone_shift", "tach_scale")
    found = diagnosed(MODEL, [log], {"runs": ["sealed"]}, only=lambda h: h.effect in few, how_far=False).content
    assert found["verdict"] == "effect"
    assert [(each["id"], each["thruster"]) for each in found["effects"]] == [("tach_dropout", 2)]
    assert "blind at low speed of thruster 2" in found["summary"]


def test_a_turned_imu_is_read_aright_and_is_all_that_is_named(healthy: list[Topic], tmp_path: Path) -> None:
    log = read(healthy, tmp_path)
    told = log.told.copy()
    told[:, 3:6], told[:, 6:9] = told[:, [4, 3, 5]] * [1, -1, 1], told[:, [7, 6, 8]] * [1, -1, 1]
    turned = replace(log, told=told)
    few = ("thruster_swap", "thruster_polarity", "thrust_loss")
    found = diagnosed(MODEL, [turned], {"runs": ["sealed"]}, only=lambda h: h.effect in few, how_far=False).content
    assert [(each["id"], each["sensor"]) for each in found["effects"]] == [("imu_misalignment", "imu")]
    assert (found["wiring"]["verdict"], found["wiring"]["imu_axes"]) == ("turned", ["-y", "x", "z"])
    assert found["summary"].startswith("The IMU is mounted turned: its -y is forward")


def test_a_turned_velocity_log_is_read_aright_and_is_all_that_is_named(healthy: list[Topic], tmp_path: Path) -> None:
    log = read(healthy, tmp_path)
    told = log.told.copy()
    told[:, 11:] *= -1.0
    few = ("velocity_scale", "thrust_loss")
    turned = replace(log, told=told)
    found = diagnosed(MODEL, [turned], {"runs": ["sealed"]}, only=lambda h: h.effect in few, how_far=False).content
    assert [(each["id"], each["sensor"]) for each in found["effects"]] == [("velocity_misalignment", "velocity")]
    assert (found["wiring"]["verdict"], found["wiring"]["velocity_axes"]) == ("turned", ["x", "-y", "-z"])
    assert found["summary"].startswith("The velocity log is mounted turned: its x is forward, its -y starboard")


def test_a_diagnosis_of_a_recording_with_fewer_throttles_asks_in_its_summary(
    healthy: list[Topic], tmp_path: Path
) -> None:
    log = read([topic for topic in healthy if topic.name != "thruster_4/throttle"], tmp_path)
    found = diagnosed(MODEL, [log], {"runs": ["sealed"]}, only=lambda h: False, how_far=False).content
    asked = "No throttle of thruster 4 in run: it counts as at rest. Is this the set's vehicle, of 6 thrusters?"
    assert found["summary"].endswith(asked)
