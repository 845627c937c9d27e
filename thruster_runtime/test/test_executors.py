from collections.abc import Iterator

import pytest
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from std_msgs.msg import Float64

from thruster_runtime.executors import (
    EXECUTOR_KINDS,
    UnknownExecutor,
    make_executor,
    spin_until,
    unsuitable_callbacks,
)
from thruster_runtime.qos import RECORDER, RELIABLE


@pytest.fixture
def node(context: Context) -> Iterator[Node]:
    node = Node("subject", context=context)
    yield node
    node.destroy_node()


@pytest.fixture(params=EXECUTOR_KINDS)
def executor(request: pytest.FixtureRequest, context: Context, node: Node) -> Iterator[Executor]:
    executor = make_executor(request.param, context=context)
    executor.add_node(node)
    yield executor
    executor.remove_node(node)
    executor.shutdown()


def test_every_message_of_a_burst_within_the_recorders_queue_arrives(executor: Executor, node: Node) -> None:
    received: list[float] = []
    node.create_subscription(Float64, "value", lambda message: received.append(message.data), RECORDER)
    publisher = node.create_publisher(Float64, "value", RECORDER)
    assert spin_until(executor, lambda: publisher.get_subscription_count() == 1, 10.0)
    for i in range(1000):
        publisher.publish(Float64(data=float(i)))
    assert spin_until(executor, lambda: len(received) == 1000, 10.0)
    assert received == [float(i) for i in range(1000)]


def test_a_burst_longer_than_the_queue_keeps_its_last_messages(executor: Executor, node: Node) -> None:
    received: list[float] = []
    node.create_subscription(Float64, "value", lambda message: received.append(message.data), RELIABLE)
    publisher = node.create_publisher(Float64, "value", RELIABLE)
    assert spin_until(executor, lambda: publisher.get_subscription_count() == 1, 10.0)
    for i in range(50):
        publisher.publish(Float64(data=float(i)))
    assert spin_until(executor, lambda: 49.0 in received, 10.0)
    assert received[-1] == 49.0
    assert received == sorted(received)


def test_an_error_in_a_callback_reaches_the_caller(executor: Executor, node: Node) -> None:
    def fail() -> None:
        raise RuntimeError("evidence")

    node.create_timer(0.001, fail)
    with pytest.raises(RuntimeError, match="evidence"):
        spin_until(executor, lambda: False, 10.0)


def test_spin_until_gives_up_at_its_deadline(executor: Executor) -> None:
    now = [0.0]

    def monotonic() -> float:
        now[0] += 0.02
        return now[0]

    assert not spin_until(executor, lambda: False, 0.1, monotonic=monotonic)
    assert now[0] == pytest.approx(0.12)


def test_spin_until_returns_at_once_when_the_predicate_holds(executor: Executor) -> None:
    assert spin_until(executor, lambda: True, 0.0)


def test_an_unknown_executor_is_refused_by_name(context: Context) -> None:
    with pytest.raises(UnknownExecutor, match="expected one of events, single, got 'multi'"):
        make_executor("multi", context=context)


def test_callbacks_that_the_events_executor_cannot_run_are_found(node: Node) -> None:
    async def later(message: Float64) -> None: ...

    async def tick() -> None: ...

    def with_information(message: Float64, information: dict[str, int]) -> None: ...

    node.create_subscription(Float64, "a", later, RELIABLE)
    node.create_subscription(Float64, "b", with_information, RELIABLE)
    node.create_subscription(Float64, "c", lambda message: None, RELIABLE)
    node.create_timer(2.0, tick)
    assert unsuitable_callbacks(node) == [
        "the callback of topic /a is async",
        "the callback of a timer of 2 s is async",
        "the callback of topic /b takes message information",
    ]
