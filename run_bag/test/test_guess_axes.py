"""Which axes are proposed for an IMU whose z points up, and for a velocity log whose names tell them."""

import numpy as np
import pytest
from map_import import imported, proposed, wide
from scipy.spatial.transform import Rotation

TIME = 0.05 * np.arange(1200)
ANGLES = np.column_stack((0.2 * np.sin(0.6 * TIME), 0.3 * np.sin(0.9 * TIME), 0.4 * TIME))
BODY = Rotation.from_euler("ZYX", ANGLES[:, ::-1])  # body (FRD) to earth (NED)
FORCE = BODY.inv().apply([0.0, 0.0, -9.81])
TO_FLU, TO_NED = np.diag([1.0, -1.0, -1.0]), np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
ANGLE = ("roll", "pitch", "yaw")


def table(path, force, attitude, heads):
    pulses = 1500 + np.round(200 * np.sin(TIME))
    columns = {"t": TIME, "pwm_1": pulses, "pwm_2": 3000 - pulses}
    columns |= {f"acc_{a}": force[:, k] for k, a in enumerate("xyz")}
    if attitude is not None:
        columns |= dict(zip(heads, attitude.as_euler("ZYX", degrees=True)[:, ::-1].T, strict=True))
    return wide(path, columns)


def in_rep_103():
    return FORCE @ TO_FLU, Rotation.from_matrix(TO_NED @ BODY.as_matrix() @ TO_FLU)


def mounted(rotation):
    """Return the specific force of a sensor in our axes that is mounted turned, and its attitude."""
    turn = Rotation.from_euler("ZYX", rotation[::-1], degrees=True)
    return turn.inv().apply(FORCE), BODY * turn


def test_an_imu_in_rep_103_s_axes_is_told_by_an_attitude_beside_it(tmp_path, capsys):
    force, attitude = in_rep_103()
    _, text = proposed(capsys, table(tmp_path / "x.csv", force, attitude, ANGLE))
    assert "\naxes: {rov/imu: rep103}   # at rest the IMU's z axis points up\n" in text


@pytest.mark.parametrize("rotation", [(180, 0, 0), (180, 0, 90), (180, 0, 180), (180, 0, -30)])
def test_an_imu_that_is_mounted_upside_down_beside_the_vehicle_s_attitude_is_asked_about(tmp_path, capsys, rotation):
    force, _ = mounted(rotation)
    _, text = proposed(capsys, table(tmp_path / "x.csv", force, BODY, ANGLE))
    assert "\naxes" not in text and "\n# axes: {rov/imu: rep103}   # at rest the IMU's z axis points up: is " in text
    assert "or is it mounted upside down? the sensors' file then states `rotation`" in text


def test_an_imu_upside_down_whose_attitude_is_its_own_is_in_our_axes(tmp_path, capsys):
    force, attitude = mounted((180, 0, 90))
    _, text = proposed(capsys, table(tmp_path / "x.csv", force, attitude, ANGLE))
    assert "axes:" not in text


def test_an_imu_whose_z_points_up_without_an_attitude_is_asked_about_and_the_import_says_both(tmp_path, capsys):
    file = table(tmp_path / "x.csv", FORCE @ TO_FLU, None, ANGLE)
    _, text = proposed(capsys, file)
    assert "\naxes" not in text and "# axes: {rov/imu: rep103}   # at rest the IMU's z axis points up: is y" in text
    imported(tmp_path, text, file)
    told = capsys.readouterr().err
    assert "say `axes: {rov/imu: rep103}`" in told and "mounted upside down the sensors' file states" in told


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (("dvl.fwd", "dvl.left", "dvl.up"), "\naxes: {rov/velocity: rep103}   # rov/velocity: as its names say"),
        (("v_fwd", "v_port", "v_z"), "\naxes: {rov/velocity: rep103}   # rov/velocity: as its names say"),
        (("v_fwd", "v_stb", "v_up"), "\n# axes: {rov/velocity: rep103}   # if x is forward, y port, z up"),
        (("v_x", "v_y", "v_down"), ""),
    ],
)
def test_the_names_of_a_velocity_log_s_axes_tell_them_where_they_agree(tmp_path, capsys, names, told):
    columns = {name: 0.3 * np.sin(TIME + k) for k, name in enumerate(names)}
    pulses = 1500 + np.round(200 * np.sin(TIME))
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, "pwm_1": pulses, "pwm_2": pulses, **columns}))
    for axis, name in zip("xyz", names, strict=True):
        assert f"{{column: {name}, unit: m/s}}" in found[f"rov/velocity.twist.twist.linear.{axis}"]
    assert told in text if told else "axes:" not in text


def test_an_attitude_that_is_told_at_other_rows_than_the_gyro_is_asked_about(tmp_path, capsys):
    columns = {"t": TIME, **{f"gyro_{a}_dps": np.sin(TIME + k) for k, a in enumerate("xyz")}}
    angles = {name: np.where(np.arange(TIME.size) % 2, np.nan, 10 * np.sin(TIME + k)) for k, name in enumerate(ANGLE)}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", columns | angles))
    assert "of this IMU? the vehicle's own" in found["rov/imu.orientation.roll"]


def test_counts_of_converters_are_commands_of_a_vehicle_and_the_question_names_all_that_is_required(tmp_path, capsys):
    counts = {f"dac{k}": 2048 + np.round(1300 * np.sin(TIME + k)) for k in (1, 2)}
    angles = {name: 10 * np.sin(TIME + k) for k, name in enumerate(("hdg", "pitch", "roll"))}
    gravity = {f"Beschl_{a} [g]": FORCE[:, k] / 9.81 for k, a in enumerate("xyz")}
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **counts, **angles, **gravity}))
    assert "Not recognised" not in text and "{column: hdg, unit: " in found["rov/imu.orientation.yaw"]
    assert "{column: 'Beschl_z [g]', unit: g}" in found["rov/imu.linear_acceleration.z"]
    asked = "unit: counts or mV? nothing says which; with all but volts write stop and per_volt, too"
    assert all(asked in found[f"thruster_{k}/throttle.commanded"] for k in (0, 1))


@pytest.mark.parametrize(("command", "there"), [(np.sin(TIME), True), (np.abs(np.sin(TIME)), False)])
def test_a_speed_without_a_sign_beside_commands_both_ways_is_proposed_as_a_magnitude(tmp_path, capsys, command, there):
    columns = {f"pwm_{k}": np.round(1500 + 300 * command) for k in (1, 2)}
    columns |= {f"rpm_{k}": np.round(1000 * np.abs(command)) for k in (1, 2)}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns}))
    assert [f"thruster_{k}/state.sign_source" in found for k in (0, 1)] == [there, there]
