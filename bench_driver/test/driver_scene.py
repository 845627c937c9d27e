"""The driver's node with a device on a line inside the test, in time that the test moves, and a listener."""

import math
from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from fake_line import FakeLine
from geometry_msgs.msg import WrenchStamped
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.parameter import Parameter

from bench_driver.driver_node import Driver
from bench_driver.link_records import LinkState
from thruster_msgs.msg import FlowVelocity, LoadCellGauges, Throttle, ThrusterState
from thruster_runtime.executors import spin_until
from thruster_runtime.qos import RELIABLE

__all__ = ["Scene"]

_STEP = 0.005  # s
_SPEEDS = {"text": 9600, "frames": 115200}


class Scene:
    """Driver and device in real time that the test makes; commands and answers travel through the graph.

    Attributes:
        throttle: published every 20 ms [V]; None: nothing.
    """

    def __init__(
        self, context: Context, spun: Callable[..., Executor], protocol: str = "frames", **parameters: object
    ) -> None:
        self.now, self.throttle = 50.0, None  # type: tuple[float, float | None]
        self.line = FakeLine(_SPEEDS[protocol])
        given = {"port": "fake", "protocol": protocol, "quiet": 0.0, "poll": 0.02, **parameters}
        overrides = [Parameter(name, value=value) for name, value in given.items()]
        self.driver = Driver(
            monotonic=lambda: self.now, open_port=self.line.open, context=context, parameter_overrides=overrides
        )
        self.link = self.driver._link
        self.node = Node("listener", context=context)
        self.heard: dict[str, list[object]] = {}
        for name, kind in (
            ("thruster_0/state", ThrusterState), ("thruster_0/flow", FlowVelocity), ("thruster_0/load", WrenchStamped),
            ("thruster_0/gauges", LoadCellGauges), ("thruster_0/throttle_sent", Throttle),
            ("/diagnostics", DiagnosticArray),
        ):  # fmt: skip
            self.heard[name] = []
            self.node.create_subscription(kind, name, self.heard[name].append, RELIABLE)
        self.commands = self.node.create_publisher(Throttle, "thruster_0/throttle", RELIABLE)
        self.executor = spun(self.driver, self.node, kind="single")
        assert spin_until(self.executor, self._connected, 10.0)

    def _connected(self) -> bool:
        heard = self.node.count_publishers("/diagnostics") == 1 and self.node.count_publishers("thruster_0/state") == 1
        return heard and self.commands.get_subscription_count() == 1

    def command(self, throttle: float) -> None:
        """Publish a throttle [V] for now."""
        message = Throttle(commanded=throttle, sent=math.nan)
        message.header.stamp = self.driver.get_clock().now().to_msg()
        self.commands.publish(message)

    def run(self, time: float) -> None:
        """Let a time [s] pass."""
        for k in range(round(time / _STEP)):
            self.line.advance(_STEP)
            self.now += _STEP
            if self.throttle is not None and k % 4 == 0:
                before = self.driver._pace._asked.copy()  # type: ignore[union-attr]
                self.command(self.throttle)
                spin_until(self.executor, lambda b=before: self.driver._pace._asked != b, 1.0)  # type: ignore[misc, union-attr]
            self.driver.look()
            if k % 20 == 0:
                self.driver.report()

    def drive(self, throttle: float = 2.0) -> None:
        """Get ready and drive for half a second."""
        self.throttle = throttle
        for _ in range(100):
            if self.link.state is LinkState.READY:
                break
            self.run(0.1)
        assert self.link.state is LinkState.READY, self.link.reason
        self.run(0.5)
        assert abs(self.line.throttle - throttle) < 0.03

    def spin(self, predicate: Callable[[], object], timeout: float = 10.0) -> bool:
        """Deliver messages until the predicate holds."""
        return spin_until(self.executor, lambda: bool(predicate()), timeout)

    def says(self, level: bytes, part: str) -> bool:
        """Deliver until /diagnostics has said it since the last time it was asked for."""
        self.driver.report()
        found = self.spin(lambda: any(s.level == level and part in s.message for s in self.statuses()), 3.0)
        if not found:
            raise AssertionError(f"expected {part!r}; heard {[s.message for s in self.statuses()]}")
        self.heard["/diagnostics"].clear()
        return found

    def statuses(self) -> list[DiagnosticStatus]:
        """Return what /diagnostics has said."""
        return [status for array in self.heard["/diagnostics"] for status in array.status]  # type: ignore[attr-defined]
