"""Outer loop and allocation of the vehicle: every `odometry` becomes one `thrust_setpoint` per thruster, of its stamp.

subscribes  rov/odometry, rov/setpoint, rov/thruster_failure; thruster_i/estimate where its inflow is used
publishes   thruster_i/thrust_setpoint, thruster_i/flow, rov/wrench, /diagnostics

What is stamped when and waits for what: `thruster_runtime.triggered_join`. Odometry in other frames than map_ned and
base_link_frd is not used: its signs would be wrong. Where odometry stays away the node asks for no thrust, once, after
`odometry_timeout` of its own clock, stamped next to the last odometry: what comes late after all is younger than that.
"""

import sys
from collections.abc import Callable, Mapping
from functools import partial
from math import isfinite, nan
from typing import Any

import numpy as np
from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node

from thruster_control.allocator_parameters import PARAMETERS, chosen_loop
from thruster_control.outer_loop.settings import VehicleSetPoint
from thruster_control.vehicle_loop import NOWHERE, Answer
from thruster_msgs.msg import FlowVelocity, ThrusterEstimate, ThrusterFailure, ThrustSetpoint, VehicleSetpoint
from thruster_runtime.join_health import JoinHealth
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import changeable, declare, refused
from thruster_runtime.records import RecordPublisher, format_of, listen
from thruster_runtime.triggered_join import Due, Input, TriggeredJoin, held

__all__ = ["AllocatorNode", "main"]

_THRUST, _WRENCH, _FLOW = map(format_of, (ThrustSetpoint, WrenchStamped, FlowVelocity))
_FRAMES = ("map_ned", "base_link_frd")


