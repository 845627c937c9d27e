"""Sensors that are stated to be mounted turned, read as those along the body's axes are."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.filtering import filtered, prepared_with
from gap_diagnosis.vehicle.learning import first_noises
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.turns import attitudes_with, read_with
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from run_bag import Topic, write_run

ALONG = load_model("ngs")
IMU, VELOCITY = (0.0, 0.0, 1.571), (0.0, 0.0, np.pi / 4.0)
TURNED = replace(
    ALONG,
    sensors=replace(
        ALONG.sensors,
        imu=replace(ALONG.sensors.imu, rotation=IMU),
        velocity=replace(ALONG.sensors.velocity, rotation=VELOCITY),
    ),
)
R_IMU, R_VELOCITY = TURNED.mounted.mountings


def as_mounted(topic: Topic) -> Topic:
    """Return a topic of a sensor along the body's axes as it would be by those mountings."""
    fields, vectors = dict(topic.fields), {"rov/imu": ("angular_velocity", "linear_acceleration")}
    R = R_IMU if topic.name == "rov/imu" else R_VELOCITY
    for name in vectors.get(topic.name, ("twist.twist.linear",) if topic.name == "rov/velocity" else ()):
        told = np.column_stack([fields[f"{name}.{a}"] for a in "xyz"]) @ R
        fields |= {f"{name}.{a}": column for a, column in zip("xyz", told.T, strict=True)}
    if topic.name == "rov/imu":
        q = attitudes_with(np.column_stack([fields[f"orientation.{a}"] for a in "wxyz"]), R.T)
        fields |= {f"orientation.{a}": column for a, column in zip("wxyz", q.T, strict=True)}
    return replace(topic, fields=fields)


def test_a_mounting_is_the_turn_that_a_set_states() -> None:
    assert pytest.approx(Rotation.from_euler("z", 1.571).as_matrix()) == R_IMU
    assert pytest.approx(Rotation.from_euler("z", 45.0, degrees=True).as_matrix()) == R_VELOCITY


def test_what_is_not_told_of_an_axis_is_missed_where_it_is_part_of_another() -> None:
    y = np.array([1.0, np.nan, 2.0])
    np.testing.assert_allclose(read_with(y, R_IMU), [np.nan, 1.0, 2.0], atol=1e-3)
    np.testing.assert_array_equal(np.isnan(read_with(y, R_VELOCITY)), [True, True, False])


def test_turned_sensors_tell_a_filter_what_those_along_the_body_do(tmp_path: Path) -> None:
    draw = Draw(seed=17, vehicle="ngs", kinds=("steps",), duration=20.0)
    (topics,) = recorded(draw, ALONG.vehicle, ALONG.sets, ALONG.sensors)
    (along,), model = read_logs([write_run(tmp_path / "along", topics)], ALONG)
    (read,), turned = read_logs([write_run(tmp_path / "turned", [as_mounted(t) for t in topics])], TURNED)
    np.testing.assert_allclose(read.told, along.told, atol=1e-9)
    assert conventions_of(turned, [read]).turned == ()
    noises = first_noises(model, [along])
    expected, found = prepared_with(model, along, 0, noises, {}), prepared_with(turned, read, 0, noises, {})
    np.testing.assert_allclose(found.base.body, expected.base.body, atol=1e-6)
    # an effect acts in the sensor's own axes
    off = ActiveVehicleEffect(id="imu_bias", axis="x", sizes={"rate": 0.01})
    change = filtered(turned, found, {}, [off]).body - found.base.body
    np.testing.assert_allclose(change[0, 3:6], -0.01 * R_IMU[:, 0], atol=1e-9)
