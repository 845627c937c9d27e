"""A graph in one process for tests of nodes: private context, own executor, own domain, simulated clock."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from run_bag.live.recorder_node import RecorderNode
from run_bag.mcap_scan import scan
from run_bag.reader import read_recording
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.qos import RECORDER

TIMEOUT = 20.0
"""[s] After which a test has failed; nothing waits for it otherwise."""
OWN = ("/clock", "/diagnostics", "/parameter_events", "/rosout")


def domain_id() -> int:
    """Return the domain of this run of the tests, or of this process where none is set."""
    return int(os.environ["ROS_DOMAIN_ID"])


class Graph:
    """Nodes that are spun together."""

    def __init__(self, kind: str = "events") -> None:
        self.context = Context()
        rclpy.init(args=[], context=self.context, domain_id=domain_id())
        self.executor = make_executor(kind, context=self.context)
        self.nodes: list[Node] = []
        self.node = self.add(Node("subject", context=self.context))

    def add(self, node: Any) -> Any:
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def recorder(self, out: Path | str, **parameters: Any) -> RecorderNode:
        overrides = [Parameter(name, value=value) for name, value in {"out": str(out), **parameters}.items()]
        node: RecorderNode = self.add(RecorderNode(context=self.context, parameter_overrides=overrides))
        return node

    def publisher(self, kind: Any, name: str, qos: Any = RECORDER, heard_by: int = 1) -> Publisher:
        """Return a publisher that so many subscriptions hear."""
        publisher = self.node.create_publisher(kind, name, qos)
        self.until(lambda: publisher.get_subscription_count() >= heard_by)
        return publisher

    def until(self, predicate: Callable[[], bool], timeout: float = TIMEOUT) -> None:
        assert spin_until(self.executor, predicate, timeout)

    def stop(self, recorder: RecorderNode) -> None:
        """Stop a recorder as run_node does."""
        recorder.on_stop()
        self.remove(recorder)

    def remove(self, node: Node) -> None:
        self.nodes.remove(node)
        self.executor.remove_node(node)
        node.destroy_node()

    def close(self) -> None:
        for node in list(self.nodes):
            self.remove(node)
        self.executor.shutdown()
        rclpy.try_shutdown(context=self.context)


def clock_at(nanoseconds: int) -> Clock:
    message = Clock()
    message.clock.sec, message.clock.nanosec = divmod(nanoseconds, 10**9)
    return message


def messages(path: Path, without: tuple[str, ...] = OWN) -> list[tuple[str, int, int, bytes]]:
    """Return (topic, log time, publish time, payload) of a run in the order of the file."""
    found: list[tuple[str, int, int, bytes]] = []
    for one in read_recording(path, set()).scans:
        scan(one.path, receive=lambda m, raw: found.append((raw.topic, m.log_time, m.publish_time, m.payload)))
    return [row for row in found if row[0] not in without]
