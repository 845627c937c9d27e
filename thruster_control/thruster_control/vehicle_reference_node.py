"""Set points of the vehicle: one `rov/setpoint` for each tick, stamped as the tick, from a script or an operator.

subscribes  rov/odometry where that is the tick; rov/operator where that is the source
publishes   rov/setpoint, /diagnostics

A tick is an `odometry`, so that lockstep needs no clock, or a timer of the node's clock. An operator's vehicle begins
level on the heading that it has; without a message on `rov/operator` for `operator_timeout` it stops and keeps its
attitude.
"""

import sys
from collections.abc import Mapping
from functools import partial
from math import isfinite, nan
from typing import Any

from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from thruster_control.errors import ThrusterControlError
from thruster_control.operator_set_points import OperatorSettings, OperatorTrack, operated
from thruster_control.outer_loop.settings import VehicleSetPoint
from thruster_control.vehicle_set_points import set_point_at
from thruster_control.vehicle_set_points_io import load_script
from thruster_model.equations.attitude import euler_from_quaternion, normalised
from thruster_msgs.msg import VehicleSetpoint
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, changeable, declare, refused
from thruster_runtime.records import RecordPublisher, format_of, listen

__all__ = ["PARAMETERS", "VehicleReferenceNode", "main"]

_SETPOINT = format_of(VehicleSetpoint)
_NOWHERE = VehicleSetPoint(*5 * ((nan, nan, nan),))
_STICK = OperatorSettings()
_LIMITS = {
    "speed": ("m/s", "operator: largest speed along an axis"),
    "rate": ("rad/s", "operator: largest rate of roll, pitch, yaw"),
    "acceleration": ("m/s^2", "operator: ramp of the speeds"),
    "turning": ("rad/s^2", "operator: ramp of the rates"),
    "tilt": ("rad", "operator: largest roll and pitch"),
}
PARAMETERS = (
    Parameter(name="source", default="script", choices=("script", "operator"), description="who says where to go"),
    Parameter(name="script", default="hover", description="script of set points, by name or YAML file"),
    Parameter(
        name="start_delay", default=0.0, unit="s", lower=0.0, upper=3600.0,
        description="how long the script's beginning is held after the first tick",
    ),
    Parameter(
        name="wait_for", default="",
        description="a topic: the script's beginning is held before it has a publisher, such as recorder/recorded; "
        "empty: none",
    ),
    Parameter(
        name="operator_timeout", default=0.5, unit="s", lower=0.0, above=True, upper=10.0,
        description="silence of the operator after which the vehicle stops and keeps its attitude",
    ),
    *(
        Parameter(name=name, default=getattr(_STICK, name), unit=unit, lower=0.0, above=True, upper=100.0,
                  live=True, description=words)
        for name, (unit, words) in _LIMITS.items()
    ),
    Parameter(name="trigger", default="odometry", choices=("odometry", "timer"), description="what a tick is"),
    Parameter(
        name="period", default=0.04, unit="s", lower=0.0, above=True, upper=10.0, description="period of the timer"
    ),
)  # fmt: skip


class VehicleReferenceNode(Node):
    """Publishes `rov/setpoint`; subscribes `rov/odometry`, and `rov/operator` where it is the source."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, then tick; `options` are those of rclpy's Node."""
        super().__init__("vehicle_reference", **options)
        values = declare(self, PARAMETERS)
        try:
            self._script = load_script(values["script"])
        except ThrusterControlError as error:
            raise refused(self, [f"script: {line}" for line in str(error).split("\n")]) from error
        self._name, self._by_operator = values["script"], values["source"] == "operator"
        self._delay, self._timeout = (round(values[name] * 1e9) for name in ("start_delay", "operator_timeout"))
        self._wait_for: str = values["wait_for"]
        self._limit(values)
        self._first: int | None = None
        self._last = 0
        self._track: OperatorTrack | None = None
        self._stick: tuple[int, Any] | None = None
        self._diagnostics = Diagnostics(self)
        self._set_points = RecordPublisher(self, VehicleSetpoint, "rov/setpoint")
        self._ticks_by_odometry = values["trigger"] == "odometry"
        if self._by_operator:
            listen(self, TwistStamped, "rov/operator", self._on_operator)
        if self._by_operator or self._ticks_by_odometry:
            listen(self, Odometry, "rov/odometry", self._on_odometry)
        if not self._ticks_by_odometry:
            self.create_timer(values["period"], lambda: self._tick(self.get_clock().now().nanoseconds))
        changeable(self, PARAMETERS, values, lambda wanted: (partial(self._limit, wanted), []))

    def _limit(self, values: Mapping[str, Any]) -> None:
        self._limits = OperatorSettings(**{name: values[name] for name in OperatorSettings._fields})

    def on_stop(self) -> None:
        """Take the set point back."""
        self._publish(self._set_points.last_word(self), _NOWHERE)

    def _on_operator(self, twist: Any) -> None:
        moving = twist.twist_linear_x, twist.twist_linear_y, twist.twist_linear_z
        turning = twist.twist_angular_x, twist.twist_angular_y, twist.twist_angular_z
        self._stick = twist.stamp, (moving, turning)

    def _on_odometry(self, odometry: Any) -> None:
        if self._track is None:
            o = odometry
            q = (o.pose_pose_orientation_w, o.pose_pose_orientation_x, o.pose_pose_orientation_y,
                 o.pose_pose_orientation_z)  # fmt: skip
            if all(map(isfinite, q)) and any(q):
                self._track = OperatorTrack((0.0, 0.0, euler_from_quaternion(normalised(q))[2]))
        if self._ticks_by_odometry:
            self._tick(odometry.stamp)

    def _tick(self, now: int) -> None:
        if self._wait_for and self.count_publishers(self._wait_for):
            self._first, self._wait_for = None, ""
        if self._first is None or now < self._last:
            self._first = self._last = now  # the source of the ticks started again
        self._publish(now, self._operated(now) if self._by_operator else self._scripted(now - self._first))
        self._last = now

    def _scripted(self, since: int) -> VehicleSetPoint:
        time = 0.0 if self._wait_for else max(since - self._delay, 0) / 1e9
        if self._wait_for:
            words = f"holding the beginning of the script {self._name}: nobody publishes {self._wait_for}"
        elif time >= self._script.end:
            words = f"the script {self._name} has ended: no set point"
        else:
            words = f"following the script {self._name}"
        self._diagnostics.report("ok", words)
        return set_point_at(self._script, time)  # type: ignore[no-any-return]

    def _operated(self, now: int) -> VehicleSetPoint:
        if self._track is None:
            self._diagnostics.report("warn", "no set point: the vehicle's heading is not known yet")
            return _NOWHERE
        held = self._stick is not None and abs(now - self._stick[0]) <= self._timeout
        stick = self._stick[1] if held and self._stick is not None else None
        self._track, set_point = operated(self._track, stick, (now - self._last) / 1e9, self._limits)
        if held:
            self._diagnostics.report("ok", "an operator steers")
        else:
            self._diagnostics.report("warn", "no operator: the vehicle stops and keeps its attitude")
        return set_point

    def _publish(self, stamp: int, set_point: VehicleSetPoint) -> None:
        self._set_points.publish(_SETPOINT.record(stamp, "base_link_frd", *set_point))


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(VehicleReferenceNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
