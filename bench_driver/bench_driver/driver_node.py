"""The thruster bench as topics: throttles to a serial port, its states, flows and loads back.

subscribes  thruster_<i>/throttle (commanded); in lockstep /clock
publishes   thruster_<i>/state, flow, throttle_sent, thruster_0/gauges and load where the device has them, /diagnostics
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock as ClockMessage

from bench_driver import driver_messages as messages
from bench_driver.dialect import Measurement
from bench_driver.driver_parameters import PARAMETERS, settings_of
from bench_driver.link import Link
from bench_driver.link_diagnosis import Level, LinkDiagnosis
from bench_driver.link_records import LinkLimits, Sent
from bench_driver.pace_io import LockstepPace, OpenPort, RealTimePace
from bench_driver.serial_port_io import SerialPort
from thruster_msgs.msg import FlowVelocity, LoadCellGauges, Throttle, ThrusterState
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.diagnostics import Level as Word
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import refused
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import RecordPublisher, listen

__all__ = ["Driver", "main"]

_WORDS: dict[Level, Word] = {Level.OK: "ok", Level.WARN: "warn", Level.ERROR: "error"}
_DIAGNOSE = 0.1  # s
SIMULATED = (
    "use_sim_time: expected false for a device by the wall's clock, whose commands grow old by it; found true "
    "(the emulated bench's simulated time comes with lockstep:=true)"
)


class Driver(Node):
    """The driver; nothing is opened or sent before it is spun."""

    def __init__(
        self, *, monotonic: Callable[[], float] = time.monotonic, open_port: OpenPort = SerialPort, **options: object
    ) -> None:
        """Build the node.

        Args:
            monotonic: the wall's clock [s].
            open_port: opens a port by name and line speed.
            options: of `Node`.
        """
        super().__init__("driver", **options)
        self._settings = settings_of(self, self._bound)
        if bool(self.get_parameter("use_sim_time").value) and not self._settings.lockstep:
            raise refused(self, [SIMULATED])
        self.add_on_set_parameters_callback(self._on_time)
        self._link = Link(self._settings.dialect(), self._settings.limits)
        self._diagnosis = LinkDiagnosis(self._link)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._diagnostics = Diagnostics(self, hardware_id=self._settings.port, clock=wall)
        thrusters = range(self._settings.thrusters)
        self._states = [self._topic(ThrusterState, i, "state") for i in thrusters]
        self._flows = [self._topic(FlowVelocity, i, "flow") for i in thrusters]
        self._sent = [self._topic(Throttle, i, "throttle_sent") for i in thrusters]
        if self._settings.protocol == "frames":
            self._gauges = self.create_publisher(LoadCellGauges, "thruster_0/gauges", RELIABLE)
            if self._settings.load_cell.matrix is not None:
                self._load = self._topic(WrenchStamped, 0, "load")
        self._pace: LockstepPace | RealTimePace
        if self._settings.lockstep:
            self._pace = LockstepPace(self._settings, self._link, monotonic, open_port)
            listen(self, ClockMessage, "/clock", self._on_clock)
        else:
            stamps = self.get_clock()
            self._pace = RealTimePace(
                self._settings, self._link, monotonic, lambda: int(stamps.now().nanoseconds), open_port
            )
        for i in thrusters:
            listen(self, Throttle, f"thruster_{i}/throttle", partial(self._on_throttle, i))
        self.create_timer(self._settings.poll, self.look, clock=wall)
        self.create_timer(_DIAGNOSE, self.report, clock=wall)

    def _bound(self, limits: LinkLimits) -> None:
        self._link.limits = limits

    def _on_time(self, given: list[Parameter]) -> SetParametersResult:
        simulated = any(each.name == "use_sim_time" and each.value for each in given)
        wrong = simulated and not self._settings.lockstep
        return SetParametersResult(
            successful=not wrong, reason=f"{self.get_name()}: parameter {SIMULATED}" if wrong else ""
        )

    def on_stop(self) -> None:
        """Command zero, end the run and close the port."""
        self._pace.session.close()
        if self._link.sent is not None:
            self._tell(int(self.get_clock().now().nanoseconds), self._link.sent)

    def _topic(self, kind: type, thruster: int, name: str) -> RecordPublisher:
        return RecordPublisher(self, kind, f"thruster_{thruster}/{name}")

    def _on_clock(self, tick: Any) -> None:
        assert isinstance(self._pace, LockstepPace)
        for stamp, sent in self._pace.tick(tick.clock):
            self._tell(stamp, sent)
        self.look()

    def _on_throttle(self, thruster: int, throttle: Any) -> None:
        self._pace.command(throttle.stamp, thruster, throttle.commanded)
        if self._settings.lockstep:
            self.look()

    def look(self) -> None:
        """Publish what has come and send what is due; the timer does so all the time."""
        for stamp, found in self._pace.read():
            self._publish(stamp, found)
        for stamp, sent in self._pace.write():
            self._tell(stamp, sent)

    def _publish(self, stamp: int, found: Measurement) -> None:
        for i in range(self._settings.thrusters):
            self._flows[i].publish(messages.flow(stamp, i, found))
        if found.load_counts and self._settings.protocol == "frames":
            cell = self._settings.load_cell
            self._gauges.publish(messages.gauges(stamp, list(cell.volts(found.load_counts))))
            if cell.matrix is not None:
                self._load.publish(messages.load(stamp, cell, found))
        for i in range(self._settings.thrusters):  # last, as others act on it
            self._states[i].publish(messages.state(stamp, i, found))

    def _tell(self, stamp: int, sent: Sent | None) -> None:
        for i, topic in enumerate(self._sent):
            topic.publish(messages.throttle_sent(stamp, i, sent))

    def report(self) -> None:
        """Say how the link is doing; another timer does so."""
        found = self._diagnosis.diagnose(self._pace.now)
        trouble = self._pace.trouble()
        level = max(found.level, Level.WARN) if trouble else found.level
        sentence = f"{found.sentence}; {trouble}" if trouble else found.sentence
        why = self._link.sent.reason if self._link.sent is not None else "nothing was sent yet"
        values = {"link": self._link.state.value, "zero because": why or "-", **found.counters}
        self._diagnostics.report(_WORDS[Level(level)], sentence, values)


def main() -> int:
    """Run the node."""
    return node_main(Driver, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
