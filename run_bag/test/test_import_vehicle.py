"""A vehicle's tables and bags: names, angles as quaternions, REP 103's axes in ours, what gravity forbids."""

import numpy as np
import pytest
from foreign_recordings import COUNT, stamps
from map_import import attempted, imported, proposal, wide
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation
from turning_vehicle import ANGLES, BODY, FORCE, PULSES, RATES, TIME, attitude, vectors

TO_NED, TO_FLU = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.diag([1, -1, -1])
"""The rotations between the axes of REP 103 and ours, each its own inverse."""


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


def test_a_vehicle_s_table_is_guessed_and_its_angles_become_a_quaternion(tmp_path, capsys):
    file = wide(tmp_path / "dive.csv", columns())
    text = proposal(capsys, file)
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
    inner = wide(tmp_path / "a.csv", {k: c for k, c in whole.items() if k == "time_s" or k not in own})
    outer = wide(tmp_path / "b.csv", {k: c for k, c in whole.items() if k in own})
    text = proposal(capsys, inner, outer)
    assert "rov/depth.depth: {column: depth, unit: m}" in text
    assert "rov/velocity.twist.twist.linear.z: {column: w, unit: m/s}" in text
    assert "rov/battery.voltage: {column: battery_V, unit: V}" in text
    assert "file:" not in text, "names that one file alone has do for the files of the next dive as well"


def test_a_file_with_a_clock_of_its_own_is_proposed_with_it_and_one_map_imports_two_dives(tmp_path, capsys):
    whole = {k: c for k, c in columns().items() if k != "depth"}
    for dive in (1, 2):
        wide(tmp_path / f"body_{dive}.csv", whole)
        wide(tmp_path / f"depth_{dive}.csv", {"t_us": 1e6 * TIME, "depth": 2.0 + 0.1 * np.sin(TIME)})
    text = proposal(capsys, tmp_path / "body_1.csv", tmp_path / "depth_1.csv")
    assert "rov/depth.depth: {column: depth, unit: m, time_column: t_us, time_unit: us}" in text
    for dive in (1, 2):
        files = [tmp_path / f"{name}_{dive}.csv" for name in ("body", "depth")]
        run = imported(tmp_path, text.replace("unit: '?'", "unit: rad/s"), *files, out=f"run_{dive}")
        assert run["rov/depth.depth"].values.size == COUNT


def test_what_a_gyro_s_unit_may_be_is_asked_and_gravity_tells_an_accelerometer_s(tmp_path, capsys):
    units = {f"gyro_{a}": RATES[:, k] for k, a in enumerate("xyz")}
    units |= {f"acc_{a}": FORCE[:, k] for k, a in enumerate("xyz")}
    text = proposal(capsys, wide(tmp_path / "a.csv", {"t": TIME, **units}))
    assert text.count("unit: '?'") == 3
    assert "write the unit: rad/s, rpm, rps or deg/s?" in text
    assert text.count("unit: m/s^2") == 3  # small along x and y, gravity along z


def test_an_attitude_in_parts_or_twice_is_not_proposed(tmp_path, capsys):
    parted = columns()
    del parted["heading"]
    text = proposal(capsys, wide(tmp_path / "a.csv", parted))
    assert "orientation" not in text
    assert "# roll " in text
    x, y, z, w = BODY.as_quat().T
    twice = columns(q_w=w, q_x=x, q_y=y, q_z=z)
    text = proposal(capsys, wide(tmp_path / "b.csv", twice))
    assert text.count("rov/imu.orientation.") == 4
    run = imported(tmp_path, text, tmp_path / "b.csv")
    assert np.max((attitude(run) * BODY.inv()).magnitude()) < 1e-6


