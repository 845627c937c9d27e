"""A vehicle's recording: channels by name, angles as quaternions, REP 103's axes in ours, what gravity forbids."""

import struct

import numpy as np
import pytest
from foreign_recordings import COUNT, message_format, stamps
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from run_bag import read_run
from run_bag.importers.cli_recording import main

TIME = 0.04 * np.arange(COUNT)
ANGLES = np.column_stack((0.2 * np.sin(TIME), 0.1 * np.cos(TIME), 3.0 + 0.5 * TIME))  # roll, pitch, yaw [rad]
BODY = Rotation.from_euler("ZYX", ANGLES[:, ::-1])  # body (FRD) to earth (NED)
FORCE = BODY.inv().apply([0.0, 0.0, -9.81])
RATES = np.column_stack((np.sin(3 * TIME), np.cos(2 * TIME), 0.5 + 0 * TIME))
PULSES = 1500 + np.round(100 * np.sin(TIME))
TO_NED, TO_FLU = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.diag([1, -1, -1])
"""The rotations between the axes of REP 103 and ours, each its own inverse."""


def write_table(path, columns):
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.9f")
    return path


def columns(**more):
    degrees = np.degrees(ANGLES)
    yaw = (degrees[:, 2] + 180.0) % 360.0 - 180.0
    return {
        "time_s": TIME, "pwm_1": PULSES, "pwm_2": 3000 - PULSES,
        **{f"gyro_{a}_dps": np.degrees(RATES[:, k]) for k, a in enumerate("xyz")},
        **{f"accel_{a}_g": FORCE[:, k] / 9.80665 for k, a in enumerate("xyz")},
        "roll": degrees[:, 0], "pitch": degrees[:, 1], "heading": yaw, "depth": 2.0 + 0 * TIME,
        "battery_V": 15.0 + 0 * TIME, "battery_current": 3.0 + 0 * TIME,
        "u": 0.1 + 0 * TIME, "v": 0.2 + 0 * TIME, "w": 0.3 + 0 * TIME, **more,
    }  # fmt: skip


def guessed(capsys, *files):
    assert main([*map(str, files), "--guess"]) == 0
    return capsys.readouterr().out


def imported(tmp_path, text, *files):
    (tmp_path / "map.yaml").write_text(text)
    assert main([*map(str, files), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    return read_run(tmp_path / "run")


def attitude(run, topic="rov/imu.orientation"):
    return Rotation.from_quat(np.column_stack([run[f"{topic}.{a}"].values for a in "xyzw"]))


def vectors(run, topic):
    return np.column_stack([run[f"{topic}.{a}"].values for a in "xyz"])


def test_a_vehicle_s_table_is_guessed_and_its_angles_become_a_quaternion(tmp_path, capsys):
    file = write_table(tmp_path / "dive.csv", columns())
    text = guessed(capsys, file)
    assert "Not recognised" not in text
    assert "\naxes" not in text  # gravity says that z points down
    assert "# axes: {rov/velocity: rep103}   # if x is forward, y port, z up in rov/velocity: nothing says so" in text
    run = imported(tmp_path, text, file)
    assert np.max((attitude(run) * BODY.inv()).magnitude()) < 1e-6
    np.testing.assert_allclose(vectors(run, "rov/imu.angular_velocity"), RATES, atol=1e-8)
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=1e-6)
    np.testing.assert_allclose(vectors(run, "rov/velocity.twist.twist.linear")[0], [0.1, 0.2, 0.3])
    np.testing.assert_allclose(run["thruster_1/throttle.commanded"].values, (1500 - PULSES) / 80.0)
    assert run["rov/battery.current"].values[0] == -3.0
    assert run["rov/depth.depth"].values[0] == 2.0
    assert capsys.readouterr().err == ""


def test_files_of_a_vehicle_s_sensors_are_guessed_as_one_vehicle(tmp_path, capsys):
    whole = columns()
    own = {"time_s", "depth", "battery_V", "u", "v", "w"}
    inner = write_table(tmp_path / "a.csv", {k: c for k, c in whole.items() if k == "time_s" or k not in own})
    outer = write_table(tmp_path / "b.csv", {k: c for k, c in whole.items() if k in own})
    text = guessed(capsys, inner, outer)
    assert "rov/depth.depth: {column: depth, unit: m}" in text
    assert "rov/velocity.twist.twist.linear.z: {column: w, unit: m/s}" in text
    assert "rov/battery.voltage: {column: battery_V, unit: V}" in text
    assert "file:" not in text, "names that one file alone has do for the files of the next dive as well"


def test_a_file_with_a_clock_of_its_own_is_proposed_with_it_and_one_map_imports_two_dives(tmp_path, capsys):
    whole = {k: c for k, c in columns().items() if k != "depth"}
    for dive in (1, 2):
        write_table(tmp_path / f"body_{dive}.csv", whole)
        write_table(tmp_path / f"depth_{dive}.csv", {"t_us": 1e6 * TIME, "depth": 2.0 + 0.1 * np.sin(TIME)})
    text = guessed(capsys, tmp_path / "body_1.csv", tmp_path / "depth_1.csv")
    assert "rov/depth.depth: {column: depth, unit: m, time_column: t_us, time_unit: us}" in text
    (tmp_path / "map.yaml").write_text(text.replace("unit: '?'", "unit: rad/s"))
    for dive in (1, 2):
        files = [str(tmp_path / f"{name}_{dive}.csv") for name in ("body", "depth")]
        assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / f"run_{dive}")]) == 0
        assert read_run(tmp_path / f"run_{dive}")["rov/depth.depth"].values.size == COUNT


