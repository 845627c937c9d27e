"""A vehicle's whole graph in one process, with a listener that keeps what is said, and a recorder on request."""

import importlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from rov_sim.vehicle.graph import Experiment, GraphNode, graph_of
from rov_sim.vehicle.plant_node import PlantNode
from rov_sim.vehicle.sensors.settings_io import load_sensors
from run_bag.known_topics import KNOWN, KNOWN_VEHICLE
from run_bag.live.recorder_node import RecorderNode
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.hand_over import hand_over
from thruster_runtime.qos import RECORDER
from thruster_runtime.simulated_time import share_clock
from thruster_runtime.stamps import nanoseconds

__all__ = ["SCRIPT", "Graph", "Listener", "experiment_of", "made", "recorder_of"]

SCRIPT = "moves:\n  - {time: 0.2, shape: quintic, duration: 1.5, size: {surge: 0.2, pitch: 0.2}}\nend: 30.0\n"
PERIOD = 40_000_000  # ns


def kind_of(name: str) -> type:
    """Return a class that is named package/msg/Type or package.module:Class."""
    package, _, kind = name.replace("/msg/", ".msg:").partition(":")
    return getattr(importlib.import_module(package), kind)  # type: ignore[no-any-return]


def experiment_of(script: Path, **given: Any) -> Experiment:
    """Return an experiment with six thrusters that is not recorded, unless `given` says otherwise."""
    told = {"thrusters": 6, "sensors": load_sensors(), "recorded": False, "start_delay": 0.2, **given}
    return Experiment(script=str(script), **told)


def made(node: GraphNode, context: Context, change: Mapping[str, Any] | None = None) -> Node:
    """Return a node of the graph, with other parameters where `change` says so."""
    values = {**node.parameters, **(change or {})}
    return kind_of(node.kind)(  # type: ignore[no-any-return]
        context=context,
        cli_args=["--ros-args", "-r", f"__node:={node.name}"],
        parameter_overrides=[Parameter(name, value=value) for name, value in values.items()],
    )


def recorder_of(context: Context, out: Path, **given: Any) -> RecorderNode:
    """Return a recorder of all topics of the nodes."""
    told = {"use_sim_time": True, "out": str(out), "exclude": ["/parameter_events", "/rosout"], **given}
    return RecorderNode(
        context=context, parameter_overrides=[Parameter(name, value=value) for name, value in told.items()]
    )


class Listener(Node):
    """Keeps the payload of every message by stamp and topic, and what nodes say of their health."""

    def __init__(self, context: Context, thrusters: int) -> None:
        super().__init__("listener", context=context)
        self.content: list[tuple[int, str, str]] = []
        self.said: list[tuple[str, int, str]] = []
        """Node, level, words."""
        topics = {name: kind for name, kind in KNOWN_VEHICLE.items() if name not in ("rov/operator", "rov/scene")}
        names = ("state", "flow", "thrust_setpoint", "estimate", "throttle", "truth")
        topics |= {f"thruster_{i}/{name}": KNOWN[name] for i in range(thrusters) for name in names}
        for topic, kind in topics.items():
            self.create_subscription(kind_of(kind), topic, self._keeping(topic), RECORDER)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, RECORDER)

    def _keeping(self, topic: str) -> Callable[[Any], None]:
        def keep(message: Any) -> None:
            self.content.append((nanoseconds(message.header.stamp), topic, repr(message)))

        return keep

    def _on_diagnostics(self, array: DiagnosticArray) -> None:
        self.said += [(s.name.lstrip("/"), int.from_bytes(s.level, "little"), s.message) for s in array.status]

    def until(self, stamp: int) -> list[tuple[int, str, str]]:
        """Return what is stamped before [ns], sorted."""
        return sorted(entry for entry in self.content if entry[0] < stamp)

    def of(self, topic: str) -> list[tuple[int, str]]:
        """Return a topic's messages with their stamps [ns]."""
        return sorted((stamp, text) for stamp, name, text in self.content if name == topic)

    def heard_of(self, node: str, level: int, words: str) -> bool:
        """Return whether a node has said so, at this level or above."""
        return any(name == node and found >= level and words in text for name, found, text in self.said)


class Graph:
    """To be closed.

    `leave_out`: nodes that are not there; `change`: parameters by node; `record`: the run's folder; `beside`: makes
    more nodes.
    """

    def __init__(
        self,
        context: Context,
        script: Path,
        *,
        handing_over: bool = False,
        leave_out: tuple[str, ...] = (),
        change: Mapping[str, Mapping[str, Any]] | None = None,
        record: Path | None = None,
        beside: Callable[[Context], list[Node]] = lambda context: [],
        **given: Any,
    ) -> None:
        experiment = experiment_of(script, **{"recorded": record is not None, **given})
        self.nodes: dict[str, Node] = {}
        for node in graph_of(experiment):
            if node.name not in leave_out:
                self.nodes[node.name] = made(node, context, (change or {}).get(node.name))
        share_clock(list(self.nodes.values()))
        if handing_over:
            hand_over(list(self.nodes.values()))
        self.listener = Listener(context, experiment.thrusters)
        self.nodes["listener"] = self.listener
        self.nodes |= {node.get_name(): node for node in beside(context)}
        if record is not None:
            done = [f"/thruster_{i}/throttle" for i in range(experiment.thrusters)]
            self.nodes["recorder"] = recorder_of(context, record, acknowledge=done)
        self.executor = make_executor("events", context=context)
        for each in self.nodes.values():
            self.executor.add_node(each)

    @property
    def plant(self) -> PlantNode:
        node = self.nodes["plant"]
        assert isinstance(node, PlantNode)
        return node

    def run(self, periods: int, longest: float = 900.0) -> None:
        """Spin until so many periods have passed; `longest` [s] ends a graph that hangs, however busy the machine."""
        end = periods * self.plant._period
        assert spin_until(self.executor, lambda: self.plant.vehicle.time >= end, longest), self.plant.waiting_for()

    def until(self, happened: Callable[[], bool], longest: float = 900.0) -> bool:
        """Spin until something has happened."""
        return spin_until(self.executor, happened, longest)

    def close(self) -> None:
        """Stop all, the recorder first: its run is whole then."""
        if not self.nodes:
            return
        recorder = self.nodes.get("recorder")
        if isinstance(recorder, RecorderNode):
            recorder.on_stop()
        for node in self.nodes.values():
            self.executor.remove_node(node)
        self.executor.shutdown()
        for node in self.nodes.values():
            node.destroy_node()
        self.nodes = {}
