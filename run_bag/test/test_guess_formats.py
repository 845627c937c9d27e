"""What is proposed for a vehicle's tables that other programs make: of a PX4's topics, MAVLink's messages, ROS'."""

import numpy as np
import pytest
from foreign_recordings import stamps
from map_import import imported, proposed, wide
from turning_vehicle import ANGLES, BODY, FORCE, RATES, TIME, attitude, vectors

X, Y, Z, W = BODY.as_quat().T
ONE = 0.4 * np.sin(4.0 * TIME)
PULSES = 1500 + np.round(400 * ONE)


def named(head, values, tail="xyz"):
    return {head.format(part): values[:, k] for k, part in enumerate(tail)}


def stamped(tmp_path, name, columns, *, time="timestamp", scale=1e6):
    return wide(tmp_path / f"{name}.csv", {time: scale * TIME + 1e6, **columns})


def px4(tmp_path):
    """Write what ulog2csv writes of a vehicle's PX4."""
    quaternion = dict(zip(("q[0]", "q[1]", "q[2]", "q[3]"), (W, X, Y, Z), strict=True))
    imu = named("gyro_rad[{}]", RATES, "012") | named("accelerometer_m_s2[{}]", FORCE, "012")
    return [
        stamped(tmp_path, "log_actuator_motors_0", {f"control[{k}]": (-1) ** k * ONE for k in range(3)}),
        stamped(tmp_path, "log_sensor_combined_0", imu),
        stamped(tmp_path, "log_vehicle_attitude_0", quaternion),
        stamped(tmp_path, "log_sensor_baro_1", {"pressure": 131000.0 + 0 * TIME}),
    ]


def test_a_vehicle_s_px4_is_known_by_the_topics_in_its_files_names(tmp_path, capsys):
    files = px4(tmp_path)
    found, text = proposed(capsys, *files)
    assert "Not recognised" not in text and "'?'" not in text and "wrench" not in text
    assert "actuator_controls" not in text, "the file says that they are the motors'"
    assert "before PX4 1.14: then unit: m, scale: 0.010197" in found["rov/depth.depth"]
    run = imported(tmp_path, text, *files)
    assert np.max((attitude(run, "rov/odometry.pose.pose.orientation") * BODY.inv()).magnitude()) < 1e-6
    np.testing.assert_allclose(vectors(run, "rov/imu.angular_velocity"), RATES, atol=1e-8)
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=1e-6)


def test_four_elements_whose_squares_add_up_to_1_are_no_torques(tmp_path, capsys):
    unit = dict(zip(("q[0]", "q[1]", "q[2]", "q[3]"), (W, X, Y, Z), strict=True))
    found, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **unit}))
    assert "torque" not in text and "# 'q[0]' " in text
    found, _ = proposed(capsys, wide(tmp_path / "y.csv", {"t": TIME, **{name: 3 * q for name, q in unit.items()}}))
    assert "thruster_0/load.wrench.torque.x" in found


def test_a_table_for_each_message_of_mavlink_is_known_as_the_log_is(tmp_path, capsys):
    force, rates = np.round(FORCE / 9.80665e-3), np.round(1e3 * RATES)
    messages = {
        "SERVO_OUTPUT_RAW": {f"servo{k}_raw": 1500 + (-1) ** k * np.round(400 * ONE) for k in (1, 2)},
        "SCALED_IMU2": named("{}acc", force) | named("{}gyro", rates),
        "ATTITUDE": named("{}", ANGLES, ("roll", "pitch", "yaw")),
        "SCALED_PRESSURE2": {"press_abs": 1013.25 + 98.0665 * 3.0 + 0 * TIME},
        "BATTERY_STATUS": {"voltages[0]": 15800.0 - TIME, "current_battery": 300.0 + TIME},
        "ESC_TELEMETRY": {f"rpm[{k}]": 900.0 + 100 * np.abs(np.sin(TIME)) for k in (0, 1)},
    }
    files = [
        stamped(tmp_path, name, columns, time="time_boot_ms", scale=1e3) for name, columns in messages.items()
    ]  # fmt: skip
    found, text = proposed(capsys, *files)
    assert "Not recognised" not in text and "'?'" not in text
    assert found["rov/odometry.pose.pose.orientation.roll"].startswith("{column: roll, unit: rad}"), "the vehicle's"
    assert found["thruster_0/state.sign_source"].startswith("{value: 0}")
    run = imported(tmp_path, text, *files)
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=5e-3)
    np.testing.assert_allclose(vectors(run, "rov/imu.angular_velocity"), RATES, atol=6e-4)
    np.testing.assert_allclose(run["rov/depth.depth"].values, 3.0, atol=1e-3)
    np.testing.assert_allclose(run["rov/battery.voltage"].values[0], 15.8, atol=1e-3)
    np.testing.assert_allclose(run["rov/battery.current"].values[0], -3.0, atol=1e-3)


