"""The vehicle's health on line: sequential tests on innovations, in /diagnostics; rov/thruster_failure on request.

subscribes  thruster_i/throttle, thruster_i/state, rov/imu, rov/depth, rov/velocity; what is not there is done without
publishes   /diagnostics; rov/thruster_failure on request
"""

import sys
from collections.abc import Callable
from functools import partial
from math import nan
from pathlib import Path
from typing import Any

from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.baseline import baseline
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.feed_io import Feed
from gap_diagnosis.vehicle.log_io import read_log
from gap_diagnosis.vehicle.watching import Alarm, Watch
from run_bag import RunError
from thruster_model.errors import ThrusterModelError
from thruster_msgs.msg import Depth, Throttle, ThrusterFailure, ThrusterState
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.errors import StartRefused
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, declare
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamps import nanoseconds

__all__ = ["PARAMETERS", "VehicleWatch", "main"]

PARAMETERS = (
    Parameter(name="vehicle", default="", description="set of the vehicle, a name or a file"),
    Parameter(name="model", default="", description="parameter set of its thrusters; empty: the vehicle's own"),
    Parameter(name="baseline", default="", description="run of the healthy vehicle, from which noises are learned"),
    Parameter(
        name="threshold",
        default=rules.WATCH_THRESHOLD,
        unit="1",
        lower=1.0,
        upper=1e6,
        description="log likelihood ratio at which it speaks; watch_rate tells it for a rate of false alarms",
    ),
    Parameter(name="report_failures", default=False, description="whether rov/thruster_failure is published"),
)
_SURE = 0.25


class VehicleWatch(Node):
    """One `Watch`, fed by topics."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, learn from the baseline, then watch; `options` are those of Node."""
        super().__init__("watch", **options)
        values = declare(self, PARAMETERS)
        try:
            model = load_model(values["vehicle"], values["model"] or None)
            known, noises = baseline(model, [read_log(Path(values["baseline"]), model.thrusters)])
        except (RunError, ThrusterModelError, OSError, ValueError) as error:
            raise StartRefused(str(error)) from error
        self._watch, self._feed = Watch(model, noises, known, values["threshold"]), Feed(model.thrusters)
        self._report_failures, self._reported = values["report_failures"], set[int]()
        self._diagnostics = Diagnostics(self)
        self._failures = self.create_publisher(ThrusterFailure, "rov/thruster_failure", RELIABLE)
        for i in range(model.thrusters):
            self.create_subscription(Throttle, f"thruster_{i}/throttle", partial(self._on_throttle, i), RELIABLE)
            self.create_subscription(ThrusterState, f"thruster_{i}/state", partial(self._on_state, i), RELIABLE)
        others: tuple[tuple[Any, str, Callable[[Any], None]], ...] = (
            (Imu, "rov/imu", self._on_imu),
            (Depth, "rov/depth", self._on_depth),
            (TwistWithCovarianceStamped, "rov/velocity", self._on_velocity),
        )
        for kind, topic, callback in others:
            self.create_subscription(kind, topic, callback, RELIABLE)
        self._diagnostics.report("ok", "waiting for throttles")

    def _on_throttle(self, i: int, message: Throttle) -> None:
        stamp = nanoseconds(message.header.stamp)
        self._feed.add(f"thruster_{i}/throttle.commanded", stamp, message.commanded)
        self._look()

    def _on_state(self, i: int, message: ThrusterState) -> None:
        stamp = nanoseconds(message.header.stamp)
        self._feed.add(f"thruster_{i}/state.n", stamp, message.n)
        self._feed.add(f"thruster_{i}/state.sign_source", stamp, float(message.sign_source))

    def _on_imu(self, message: Imu) -> None:
        stamp = nanoseconds(message.header.stamp)
        for field, axes in (("orientation", "wxyz"), ("angular_velocity", "xyz"), ("linear_acceleration", "xyz")):
            for axis in axes:
                self._feed.add(f"rov/imu.{field}.{axis}", stamp, getattr(getattr(message, field), axis))

    def _on_depth(self, message: Depth) -> None:
        self._feed.add("rov/depth.depth", nanoseconds(message.header.stamp), message.depth)

    def _on_velocity(self, message: TwistWithCovarianceStamped) -> None:
        stamp, linear = nanoseconds(message.header.stamp), message.twist.twist.linear
        for axis in "xyz":
            self._feed.add(f"rov/velocity.twist.twist.linear.{axis}", stamp, getattr(linear, axis))

    def _look(self) -> None:
        piece = self._feed.piece()
        if piece is None:
            return
        alarms = self._watch.step(piece)
        if not alarms:
            self._diagnostics.report("ok", "well", {"watched [s]": round(self._watch.time)})
            return
        ratios = {
            f"log ratio of {a.effect} {a.thruster if a.thruster is not None else a.sensor} [1]": a.log_ratio
            for a in alarms
        }
        self._diagnostics.report("error", alarms[0].words, ratios)
        if self._report_failures:
            self._fail(alarms[0])

    def _fail(self, alarm: Alarm) -> None:
        if alarm.thruster is None or alarm.deviation > _SURE or alarm.thruster in self._reported:
            return
        self._reported.add(alarm.thruster)
        left = max(1.0 - alarm.size, 0.0)
        kind = ThrusterFailure.KIND_DEAD if left < 0.1 else ThrusterFailure.KIND_WEAK
        message = ThrusterFailure(thruster=alarm.thruster, kind=kind, effectiveness=left, stuck_thrust=nan)
        message.header.stamp = self.get_clock().now().to_msg()
        self._failures.publish(message)


def main() -> int:
    """Watch until stopped; return the exit status."""
    return node_main(VehicleWatch, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
