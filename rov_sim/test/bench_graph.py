"""The live bench in one process: emulated bench, driver and others, with a listener, in a graph of its own."""

from collections.abc import Iterable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import WrenchStamped
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from bench_driver.driver_node import Driver
from rov_sim.emulated_bench_node import EmulatedBenchNode
from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterState, ThrusterTruth, ThrustSetpoint
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.qos import RECORDER
from thruster_runtime.stamps import nanoseconds

__all__ = ["Graph", "parameters"]

_HEARD = {
    "/clock": Clock, "thruster_0/state": ThrusterState, "thruster_0/flow": FlowVelocity,
    "thruster_0/throttle": Throttle, "thruster_0/throttle_sent": Throttle, "thruster_0/truth": ThrusterTruth,
    "daq/thruster_0/load": WrenchStamped, "thruster_0/thrust_setpoint": ThrustSetpoint,
    "/diagnostics": DiagnosticArray,
}  # fmt: skip


def parameters(**given: object) -> list[Parameter]:
    """Return overrides for a node."""
    return [Parameter(name, value=value) for name, value in given.items()]


class Graph:
    """To be closed. `heard`: all messages by topic."""

    def __init__(self, context: Context, *, driver: dict[str, Any] | None = None, **bench: Any) -> None:
        self.context = context
        given = {"noise": False, "settle": 0.1, **bench}
        self.bench = EmulatedBenchNode(context=context, parameter_overrides=parameters(**given))
        protocol, lockstep = given.get("protocol", "text"), given.get("lockstep", True)
        own = {
            "port": self.bench.bench.port,
            "protocol": protocol,
            "lockstep": lockstep,
            "quiet": 0.0,
            **(driver or {}),
        }
        self.driver = Driver(context=context, parameter_overrides=parameters(**own))
        self.listener = Node("listener", context=context)
        self.heard: dict[str, list[Any]] = {}
        for name, kind in _HEARD.items():
            self.heard[name] = []
            self.listener.create_subscription(kind, name, self.heard[name].append, RECORDER)
        self.executor = make_executor("events", context=context)
        self._nodes: list[Node] = []
        self.add(self.bench, self.driver, self.listener)

    def add(self, *nodes: Node) -> None:
        """Run more nodes in it."""
        for node in nodes:
            self.executor.add_node(node)
            self._nodes.append(node)

    def answer(self, throttle: float) -> None:
        """Answer each state with a throttle [V], as a controller does."""
        topic = self.listener.create_publisher(Throttle, "thruster_0/throttle", 10)

        def on_state(state: ThrusterState) -> None:
            message = Throttle(commanded=throttle, sent=float("nan"))
            message.header.stamp = state.header.stamp
            topic.publish(message)

        self.listener.create_subscription(ThrusterState, "thruster_0/state", on_state, RECORDER)

    def until(self, time: float, longest: float = 60.0) -> bool:
        """Spin until the simulated time [s] has come."""
        end = round(1e9 * time)
        return spin_until(
            self.executor,
            lambda: bool(self.heard["/clock"]) and nanoseconds(self.heard["/clock"][-1].clock) >= end,
            longest,
        )

    def stamps(self, name: str) -> list[int]:
        """Return the stamps of a topic's messages [ns]."""
        return [nanoseconds(message.header.stamp) for message in self.heard[name]]

    def statuses(self, node: str) -> Iterable[str]:
        """Return what a node has said on /diagnostics."""
        return [s.message for array in self.heard["/diagnostics"] for s in array.status if s.name == node]

    def close(self) -> None:
        """Stop all."""
        self.driver.on_stop()
        self.bench.on_stop()
        for node in self._nodes:
            self.executor.remove_node(node)
        self.executor.shutdown()
        for node in self._nodes:
            node.destroy_node()
