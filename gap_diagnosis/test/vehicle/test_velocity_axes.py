"""How a velocity log is mounted, told from recordings of the sealed world."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.mounting import MOUNTINGS, imu_mounted, velocity_mounted
from gap_diagnosis.vehicle.velocity_axes import velocity_between, velocity_mounting, velocity_size
from rov_sim.vehicle.innovations import LATE
from run_bag import write_run

MODEL = load_model("ngs")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> VehicleLog:
    draw = Draw(seed=17, vehicle="ngs", kinds=("steps",), duration=40.0)
    (topics,) = recorded(draw, MODEL.vehicle, MODEL.sets, MODEL.sensors)
    path: Path = write_run(tmp_path_factory.mktemp("velocity") / "run", topics)
    (read,), _ = read_logs([path], MODEL)
    return read


def later(log: VehicleLog, time: float) -> VehicleLog:
    """Return a log whose velocity is told so much later."""
    rows = round(time / log.period)
    told, lateness = log.told.copy(), log.lateness.copy()
    told[rows:, 10:], told[:rows, 10:] = log.told[:-rows, 10:], np.nan
    column = LATE.index("velocity")
    lateness[rows:, column] = log.lateness[:-rows, column]
    return replace(log, told=told, lateness=lateness)


@pytest.mark.parametrize("R", MOUNTINGS[1:])
def test_each_of_23_ways_to_turn_a_velocity_log_is_told(log: VehicleLog, R: NDArray[np.float64]) -> None:
    turned = velocity_mounted(log, R.T)
    found, gain = velocity_mounting([turned])
    np.testing.assert_array_equal(found, R)
    assert gain > 60.0


@pytest.mark.parametrize("time", [0.2, 0.4, 0.6])
def test_a_velocity_log_that_is_late_is_not_called_turned(log: VehicleLog, time: float) -> None:
    assert velocity_mounting([later(log, time)])[1] == 0.0


@pytest.mark.parametrize("R", MOUNTINGS)
def test_without_an_accelerometer_the_right_mounting_is_told_or_none(log: VehicleLog, R: NDArray[np.float64]) -> None:
    told = log.told.copy()
    told[:, 6:9] = np.nan
    found, gain = velocity_mounting([velocity_mounted(replace(log, told=told), R.T)])
    assert gain == 0.0 or np.array_equal(found, R)


def test_an_imu_and_a_velocity_log_that_are_both_turned_are_read_aright(log: VehicleLog) -> None:
    rep103 = np.diag([1.0, -1.0, -1.0])
    turn = next(R for R in MOUNTINGS if R[2, 2] == 1.0 and R[0, 1] != 0.0)
    both = velocity_mounted(imu_mounted(log, turn.T, attitude=False), rep103)
    found = conventions_of(MODEL, [both])
    np.testing.assert_array_equal(found.imu.R, turn)
    np.testing.assert_array_equal(found.velocity.R, rep103)
    assert found.verdict == "turned"
    assert "The velocity log is mounted turned: its x is forward, its -y starboard, its -z down." in found.sentences
    read = found.read(both)
    np.testing.assert_allclose(read.told, log.told)
    assert [each.effect for each in read.oddities] == ["imu_misalignment", "velocity_misalignment"]


def test_a_velocity_log_between_right_angles_is_said_to_be_turned_by_about_one(log: VehicleLog) -> None:
    between = Rotation.from_euler("z", 60.0, degrees=True).as_matrix()
    found = conventions_of(MODEL, [velocity_mounted(log, between.T)])
    assert found.velocity.turned
    told = " ".join(found.sentences)
    assert "The velocity log is mounted turned: its -y is forward" in told
    assert "Only right angles are tried, so axes are about these" in told and "`rotation` in the sensors' file" in told


def test_a_log_as_stated_is_read_as_it_is(log: VehicleLog) -> None:
    found = conventions_of(MODEL, [log])
    assert found.verdict != "turned" and found.read(log) is log


@pytest.mark.parametrize("turn", [[0.0, 0.0, 45.0], [0.0, 40.0, 0.0], [0.0, 0.0, -135.0]])
def test_a_velocity_log_far_from_all_right_angles_is_said_to_be_neither_as_stated_nor_at_one(
    log: VehicleLog, turn: list[float]
) -> None:
    askew = velocity_mounted(log, Rotation.from_euler("xyz", turn, degrees=True).as_matrix().T)
    found = conventions_of(MODEL, [askew])
    assert not found.velocity.turned and found.verdict == "turned" and found.read(askew) is askew
    assert np.degrees(found.between) == pytest.approx(45.0, abs=18.0)
    assert "velocity log's direction is neither as stated nor at a right angle" in " ".join(found.sentences)


@pytest.mark.parametrize("axis", [10, 11, 12])
def test_what_an_effect_or_a_wrong_sign_explains_is_no_turn_between_right_angles(log: VehicleLog, axis: int) -> None:
    told = log.told.copy()
    told[:, axis] *= -1.0
    assert velocity_between([replace(log, told=told)]) == 0.0
    askew = Rotation.from_rotvec(0.3 * np.eye(3)[axis - 10]).as_matrix()
    assert velocity_between([velocity_mounted(log, askew)]) == 0.0
    assert velocity_between([later(log, 0.3)]) == 0.0


@pytest.mark.parametrize("missing", [[], [6, 7, 8], [9]])
@pytest.mark.parametrize("factor", [1.0, 0.1, 3.28, 100.0])
def test_the_size_of_what_a_velocity_log_tells_is_told_by_depth_or_accelerometer(
    log: VehicleLog, factor: float, missing: list[int]
) -> None:
    told = log.told.copy()
    told[:, 10:] *= factor
    told[:, missing] = np.nan
    assert velocity_size([replace(log, told=told)]) == pytest.approx(factor, rel=0.2)
    told[:, 6:10] = np.nan
    assert velocity_size([replace(log, told=told)]) is None
