"""One subscription to `/clock` for all nodes of a process.

rclpy subscribes every node on its own, and makes a message of each tick for each of them: in lockstep a third of what
twelve composed nodes receive. The nodes' time sources stay as they are: a node that is told to leave simulated time,
or to come back to it, does as rclpy has it.
"""

from collections.abc import Callable, Sequence
from typing import Any

from rclpy.clock import ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rclpy.time_source import CLOCK_TOPIC, TimeSource
from rosgraph_msgs.msg import Clock

from thruster_runtime.records import listen

__all__ = ["share_clock"]

_QOS = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)  # that of rclpy's own subscription


def share_clock(nodes: Sequence[Node]) -> None:
    """Let the first of the nodes that use simulated time receive it for all of them; before they spin."""
    simulated = [node for node in nodes if node._time_source.ros_time_is_active]
    sources = [node._time_source for node in simulated]
    for node, source in zip(simulated, sources, strict=True):
        node.destroy_subscription(source._clock_sub)
        source._clock_sub = None
    if simulated:
        listen(simulated[0], Clock, CLOCK_TOPIC, _setting(sources), _QOS)


def _setting(sources: Sequence[TimeSource]) -> Callable[[Any], None]:
    def set_clocks(tick: Any) -> None:
        time = Time(nanoseconds=tick.clock, clock_type=ClockType.ROS_TIME)
        for source in sources:
            if source.ros_time_is_active and source._clock_sub is None:
                source._last_time_set = time
                for clock in source._associated_clocks:
                    clock.set_ros_time_override(time)

    return set_clocks
