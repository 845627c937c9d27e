"""The vehicle's health on line: sequential tests on innovations, in /diagnostics; rov/thruster_failure on request.

subscribes  thruster_i/throttle, thruster_i/state, rov/imu, rov/odometry, rov/depth, rov/velocity, rov/battery.
            Sensors that are missing are left out. A throttle without new messages counts as zero, as for a driver.
publishes   /diagnostics; rov/thruster_failure on request; ~/watched, stamped with each instant up to which all
            throttles are known. A lockstep waits for it, so that an alarm does not depend on how fast time passes.
"""

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from math import nan
from pathlib import Path
from typing import Any

from geometry_msgs.msg import TwistWithCovarianceStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from sensor_msgs.msg import BatteryState, Imu
from std_msgs.msg import Header

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.baseline import baseline
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.false_alarms import stated_rate
from gap_diagnosis.vehicle.feed_io import Feed
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.watching import Alarm, Watch
from run_bag import RunError
from thruster_model.errors import ThrusterModelError
from thruster_msgs.msg import Depth, Throttle, ThrusterFailure, ThrusterState
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.errors import StartRefused
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, declare
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import RecordPublisher, format_of, listen
from thruster_runtime.stamps import nanoseconds

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
        lower=rules.WATCH_THRESHOLDS[0],
        upper=rules.WATCH_THRESHOLDS[1],
        description="log likelihood ratio that is an alarm; watch_rate finds it for a rate of false alarms",
    ),
    Parameter(name="report_failures", default=False, description="whether rov/thruster_failure is published"),
)
_SURE = 0.25


def _fields(**axes_of: str) -> dict[str, str]:
    """Return fields of a record by their paths in the message, of parts with their axes."""
    paths = [f"{part.replace('__', '.')}.{axis}" for part, axes in axes_of.items() for axis in axes]
    return {path: path.replace(".", "_") for path in paths}


_TOLD: dict[str, tuple[type, dict[str, str]]] = {
    "rov/imu": (Imu, _fields(orientation="wxyz", angular_velocity="xyz", linear_acceleration="xyz")),
    "rov/odometry": (Odometry, _fields(pose__pose__orientation="wxyz", twist__twist__angular="xyz")),
    "rov/depth": (Depth, {"depth": "depth"}),
    "rov/velocity": (TwistWithCovarianceStamped, _fields(twist__twist__linear="xyz")),
}
"""What is read of each topic: its type, and the record's field by the path that a recording has it under."""


class VehicleWatch(Node):
    """One `Watch`, fed by topics."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, learn from the baseline, then watch; `options` are those of Node."""
        super().__init__("watch", **options)
        values = declare(self, PARAMETERS)
        if not values["baseline"]:
            raise StartRefused("parameter baseline: expected a run of the healthy vehicle; found none")
        try:
            model = load_model(values["vehicle"], values["model"] or None)
            healthy, model = read_logs([Path(values["baseline"])], model)
            learned = baseline(model, healthy)
            self._watch = Watch(model, learned, values["threshold"])
        except (RunError, ThrusterModelError, OSError, ValueError) as error:
            raise StartRefused(str(error)) from error
        self._feed = Feed(model.thrusters, model.period, stated=model.mounted)
        self._report_failures, self._reported, self._told = values["report_failures"], set[int](), set[str]()
        self._diagnostics = Diagnostics(self)
        self._failures = RecordPublisher(self, ThrusterFailure, "rov/thruster_failure")
        self._watched = RecordPublisher(self, Header, f"{self.get_name()}/watched")
        self._known: int | None = None
        self._rate = stated_rate(values["threshold"])
        for i in range(model.thrusters):
            listen(self, Throttle, f"thruster_{i}/throttle", partial(self._on_throttle, i))
            listen(self, ThrusterState, f"thruster_{i}/state", partial(self._on_state, i))
        for topic, (kind, fields) in _TOLD.items():
            listen(self, kind, topic, partial(self._on_sensor, topic, fields))
        self.create_subscription(BatteryState, "rov/battery", self._on_battery, RELIABLE)
        if learned.doubt:
            self.get_logger().warning(learned.doubt)
        self.get_logger().info(f"watching for {self._watch.words}; false alarms an hour: {self._rate}")
        self._diagnostics.report("ok", "waiting for throttles", self._values())

    def _on_throttle(self, i: int, throttle: Any) -> None:
        self._feed.add_throttle(i, throttle.stamp, throttle.commanded)
        self._advance()

    def _on_state(self, i: int, state: Any) -> None:
        of = f"thruster_{i}/state"
        self._feed.add(state.stamp, {f"{of}.n": state.n, f"{of}.sign_source": float(state.sign_source)})

    def _on_sensor(self, topic: str, fields: Mapping[str, str], record: Any) -> None:
        self._feed.add(record.stamp, {f"{topic}.{path}": getattr(record, name) for path, name in fields.items()})
        self._advance()

    def _on_battery(self, battery: BatteryState) -> None:
        told = {"rov/battery.voltage": battery.voltage, "rov/battery.current": battery.current}
        self._feed.add(nanoseconds(battery.header.stamp), told)

    def _advance(self) -> None:
        """Look, and say so, if all throttles are known farther than they were."""
        known = self._feed.known
        if known is not None and known != self._known:
            self._known = known
            self._look(known)
            self._watched.publish(_HEADER.record(known, ""))

    def _look(self, stamp: int) -> None:
        try:
            piece = self._feed.piece()
        except RunError as error:
            self._watch.begin()
            self._diagnostics.report("warn", f"not watching: {error}", self._values())
            return
        if piece is None:
            return
        silent = self._feed.silent
        if len(silent) == piece.thrusters:
            self._watch.begin()
            self._diagnostics.report("warn", "not watching: all throttles are silent", self._values())
            return
        alarms = self._watch.step(piece)
        without = [f"thruster {', '.join(map(str, silent))}: no throttle, counts as zero"] if silent else []
        without += self._watch.stuck.values()
        if not alarms:
            self._diagnostics.report("warn" if without else "ok", "; ".join(without) or "well", self._values())
            return
        for alarm in alarms:
            if alarm.name not in self._told:
                self._told.add(alarm.name)
                self.get_logger().error(alarm.words)
        self._diagnostics.report("error", "; ".join([alarms[0].words, *without]), self._values(alarms))
        if self._report_failures:
            self._fail(alarms[0], stamp)

    def _values(self, alarms: Sequence[Alarm] = ()) -> dict[str, object]:
        values: dict[str, object] = {"watched [s]": round(self._watch.time), "false alarms [1/h]": self._rate}
        for alarm in alarms:
            values |= {
                f"log ratio of {alarm.name} [1]": alarm.log_ratio,
                f"probability of {alarm.name} [1]": alarm.probability,
            }
        return values

    def _fail(self, alarm: Alarm, stamp: int) -> None:
        thruster = alarm.failure.thruster
        if thruster is None or alarm.failure.effect != "thrust_loss":
            return
        if thruster in self._reported or alarm.deviation > _SURE:
            return
        self._reported.add(thruster)
        left = max(1.0 - alarm.size, 0.0)
        kind = ThrusterFailure.KIND_DEAD if left < 0.1 else ThrusterFailure.KIND_WEAK
        self._failures.publish(
            _FAILURE.record(stamp, "", thruster=thruster, kind=kind, effectiveness=left, stuck_thrust=nan)
        )


def main() -> int:
    """Watch until stopped; return the exit status."""
    return node_main(VehicleWatch, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
