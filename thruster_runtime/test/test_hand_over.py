"""Records handed over between the nodes of an executor."""

from collections.abc import Callable
from typing import Any

import pytest
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node

from thruster_msgs.msg import Throttle
from thruster_runtime.executors import spin_until
from thruster_runtime.hand_over import hand_over
from thruster_runtime.records import RecordPublisher, format_of, listen

THROTTLES = format_of(Throttle)
Spun = Callable[..., Executor]


class Echo(Node):
    """Publishes on one topic what it hears on another one, up to a stamp; notes when it was called and when done."""

    def __init__(self, context: Context, name: str, hears: str, says: str, notes: list[tuple[str, int]]) -> None:
        super().__init__(name, context=context)
        self.notes = notes
        self.publisher = RecordPublisher(self, Throttle, says)
        listen(self, Throttle, hears, self._on_throttle)

    def _on_throttle(self, throttle: Any) -> None:
        self.notes.append((f"{self.get_name()} begins", throttle.stamp))
        if throttle.stamp < 4:
            self.publisher.publish(throttle._replace(stamp=throttle.stamp + 1))
        self.notes.append((f"{self.get_name()} ends", throttle.stamp))


def test_what_is_handed_over_waits_until_the_callback_has_returned(context: Context, spun: Spun) -> None:
    notes: list[tuple[str, int]] = []
    a, b = Echo(context, "a", "one", "two", notes), Echo(context, "b", "two", "one", notes)
    assert hand_over([a, b]) == ["/one", "/two"]
    a.publisher.publish(THROTTLES.record(stamp=1, frame_id="", commanded=1.0, sent=0.0))
    assert notes == [
        (f"{name} {what}", stamp)
        for stamp, name in ((1, "b"), (2, "a"), (3, "b"), (4, "a"))
        for what in ("begins", "ends")
    ]
    executor = spun(a, b)
    spin_until(executor, lambda: False, 0.3)
    assert len(notes) == 8, "nothing comes a second time through the middleware"


def test_other_processes_still_get_every_message_and_other_topics_still_come_in(context: Context, spun: Spun) -> None:
    notes: list[tuple[str, int]] = []
    a, b = Echo(context, "a", "outside", "between", notes), Echo(context, "b", "between", "out", notes)
    assert hand_over([a, b]) == ["/between"]
    other, heard = Node("other", context=context), []
    outside = other.create_publisher(Throttle, "outside", 10)
    for topic in ("between", "out"):
        listen(other, Throttle, topic, lambda throttle, topic=topic: heard.append((topic, throttle.stamp)))
    executor = spun(a, b, other)
    counts = (outside, a.publisher, b.publisher)
    assert spin_until(executor, lambda: all(each.get_subscription_count() == 1 for each in counts), 10.0)
    message = Throttle()
    message.header.stamp.nanosec = 1
    outside.publish(message)
    assert spin_until(executor, lambda: len(heard) == 2, 10.0)
    assert sorted(heard) == [("between", 2), ("out", 3)]


def test_an_error_in_a_callback_is_not_swallowed_and_the_next_message_is_heard(context: Context, spun: Spun) -> None:
    a, b, heard = Node("a", context=context), Node("b", context=context), []
    publisher = RecordPublisher(a, Throttle, "topic")

    def hear(throttle: Any) -> None:
        heard.append(throttle.stamp)
        if throttle.stamp == 1:
            raise RuntimeError("no")

    listen(b, Throttle, "topic", hear)
    hand_over([a, b])
    record = THROTTLES.record(stamp=1, frame_id="", commanded=1.0, sent=0.0)
    with pytest.raises(RuntimeError, match="no"):
        publisher.publish(record)
    publisher.publish(record._replace(stamp=2))
    assert heard == [1, 2]
    spun(a, b)