def test_what_a_gyro_s_unit_may_be_is_asked_and_gravity_tells_an_accelerometer_s(tmp_path, capsys):
    units = {f"gyro_{a}": RATES[:, k] for k, a in enumerate("xyz")}
    units |= {f"acc_{a}": FORCE[:, k] for k, a in enumerate("xyz")}
    text = guessed(capsys, write_table(tmp_path / "a.csv", {"t": TIME, **units}))
    assert text.count("unit: '?'") == 3
    assert "write the unit: rad/s, rpm, rps or deg/s?" in text
    assert text.count("unit: m/s^2") == 3  # small along x and y, gravity along z


def test_an_attitude_in_parts_or_twice_is_not_proposed(tmp_path, capsys):
    parted = columns()
    del parted["heading"]
    text = guessed(capsys, write_table(tmp_path / "a.csv", parted))
    assert "orientation" not in text
    assert "# roll " in text
    x, y, z, w = BODY.as_quat().T
    twice = columns(q_w=w, q_x=x, q_y=y, q_z=z)
    text = guessed(capsys, write_table(tmp_path / "b.csv", twice))
    assert text.count("rov/imu.orientation.") == 4
    run = imported(tmp_path, text, tmp_path / "b.csv")
    assert np.max((attitude(run) * BODY.inv()).magnitude()) < 1e-6


def dive(imu, log, **more):
    """Return 40 s of a vehicle that pitches, surges and heaves; imu, log: 1 in our axes, -1 in REP 103's."""
    time, draw = 0.04 * np.arange(1000), np.random.default_rng(3)
    pitch, surge, heave = 0.3 * np.sin(0.9 * time), 0.5 * np.cos(0.5 * time), 0.2 * np.sin(0.7 * time)
    falling = -np.sin(pitch) * surge + np.cos(pitch) * heave
    noise = draw.normal(0.0, 0.01, (3, time.size))
    return {
        "t": time, "pwm_1": 1500.0 + 0 * time, "pwm_2": 1500.0 + 0 * time,
        "acc_x": 9.81 * np.sin(pitch), "acc_y": 0 * time, "acc_z": -imu * 9.81 * np.cos(pitch),
        "roll": 0 * time, "pitch": imu * np.degrees(pitch), "yaw": 0 * time,
        "depth": 3.0 + np.cumsum(0.04 * falling) + 0.3 * noise[0],
        "vel_x": surge + noise[1], "vel_y": 0 * time, "vel_z": log * (heave + noise[2]), **more,
    }  # fmt: skip


