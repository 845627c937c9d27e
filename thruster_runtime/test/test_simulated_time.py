from collections.abc import Callable

import pytest
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE
from thruster_runtime.simulated_time import share_clock

Graph = tuple[list[Node], Executor]


@pytest.fixture
def graph(context: Context, spun: Callable[..., Executor]) -> Graph:
    """Two nodes in simulated time and one that is not, sharing a clock, and who sets it."""
    simulated = [Parameter("use_sim_time", value=True)]
    nodes = [
        Node(name, context=context, parameter_overrides=overrides)
        for name, overrides in (("wall", []), ("a", simulated), ("b", simulated), ("source", []))
    ]
    share_clock(nodes)
    return nodes, spun(*nodes)


def now(node: Node) -> int:
    return int(node.get_clock().now().nanoseconds)


def test_one_subscription_moves_the_clocks_of_all_nodes_in_simulated_time(graph: Graph) -> None:
    (wall, a, b, source), executor = graph
    ticks = source.create_publisher(Clock, "/clock", RELIABLE)
    assert spin_until(executor, lambda: ticks.get_subscription_count() > 0, 10.0)
    assert [len([s for s in node.subscriptions if s.topic_name == "/clock"]) for node in (wall, a, b)] == [0, 1, 0]

    def publish(seconds: int) -> None:
        tick = Clock()
        tick.clock.sec = seconds
        ticks.publish(tick)

    publish(7)
    assert spin_until(executor, lambda: now(a) == now(b) == 7 * 10**9, 10.0)
    assert now(wall) > 10**18
    b.set_parameters([Parameter("use_sim_time", value=False)])
    publish(8)
    assert spin_until(executor, lambda: now(a) == 8 * 10**9, 10.0)
    assert now(b) > 10**18
    b.set_parameters([Parameter("use_sim_time", value=True)])
    assert spin_until(executor, lambda: ticks.get_subscription_count() == 2, 10.0)
    publish(9)
    assert spin_until(executor, lambda: now(a) == now(b) == 9 * 10**9, 10.0)


def test_nodes_in_wall_time_listen_to_no_clock(context: Context) -> None:
    node = Node("wall", context=context)
    share_clock([node])
    assert [s.topic_name for s in node.subscriptions if s.topic_name == "/clock"] == []
    node.destroy_node()
