import math
import struct
from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import WrenchStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.serialization import deserialize_message, serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Header

from thruster_msgs.msg import FlowVelocity, ThrusterEstimate, ThrusterState, ThrustSetpoint
from thruster_runtime.executors import EXECUTOR_KINDS, spin_until
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import RecordPublisher, UnreadableBytes, UnreadableType, ends_of, format_of, listen

texts = st.text(st.characters(min_codepoint=1, exclude_categories=["Cs"]), max_size=20)
numbers = st.floats(allow_nan=False)
times = st.builds(Time, sec=st.integers(-(2**31), 2**31 - 1), nanosec=st.integers(0, 10**9 - 1))
headers = st.builds(Header, stamp=times, frame_id=texts)
Spun = Callable[..., Executor]


def of(kind: type, data: bytes | Any) -> Any:
    return format_of(kind).read(data if isinstance(data, bytes) else serialize_message(data))


@settings(max_examples=100, deadline=None)
@given(headers, st.lists(numbers, min_size=12, max_size=12), texts, texts, st.integers(0, 255))
def test_a_record_has_what_the_message_has_and_is_written_as_that_message(
    header: Header, values: list[float], estimator: str, reason: str, status: int
) -> None:
    message = ThrusterEstimate(header=header, estimator=estimator, reason=reason, status=status)
    message.n, message.v, message.ambient = values[:3]
    message.covariance = values[3:]
    record = of(ThrusterEstimate, message)
    assert record == (
        header.stamp.sec * 10**9 + header.stamp.nanosec, header.frame_id, *values[:3], tuple(values[3:]), estimator,
        status, reason,
    )  # fmt: skip
    written = format_of(ThrusterEstimate).write(record)
    assert len(written) == len(serialize_message(message))
    assert deserialize_message(written, ThrusterEstimate) == message


@pytest.mark.parametrize("frame", ["", "a", "ab", "abc", "abcd", "abcde", "abcdef", "abcdefg", "abcdefgh", "é"])
def test_fields_are_found_by_name_whatever_the_length_of_the_text_before_them(frame: str) -> None:
    header = Header(stamp=Time(sec=3, nanosec=5), frame_id=frame)
    flow = of(FlowVelocity, FlowVelocity(header=header, axial=math.nan, ambient=0.25, quality=0.5, spike=True))
    assert (flow.stamp, flow.frame_id, flow.ambient, flow.quality, flow.spike) == (
        3_000_000_005,
        frame,
        0.25,
        0.5,
        True,
    )
    assert math.isnan(flow.axial)
    assert repr(of(FlowVelocity, format_of(FlowVelocity).write(flow))) == repr(flow)
    wrench = WrenchStamped(header=header)
    wrench.wrench.force.x, wrench.wrench.torque.z = -1.5, 2.5
    load = of(WrenchStamped, wrench)
    assert (load.wrench_force_x, load.wrench_force_y, load.wrench_torque_z) == (-1.5, 0.0, 2.5)


def test_a_message_without_header_keeps_the_name_of_its_stamp() -> None:
    assert of(Clock, Clock(clock=Time(sec=-1, nanosec=1)))._asdict() == {"clock": -999_999_999}


def test_bytes_of_another_order_are_read_as_what_they_are() -> None:
    written = b"\0\0\0\0" + struct.pack(">iII4sd", 1, 2, 4, b"abc\0", 12.5)
    assert of(ThrustSetpoint, written) == (1_000_000_002, "abc", 12.5)


def test_another_encoding_than_plain_cdr_is_refused() -> None:
    with pytest.raises(UnreadableBytes, match=r"expected the encapsulation of plain CDR .* found 00 07"):
        of(ThrustSetpoint, b"\0\7\0\0" + bytes(30))


def test_texts_of_other_lengths_are_read_anew_also_where_the_message_is_as_long() -> None:
    for estimator, reason in (("ab", "c"), ("a", "bcdefgh"), ("abcdefgh", ""), ("ab", "d")):
        estimate = ThrusterEstimate(estimator=estimator, n=1.5, status=2, reason=reason)
        record = of(ThrusterEstimate, estimate)
        assert (record.estimator, record.n, record.status, record.reason) == (estimator, 1.5, 2, reason)


