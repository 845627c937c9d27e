"""The vehicle's health on line: sequential tests on innovations, in /diagnostics; rov/thruster_failure on request.

subscribes  thruster_i/throttle, thruster_i/state, rov/imu, rov/depth, rov/velocity; what is not there is done without
publishes   /diagnostics; rov/thruster_failure on request; ~/watched, stamped with each instant that all throttles have
            come for: what a lockstep waits for, so that an alarm does not depend on how fast time is simulated
"""

import sys
from functools import partial
from math import nan
from pathlib import Path
from typing import Any

from geometry_msgs.msg import TwistWithCovarianceStamped
from rclpy.node import Node
from sensor_msgs.msg import Imu
from std_msgs.msg import Header

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
from thruster_runtime.records import RecordPublisher, format_of, listen

__all__ = ["PARAMETERS", "VehicleWatch", "main"]

_FAILURE, _HEADER = format_of(ThrusterFailure), format_of(Header)
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
        self._failures = RecordPublisher(self, ThrusterFailure, "rov/thruster_failure")
        self._watched = RecordPublisher(self, Header, f"{self.get_name()}/watched")
        self._throttles: dict[int, int] = dict.fromkeys(range(model.thrusters), -1)
        for i in range(model.thrusters):
            listen(self, Throttle, f"thruster_{i}/throttle", partial(self._on_throttle, i))
            listen(self, ThrusterState, f"thruster_{i}/state", partial(self._on_state, i))
        listen(self, Imu, "rov/imu", self._on_imu)
        listen(self, Depth, "rov/depth", self._on_depth)
        listen(self, TwistWithCovarianceStamped, "rov/velocity", self._on_velocity)
        self._diagnostics.report("ok", "waiting for throttles")

    def _on_throttle(self, i: int, throttle: Any) -> None:
        self._feed.add(f"thruster_{i}/throttle.commanded", throttle.stamp, throttle.commanded)
        self._throttles[i] = throttle.stamp
        if min(self._throttles.values()) == throttle.stamp:
            self._look(throttle.stamp)
            self._watched.publish(_HEADER.record(throttle.stamp, ""))

    def _on_state(self, i: int, state: Any) -> None:
        self._feed.add(f"thruster_{i}/state.n", state.stamp, state.n)
        self._feed.add(f"thruster_{i}/state.sign_source", state.stamp, float(state.sign_source))

    def _on_imu(self, imu: Any) -> None:
        for field, axes in (("orientation", "wxyz"), ("angular_velocity", "xyz"), ("linear_acceleration", "xyz")):
            for axis in axes:
                self._feed.add(f"rov/imu.{field}.{axis}", imu.stamp, getattr(imu, f"{field}_{axis}"))

    def _on_depth(self, depth: Any) -> None:
        self._feed.add("rov/depth.depth", depth.stamp, depth.depth)

    def _on_velocity(self, velocity: Any) -> None:
        for axis in "xyz":
            value = getattr(velocity, f"twist_twist_linear_{axis}")
            self._feed.add(f"rov/velocity.twist.twist.linear.{axis}", velocity.stamp, value)

    def _look(self, stamp: int) -> None:
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
            self._fail(alarms[0], stamp)

    def _fail(self, alarm: Alarm, stamp: int) -> None:
        if alarm.thruster is None or alarm.deviation > _SURE or alarm.thruster in self._reported:
            return
        self._reported.add(alarm.thruster)
        left = max(1.0 - alarm.size, 0.0)
        kind = ThrusterFailure.KIND_DEAD if left < 0.1 else ThrusterFailure.KIND_WEAK
        self._failures.publish(
            _FAILURE.record(stamp, "", thruster=alarm.thruster, kind=kind, effectiveness=left, stuck_thrust=nan)
        )


def main() -> int:
    """Watch until stopped; return the exit status."""
    return node_main(VehicleWatch, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