@pytest.mark.parametrize("imu", [1, -1])
@pytest.mark.parametrize("log", [1, -1])
def test_axes_of_a_velocity_log_are_told_by_the_change_of_depth_and_not_by_the_imu(tmp_path, capsys, imu, log):
    text = guessed(capsys, write_table(tmp_path / "a.csv", dive(imu, log)))
    turned = [f"{topic}: rep103" for topic, way in (("rov/imu", imu), ("rov/velocity", log)) if way < 0]
    found = [line.partition("   #")[0] for line in text.splitlines() if "axes" in line]
    assert found == ([f"axes: {{{', '.join(turned)}}}"] if turned else [])


def test_without_an_attitude_a_velocity_log_is_held_against_the_depth_as_if_level(tmp_path, capsys):
    level = {k: c for k, c in dive(1, -1).items() if k not in ("roll", "pitch", "yaw")}
    text = guessed(capsys, write_table(tmp_path / "a.csv", level))
    assert "\naxes: {rov/velocity: rep103}   # rov/velocity.z is positive while the depth shrinks" in text


def test_a_height_tells_the_axes_of_a_velocity_log_as_a_depth_does(tmp_path, capsys):
    above = dive(-1, -1)
    above["depth"] = -above["depth"]
    text = guessed(capsys, write_table(tmp_path / "a.csv", above))
    assert "rov/depth.depth: {column: depth, unit: m, sign: -1}" in text
    assert "\naxes: {rov/imu: rep103, rov/velocity: rep103}" in text


@pytest.mark.parametrize("depth", ["level", "none"])
def test_a_velocity_log_whose_axes_nothing_tells_stays_as_stated_with_a_question(tmp_path, capsys, depth):
    table = dive(-1, -1)
    shown = {"level": 3.0 + 0 * table["t"]}
    del table["depth"]
    text = guessed(capsys, write_table(tmp_path / "a.csv", table | ({"depth": shown[depth]} if depth in shown else {})))
    assert "\naxes: {rov/imu: rep103}   # at rest the IMU's z axis points up\n" in text
    assert "\n# axes: {rov/imu: rep103, rov/velocity: rep103}   # if x is forward" in text


@pytest.mark.parametrize(("unit", "gravity"), [("g", 1.0), ("m/s^2", 9.81), ("mg", 1000.0)])
def test_gravity_tells_the_unit_of_an_accelerometer_whose_name_does_not(tmp_path, capsys, unit, gravity):
    table = dive(1, 1)
    table |= {f"acc_{a}": table[f"acc_{a}"] * gravity / 9.81 for a in "xyz"}
    text = guessed(capsys, write_table(tmp_path / "a.csv", table))
    assert text.count(f"unit: {unit}}}") == 3
    assert f"unit by its values: |a| is {gravity:.4g} as a rule, as gravity at rest" in text


def test_gravity_tells_the_unit_of_an_accelerometer_in_a_long_table(tmp_path, capsys):
    rows = [f"{t},{name},{value}" for k, t in enumerate(TIME) for name, value in long_row(k)]
    (tmp_path / "a.csv").write_text("\n".join(["time,name,value", *rows]))
    assert guessed(capsys, tmp_path / "a.csv").count("|a| is 1 as a rule, as gravity at rest") == 3


def long_row(k):
    forces = zip("xyz", FORCE[k] / 9.81, strict=True)
    return [("gyro_x", RATES[k, 0]), *((f"acc_{a}", value) for a, value in forces), ("pwm_1", PULSES[k])]


def test_an_acceleration_without_gravity_is_asked_about(tmp_path, capsys):
    table = dive(1, 1)
    table |= {f"acc_{a}": np.sin((k + 1.0) * table["t"]) for k, a in enumerate("xyz")}
    text = guessed(capsys, write_table(tmp_path / "a.csv", table))
    assert text.count("write the unit: m/s^2 or g? no other sensor says which") == 3


