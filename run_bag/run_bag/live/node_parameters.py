"""The parameters of the nodes in the graph: asked for as nodes appear, and what is changed in them later."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.clock import Clock
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events
from rclpy.task import Future

from ..provenance import plain


class NodeParameters:
    """Asks each other node of the graph for its parameters, once; nodes without parameter services have none."""

    def __init__(
        self, node: Node, learned: Callable[[], None], *, period: float, clock: Clock, now: Callable[[], int]
    ) -> None:
        """Begin to ask; `learned` is called whenever there is more to tell.

        New nodes are looked for every `period` [s]; `now` is the time [ns] that a change is told to have happened at.
        """
        self.found: dict[str, dict[str, Any]] = {}
        self.changes: list[dict[str, Any]] = []
        self._now = now
        self._node = node
        self._learned = learned
        self._waiting: dict[str, tuple[Any, Any]] = {}
        self._known = {node.get_fully_qualified_name()}
        node.create_timer(period, self._look, clock=clock)
        node.create_subscription(ParameterEvent, "/parameter_events", self._on_event, qos_profile_parameter_events)

    def _look(self) -> None:
        for name, space in self._node.get_node_names_and_namespaces():
            full = f"{space.rstrip('/')}/{name}"
            if full not in self._known:
                self._known.add(full)
                lists = self._node.create_client(ListParameters, f"{full}/list_parameters")
                gets = self._node.create_client(GetParameters, f"{full}/get_parameters")
                self._waiting[full] = (lists, gets)
        for full, (lists, gets) in list(self._waiting.items()):
            if lists.service_is_ready() and gets.service_is_ready():
                del self._waiting[full]
                future = lists.call_async(ListParameters.Request())
                future.add_done_callback(lambda done, full=full, gets=gets: self._listed(full, gets, done))

    def _on_event(self, event: ParameterEvent) -> None:
        if not event.changed_parameters or event.node not in self.found:
            return
        values = {each.name: parameter_value_to_python(each.value) for each in event.changed_parameters}
        self.changes.append({"time [ns]": self._now(), "node": event.node, "values": plain(values)})
        self._learned()

    def _listed(self, full: str, gets: Any, done: Future) -> None:
        names = list(done.result().result.names)
        future = gets.call_async(GetParameters.Request(names=names))
        future.add_done_callback(lambda answer: self._got(full, names, answer))

    def _got(self, full: str, names: list[str], done: Future) -> None:
        values = [parameter_value_to_python(v) for v in done.result().values]
        self.found[full] = plain(dict(zip(names, values, strict=True)))
        self._learned()
