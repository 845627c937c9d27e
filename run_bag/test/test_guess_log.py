"""What is proposed for a vehicle's logs, those of an autopilot and of a ground station."""

import struct

import numpy as np
from foreign_recordings import COUNT, message_format, stamps
from map_import import imported, proposal
from turning_vehicle import ANGLES, BODY, FORCE, PULSES, RATES, attitude, vectors


def test_an_autopilot_s_attitude_depth_and_battery_are_guessed(tmp_path, capsys):
    data = message_format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    data += message_format(10, 3 + 8 + 4, "RCOU", "QHH", "TimeUS,C1,C2")
    data += message_format(11, 3 + 8 + 24, "IMU", "Qffffff", "TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ")
    data += message_format(12, 3 + 8 + 6, "ATT", "QccC", "TimeUS,Roll,Pitch,Yaw")
    data += message_format(13, 3 + 8 + 4, "CTUN", "Qf", "TimeUS,Alt")
    data += message_format(14, 3 + 8 + 8, "BAT", "Qff", "TimeUS,Volt,Curr")
    for k in range(COUNT):
        at = 5_000_000 + k * 40_000
        hundredths = np.round(np.degrees(ANGLES[k]) * 100).astype(int)
        data += b"\xa3\x95\x0a" + struct.pack("<QHH", at, int(PULSES[k]), 1500)
        data += b"\xa3\x95\x0b" + struct.pack("<Qffffff", at, *RATES[k], *FORCE[k])
        data += b"\xa3\x95\x0c" + struct.pack("<QhhH", at + 7000, *hundredths)
        data += b"\xa3\x95\x0d" + struct.pack("<Qf", at, -2.0)
        data += b"\xa3\x95\x0e" + struct.pack("<Qff", at, 15.5, 4.0)
    (tmp_path / "x.BIN").write_bytes(data)
    run = imported(tmp_path, proposal(capsys, tmp_path / "x.BIN"), tmp_path / "x.BIN")
    assert np.max((attitude(run, "rov/odometry.pose.pose.orientation") * BODY.inv()).magnitude()) < 2e-4
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=1e-5)
    assert (run["rov/depth.depth"].values[0], run["rov/battery.current"].values[0]) == (2.0, -4.0)


