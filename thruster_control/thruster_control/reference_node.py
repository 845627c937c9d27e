"""Set points of thrust for one thruster: one `thrust_setpoint` for each tick, stamped as the tick.

subscribes  thruster_i/state where that is the tick
publishes   thruster_i/thrust_setpoint, /diagnostics

A tick is a `state`, so that lockstep needs no clock, or a timer of the node's clock.
"""

import sys
from collections.abc import Callable, Mapping
from math import nan
from typing import Any

from rclpy.node import Node

from thruster_control.set_points import KINDS, SetPoint
from thruster_msgs.msg import ThrusterState, ThrustSetpoint
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, changeable, declare
from thruster_runtime.records import RecordPublisher, format_of, listen

__all__ = ["PARAMETERS", "ReferenceNode", "main"]

_SETPOINT = format_of(ThrustSetpoint)
PARAMETERS = (
    Parameter(name="thruster", default=0, lower=0, upper=99, description="index of the thruster"),
    Parameter(
        name="kind", default="constant", choices=KINDS, live=True,
        description="the rig's step, sine or ramp (also called triangle) of 10 s, or a constant",
    ),
    Parameter(
        name="level", default=0.0, unit="N", lower=-1000.0, upper=1000.0, live=True,
        description="thrust of the constant",
    ),
    Parameter(
        name="start_delay", default=0.0, unit="s", lower=0.0, upper=3600.0,
        description="how long 0 N is asked for after the first tick",
    ),
    Parameter(
        name="wait_for", default="",
        description="a topic: no thrust is asked for before it has a publisher, such as recorder/recorded; empty: none",
    ),
    Parameter(
        name="repeats", default=1, lower=0, upper=1_000_000, live=True,
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
        self._set_point = self._chosen(values)
        self._wait_for: str = values["wait_for"]
        self._first: int | None = None
        self._last = 0
        self._diagnostics = Diagnostics(self)
        prefix = f"thruster_{values['thruster']}"
        self._set_points = RecordPublisher(self, ThrustSetpoint, f"{prefix}/thrust_setpoint")
        if values["trigger"] == "state":
            listen(self, ThrusterState, f"{prefix}/state", self._on_state)
        else:
            self.create_timer(values["period"], self._on_timer)
        changeable(self, PARAMETERS, values, self._change)

    @staticmethod
    def _chosen(values: Mapping[str, Any]) -> SetPoint:
        return SetPoint(**{name: values[name] for name in ("kind", "level", "start_delay", "repeats")})

    def _change(self, values: Mapping[str, Any]) -> tuple[Callable[[], None], list[str]]:
        """A level counts from the next tick on; another kind begins with it, without a delay."""
        wanted = self._chosen(values)

        def count() -> None:
            if wanted.kind != self._set_point.kind and self._first is not None:
                self._first = self._last - round(1e9 * wanted.start_delay)
                self._diagnostics.report("ok", f"asking for thrust: {wanted.kind}")
            self._set_point = wanted

        return count, []

    def on_stop(self) -> None:
        """Take the request back."""
        self._publish(self._set_points.last_word(self), nan)

    def _on_state(self, state: Any) -> None:
        self._tick(state.stamp)

    def _on_timer(self) -> None:
        self._tick(self.get_clock().now().nanoseconds)

    def _tick(self, now: int) -> None:
        if self._wait_for and not self.count_publishers(self._wait_for):
            self._diagnostics.report("ok", f"not asking for thrust yet: nobody publishes {self._wait_for}")
            self._publish(now, nan)
            return
        self._wait_for = ""
        if self._first is None or now < self._last:
            self._first = now  # the source of the ticks started again
            self._diagnostics.report("ok", f"asking for thrust: {self._set_point.kind}")
        self._last = now
        self._publish(now, self._set_point.thrust(now - self._first))

    def _publish(self, stamp: int, thrust: float) -> None:
        self._set_points.publish(_SETPOINT.record(stamp=stamp, frame_id="", thrust=thrust))


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(ReferenceNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
