"""What is proposed for a bag of a vehicle, by the types of its messages and by what they tell."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from map_import import imported, proposed
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from run_bag.cli_info import main as info

TIME = 1e9 + 0.05 * np.arange(800)
FALLING = 0.3 * np.sin(0.5 * TIME)
"""[m/s] downwards."""
DEPTH = 3.0 - 0.6 * np.cos(0.5 * TIME)
RCOUT, RCIN = "std_msgs/Header header\nuint16[] channels\n", "std_msgs/Header header\nuint8 rssi\nuint16[] channels\n"
PULSES = 1500 + np.round(100 * np.sin(TIME[:, None] + np.arange(3)))


def write_bag(path: Path, topics: dict[str, tuple[str, Callable[[Any, Any, int], Any]]]) -> Path:
    """Write a bag; each topic has a type, and what gives message k from (types, header)."""
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(
        get_types_from_msg(RCOUT, "mavros_msgs/msg/RCOut") | get_types_from_msg(RCIN, "mavros_msgs/msg/RCIn")
    )
    types = store.types
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        for name, (kind, made) in topics.items():
            connection = writer.add_connection(name, kind, typestore=store)
            for k, at in enumerate(map(int, np.round(TIME * 1e9))):
                stamp = types["builtin_interfaces/msg/Time"](*divmod(at, 10**9))
                message = made(types, types["std_msgs/msg/Header"](stamp, "base_link"), k)
                writer.write(connection, at, store.serialize_cdr(message, kind))
    return path


def imu(types: Any, header: Any, k: int) -> Any:
    vector, none = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    level = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    return types["sensor_msgs/msg/Imu"](header, level, none, vector(0.1, 0.0, 0.0), none, vector(0.0, 0.0, 9.8), none)


def turning_imu(covariance: float) -> Callable[[Any, Any, int], Any]:
    """Return an IMU's messages with an attitude that turns, and its first covariance."""

    def made(types: Any, header: Any, k: int) -> Any:
        message = imu(types, header, k)
        half = 0.2 * np.sin(TIME[k])
        message.orientation = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(half), np.cos(half))
        message.orientation_covariance = np.array([covariance, *np.zeros(8)])
        return message

    return made