@pytest.mark.parametrize("spoiled", [b"", b"\0", b"\0\1\0\0", bytes(4) + b"\xff" * 40, "shorter", "longer"])
def test_bytes_that_are_no_such_message_are_refused(spoiled: bytes | str) -> None:
    whole = bytes(serialize_message(ThrustSetpoint(header=Header(frame_id="abc"), thrust=1.0)))
    data = {"shorter": whole[:-1], "longer": whole + bytes(4)}.get(str(spoiled), spoiled)
    with pytest.raises(UnreadableBytes, match="payload: "):
        of(ThrustSetpoint, data)


def test_a_text_that_is_no_utf_8_is_read_as_rclpy_reads_it() -> None:
    good = ThrusterEstimate(header=Header(frame_id="abc"), estimator="ekf", n=1.5, reason="none")
    data = bytes(serialize_message(good)).replace(b"abc", b"a\xff\xfe").replace(b"none", b"\xc3\x28\xed\xa0")
    message = deserialize_message(data, ThrusterEstimate)
    for _ in range(2):  # learnt, then known
        record = of(ThrusterEstimate, data)
        assert (record.frame_id, record.reason) == (message.header.frame_id, message.reason)
        assert "\ufffd" in record.frame_id and record.n == 1.5
    assert deserialize_message(format_of(ThrusterEstimate).write(record), ThrusterEstimate) == message


def test_a_number_that_its_field_cannot_hold_is_not_written() -> None:
    setpoint = format_of(ThrustSetpoint)
    with pytest.raises(struct.error):
        setpoint.write(setpoint.record(stamp=2**63, frame_id="", thrust=0.0))


def test_a_type_with_a_sequence_is_refused_by_its_field() -> None:
    with pytest.raises(UnreadableType, match=r"DiagnosticStatus: field 'values': .* sequence"):
        format_of(DiagnosticStatus)


@pytest.mark.parametrize("kind", EXECUTOR_KINDS)
def test_a_listener_gets_records_and_a_subscription_messages_of_what_is_published(
    context: Context, spun: Spun, kind: str
) -> None:
    node, heard, messages = rclpy.create_node("listener", context=context), [], []
    publisher = RecordPublisher(node, ThrusterState, "state")
    listen(node, ThrusterState, "state", heard.append)
    node.create_subscription(ThrusterState, "state", messages.append, RELIABLE)
    executor = spun(node, kind=kind)
    assert spin_until(executor, lambda: publisher.get_subscription_count() == 2, 10.0)
    message = ThrusterState(n=60.0, sign_source=ThrusterState.SIGN_MEASURED, supply_voltage=12.0)
    message.header.stamp.sec, message.header.frame_id = 3, "thruster_0"
    record = of(ThrusterState, message)
    publisher.publish(record)
    assert spin_until(executor, lambda: bool(heard) and bool(messages), 10.0)
    assert (heard, messages) == ([record], [message])


@pytest.mark.parametrize("kind", EXECUTOR_KINDS)
def test_bytes_of_anyone_do_not_end_a_listener_and_the_next_message_is_heard(
    context: Context, spun: Spun, kind: str
) -> None:
    node, heard = rclpy.create_node("listener", context=context), []
    publisher = node.create_publisher(ThrusterState, "state", RELIABLE)
    listen(node, ThrusterState, "state", heard.append)
    (listener,) = ends_of(node).listeners
    executor = spun(node, kind=kind)
    assert spin_until(executor, lambda: publisher.get_subscription_count() == 1, 10.0)
    good = bytes(serialize_message(ThrusterState(header=Header(frame_id="abcd"), n=60.0)))
    for data in (good[:-20], good + bytes(4), good.replace(b"abcd", b"\xff\xfe\xfd\xfc"), good):
        publisher.publish(data)
    assert spin_until(executor, lambda: len(heard) == 2, 10.0)
    assert [record.frame_id for record in heard] == ["\ufffd" * 4, "abcd"]
    assert listener.passed_over == 2