def bag(path):
    """Write a bag in REP 103's axes, under names of others."""
    store = get_typestore(Stores.ROS2_JAZZY)
    types = store.types
    q = Rotation.from_matrix(TO_NED @ BODY.as_matrix() @ TO_FLU).as_quat()
    header = types["std_msgs/msg/Header"]
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    none = np.zeros(9)
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        imu = writer.add_connection("/mavros/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        dvl = writer.add_connection("/dvl/twist", "geometry_msgs/msg/TwistWithCovarianceStamped", typestore=store)
        for k, at in enumerate(stamps()):
            top = header(types["builtin_interfaces/msg/Time"](int(at // 10**9), int(at % 10**9)), "base_link")
            turned, pushed = TO_FLU @ RATES[k], TO_FLU @ FORCE[k]
            message = types[imu.msgtype](top, quaternion(*q[k]), none, vector(*turned), none, vector(*pushed), none)
            writer.write(imu, at, store.serialize_cdr(message, imu.msgtype))
            twist = types["geometry_msgs/msg/Twist"](vector(0.1, -0.2, -0.3), vector(0.0, 0.0, 0.0))
            message = types[dvl.msgtype](top, types["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)))
            writer.write(dvl, at, store.serialize_cdr(message, dvl.msgtype))
    return path


def test_a_bag_in_rep_103_s_axes_comes_out_in_ours(tmp_path, capsys):
    file = bag(tmp_path / "bag")
    text = guessed(capsys, file)
    assert "\naxes: {rov/imu: rep103}   # at rest the IMU's z axis points up" in text
    assert "\n# axes: {rov/imu: rep103, rov/velocity: rep103}   # if x is forward, y port, z up in rov/velocity" in text
    answered = text.replace("\naxes: {rov/imu: rep103}", "\n").replace("\n# axes", "\naxes")
    run = imported(tmp_path, answered, file)
    assert np.max((attitude(run) * BODY.inv()).magnitude()) < 1e-6
    np.testing.assert_allclose(vectors(run, "rov/imu.angular_velocity"), RATES, atol=1e-12)
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=1e-12)
    np.testing.assert_allclose(vectors(run, "rov/velocity.twist.twist.linear")[0], [0.1, 0.2, 0.3])


def test_without_the_axes_the_import_says_that_z_points_up(tmp_path, capsys):
    file = bag(tmp_path / "bag")
    text = "".join(line + "\n" for line in guessed(capsys, file).splitlines() if not line.startswith("axes"))
    imported(tmp_path, text, file)
    assert "rov/imu: its z axis points up: expected axes forward, starboard, down" in capsys.readouterr().err


def test_outputs_with_the_thruster_s_number_inside_and_specific_forces_are_a_vehicle_s(tmp_path, capsys):
    names = {f"servo{k}_out": 1500.0 + 200.0 * np.sin(TIME + k) for k in (1, 2)}
    forces = {"fx": 0.1 * np.sin(TIME), "fy": 0.2 * np.cos(TIME), "fz": np.full(TIME.size, -9.8)}
    text = guessed(capsys, write_table(tmp_path / "a.csv", {"t": TIME, **names, **forces, "volts": 15.0 + TIME}))
    for k in (1, 2):
        assert f"thruster_{k - 1}/throttle.commanded: {{column: servo{k}_out, unit: us" in text
    assert "rov/imu.linear_acceleration.z: {column: fz" in text and "rov/battery.voltage: {column: volts" in text


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
    run = imported(tmp_path, guessed(capsys, tmp_path / "x.BIN"), tmp_path / "x.BIN")
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
    text = guessed(capsys, tmp_path / "x.BIN")
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
    text = guessed(capsys, tmp_path / "x.BIN")
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
    text = guessed(capsys, tmp_path / "x.tlog")
    assert "wrench" not in text and "# SYS_STATUS.load 300 to 349 d%, 50 samples" in text, "the processor's load"
    run = imported(tmp_path, text, tmp_path / "x.tlog")
    np.testing.assert_allclose(vectors(run, "rov/imu.linear_acceleration"), FORCE, atol=5e-3)
    np.testing.assert_allclose(vectors(run, "rov/imu.angular_velocity"), RATES, atol=6e-4)
    np.testing.assert_allclose(run["rov/depth.depth"].values, 3.0, atol=1e-3)
    np.testing.assert_allclose(run["thruster_4/state.n"].values[0], 900.0 * np.pi / 30.0)
    assert not any(name.startswith("thruster_5/") for name in run), "nobody has a sixth thruster"


CLOCK = "time: {column: time_s}\n"
ROLL = "rov/imu.orientation.roll: {column: roll, unit: deg}\n"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (ROLL, "rov/imu.orientation: expected all of roll, pitch, yaw, or of w, x, y, z, found roll"),
        (ROLL + "rov/imu.orientation.w: {column: pitch, unit: '1'}", "or of w, x, y, z, found roll, w"),
        ("axes: rep103\n" + ROLL, "axes: expected {topic: rep103}, found 'rep103'"),
        ("axes: {rov/depth: enu}\nrov/depth.depth: {column: depth, unit: m}", "axes: rov/depth: expected rep103"),
        ("axes: {rov/imu: rep103}\nrov/depth.depth: {column: depth, unit: m}", "expected topics rov/... of this map"),
        ("rov/depth.roll: {column: depth, unit: m}", "has no numeric field 'roll'"),
        (
            "rov/depth: {column: depth, unit: m}",
            "rov/depth: expected a channel, rov/depth.<field>, or one of axes, csv,",
        ),
    ],
)
def test_an_attitude_in_parts_or_unknown_axes_are_refused(tmp_path, capsys, text, sentence):
    file = write_table(tmp_path / "dive.csv", columns())
    (tmp_path / "map.yaml").write_text(CLOCK + text)
    assert main([str(file), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    assert sentence in capsys.readouterr().err


def test_an_attitude_whose_angles_never_come_together_is_refused(tmp_path, capsys):
    apart = columns()
    for k, name in enumerate(("roll", "pitch", "heading")):
        apart[name] = np.where(np.arange(COUNT) % 3 == k, apart[name], np.nan)
    file = write_table(tmp_path / "dive.csv", apart)
    text = guessed(capsys, file)
    (tmp_path / "map.yaml").write_text(text)
    assert main([str(file), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    assert "rov/imu.orientation: expected all its parts measured at one time" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"roll": np.degrees(ANGLES[:, 0]) + 90.0}, "force disagree about where down is, by 90 degrees"),
        ({"depth": -2.0 + 0 * TIME}, "rov/depth.depth: -2 m as a rule: expected depths, positive down; say `sign: -1`"),
        ({f"accel_{a}_g": 0.1 * RATES[:, k] for k, a in enumerate("xyz")}, "is gravity taken away?"),
    ],
)
def test_what_gravity_and_water_do_not_allow_is_said_at_once(tmp_path, capsys, change, sentence):
    usual = write_table(tmp_path / "usual.csv", columns())
    text = guessed(capsys, usual)
    imported(tmp_path, text, write_table(tmp_path / "dive.csv", columns(**change)))
    assert sentence in capsys.readouterr().err


LOG = "rov/velocity.twist.twist.linear.x: {{column: u, unit: {}}}\nrov/depth.depth: {{column: depth, unit: {}}}"


@pytest.mark.parametrize(
    ("speed", "depth", "said"),
    [
        ("m/s", "m", []),
        ("cm/s", "m", ["rov/velocity.twist.twist.linear: up to 40 m/s: no vehicle's"]),
        ("m/s", "cm", ["rov/depth.depth: changes by up to "]),
    ],
)
def test_a_vehicle_faster_than_any_is_of_another_unit(tmp_path, capsys, speed, depth, said):
    """The noise of the depth alone changes it by 20 m/s between two readings."""
    time, draw = 0.01 * np.arange(3000), np.random.default_rng(5)
    log = 0.4 * np.cos(time) * (100.0 if speed == "cm/s" else 1.0)
    level = (6.0 + 0.4 * np.sin(time) + draw.normal(0.0, 0.05, time.size)) * (100.0 if depth == "cm" else 1.0)
    file = write_table(tmp_path / "dive.csv", {"t": time, "u": log, "depth": level})
    thruster = "thruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
    clock = "time: {column: t, unit: s}\n"
    imported(tmp_path, clock + thruster + LOG.format("m/s", "m"), file)
    warnings = [line for line in capsys.readouterr().err.splitlines() if "rov/" in line]
    assert len(warnings) == len(said) and all(sentence in line for sentence, line in zip(said, warnings, strict=True))
    (tmp_path / "right").mkdir()
    imported(tmp_path / "right", clock + thruster + LOG.format(speed, depth), file)
    assert "rov/" not in capsys.readouterr().err


def test_a_battery_that_is_charged_throughout_is_asked_about(tmp_path, capsys):
    text = "time: {column: t, unit: s}\nrov/battery.current: {column: amps, unit: A%s}"
    drawn = 3.0 + np.sin(TIME)
    drawn[0] = -0.1  # at rest, of a sensor with an offset
    file = write_table(tmp_path / "dive.csv", {"t": TIME, "amps": drawn})
    said = "rov/battery.current: positive throughout, "
    imported(tmp_path, text % "", file)
    assert said in capsys.readouterr().err
    (tmp_path / "right").mkdir()
    imported(tmp_path / "right", text % ", sign: -1", file)
    assert said not in capsys.readouterr().err


STATED = {
    "yaw": "rov/imu.angular_velocity.z",
    "speed": "rov/velocity.twist.twist.linear.x",
    "rpm": "thruster_0/state.n",
}


@pytest.mark.parametrize(
    ("header", "name", "keys", "said"),
    [
        ("yaw [deg/s]", "yaw", "unit: rad/s", "column 'yaw [deg/s]' is in deg/s, as the recording states"),
        ("yaw [deg/s]", "yaw", "unit: dps", ""),
        ("speed [cm/s]", "speed", "unit: mm/s, sign: -1", "is in cm/s, as the recording states; the map says mm/s"),
        ("rpm [rpm]", "rpm", "unit: rad/s", "is in rpm, as the recording states; the map says rad/s"),
        ("speed [mV]", "speed", "unit: m/s", ""),  # of another quantity: nobody has to write so little
        ("speed [cm/s]", "speed", "unit: m/s, scale: 0.01", ""),
        ("speed", "speed", "unit: mm/s", ""),
    ],
)  # fmt: skip
def test_a_unit_of_the_map_that_contradicts_the_header_s_is_remarked_on(tmp_path, capsys, header, name, keys, said):
    file = write_table(tmp_path / "dive.csv", {"t": TIME, header: np.sin(TIME)})
    imported(tmp_path, f"time: {{column: t, unit: s}}\n{STATED[name]}: {{column: {name}, {keys}}}", file)
    told = [line for line in capsys.readouterr().err.splitlines() if "as the recording states" in line]
    assert len(told) == bool(said) and all(said in line for line in told)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_battery_s_current_by_its_unit_alone_counts_as_drawn_whichever_way_it_is_written(tmp_path, capsys, way):
    own = {k: v for k, v in columns().items() if not k.startswith("battery")}
    table = write_table(tmp_path / "dive.csv", own | {"batt_V": 15.0 + 0 * TIME, "batt_A": way * 3.0 + 0 * TIME})
    run = imported(tmp_path, guessed(capsys, table), table)
    assert (run["rov/battery.voltage"].values[0], run["rov/battery.current"].values[0]) == (15.0, -3.0)


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
    text = guessed(capsys, tmp_path / "x.tlog")
    assert "twist.angular" not in text and "# 0 in all messages: " in text
    assert "rov/odometry.pose.pose.orientation.yaw" in text and "angular_velocity.x: {field: RAW_IMU.xgyro" in text
