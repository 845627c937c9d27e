from collections.abc import Callable

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock as ClockMessage

from thruster_runtime.diagnostics import Diagnostics, diagnostic_status
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE


class Scene:
    """A node with simulated time, and a listener that also moves the clock."""

    def __init__(self, context: Context, spun: Callable[..., Executor]) -> None:
        simulated = Parameter("use_sim_time", value=True)
        self.node = Node("subject", context=context, parameter_overrides=[simulated])
        self.listener = Node("listener", context=context)
        self.arrays: list[DiagnosticArray] = []
        self.listener.create_subscription(DiagnosticArray, "/diagnostics", self.arrays.append, RELIABLE)
        self.clock = self.listener.create_publisher(ClockMessage, "/clock", RELIABLE)
        self.executor = spun(self.node, self.listener, kind="single")
        self.diagnostics = Diagnostics(self.node)
        assert spin_until(self.executor, self._connected, 10.0)

    def _connected(self) -> bool:
        heard = self.node.count_subscribers("/diagnostics") == 1
        return heard and self.clock.get_subscription_count() == 1

    def set_time(self, seconds: int) -> None:
        message = ClockMessage()
        message.clock.sec = seconds
        self.clock.publish(message)
        assert spin_until(self.executor, lambda: self.now() == seconds, 10.0)

    def now(self) -> float:
        return self.node.get_clock().now().nanoseconds / 1e9

    def messages_after(self, count: int) -> list[str]:
        assert spin_until(self.executor, lambda: len(self.arrays) >= count, 10.0), self.arrays
        spin_until(self.executor, lambda: len(self.arrays) > count, 0.2)
        return [array.status[0].message for array in self.arrays]


@pytest.fixture
def scene(context: Context, spun: Callable[..., Executor]) -> Scene:
    return Scene(context, spun)


def test_a_status_carries_level_message_and_values_as_text() -> None:
    status = diagnostic_status("driver", "warn", "late", {"age [s]": 0.25}, hardware_id="bench")
    assert status == DiagnosticStatus(
        level=DiagnosticStatus.WARN,
        name="driver",
        message="late",
        hardware_id="bench",
        values=[KeyValue(key="age [s]", value="0.25")],
    )


def test_a_change_is_published_at_once_and_a_repetition_is_not(scene: Scene) -> None:
    scene.diagnostics.report("ok", "running")
    scene.diagnostics.report("ok", "running", {"age [s]": 0.1})
    scene.diagnostics.report("warn", "late")
    assert scene.messages_after(2) == ["running", "late"]
    assert scene.arrays[0].status[0].name == "/subject"


def test_the_last_status_is_repeated_each_second_of_the_nodes_clock(scene: Scene) -> None:
    scene.set_time(100)
    scene.messages_after(0)  # the timer's first tick, overdue since time 0
    scene.diagnostics.report("ok", "running")
    assert scene.messages_after(1) == ["running"]
    scene.diagnostics.report("ok", "running", {"age [s]": 0.1})
    for second in (102, 104):
        count = len(scene.arrays)
        scene.set_time(second)
        scene.messages_after(count + 1)
    assert [array.header.stamp.sec for array in scene.arrays] == [100, 102, 104]
    assert [len(array.status[0].values) for array in scene.arrays] == [0, 1, 1]


def test_nothing_is_published_before_the_first_report(scene: Scene) -> None:
    for second in (100, 102):
        scene.set_time(second)
    assert scene.messages_after(0) == []
