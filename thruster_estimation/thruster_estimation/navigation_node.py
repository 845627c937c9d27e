"""The navigation of a vehicle: IMU, velocity log and depth become `rov/odometry` at the control rate.

subscribes  rov/imu, which triggers; rov/velocity, rov/depth
publishes   rov/odometry: pose in map_ned, velocity in base_link_frd, stamped with the IMU's instants; on request
            the same in map and base_link on rov/odometry_enu; /diagnostics
"""

import sys
from collections.abc import Callable, Mapping
from functools import lru_cache
from math import nan
from typing import Any

from geometry_msgs.msg import TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import Imu

from thruster_estimation.belief import Level
from thruster_estimation.navigation_belief import Heard, navigation_level, navigation_reason
from thruster_estimation.navigation_online import NAVIGATION_START, LateReading, navigation_advance
from thruster_estimation.navigation_output import NavigationOutput, compiled_output
from thruster_estimation.navigation_parameters import NAVIGATION_PARAMETERS, chosen_settings
from thruster_model.equations.rep103 import (
    in_body_flu,
    in_map,
    pose_covariance_in_map,
    turned_attitude,
    velocity_covariance_in_body_flu,
)
from thruster_msgs.msg import Depth
from thruster_runtime.diagnostics import Level as DiagnosticLevel
from thruster_runtime.join_health import JoinHealth
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import changeable, declare
from thruster_runtime.records import RecordPublisher, format_of, listen
from thruster_runtime.triggered_join import Due, Input, TriggeredJoin

__all__ = ["NavigationNode", "main"]

_ODOMETRY = format_of(Odometry)
_WORDS: dict[Level, DiagnosticLevel] = {Level.OK: "ok", Level.DEGRADED: "warn", Level.INVALID: "error"}


@lru_cache(maxsize=1024)
def _verdict(status: int) -> tuple[Level, str]:
    return navigation_level(status), navigation_reason(status)


class NavigationNode(Node):
    """Turns readings into odometry."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, compile the filter, then listen; `options` are those of rclpy's Node."""
        super().__init__("navigation", **options)
        values = declare(self, NAVIGATION_PARAMETERS)
        self._settings = chosen_settings(values)
        self._period = round(values["period"] * 1e9)
        self._compile()
        self._track = NAVIGATION_START
        self._slot: int | None = None  # of the last reading, in periods
        inputs, self._taken = {}, {"velocity": -1, "depth": -1}
        for name in self._taken:
            every, first, timeout = (round(values[f"{name}_{key}"] * 1e9) for key in ("every", "first", "timeout"))
            inputs[name] = Input(timeout=timeout, wait=every > 0, every=every, first=first)
        self._join = TriggeredJoin("imu", inputs)
        self._health = JoinHealth(self, self._join)
        self._odometry = RecordPublisher(self, Odometry, "rov/odometry")
        self._enu = RecordPublisher(self, Odometry, "rov/odometry_enu") if values["rep103"] else None
        listen(self, TwistWithCovarianceStamped, "rov/velocity", self._on_velocity)
        listen(self, Depth, "rov/depth", self._on_depth)
        listen(self, Imu, "rov/imu", self._on_imu)
        self._health.report(0, "warn", "nothing heard on rov/imu yet")
        changeable(self, NAVIGATION_PARAMETERS, values, self._change)

    def _change(self, values: Mapping[str, Any]) -> tuple[Callable[[], None], list[str]]:
        """Noise and gates count from the next reading on; the belief stays."""
        try:
            settings = chosen_settings(values)
        except ValueError as error:
            return (lambda: None), str(error).split("\n")

        def count() -> None:
            self._settings = settings

        return count, []

    def _compile(self) -> None:
        """Step twice beside the track: the first message shall not wait for a compiler."""
        rest = Heard(w=1.0, x=0.0, y=0.0, z=0.0)
        track = navigation_advance(NAVIGATION_START, 0, rest, (), self._settings)
        track = navigation_advance(track, 1, rest, (), self._settings)
        compiled_output(track.belief, self._settings)

    def _on_velocity(self, velocity: Any) -> None:
        values = {f"velocity_{axis}": getattr(velocity, f"twist_twist_linear_{axis}") for axis in "xyz"}
        self._take("velocity", velocity.stamp, LateReading(velocity.stamp, values))

    def _on_depth(self, depth: Any) -> None:
        self._take("depth", depth.stamp, LateReading(depth.stamp, {"depth": depth.depth}))

    def _on_imu(self, imu: Any) -> None:
        self._take("imu", imu.stamp, imu)

    def _take(self, name: str, stamp: int, kept: Any) -> None:
        for due in self._join.put(name, stamp, kept):
            self._advance(due)

    def _advance(self, due: Due) -> None:
        if due.former is None:  # the first one, or the IMU's source started again
            self._track, self._slot = NAVIGATION_START, None
            self._taken = dict.fromkeys(self._taken, -1)
        others = []
        for name, taken in self._taken.items():
            new = [reading for stamp, reading in due.inputs[name] if stamp > taken]
            self._taken[name] = new[-1].stamp if new else taken
            others += new
        self._track = navigation_advance(self._track, due.stamp, _heard(due.message), others, self._settings)
        belief = self._track.belief
        assert belief is not None
        slot, within = divmod(due.stamp, self._period)
        if within == 0 or self._slot not in (None, slot):
            self._publish(due.stamp, compiled_output(belief, self._settings))
        self._slot = slot
        how, why = _verdict(belief.status)
        self._health.report(due.stamp, _WORDS[how], why or "estimating")

    def _publish(self, stamp: int, out: NavigationOutput) -> None:
        pose, motion = out.pose_covariance, out.velocity_covariance
        parts = ("map_ned", "base_link_frd", out.position, out.attitude, pose, out.velocity, motion)
        self._odometry.publish(_record(stamp, *parts))
        if self._enu is not None:
            pose, motion = pose_covariance_in_map(pose), velocity_covariance_in_body_flu(motion)
            place, speed = in_map(out.position), in_body_flu(out.velocity)
            attitude = turned_attitude(out.attitude)
            self._enu.publish(_record(stamp, "map", "base_link", place, attitude, pose, speed, motion))


def _heard(imu: Any) -> Heard:
    """Return a reading of the IMU; a covariance that begins with -1 says that there is none."""
    q = (imu.orientation_w, imu.orientation_x, imu.orientation_y, imu.orientation_z)
    rate = (imu.angular_velocity_x, imu.angular_velocity_y, imu.angular_velocity_z)
    force = (imu.linear_acceleration_x, imu.linear_acceleration_y, imu.linear_acceleration_z)
    q = q if imu.orientation_covariance[0] != -1.0 else (nan,) * 4
    rate = rate if imu.angular_velocity_covariance[0] != -1.0 else (nan,) * 3
    force = force if imu.linear_acceleration_covariance[0] != -1.0 else (nan,) * 3
    return Heard(*q, *rate, *force)


def _record(
    stamp: int, frame: str, child: str, position: Any, attitude: Any, pose: Any, velocity: Any, motion: Any
) -> Any:
    w, x, y, z = attitude
    return _ODOMETRY.record(stamp, frame, child, *position, x, y, z, w, pose.ravel(), *velocity, motion.ravel())


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(NavigationNode, __doc__, NAVIGATION_PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