def test_sensors_of_one_message_are_told_apart_without_the_log_s_units_and_the_outer_barometer_is_the_depth(
    tmp_path, capsys
):
    data = message_format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    data += message_format(10, 3 + 8 + 8, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4")
    data += message_format(11, 3 + 8 + 1 + 8, "ESC", "QBff", "TimeUS,Instance,RPM,Volt")
    data += message_format(12, 3 + 8 + 1 + 8, "BARO", "QBff", "TimeUS,I,Alt,Press")
    data += message_format(13, 3 + 8 + 12, "PIDR", "Qfff", "TimeUS,P,I,D")
    for k in range(COUNT):
        at = 5_000_000 + k * 40_000
        data += b"\xa3\x95\x0a" + struct.pack("<QHHHH", at, 1500, int(PULSES[k]), 1500, 0)
        for i in (0, 1):
            data += b"\xa3\x95\x0b" + struct.pack("<QBff", at, i, 600.0 + 100 * i + k, 0.0)
            data += b"\xa3\x95\x0c" + struct.pack("<QBff", at, i, -3.0 * i, 101325.0 + 29420.0 * i)
        data += b"\xa3\x95\x0d" + struct.pack("<Qfff", at, 0.1, 0.2 * k, 0.3)
    (tmp_path / "x.BIN").write_bytes(data)
    text = proposal(capsys, tmp_path / "x.BIN")
    assert "# RCOU.C3 always 1500, 50 samples" in text and "supply_voltage" not in text and "PIDR.I" in text
    run = imported(tmp_path, text, tmp_path / "x.BIN")
    assert "sign_source" not in capsys.readouterr().err, "the proposal says that ESCs tell no direction"
    assert not run["thruster_1/state.sign_source"].values.any()
    commanded = [name for name in run if name.endswith("throttle.commanded")]
    assert commanded == ["thruster_0/throttle.commanded", "thruster_1/throttle.commanded"], "two more never move"
    assert run["thruster_1/state.n"].values.size == COUNT
    np.testing.assert_allclose(run["thruster_1/state.n"].values[0], 700.0 * np.pi / 30.0)
    np.testing.assert_allclose(run["rov/depth.depth"].values, 3.0)


def test_messages_of_older_logs_with_the_sensor_s_number_in_their_name_are_known(tmp_path, capsys):
    data = message_format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    names = ("ESC1", "ESC2", "BARO", "BAR2")
    for kind, name in enumerate(names, 10):
        data += message_format(kind, 3 + 8 + 4, name, "Qf", "TimeUS,RPM" if name.startswith("ESC") else "TimeUS,Alt")
    for k in range(COUNT):
        for kind, value in enumerate((600.0, 700.0, -0.1, -3.0), 10):
            data += b"\xa3\x95" + bytes([kind]) + struct.pack("<Qf", 5_000_000 + 40_000 * k, value + 0.01 * k)
    (tmp_path / "x.BIN").write_bytes(data)
    text = proposal(capsys, tmp_path / "x.BIN")
    assert "thruster_1/state.n: {field: ESC2.RPM, unit: rpm}" in text
    assert "rov/depth.depth: {field: BAR2.Alt, unit: m, sign: -1}" in text


def test_a_ground_station_s_inertial_sensors_depth_and_all_its_escs_are_guessed(tmp_path, capsys):
    from pymavlink.dialects.v20 import ardupilotmega as link

    sender, none, data = link.MAVLink(None, srcSystem=1, srcComponent=1), [0] * 4, b""
    for k, at in enumerate(stamps()):
        force, rates = np.round(FORCE[k] / 9.80665e-3).astype(int), np.round(1e3 * RATES[k]).astype(int)
        turning = [900 + k, 0, 0, 0]
        for message in (
            sender.servo_output_raw_encode(k, 0, *[int(PULSES[k])] * 5, 1500, 1500, 1500),
            sender.scaled_imu_encode(k, *map(int, force), *map(int, rates), 0, 0, 0),
            sender.scaled_pressure2_encode(k, 1013.25 + 98.0665 * 3.0, 0.0, 1700),
            sender.esc_telemetry_5_to_8_encode(none, none, none, none, turning, none),
            sender.sys_status_encode(0, 0, 0, 300 + k, 15000, 400, 90, 0, 0, 0, 0, 0, 0),
        ):
            data += (at // 1000).to_bytes(8, "big") + bytes(message.pack(sender))
    (tmp_path / "x.tlog").write_bytes(data)
    text = proposal(capsys, tmp_path / "x.tlog")
    assert "wrench" not in text and "# SYS_STATUS.load 300 to 349 d%, 50 samples" in text, "the processor's load"
    run = imported(tmp_path, text, tmp_path / "x.tlog")
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=5e-3)
    np.testing.assert_allclose(vectors(run, "rov/imu.angular_velocity"), RATES, atol=6e-4)
    np.testing.assert_allclose(run["rov/depth.depth"].values, 3.0, atol=1e-3)
    np.testing.assert_allclose(run["thruster_4/state.n"].values[0], 900.0 * np.pi / 30.0)
    assert not any(name.startswith("thruster_5/") for name in run), "nobody has a sixth thruster"


def test_a_vector_that_a_ground_station_s_log_has_as_0_throughout_is_left_out_as_a_whole(tmp_path, capsys):
    from pymavlink.dialects.v20 import ardupilotmega as link

    sender, data = link.MAVLink(None, srcSystem=1, srcComponent=1), b""
    for k, at in enumerate(stamps()):
        force = np.round(FORCE[k] / 9.80665e-3).astype(int)
        for message in (
            sender.servo_output_raw_encode(k, 0, *[int(PULSES[k])] * 8),
            sender.raw_imu_encode(k, *map(int, force), 0, int(900 * np.sin(k)), 0, 0, 0, 0),
            sender.attitude_encode(k, *map(float, ANGLES[k]), 0.0, 0.0, 0.0),
        ):
            data += (at // 1000).to_bytes(8, "big") + bytes(message.pack(sender))
    (tmp_path / "x.tlog").write_bytes(data)
    text = proposal(capsys, tmp_path / "x.tlog")
    assert "twist.angular" not in text and "# 0 in all messages: " in text
    assert "rov/odometry.pose.pose.orientation.yaw" in text and "angular_velocity.x: {field: RAW_IMU.xgyro" in text
