"""What is proposed by words of names: units, topics of messages of one's own, an autopilot's battery on a bench."""

import struct

import numpy as np
import pytest
from foreign_recordings import COUNT, message_format, stamps
from map_import import SWEEP, attempted, proposed, wide
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

TIME = 0.01 * np.arange(SWEEP.size)


@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("shaft_rev_s", "thruster_0/state.n: {column: shaft_rev_s, unit: rps}"),
        ("shaft_rpm", "thruster_0/state.n: {column: shaft_rpm, unit: rpm}"),
        ("pull_grams", "thruster_0/load.wrench.force.x: {column: pull_grams, unit: gf}"),
        ("thrust_ozf", "thruster_0/load.wrench.force.x: {column: thrust_ozf, unit: ozf}"),
    ],
)
def test_a_shaft_turns_and_a_pull_is_a_thrust(tmp_path, capsys, name, entry):
    _, text = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, name: 20 * SWEEP}))
    assert entry in text


def test_the_one_name_in_a_column_of_names_is_told(tmp_path, capsys):
    rows = "\n".join(f"{10000 * k},pull,{u:.4f},0,0" for k, u in enumerate(SWEEP))
    (tmp_path / "log_debug_vect_0.csv").write_text(f"timestamp,name,x,y,z\n{rows}\n")
    _, text = proposed(capsys, tmp_path / "log_debug_vect_0.csv")
    assert "# name no numbers: always pull" in text


def test_a_field_that_is_called_as_its_unit_is_what_its_topic_is_called(tmp_path, capsys):
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg("std_msgs/Header header\nfloat64 rev_per_min\n", "bench_msgs/msg/Tacho"))
    types = store.types
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/rig/tacho", "bench_msgs/msg/Tacho", typestore=store)
        for at, u in zip(stamps(), SWEEP, strict=False):
            header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](*divmod(at, 10**9)), "")
            message = types["bench_msgs/msg/Tacho"](header, 900.0 * u)
            writer.write(connection, at, store.serialize_cdr(message, "bench_msgs/msg/Tacho"))
    found, _ = proposed(capsys, tmp_path / "bag")
    assert found["thruster_0/state.n"].startswith("{field: rig/tacho.rev_per_min, unit: rpm}")


@pytest.mark.parametrize("outputs", [1, 2])
def test_an_autopilot_s_battery_on_a_bench_is_the_supply_where_the_driver_s_never_changes(tmp_path, capsys, outputs):
    data = message_format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    data += message_format(10, 3 + 8 + 4, "RCOU", "QHH", "TimeUS,C1,C2")
    data += message_format(11, 3 + 8 + 1 + 8, "ESC", "QBff", "TimeUS,Instance,RPM,Volt")
    data += message_format(14, 3 + 8 + 8, "BAT", "Qff", "TimeUS,Volt,Curr")
    for k in range(COUNT):
        at, pulse = 5_000_000 + k * 40_000, 1500 + round(200 * np.sin(k))
        data += b"\xa3\x95\x0a" + struct.pack("<QHH", at, pulse, pulse if outputs > 1 else 1500)
        data += b"\xa3\x95\x0b" + struct.pack("<QBff", at, 0, 600.0 + k, 15.2)
        data += b"\xa3\x95\x0e" + struct.pack("<Qff", at, 15.5 - 0.01 * k, 4.0)
    (tmp_path / "x.BIN").write_bytes(data)
    found, text = proposed(capsys, tmp_path / "x.BIN")
    if outputs == 1:
        assert "BAT.Volt" in found["thruster_0/state.supply_voltage"] and "rov/battery" not in text
    else:
        assert "BAT.Volt" in found["rov/battery.voltage"]


def test_what_is_wrong_with_many_entries_alike_is_said_behind_the_first(tmp_path, capsys):
    table = wide(tmp_path / "x.csv", {"t": TIME, "a": SWEEP})
    parts = [f"rov/imu.{kind}.{axis}" for kind in ("angular_velocity", "linear_acceleration") for axis in "xyz"]
    units = {"angular_velocity": "rad/s", "linear_acceleration": "m/s^2"}
    lines = [f"{p}: {{column: a, unit: {units[p.split('.')[1]]}, time_offset: LATER}}" for p in parts]
    assert attempted(tmp_path, "time: {column: t}\n" + "\n".join(lines), table) == 1
    told = capsys.readouterr().err
    assert "rov/imu.angular_velocity.x and 5 other entries: time_offset: expected a number, found 'LATER'" in told


def test_what_a_driver_tells_without_change_is_asked_about_in_a_table_of_its_messages_too(tmp_path, capsys):
    columns = {
        "timestamp": 1e6 * TIME,
        "output[0]": 1500 + np.round(300 * SWEEP),
        "esc[0].esc_voltage": 15.9 + 0 * TIME,
    }
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", columns))
    assert "always 15.9, 600 samples; never changes: is it measured?" in found["thruster_0/state.supply_voltage"]
    found, _ = proposed(
        capsys, wide(tmp_path / "y.csv", {"t": TIME, "pwm": 1500 + 9 * SWEEP, "battery_V": 15.9 + 0 * TIME})
    )
    assert "measured?" not in found["thruster_0/state.supply_voltage"]
