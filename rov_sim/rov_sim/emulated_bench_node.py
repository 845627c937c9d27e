"""The emulated bench: a thruster in its flow tank behind the rig's device, on a pseudo-terminal, owner of time.

publishes   thruster_0/truth; daq/thruster_0/load, the load cell's mean over each period, stamped in its middle;
            /clock in lockstep; /diagnostics
subscribes  in lockstep thruster_0/throttle_sent and the participants of the parameter

In lockstep a period t passes once the driver has told what it sent at t, its bytes have arrived at the port and each
participant has published a message stamped t. Whoever keeps it waiting is named on /diagnostics.
"""

import math
import sys
import time
from collections.abc import Callable
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from bench_driver.errors import EmulatorFailed
from rov_sim import emulated_bench_messages as messages
from rov_sim.emulated_bench_io import EmulatedBench
from rov_sim.emulated_bench_parameters import PARAMETERS, settings_of
from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterEstimate, ThrusterState, ThrusterTruth, ThrustSetpoint
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.lockstep import Lockstep, known_participants
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import refused
from thruster_runtime.records import RecordPublisher

__all__ = ["EmulatedBenchNode", "main"]

DRIVER = "thruster_0/throttle_sent"
_TYPES = {
    "throttle_sent": Throttle, "throttle": Throttle, "estimate": ThrusterEstimate, "state": ThrusterState,
    "flow": FlowVelocity, "thrust_setpoint": ThrustSetpoint, "recorded": Header,
}  # fmt: skip
_POLL = {True: 0.001, False: 0.005}  # s, in lockstep or not
_LATE = 0.25  # s of the wall that are lost rather than caught up with


class EmulatedBenchNode(Node):
    """Serves the port from its construction on; time begins when it is spun and all wires are there."""

    def __init__(self, *, monotonic: Callable[[], float] = time.monotonic, **options: Any) -> None:
        """Refuse wrong parameters, then serve; `monotonic`: the wall's clock [s]; `options` are those of Node."""
        super().__init__("emulated_bench", **options)
        self._given = settings_of(self)
        try:
            self.bench = EmulatedBench(self._given.device, self._given.bench)
        except (EmulatorFailed, OSError) as error:
            raise refused(self, [f"device: {error}"]) from error
        self._monotonic = monotonic
        self._period = round(1e9 * self._given.device.period)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._diagnostics = Diagnostics(self, hardware_id=self.bench.port, clock=wall)
        self._truth = RecordPublisher(self, ThrusterTruth, "thruster_0/truth")
        self._load = RecordPublisher(self, WrenchStamped, "daq/thruster_0/load")
        self._expecting = False
        self._since = self._monotonic()
        self._time = self._in_lockstep() if self._given.lockstep else None
        poll = self._catch_up if self._time is None else self._time.look
        self.create_timer(_POLL[self._given.lockstep], poll, clock=wall)
        self.create_timer(0.1, self._report, clock=wall)
        self.get_logger().info(f"port: {self.bench.port}")

    def on_stop(self) -> None:
        """Take the port away."""
        self.bench.close()

    # In lockstep

    def _in_lockstep(self) -> Lockstep:
        given = self._given
        kinds, problems = known_participants((DRIVER, *given.participants), _TYPES)
        if problems:
            self.bench.close()
            raise refused(self, problems)
        return Lockstep(
            self, period=self._period, pass_until=self._pass_until, participants=kinds, wires=given.wires,
            settle=given.settle, timeout=given.timeout, heard=self._on_done, also=self._bytes_missing,
            monotonic=self._monotonic,
        )  # fmt: skip

    def _on_done(self, name: str, record: Any) -> None:
        if name == DRIVER and self._time is not None and record.stamp == self._time.now:
            self._expecting = math.isfinite(record.sent)

    def _bytes_missing(self) -> list[str]:
        return ["the bytes that the driver has sent"] if self._expecting and not self.bench.heard() else []

    def waiting_for(self) -> list[str]:
        """Return what the next period waits for in lockstep, in words."""
        return [] if self._time is None else self._time.waiting_for()

    def _pass_until(self, stamp: int) -> None:
        self.bench.advance(1e-9 * self._period)
        self._expecting = False
        self._tell(stamp)

    # In real time

    def _catch_up(self) -> None:
        left = self._monotonic() - self._since
        if left > _LATE:
            self._since += left - _LATE
            left = _LATE
        steps = math.floor(left / self.bench.step)
        for _ in range(steps):
            self.bench.advance(self.bench.step)
            if round(1e9 * self.bench.plant.time) % self._period == 0:
                self._tell(int(self.get_clock().now().nanoseconds))
        self._since += steps * self.bench.step

    def _tell(self, stamp: int) -> None:
        self._truth.publish(messages.truth(stamp, self.bench.plant.truth()))
        self._load.publish(messages.load(stamp - self._period // 2, self.bench.plant.mean_thrust()))

    def _report(self) -> None:
        values = {"port": self.bench.port, "time [s]": f"{self.bench.plant.time:.3f}"}
        if self._time is not None and (trouble := self._time.standstill()):
            self._diagnostics.report("error", trouble, values)
        elif self._time is not None and self._time.now == 0:
            self._diagnostics.report("ok", "time has not begun", values)
        else:
            self._diagnostics.report("ok", "time passes", values)


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(EmulatedBenchNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