def test_a_battery_of_a_ground_station_s_log_is_known_and_cells_that_it_has_not_are_counted_alone(tmp_path, capsys):
    from pymavlink.dialects.v20 import ardupilotmega as link

    sender, data = link.MAVLink(None, srcSystem=1, srcComponent=1), b""
    for k, at in enumerate(stamps()):
        for message in (
            sender.servo_output_raw_encode(k, 0, int(PULSES[k]), 3000 - int(PULSES[k]), *[1500] * 6),
            sender.battery_status_encode(0, 0, 0, 32767, [15800 - k, *[65535] * 9], 300 + k, -1, -1, -1),
        ):
            data += (at // 1000).to_bytes(8, "big") + bytes(message.pack(sender))
    (tmp_path / "x.tlog").write_bytes(data)
    log = wide(tmp_path / "dvl.csv", {"unix_s": 1e9 + TIME, "v_fwd": ONE, "v_stb": -ONE, "v_down": 0.5 * ONE})
    found, text = proposed(capsys, tmp_path / "x.tlog", log)
    assert found["rov/battery.voltage"].startswith("{field: 'BATTERY_STATUS.voltages[0]', unit: mV}")
    assert found["rov/battery.current"].startswith("{field: BATTERY_STATUS.current_battery, unit: cA, sign: -1}")
    assert "voltages[1]" not in text and "# A mark that nothing is known in all messages: 13 fields more" in text
    assert "{column: v_stb, unit: m/s}" in found["rov/velocity.twist.twist.linear.y"], "a log is a vehicle's"


def test_tables_of_rostopic_are_known_by_ros_names_at_the_times_of_the_messages(tmp_path, capsys):
    at, sent = 1.7e18 + 1e9 * TIME, 1.7e18 + 1e9 * TIME + 3e6
    turned = np.diag([1.0, -1.0, -1.0])
    q = dict(zip("wxyz", (W, X, Y, Z), strict=True))
    head = {"%time": sent, "field.header.seq": np.arange(TIME.size), "field.header.stamp": at}
    imu = {f"field.orientation.{part}": q[part] for part in "xyzw"}
    imu |= named("field.angular_velocity.{}", RATES @ turned) | named("field.linear_acceleration.{}", FORCE @ turned)
    files = [
        exact(tmp_path / "imu_data.csv", head | imu),
        exact(tmp_path / "pressure.csv", head | {"field.fluid_pressure": 131000.0 + 0 * TIME}),
        exact(tmp_path / "thruster_cmd.csv", {"%time": sent, "field.data0": ONE, "field.data1": -ONE}),
    ]
    found, text = proposed(capsys, *files)
    assert found["time"].startswith("{column: field.header.stamp, unit: ns}")
    assert "time_column: '%time', time_unit: ns}" in found["thruster_1/throttle.commanded"]
    assert "{column: field.data1, unit: '1'" in found["thruster_1/throttle.commanded"]
    for channel in ("orientation.w", "angular_velocity.z", "linear_acceleration.x"):
        assert f"{{column: field.{channel}, unit: " in found[f"rov/imu.{channel}"]
    assert "{column: field.fluid_pressure, unit: m, scale: 0.00010197" in found["rov/depth.depth"]
    _, text = proposed(capsys, exact(tmp_path / "o.csv", head | dict.fromkeys(list(head)[1:], 0.0 * TIME)))
    assert "column: '%time'" in text, "a stamp that nobody sets is no time"


def exact(path, columns):
    """Write a csv of whole ns and rounded readings."""
    rows = zip(*columns.values(), strict=True)
    text = "\n".join(",".join(f"{v:.0f}" if abs(v) > 1e9 else f"{v:.9g}" for v in row) for row in rows)
    path.write_text(",".join(columns) + "\n" + text + "\n")
    return path


@pytest.mark.parametrize("name", ["wanted.angular_velocity.x", "field.setpoint.linear_acceleration.x"])
def test_what_is_wanted_of_a_vehicle_is_not_measured(tmp_path, capsys, name):
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, "pwm_1": PULSES, "pwm_2": PULSES, name: ONE}))
    assert not any(channel.startswith("rov/imu") for channel in found)