class AllocatorNode(Node):
    """Turns `rov/odometry`, `rov/setpoint`, `rov/thruster_failure` into `thrust_setpoint`, `flow` and `rov/wrench`.

    `flow` tells observers the inflow of the vehicle's own motion through still water, U = K_t^T nu as measured.
    """

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, compile the loop, then listen; `options` are those of rclpy's Node."""
        super().__init__("allocator", **options)
        values = declare(self, PARAMETERS)
        loop, problems = chosen_loop(values)
        if loop is None:
            raise refused(self, problems)
        self._loop = loop
        self._setpoint_timeout, self._silence, self._estimate_timeout = (
            round(values[name] * 1e9) for name in ("setpoint_timeout", "odometry_timeout", "estimate_timeout")
        )
        # Once beside the loop: the first message shall not wait for a compiler.
        self._loop.advance(None, (1.0, 0.0, 0.0, 0.0), np.zeros(6), NOWHERE, np.full(loop.thrusters, nan))
        inputs = {"setpoint": Input(timeout=self._setpoint_timeout, wait=values["wait_for_setpoint"])}
        self._inflows = [f"estimate_{i}" for i in range(loop.thrusters)] if values["estimated_inflow"] else []
        inputs |= {name: Input(timeout=self._estimate_timeout) for name in self._inflows}
        self._join = TriggeredJoin("odometry", inputs)
        self._health = JoinHealth(self, self._join)
        self._heard: int | None = None  # when odometry was heard last, by the node's clock [ns]; None: not, or told
        self._answered = 0  # the stamp of that odometry [ns]
        self._thrusts = [
            RecordPublisher(self, ThrustSetpoint, f"thruster_{i}/thrust_setpoint") for i in range(loop.thrusters)
        ]
        told = range(loop.thrusters) if values["flow"] == "kinematic" else ()
        self._flows = [RecordPublisher(self, FlowVelocity, f"thruster_{i}/flow") for i in told]
        self._wrenches = RecordPublisher(self, WrenchStamped, "rov/wrench")
        listen(self, VehicleSetpoint, "rov/setpoint", self._on_setpoint)
        listen(self, ThrusterFailure, "rov/thruster_failure", self._on_failure)
        for i, name in enumerate(self._inflows):
            listen(self, ThrusterEstimate, f"thruster_{i}/estimate", partial(self._on_estimate, name))
        listen(self, Odometry, "rov/odometry", self._on_odometry)
        self.create_timer(values["odometry_timeout"] / 4.0, self._on_timer)
        changeable(self, PARAMETERS, values, self._change)

    def _change(self, values: Mapping[str, Any]) -> tuple[Callable[[], None], list[str]]:
        """Gains take over little by little; what has failed and what is remembered stays."""
        other, problems = chosen_loop(values)

        def count() -> None:
            assert other is not None
            self._loop.take_up(other.law)

        return count, problems

    def on_stop(self) -> None:
        """Take the requests back."""
        self._publish_thrusts(self._thrusts[0].last_word(self), self._loop.thrusters * [nan])

    def _on_setpoint(self, sp: Any) -> None:
        self._take("setpoint", sp.stamp, VehicleSetPoint(*sp[2:]))

    def _on_estimate(self, name: str, estimate: Any) -> None:
        usable = estimate.status != ThrusterEstimate.STATUS_INVALID
        self._take(name, estimate.stamp, estimate.ambient if usable else nan)

    def _on_failure(self, failure: Any) -> None:
        wrong = self._loop.report(failure.thruster, failure.kind, failure.effectiveness, failure.stuck_thrust)
        if wrong:
            self.get_logger().warning(f"rov/thruster_failure: {wrong}: not used")

    def _on_odometry(self, odometry: Any) -> None:
        self._heard, self._answered = self.get_clock().now().nanoseconds, odometry.stamp
        self._take("odometry", odometry.stamp, odometry)

    def _take(self, name: str, stamp: int, kept: Any) -> None:
        for due in self._join.put(name, stamp, kept):
            self._control(due)

    def _control(self, due: Due) -> None:
        o = due.message
        frames = (o.frame_id, o.child_frame_id)
        if frames != _FRAMES:
            self._publish_thrusts(due.stamp, self._loop.thrusters * [0.0])
            words = f"odometry in {' and '.join(map(repr, frames))}: expected {' and '.join(_FRAMES)}: no thrust"
            self._health.report(due.stamp, "error", words)
            return
        q = (o.pose_pose_orientation_w, o.pose_pose_orientation_x, o.pose_pose_orientation_y, o.pose_pose_orientation_z)
        nu = np.array(o[11:17], dtype=np.float64)
        set_point = held(due, "setpoint", self._setpoint_timeout)
        U = np.full(self._loop.thrusters, nan)
        for i, name in enumerate(self._inflows):
            found = held(due, name, self._estimate_timeout)
            U[i] = nan if found is None or not isfinite(found) else found
        dt = None if due.former is None else (due.stamp - due.former) / 1e9
        answer = self._loop.advance(dt, q, nu, NOWHERE if set_point is None else set_point, U)
        self._publish_flows(due.stamp, nu)
        self._publish(due.stamp, answer)

    def _publish(self, stamp: int, answer: Answer) -> None:
        self._publish_thrusts(stamp, answer.thrusts.tolist())
        self._wrenches.publish(_WRENCH.record(stamp, _FRAMES[1], *answer.wrench.tolist()))
        self._health.report(stamp, answer.level, answer.words)

    def _publish_flows(self, stamp: int, nu: Any) -> None:
        for i, publisher in enumerate(self._flows):
            U = float(self._loop.inflow[:, i] @ nu)
            publisher.publish(_FLOW.record(stamp, f"thruster_{i}", axial=nan, ambient=U, quality=nan, spike=False))

    def _publish_thrusts(self, stamp: int, thrusts: list[float]) -> None:
        for publisher, thrust in zip(self._thrusts, thrusts, strict=True):
            publisher.publish(_THRUST.record(stamp=stamp, frame_id="", thrust=thrust))

    def _on_timer(self) -> None:
        now = self.get_clock().now().nanoseconds
        if self._heard is None or now - self._heard <= self._silence:
            return
        self._heard = None
        self._loop.restart()
        self._publish_thrusts(self._answered + 1, self._loop.thrusters * [0.0])
        self._health.report(now, "error", "no odometry: no thrust")


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(AllocatorNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
