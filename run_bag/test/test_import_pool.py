"""Arrays of ROS 1 topics become a run: throttles in volts, angles as a quaternion, nothing that was not measured."""

from pathlib import Path

import numpy as np
import pytest
from synthetic_bench import pool_arrays

from run_bag import read_run
from run_bag.importers.cli_pool import main

T0 = 1.4609e9


def arrays(**changes: object) -> dict[str, object]:
    """Return the synthetic recording with other arrays, or without those that are None."""
    return {k: v for k, v in {**pool_arrays(), **changes}.items() if v is not None}


def imported(tmp_path: Path, *options: str, **changes: object):  # type: ignore[no-untyped-def]
    np.savez(tmp_path / "dive.npz", **arrays(**changes))  # type: ignore[arg-type]
    assert main([str(tmp_path / "dive.npz"), "--out", str(tmp_path / "runs"), *options]) == 0
    return read_run(tmp_path / "runs/dive")


def test_after_the_last_command_the_thrusters_stop_unless_told_to_hold(tmp_path: Path) -> None:
    run = imported(tmp_path)
    assert run["thruster_4/throttle.commanded"].values.tolist() == [0.0, 0.0, 5.0, 0.0]
    assert run.time("thruster_4/throttle.commanded")[-1] - run.time("rov/depth.depth")[0] == pytest.approx(2.25)


def test_pulses_become_volts_and_before_the_first_all_is_at_its_stop(tmp_path: Path) -> None:
    run = imported(tmp_path, "--hold-last")
    assert run["thruster_2/throttle.commanded"].values.tolist() == [0.0, -3.5, 0.0]
    assert run["thruster_4/throttle.commanded"].values.tolist() == [0.0, 0.0, 5.0]
    assert run["thruster_5/throttle.commanded"].values.tolist() == [0.0, 0.0, -5.0]
    np.testing.assert_allclose(np.diff(run.time("thruster_2/throttle.commanded")), [1.0, 1.0], atol=1e-6)


def test_the_quaternion_turns_body_into_earth_axes_as_yaw_pitch_roll_do(tmp_path: Path) -> None:
    states = np.asarray(arrays()["sensor_fusion__states"]).astype(np.float64)
    states[:, :3] = (2.8, -0.4, 1.1)
    run = imported(tmp_path, sensor_fusion__states=states)
    w, x, y, z = (float(run[f"rov/odometry.pose.pose.orientation.{c}"].values[0]) for c in "wxyz")
    (c1, c2, c3), (s1, s2, s3) = np.cos([2.8, -0.4, 1.1]), np.sin([2.8, -0.4, 1.1])
    yaw = np.array([[c3, -s3, 0], [s3, c3, 0], [0, 0, 1]])
    pitch = np.array([[c2, 0, s2], [0, 1, 0], [-s2, 0, c2]])
    roll = np.array([[1, 0, 0], [0, c1, -s1], [0, s1, c1]])
    rotation = yaw @ pitch @ roll
    third_row = [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]
    assert third_row == pytest.approx(list(rotation[2]))
    assert 2 * (x * y + w * z) == pytest.approx(rotation[1, 0])


def test_what_was_not_measured_is_nan_and_what_is_left_out_is_said(tmp_path: Path) -> None:
    run = imported(tmp_path)
    assert "rov/odometry.twist.twist.linear.x" not in run
    assert run["rov/odometry.twist.twist.angular.z"].values[0] == pytest.approx(0.3)
    assert run["rov/depth.depth"].values[0] == pytest.approx(1.5)
    assert run["rov/imu.linear_acceleration.z"].values[0] == pytest.approx(-9.81)
    decisions = {d["what"]: d for d in run.metadata["import"]["decisions"]}
    assert decisions["recording after the last command"]["value"] == pytest.approx(1.0)
    assert "magnetometer" in decisions["left out"]["value"]


def test_a_recording_without_commands_is_one_without_thrust(tmp_path: Path) -> None:
    run = imported(tmp_path, rovio__thrusters=None, rovio__thrusters__t=None)
    assert all(run[f"thruster_{k}/throttle.commanded"].values.tolist() == [0.0] for k in range(6))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"sensor_fusion__states": None}, "expected the arrays sensor_fusion__states and sensor_fusion__states__t"),
        (
            {"rovio__thrusters": np.zeros((2, 5))},
            r"rovio__thrusters: expected shape (N, 6) beside N times; found (2, 5)",
        ),
        (
            {"rovio__imu__data__t": T0 - np.arange(3.0)},
            "rovio__imu__data__t: expected times from 0 to 9e+09 s that never",
        ),
        ({"rovio__imu__data": np.full((3, 7), np.nan)}, "rovio__imu__data: expected finite numbers; found 21 others"),
    ],
)
def test_what_is_no_recording_is_refused_with_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: dict[str, object], said: str
) -> None:
    np.savez(tmp_path / "dive.npz", **arrays(**changes))  # type: ignore[arg-type]
    assert main([str(tmp_path / "dive.npz"), "--out", str(tmp_path / "runs")]) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "runs/dive").exists()
