"""Set points of thrust for one thruster: one `thrust_setpoint` for each tick, stamped as the tick.

A tick is a `state`, so that lockstep needs no clock, or a timer of the node's clock.
"""

import sys
from math import nan
from typing import Any

from rclpy.node import Node

from thruster_control.set_points import KINDS, SetPoint
from thruster_msgs.msg import ThrusterState, ThrustSetpoint
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.node_main import run_node
from thruster_runtime.parameters import Parameter, declare
from thruster_runtime.records import RecordPublisher, format_of, listen

__all__ = ["PARAMETERS", "ReferenceNode", "main"]

_SETPOINT = format_of(ThrustSetpoint)
PARAMETERS = (
    Parameter(name="thruster", default=0, lower=0, upper=99, description="index of the thruster"),
    Parameter(
        name="kind", default="constant", choices=KINDS,
        description="the rig's step, sine or ramp (also called triangle) of 10 s, or a constant",
    ),
    Parameter(name="level", default=0.0, unit="N", lower=-1000.0, upper=1000.0, description="thrust of the constant"),
    Parameter(
        name="start_delay", default=0.0, unit="s", lower=0.0, upper=3600.0,
        description="how long 0 N is asked for after the first tick",
    ),
    Parameter(
        name="repeats", default=1, lower=0, upper=1_000_000,
        description="runs of 10 s, after which 0 N is asked for; 0: without end",
    ),
    Parameter(
        name="trigger", default="state", choices=("state", "timer"), description="what a tick is",
    ),
    Parameter(
        name="period", default=0.04, unit="s", lower=0.0, above=True, upper=10.0, description="period of the timer"
    ),
)  # fmt: skip


class ReferenceNode(Node):
    """Publishes `thrust_setpoint`; subscribes `state` where that is the tick."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, then tick; `options` are those of rclpy's Node."""
        super().__init__("reference", **options)
        values = declare(self, PARAMETERS)
        self._set_point = SetPoint(**{name: values[name] for name in ("kind", "level", "start_delay", "repeats")})
        self._first: int | None = None
        self._last = 0
        self._diagnostics = Diagnostics(self)
        prefix = f"thruster_{values['thruster']}"
        self._set_points = RecordPublisher(self, ThrustSetpoint, f"{prefix}/thrust_setpoint")
        if values["trigger"] == "state":
            listen(self, ThrusterState, f"{prefix}/state", self._on_state)
        else:
            self.create_timer(values["period"], self._on_timer)

    def on_stop(self) -> None:
        """Take the request back."""
        self._publish(self.get_clock().now().nanoseconds, nan)

    def _on_state(self, state: Any) -> None:
        self._tick(state.stamp)

    def _on_timer(self) -> None:
        self._tick(self.get_clock().now().nanoseconds)

    def _tick(self, now: int) -> None:
        if self._first is None or now < self._last:
            self._first = now  # the source of the ticks started again
            self._diagnostics.report("ok", f"asking for thrust: {self._set_point.kind}")
        self._last = now
        self._publish(now, self._set_point.thrust(now - self._first))

    def _publish(self, stamp: int, thrust: float) -> None:
        self._set_points.publish(_SETPOINT.record(stamp=stamp, frame_id="", thrust=thrust))


def main() -> int:
    """Run the node until it is told to stop."""
    return run_node(ReferenceNode)


if __name__ == "__main__":
    sys.exit(main())