def dive(imu, log, **more):
    """Return 40 s of a vehicle that rolls, pitches, surges and heaves; imu, log: 1 in our axes, -1 in REP 103's."""
    time, draw = 0.04 * np.arange(1000), np.random.default_rng(3)
    pitch, surge, heave = 0.3 * np.sin(0.9 * time), 0.5 * np.cos(0.5 * time), 0.2 * np.sin(0.7 * time)
    roll = 0.2 * np.sin(0.6 * time)
    down = np.stack((-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)))
    falling = down[0] * surge + down[2] * heave
    noise = draw.normal(0.0, 0.01, (3, time.size))
    return {
        "t": time, "pwm_1": 1500.0 + 0 * time, "pwm_2": 1500.0 + 0 * time,
        "acc_x": -9.81 * down[0], "acc_y": -imu * 9.81 * down[1], "acc_z": -imu * 9.81 * down[2],
        "roll": np.degrees(roll), "pitch": imu * np.degrees(pitch), "yaw": 0 * time,
        "depth": 3.0 + np.cumsum(0.04 * falling) + 0.3 * noise[0],
        "vel_x": surge + noise[1], "vel_y": 0 * time, "vel_z": log * (heave + noise[2]), **more,
    }  # fmt: skip


@pytest.mark.parametrize("imu", [1, -1])
@pytest.mark.parametrize("log", [1, -1])
def test_axes_of_a_velocity_log_are_told_by_the_change_of_depth_and_not_by_the_imu(tmp_path, capsys, imu, log):
    text = proposal(capsys, wide(tmp_path / "a.csv", dive(imu, log)))
    turned = [f"{topic}: rep103" for topic, way in (("rov/imu", imu), ("rov/velocity", log)) if way < 0]
    found = [line.partition("   #")[0] for line in text.splitlines() if "axes" in line]
    assert found == ([f"axes: {{{', '.join(turned)}}}"] if turned else [])


def test_without_an_attitude_a_velocity_log_is_held_against_the_depth_as_if_level(tmp_path, capsys):
    level = {k: c for k, c in dive(1, -1).items() if k not in ("roll", "pitch", "yaw")}
    text = proposal(capsys, wide(tmp_path / "a.csv", level))
    assert "\naxes: {rov/velocity: rep103}   # rov/velocity.z is positive while the depth shrinks" in text


@pytest.mark.parametrize(("log", "told"), [(1, False), (-1, True)])
def test_an_imu_that_is_mounted_upside_down_does_not_turn_a_velocity_log(tmp_path, capsys, log, told):
    turned = dive(1, log)
    turned |= {"acc_y": -turned["acc_y"], "acc_z": -turned["acc_z"], "roll": turned["roll"] + 180.0}
    text = proposal(capsys, wide(tmp_path / "a.csv", turned))
    text = "\n".join(line for line in text.splitlines() if "axes:" not in line)
    imported(tmp_path, text, tmp_path / "a.csv")
    assert ("rov/velocity: its z is positive while the depth shrinks" in capsys.readouterr().err) is told


def test_a_height_tells_the_axes_of_a_velocity_log_as_a_depth_does(tmp_path, capsys):
    above = dive(-1, -1)
    above["depth"] = -above["depth"]
    text = proposal(capsys, wide(tmp_path / "a.csv", above))
    assert "rov/depth.depth: {column: depth, unit: m, sign: -1}" in text
    assert "\naxes: {rov/imu: rep103, rov/velocity: rep103}" in text


@pytest.mark.parametrize("depth", ["level", "none"])
def test_a_velocity_log_whose_axes_nothing_tells_stays_as_stated_with_a_question(tmp_path, capsys, depth):
    table = dive(-1, -1)
    shown = {"level": 3.0 + 0 * table["t"]}
    del table["depth"]
    text = proposal(capsys, wide(tmp_path / "a.csv", table | ({"depth": shown[depth]} if depth in shown else {})))
    assert "\naxes: {rov/imu: rep103}   # at rest the IMU's z axis points up\n" in text
    assert "\n# axes: {rov/imu: rep103, rov/velocity: rep103}   # if x is forward" in text


@pytest.mark.parametrize(("unit", "gravity"), [("g", 1.0), ("m/s^2", 9.81), ("mg", 1000.0)])
def test_gravity_tells_the_unit_of_an_accelerometer_whose_name_does_not(tmp_path, capsys, unit, gravity):
    table = dive(1, 1)
    table |= {f"acc_{a}": table[f"acc_{a}"] * gravity / 9.81 for a in "xyz"}
    text = proposal(capsys, wide(tmp_path / "a.csv", table))
    assert text.count(f"unit: {unit}}}") == 3
    assert f"unit by its values: |a| is {gravity:.4g} as a rule, as gravity at rest" in text


