"""A node's health on /diagnostics: at each change, and once a second so that silence means something."""

from collections.abc import Mapping
from typing import Literal

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.node import Node

from thruster_runtime.qos import RELIABLE

Level = Literal["ok", "warn", "error", "stale"]

_LEVELS: dict[Level, bytes] = {
    "ok": DiagnosticStatus.OK,
    "warn": DiagnosticStatus.WARN,
    "error": DiagnosticStatus.ERROR,
    "stale": DiagnosticStatus.STALE,
}


def diagnostic_status(
    name: str,
    level: Level,
    message: str,
    values: Mapping[str, object] | None = None,
    *,
    hardware_id: str = "",
) -> DiagnosticStatus:
    """Return a status; the keys of `values` carry their unit, e.g. "age [s]"."""
    return DiagnosticStatus(
        name=name,
        level=_LEVELS[level],
        message=message,
        hardware_id=hardware_id,
        values=[KeyValue(key=key, value=str(value)) for key, value in (values or {}).items()],
    )


class Diagnostics:
    """Publishes one node's health.

    A change is one of level or message; new values alone wait for the next second, since some change always.
    """

    def __init__(self, node: Node, *, hardware_id: str = "", period: float = 1.0, clock: Clock | None = None) -> None:
        """Begin to publish for `node`, every `period` [s] of `clock` (None: the node's own)."""
        self._node = node
        self._hardware_id = hardware_id
        self._told: tuple[Level, str, Mapping[str, object] | None] | None = None
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", RELIABLE)
        self._timer = node.create_timer(period, self._publish, clock=clock)

    def report(self, level: Level, message: str, values: Mapping[str, object] | None = None) -> None:
        """Set the node's health; nothing is published before the first report.

        Messages are made when they are published: nodes of one process report all at once, while others wait.
        """
        before, self._told = self._told, (level, message, values)
        if before is None or before[:2] != (level, message):
            self._publish()

    def _publish(self) -> None:
        if self._told is None:
            return
        name = self._node.get_fully_qualified_name()
        status = diagnostic_status(name, *self._told, hardware_id=self._hardware_id)
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)