def autopilot(parent: str) -> Callable[[Any, Any, int], Any]:
    """Return messages of an odometry in a frame of that name."""

    def made(types: Any, header: Any, k: int) -> Any:
        vector, half = types["geometry_msgs/msg/Vector3"], 0.2 * np.sin(TIME[k])
        turned = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, np.sin(half), np.cos(half))
        pose = types["geometry_msgs/msg/Pose"](types["geometry_msgs/msg/Point"](0.0, 0.0, 0.0), turned)
        twist = types["geometry_msgs/msg/Twist"](vector(0.0, 0.0, 0.0), vector(0.0, 0.0, 0.4 * np.cos(TIME[k])))
        header.frame_id = parent
        return types["nav_msgs/msg/Odometry"](
            header, "base_link_frd",
            types["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36)),
            types["geometry_msgs/msg/TwistWithCovariance"](twist, np.zeros(36)),
        )  # fmt: skip

    return made


def battery(types: Any, header: Any, k: int) -> Any:
    return types["sensor_msgs/msg/BatteryState"](
        header, 16.0, 0.0, -1.0 - 0.01 * k, 0.0, 0.0, 0.0, 0.0, 0, 0, 0, True, np.zeros(0, np.float32),
        np.zeros(0, np.float32), "", "",
    )  # fmt: skip


def dvl(types: Any, header: Any, k: int) -> Any:
    vector = types["geometry_msgs/msg/Vector3"]
    twist = types["geometry_msgs/msg/Twist"](vector(0.2, 0.0, -FALLING[k]), vector(0.0, 0.0, 0.0))
    return types["geometry_msgs/msg/TwistStamped"](header, twist)


def pressure(types: Any, header: Any, k: int) -> Any:
    return types["sensor_msgs/msg/FluidPressure"](header, 101325.0 + 1000.0 * 9.80665 * DEPTH[k], 0.0)


def sent(values: np.ndarray, *more: float) -> Callable[[Any, Any, int], Any]:
    def made(types: Any, header: Any, k: int) -> Any:
        return types["mavros_msgs/msg/RCOut"](header, np.array([*values[k], *more], dtype=np.uint16))

    return made


def sticks(types: Any, header: Any, k: int) -> Any:
    return types["mavros_msgs/msg/RCIn"](header, 90, PULSES[k].astype(np.uint16))


def shares(types: Any, header: Any, k: int) -> Any:
    layout = types["std_msgs/msg/MultiArrayLayout"]([], 0)
    return types["std_msgs/msg/Float32MultiArray"](layout, ((PULSES[k] - 1500) / 400).astype(np.float32))


def joints(types: Any, header: Any, k: int) -> Any:
    names = ["a", "b", "c"]
    return types["sensor_msgs/msg/JointState"](header, names, np.zeros(0), PULSES[k] - 1500.0, np.zeros(0))


def depth(types: Any, header: Any, k: int) -> Any:
    return types["std_msgs/msg/Float64"](DEPTH[k])


def push(types: Any, header: Any, k: int) -> Any:
    vector, none = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
    return types["geometry_msgs/msg/WrenchStamped"](
        header, types["geometry_msgs/msg/Wrench"](vector(PULSES[k, 0] - 1500.0, 0.0, 0.0), none)
    )


def stick(types: Any, header: Any, k: int) -> Any:
    axes = ((PULSES[k, :1] - 1500) / 400).astype(np.float32)
    return types["sensor_msgs/msg/Joy"](header, axes, np.zeros(0, np.int32))


def below(types: Any, header: Any, k: int) -> Any:
    return types["geometry_msgs/msg/PointStamped"](header, types["geometry_msgs/msg/Point"](0.0, 0.0, DEPTH[k]))


IMU, DVL = ("sensor_msgs/msg/Imu", imu), ("geometry_msgs/msg/TwistStamped", dvl)
OUT = ("mavros_msgs/msg/RCOut", sent(PULSES, 0.0, 0.0))


def test_a_vehicle_s_bag_is_proposed_whole_and_imported_as_it_is(tmp_path: Path, capsys: Any) -> None:
    topics = {"/mavros/imu/data": IMU, "/mavros/rc/in": ("mavros_msgs/msg/RCIn", sticks), "/mavros/rc/out": OUT}
    topics |= {"/dvl/twist": DVL, "/cmd/twist": DVL, "/bar30": ("sensor_msgs/msg/FluidPressure", pressure)}
    topics |= {"/esc/states": ("sensor_msgs/msg/JointState", joints), "/arm": ("sensor_msgs/msg/JointState", joints)}
    bag = write_bag(tmp_path / "bag", topics)
    found, text = proposed(capsys, bag)
    commanded = [name for name in found if name.endswith(".commanded")]
    assert commanded == [f"thruster_{i}/throttle.commanded" for i in range(3)], "two elements are 0 ever after"
    assert "mavros/rc/out.channels[2]" in found["thruster_2/throttle.commanded"], "nobody's sticks"
    assert "esc/states.velocity[1]', unit: rad/s" in found["thruster_1/state.n"], "and no arm's joints"
    assert "dvl/twist" in found["rov/velocity.twist.twist.linear.x"], "and nothing that is only wanted"
    assert found["axes"].startswith("{rov/imu: rep103, rov/velocity: rep103}")
    assert "covariance" not in text and "layout" not in text
    run = imported(tmp_path, text, bag)
    np.testing.assert_allclose(run["rov/depth.depth"].values, DEPTH, atol=2e-3)
    np.testing.assert_allclose(run["rov/velocity.twist.twist.linear.z"].values, FALLING, atol=1e-9)
    np.testing.assert_allclose(run["thruster_1/throttle.commanded"].values, (PULSES[:, 1] - 1500) / 80)


@pytest.mark.parametrize("topic", ["/thruster_cmd", "/control/pwm", "/outputs"])
def test_an_array_within_1_of_things_that_drive_are_commands(topic: str, tmp_path: Path, capsys: Any) -> None:
    kind = "std_msgs/msg/Float32MultiArray"
    found, _ = proposed(capsys, write_bag(tmp_path / "bag", {"/imu": IMU, topic: (kind, shares)}))
    assert [name for name in found if "commanded" in name] == [f"thruster_{i}/throttle.commanded" for i in range(3)]
    assert "unit: '1', stop: 0, per_volt: 0.2" in found["thruster_0/throttle.commanded"]
    found, text = proposed(capsys, write_bag(tmp_path / "other", {"/imu": IMU, "/filter_state": (kind, shares)}))
    assert not any("commanded" in name for name in found)
    assert "# No command of a thruster was recognised" in text


def test_an_import_tells_of_a_velocity_log_whose_axes_were_forgotten(tmp_path: Path, capsys: Any) -> None:
    bag = write_bag(
        tmp_path / "bag", {"/imu": IMU, "/rc/out": OUT, "/dvl": DVL, "/depth": ("std_msgs/msg/Float64", depth)}
    )
    _, text = proposed(capsys, bag)
    for name, axes, told in (("all", "rov/imu: rep103, rov/velocity: rep103", False), ("imu", "rov/imu: rep103", True)):
        imported(tmp_path, re.sub(r"(?m)^axes: .*$", f"axes: {{{axes}}}", text), bag, out=name)
        error = capsys.readouterr().err
        assert info([str(tmp_path / name)]) == 0
        told_of = capsys.readouterr().out
        assert "field 'imu.angular_velocity.x' at its headers' stamps;" in told_of
        assert "field 'depth.data' at the recorder's times;" in told_of
        assert ("rov/velocity: its z is positive while the depth shrinks" in error) == told
        assert "messages of depth have no header: their times are those at which the recorder got them" in error


def test_an_import_says_nothing_of_the_recorder_s_times_of_commands_whose_clock_is_stated(
    tmp_path: Path, capsys: Any
) -> None:
    topics = {"/imu": IMU, "/thruster_cmd": ("std_msgs/msg/Float32MultiArray", shares)}
    bag = write_bag(tmp_path / "bag", topics)
    _, text = proposed(capsys, bag)
    for name, stated in (("said", ""), ("stated", ", clock_deviation: 0.005")):
        imported(tmp_path, text.replace(", hold: previous}", f", hold: previous{stated}}}"), bag, out=name)
        assert ("messages of thruster_cmd have no header" in capsys.readouterr().err) is (name == "said")


@pytest.mark.parametrize(("topic", "told"), [("/esc/command", True), ("/esc/states", False)])
def test_an_effort_in_volts_is_a_command_where_the_topic_says_so(
    topic: str, told: bool, tmp_path: Path, capsys: Any
) -> None:
    def efforts(types: Any, header: Any, k: int) -> Any:
        none = np.zeros(0)
        return types["sensor_msgs/msg/JointState"](header, ["a"], none, none, (PULSES[k, :1] - 1500.0) / 30.0)

    found, _ = proposed(capsys, write_bag(tmp_path / "bag", {topic: ("sensor_msgs/msg/JointState", efforts)}))
    line = f"{{field: '{topic[1:]}.effort[0]', unit: V, hold: previous}}"
    assert found.get("thruster_0/throttle.commanded", "").startswith(line) is told


@pytest.mark.parametrize(
    ("topic", "kind", "made", "field"),
    [
        ("/mavros/rc/out", "mavros_msgs/msg/RCOut", sent(PULSES[:, :1], 1500.0, 1500.0), "mavros/rc/out.channels[0]"),
        ("/joy", "sensor_msgs/msg/Joy", stick, "joy.axes[0]"),
    ],
)
def test_a_bench_s_bag_is_proposed_with_its_one_command_its_load_cell_and_its_flow(
    topic: str, kind: str, made: Any, field: str, tmp_path: Path, capsys: Any
) -> None:
    topics = {topic: (kind, made), "/load_cell": ("geometry_msgs/msg/WrenchStamped", push), "/wrench_cmd": DVL}
    topics |= {"/adv/axial": DVL, "/current_meter": DVL, "/esc/states": ("sensor_msgs/msg/JointState", joints)}
    bag = write_bag(tmp_path / "bag", topics)
    found, text = proposed(capsys, bag)
    assert [name for name in found if name.endswith("commanded")] == ["thruster_0/throttle.commanded"]
    assert f"{{field: '{field}', " in found["thruster_0/throttle.commanded"]
    assert "by its values alone: is it?" in found["thruster_0/throttle.commanded"]
    assert "{field: load_cell.wrench.force.x, unit: N}" in found["thruster_0/load.wrench.force.x"]
    assert "{field: adv/axial.twist.linear.x, unit: m/s}" in found["thruster_0/flow.axial"]
    assert "of the water around? at the propeller it is flow.axial" in found["thruster_0/flow.ambient"]
    assert "wrench.torque" not in "".join(found) and "# 0 in all messages: " in text, "nobody measured a torque"
    found, _ = proposed(capsys, write_bag(tmp_path / "vehicle", topics | {"/imu": IMU}))
    assert not any(name.startswith(("thruster_0/load", "thruster_0/flow")) for name in found)


def test_several_sticks_are_no_commands_and_a_point_below_the_surface_is_a_depth(tmp_path: Path, capsys: Any) -> None:
    def sticks_of_joy(types: Any, header: Any, k: int) -> Any:
        axes = ((PULSES[k] - 1500) / 400).astype(np.float32)
        return types["sensor_msgs/msg/Joy"](header, axes, np.zeros(0, np.int32))

    topics = {"/imu": IMU, "/joy": ("sensor_msgs/msg/Joy", sticks_of_joy)}
    bag = write_bag(tmp_path / "bag", topics | {"/keller/depth": ("geometry_msgs/msg/PointStamped", below)})
    found, _ = proposed(capsys, bag)
    assert not any("commanded" in name for name in found)
    assert found["rov/depth.depth"].startswith("{field: keller/depth.point.z, unit: m}")


def test_speeds_beyond_any_thruster_s_are_rpm_and_asked_about_once(tmp_path: Path, capsys: Any) -> None:
    def tachometers(types: Any, header: Any, k: int) -> Any:
        message = joints(types, header, k)
        message.velocity = np.abs(PULSES[k] - 1500.0) * np.array([6.0, 20.0, 0.0])
        return message

    topics = {"/imu": IMU, "/out": OUT, "/esc/states": ("sensor_msgs/msg/JointState", tachometers)}
    bag = write_bag(tmp_path / "bag", topics)
    found, text = proposed(capsys, bag)
    units = [re.findall(r"unit: ([^,}]+)", found[f"thruster_{i}/state.n"])[0] for i in range(2)]
    assert units == ["rpm", "rpm"], "the first would be none by its own values"
    assert text.count("in rad/s by its type, and 2000 is no thruster's: is it rpm?") == 1
    imported(tmp_path, text.replace("unit: rpm", "unit: rad/s"), bag)
    told = capsys.readouterr()
    assert told.err.count("no thruster's; is `unit` that of the recording?") == 1
    assert "thruster_1/state.n: up to 2000 rad/s: no thruster's" in told.err
    assert "  thruster_0 to 2/throttle: commanded: 800 readings in 40.0 s, 20 Hz\n" in told.out


def test_a_depth_that_is_negative_as_a_rule_is_a_height_with_a_sign_and_a_question(tmp_path: Path, capsys: Any) -> None:
    def above(types: Any, header: Any, k: int) -> Any:
        return types["geometry_msgs/msg/PointStamped"](header, types["geometry_msgs/msg/Point"](0.0, 0.0, -DEPTH[k]))

    bag = write_bag(tmp_path / "bag", {"/imu": IMU, "/depth": ("geometry_msgs/msg/PointStamped", above)})
    entry = proposed(capsys, bag)[0]["rov/depth.depth"]
    assert entry.startswith("{field: depth.point.z, unit: m, sign: -1}")
    assert entry.endswith("a height by its values: is it?")


@pytest.mark.parametrize(("way", "sign"), [(-1, ""), (1, ", sign: -1")])
def test_a_current_that_is_positive_throughout_is_asked_about(way: int, sign: str, tmp_path: Path, capsys: Any) -> None:
    def drawn(types: Any, header: Any, k: int) -> Any:
        message = battery(types, header, k)
        message.current *= -way
        return message

    topics = {"/imu": IMU, "/rc/out": OUT, "/battery": ("sensor_msgs/msg/BatteryState", drawn)}
    entry = proposed(capsys, write_bag(tmp_path / "bag", topics))[0]["rov/battery.current"]
    assert entry.startswith(f"{{field: battery.current, unit: A{sign}}}")
    assert ("positive throughout: is it while it is drawn?" in entry) is (way > 0)


def test_an_array_of_volts_is_commands_where_its_name_says_volts(tmp_path: Path, capsys: Any) -> None:
    def volts(types: Any, header: Any, k: int) -> Any:
        layout = types["std_msgs/msg/MultiArrayLayout"]([], 0)
        return types["std_msgs/msg/Float32MultiArray"](layout, ((PULSES[k] - 1500) / 30).astype(np.float32))

    for topic, told in (("/prop/demand_volts", True), ("/prop/demand", False)):
        topics = {"/imu": IMU, topic: ("std_msgs/msg/Float32MultiArray", volts)}
        found, _ = proposed(capsys, write_bag(tmp_path / topic[-1], topics))
        entry = found.get("thruster_2/throttle.commanded", "")
        assert ("{field: 'prop/demand_volts.data[2]', unit: V, hold: previous}" in entry) is told


@pytest.mark.parametrize(
    ("made", "there"), [(imu, False), (turning_imu(-1.0), False), (turning_imu(0.0), True), (turning_imu(1e-4), True)]
)
def test_an_attitude_that_nobody_measured_is_not_proposed(made: Any, there: bool, tmp_path: Path, capsys: Any) -> None:
    found, text = proposed(capsys, write_bag(tmp_path / "bag", {"/imu": ("sensor_msgs/msg/Imu", made), "/rc/out": OUT}))
    assert ("rov/imu.orientation.w" in found) is there and "rov/imu.angular_velocity.x" in found
    assert ("# imu.orientation.w " in text) is not there


@pytest.mark.parametrize(("frame", "asked"), [("map_ned", False), ("odom", True)])
def test_axes_that_a_message_s_frame_says_are_not_asked_about(
    frame: str, asked: bool, tmp_path: Path, capsys: Any
) -> None:
    topics = {"/autopilot/odometry": ("nav_msgs/msg/Odometry", autopilot(frame)), "/rc/out": OUT}
    _, text = proposed(capsys, write_bag(tmp_path / "bag", topics))
    assert ("# axes: {rov/odometry: rep103}" in text) is asked


def test_a_sensor_that_never_changes_is_asked_about_and_a_hold_once(tmp_path: Path, capsys: Any) -> None:
    topics = {"/imu": IMU, "/rc/out": OUT, "/battery": ("sensor_msgs/msg/BatteryState", battery)}
    found, text = proposed(capsys, write_bag(tmp_path / "bag", topics))
    assert found["rov/battery.voltage"].endswith("always 16 V, 800 samples; never changes: is it measured?")
    assert text.count("never changes: is it measured?") == 1
    assert text.count("hold is a guess: previous or linear?") == 1
    assert "hold is a guess" in found["thruster_0/throttle.commanded"] and len(found) > 10


def turning(values: np.ndarray, *, efforts: bool = False) -> tuple[str, Callable[[Any, Any, int], Any]]:
    """Return the type and the messages of a joint whose speeds or efforts are the values."""

    def made(types: Any, header: Any, k: int) -> Any:
        none, own = np.zeros(0), values[k : k + 1]
        return types["sensor_msgs/msg/JointState"](
            header, ["a"], none, none if efforts else own, own if efforts else none
        )

    return "sensor_msgs/msg/JointState", made


FORCE, VOLTS, SPEED = ("geometry_msgs/msg/WrenchStamped", push), 4.0 * np.sin(TIME), 90.0 * np.sin(TIME)


@pytest.mark.parametrize(
    ("inside", "outside", "axial"),
    [("/laser/inside", "/laser/outside", True), ("/meter/inside", "/meter/tank", True), ("/meter", "/other", False)],
)
def test_of_two_flows_of_a_bench_the_names_tell_which_is_which(
    inside: str, outside: str, axial: bool, tmp_path: Path, capsys: Any
) -> None:
    found, text = proposed(capsys, write_bag(tmp_path / "bag", {inside: DVL, outside: DVL, "/six_axes": FORCE}))
    flows = {name.partition(".")[2]: entry for name, entry in found.items() if "flow" in name}
    assert set(flows) == ({"axial", "ambient"} if axial else set()), "of two alike nobody knows"
    if axial:
        assert inside[1:] in flows["axial"] and outside[1:] in flows["ambient"] and "of the water around?" not in text


def test_a_bench_s_topic_is_known_by_a_type_that_it_alone_has(tmp_path: Path, capsys: Any) -> None:
    topics = {"/six_axes": FORCE, "/wanted/wrench_cmd": FORCE, "/laser": DVL, "/hub": turning(SPEED)}
    topics |= {"/hub_setpoint": turning(VOLTS, efforts=True)}
    found, text = proposed(capsys, write_bag(tmp_path / "bag", topics))
    for channel, field in (
        ("load.wrench.force.x", "six_axes.wrench.force.x"), ("flow.ambient", "laser.twist.linear.x"),
        ("state.n", "hub.velocity[0]"),
    ):  # fmt: skip
        assert field in found[f"thruster_0/{channel}"] and "by its type alone: is it?" in found[f"thruster_0/{channel}"]
    assert "at the propeller it is flow.axial" in found["thruster_0/flow.ambient"]
    assert "hub_setpoint.effort[0]" in found["thruster_0/throttle.commanded"]
    assert text.count("by its type alone") == 3 and len(found) == 4


@pytest.mark.parametrize(
    "more",
    [
        {"/imu": IMU, "/rc/out": OUT},
        {"/rc/out": OUT},
        {"/seven_axes": FORCE, "/lamp": DVL, "/wheel": turning(SPEED)},
        {"/bar30": ("sensor_msgs/msg/FluidPressure", pressure)},
    ],
)
def test_a_type_alone_tells_nothing_of_a_vehicle_or_of_two_topics(
    more: dict[str, Any], tmp_path: Path, capsys: Any
) -> None:
    topics = {"/six_axes": FORCE, "/laser": DVL, "/hub": turning(SPEED), **more}
    found, text = proposed(capsys, write_bag(tmp_path / "bag", topics))
    assert "by its type alone" not in text and not any("load" in name or "flow" in name for name in found)


@pytest.mark.parametrize("topic", ["/thr/encoder", "/drive/state", "/motor/shaft"])
def test_a_bench_s_rotor_is_known_by_words_that_an_arm_s_joint_may_have_on_a_vehicle(
    topic: str, tmp_path: Path, capsys: Any
) -> None:
    topics = {topic: turning(SPEED), "/other": turning(SPEED)}
    found, _ = proposed(capsys, write_bag(tmp_path / "bag", topics))
    assert f"{topic[1:]}.velocity[0]" in found["thruster_0/state.n"]


@pytest.mark.parametrize("topic", ["/drive/reference", "/drehzahl_soll", "/drive/target"])
def test_a_joint_s_speed_that_is_only_wanted_is_not_measured(topic: str, tmp_path: Path, capsys: Any) -> None:
    found, _ = proposed(capsys, write_bag(tmp_path / "bag", {topic: turning(SPEED)}))
    assert "thruster_0/state.n" not in found