def test_gravity_tells_the_unit_of_an_accelerometer_in_a_long_table(tmp_path, capsys):
    rows = [f"{t},{name},{value}" for k, t in enumerate(TIME) for name, value in long_row(k)]
    (tmp_path / "a.csv").write_text("\n".join(["time,name,value", *rows]))
    assert proposal(capsys, tmp_path / "a.csv").count("|a| is 1 as a rule, as gravity at rest") == 3


def long_row(k):
    forces = zip("xyz", FORCE[k] / 9.81, strict=True)
    return [("gyro_x", RATES[k, 0]), *((f"acc_{a}", value) for a, value in forces), ("pwm_1", PULSES[k])]


def test_an_acceleration_without_gravity_is_asked_about(tmp_path, capsys):
    table = dive(1, 1)
    table |= {f"acc_{a}": np.sin((k + 1.0) * table["t"]) for k, a in enumerate("xyz")}
    text = proposal(capsys, wide(tmp_path / "a.csv", table))
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
    text = proposal(capsys, file)
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
    text = "".join(line + "\n" for line in proposal(capsys, file).splitlines() if not line.startswith("axes"))
    imported(tmp_path, text, file)
    assert "rov/imu: its z axis points up: expected axes forward, starboard, down" in capsys.readouterr().err


def test_outputs_with_the_thruster_s_number_inside_and_specific_forces_are_a_vehicle_s(tmp_path, capsys):
    names = {f"servo{k}_out": 1500.0 + 200.0 * np.sin(TIME + k) for k in (1, 2)}
    forces = {"fx": 0.1 * np.sin(TIME), "fy": 0.2 * np.cos(TIME), "fz": np.full(TIME.size, -9.8)}
    text = proposal(capsys, wide(tmp_path / "a.csv", {"t": TIME, **names, **forces, "volts": 15.0 + TIME}))
    for k in (1, 2):
        assert f"thruster_{k - 1}/throttle.commanded: {{column: servo{k}_out, unit: us" in text
    assert "rov/imu.linear_acceleration.z: {column: fz" in text and "rov/battery.voltage: {column: volts" in text


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
    file = wide(tmp_path / "dive.csv", columns())
    assert attempted(tmp_path, CLOCK + text, file) == 1
    assert sentence in capsys.readouterr().err


def test_an_attitude_whose_angles_never_come_together_is_refused(tmp_path, capsys):
    apart = columns()
    for k, name in enumerate(("roll", "pitch", "heading")):
        apart[name] = np.where(np.arange(COUNT) % 3 == k, apart[name], np.nan)
    file = wide(tmp_path / "dive.csv", apart)
    assert attempted(tmp_path, proposal(capsys, file), file) == 1
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
    usual = wide(tmp_path / "usual.csv", columns())
    text = proposal(capsys, usual)
    imported(tmp_path, text, wide(tmp_path / "dive.csv", columns(**change)))
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
    file = wide(tmp_path / "dive.csv", {"t": time, "u": log, "depth": level})
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
    file = wide(tmp_path / "dive.csv", {"t": TIME, "amps": drawn})
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
    file = wide(tmp_path / "dive.csv", {"t": TIME, header: np.sin(TIME)})
    imported(tmp_path, f"time: {{column: t, unit: s}}\n{STATED[name]}: {{column: {name}, {keys}}}", file)
    told = [line for line in capsys.readouterr().err.splitlines() if "as the recording states" in line]
    assert len(told) == bool(said) and all(said in line for line in told)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_battery_s_current_by_its_unit_alone_counts_as_drawn_whichever_way_it_is_written(tmp_path, capsys, way):
    own = {k: v for k, v in columns().items() if not k.startswith("battery")}
    table = wide(tmp_path / "dive.csv", own | {"batt_V": 15.0 + 0 * TIME, "batt_A": way * 3.0 + 0 * TIME})
    run = imported(tmp_path, proposal(capsys, table), table)
    assert (run["rov/battery.voltage"].values[0], run["rov/battery.current"].values[0]) == (15.0, -3.0)
