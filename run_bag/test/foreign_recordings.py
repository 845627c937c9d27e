"""Recordings as others make them, written by their own libraries: ROS 1, sqlite3, ArduPilot's logs."""

import struct
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND
COUNT = 50
PERIOD = SECOND // 25


def stamps():
    return [START + k * PERIOD for k in range(COUNT)]


def throttle_us(k: int) -> float:
    """A command in microseconds: at rest, forward, backward."""
    return 1500.0 + (0.0 if k < 10 else 160.0 if k < 30 else -160.0)


def speed_rpm(k: int) -> float:
    return (throttle_us(k) - 1500.0) * 10.0


def ros1_bag(path: Path) -> Path:
    """JointState-like floats under names of a vehicle's own."""
    store = get_typestore(Stores.ROS1_NOETIC)
    vector, header, time = (
        store.types[f"{n}"]
        for n in ("geometry_msgs/msg/Vector3Stamped", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    number = store.types["std_msgs/msg/Float64"]
    with Ros1Writer(path) as writer:
        pwm = writer.add_connection("/motor/pwm", "std_msgs/msg/Float64", typestore=store)
        motor = writer.add_connection("/motor/state", "geometry_msgs/msg/Vector3Stamped", typestore=store)
        for k, at in enumerate(stamps()):
            writer.write(pwm, at, store.serialize_ros1(number(throttle_us(k)), pwm.msgtype))
            three = store.types["geometry_msgs/msg/Vector3"](speed_rpm(k), float(k), 0.0)
            head = header(k, time(at // SECOND, at % SECOND), "motor")
            writer.write(motor, at, store.serialize_ros1(vector(head, three), motor.msgtype))
    return path


def ros2_bag(path: Path, storage: StoragePlugin, mode: CompressionMode = CompressionMode.NONE) -> Path:
    store = get_typestore(Stores.ROS2_JAZZY)
    number = store.types["std_msgs/msg/Float64"]
    writer = Ros2Writer(path, version=9, storage_plugin=storage)
    if mode is not CompressionMode.NONE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        pwm = writer.add_connection("/motor/pwm", "std_msgs/msg/Float64", typestore=store)
        rpm = writer.add_connection("/motor/rpm", "std_msgs/msg/Float64", typestore=store)
        for k, at in enumerate(stamps()):
            writer.write(pwm, at, store.serialize_cdr(number(throttle_us(k)), pwm.msgtype))
            writer.write(rpm, at, store.serialize_cdr(number(speed_rpm(k)), rpm.msgtype))
    return path


def message_format(kind: int, length: int, name: str, form: str, columns: str) -> bytes:
    body = struct.pack("<BB4s16s64s", kind, length, name.encode(), form.encode(), columns.encode())
    return b"\xa3\x95\x80" + body


def autopilot_log(path: Path, *, escs: int = 2) -> Path:
    """A dataflash log: outputs, ESCs with units, of which the first alone turns, the battery."""
    data = message_format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    data += message_format(1, 3 + 8 + 1 + 64, "UNIT", "QbZ", "TimeUS,Id,Label")
    data += message_format(2, 3 + 8 + 1 + 16 + 16, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")
    data += message_format(10, 3 + 8 + 4, "RCOU", "QHH", "TimeUS,C1,C2")
    data += message_format(11, 3 + 8 + 1 + 4 + 4, "ESC", "QBff", "TimeUS,Instance,RPM,Volt")
    data += message_format(12, 3 + 8 + 2, "BAT", "Qc", "TimeUS,Volt")
    for letter, label in (("s", "s"), ("#", "instance"), ("q", "rpm"), ("v", "V"), ("Y", "us")):
        data += b"\xa3\x95\x01" + struct.pack("<Qb64s", 0, ord(letter), label.encode())
    for kind, units in ((10, "sYY"), (11, "s#qv"), (12, "sv")):
        data += b"\xa3\x95\x02" + struct.pack("<QB16s16s", 0, kind, units.encode(), b"F---")
    for k in range(COUNT):
        at = 5_000_000 + k * 40_000
        data += b"\xa3\x95\x0a" + struct.pack("<QHH", at, int(throttle_us(k)), 1500)
        for i in range(escs):
            data += b"\xa3\x95\x0b" + struct.pack("<QBff", at, i, speed_rpm(k) * (1 - i), 15.5)
        data += b"\xa3\x95\x0c" + struct.pack("<Qh", at, 1550)
    path.write_bytes(data)
    return path


def telemetry_log(path: Path) -> Path:
    """A ground station's log: packets of MAVLink 2, each behind its time of arrival."""
    from pymavlink.dialects.v20 import ardupilotmega as link

    sender, station = link.MAVLink(None, srcSystem=1, srcComponent=1), link.MAVLink(None, srcSystem=255)
    data = b""
    for k, at in enumerate(stamps()):
        messages = [
            (sender, sender.servo_output_raw_encode(k, 0, int(throttle_us(k)), *[1500] * 7)),
            (sender, sender.esc_telemetry_1_to_4_encode([0] * 4, [1550] * 4, [100] * 4, [0] * 4,
                                                        [int(abs(speed_rpm(k))), 0, 0, 0], [0] * 4)),
            (station, station.heartbeat_encode(6, 8, 0, 0, 0)),
            (sender, sender.heartbeat_encode(12, 3, 0, 0, 0)),
        ]  # fmt: skip
        for who, message in messages:
            data += (at // 1000).to_bytes(8, "big") + bytes(message.pack(who))
    path.write_bytes(data)
    return path


def table(path: Path, *, separator: str = ",", comma: bool = False, rows: int = COUNT) -> Path:
    """A csv with units in its header."""
    lines = [separator.join(["time [ms]", "PWM (us)", "rpm", "Thrust [kgf]"])]
    for k in range(rows):
        cells = [f"{k * 40.0:.1f}", f"{throttle_us(k % COUNT):.1f}", f"{speed_rpm(k % COUNT):.2f}", f"{np.sin(k):.4f}"]
        lines.append(separator.join(c.replace(".", ",") if comma else c for c in cells))
    path.write_text("\n".join(lines) + "\n")
    return path
