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
from functools import partial
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage
from std_msgs.msg import Header

from bench_driver.errors import EmulatorFailed
from rov_sim import emulated_bench_messages as messages
from rov_sim.emulated_bench_io import EmulatedBench
from rov_sim.emulated_bench_parameters import settings_of
from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterEstimate, ThrusterState, ThrusterTruth, ThrustSetpoint
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.node_main import run_node
from thruster_runtime.parameters import refused
from thruster_runtime.records import RecordPublisher, format_of, listen

__all__ = ["EmulatedBenchNode", "main"]

DRIVER = "thruster_0/throttle_sent"
_CLOCK = format_of(ClockMessage)
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
        self._monotonic, self._lockstep = monotonic, self._given.lockstep
        self._period = round(1e9 * self._given.device.period)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._diagnostics = Diagnostics(self, hardware_id=self.bench.port, clock=wall)
        self._truth = RecordPublisher(self, ThrusterTruth, "thruster_0/truth")
        self._load = RecordPublisher(self, WrenchStamped, "daq/thruster_0/load")
        self._tick = 0  # [ns]; 0: time has not begun
        self._seen: dict[str, int] = {}
        self._expecting = False
        self._since = self._monotonic()
        self._ready_since = math.inf
        if self._lockstep:
            self._clock_topic = RecordPublisher(self, ClockMessage, "/clock")
            self._participants = tuple(dict.fromkeys((DRIVER, *self._given.participants)))
            for name in self._participants:
                kind = _TYPES.get(name.rpartition("/")[2])
                if kind is None:
                    known = ", ".join(_TYPES)
                    self.bench.close()
                    raise refused(self, [f"participants: expected topics that end in one of {known}; found {name!r}"])
                listen(self, kind, name, partial(self._on_done, name))
        self.create_timer(_POLL[self._lockstep], self._step if self._lockstep else self._catch_up, clock=wall)
        self.create_timer(0.1, self._report, clock=wall)
        self.get_logger().info(f"port: {self.bench.port}")
        if self._given.left_out:
            names = ", ".join(self._given.left_out)
            self.get_logger().warning(f"left out: {names}, which concern the log or the load cell alone, not the loop")

    def on_stop(self) -> None:
        """Take the port away."""
        self.bench.close()

    # In lockstep

    def _on_done(self, name: str, record: Any) -> None:
        self._seen[name] = record.stamp
        if name == DRIVER and record.stamp == self._tick:
            self._expecting = math.isfinite(record.sent)
        self._step()

    def waiting_for(self) -> list[str]:
        """Return what the next period waits for, in words."""
        if self._tick == 0:
            missing = [f"a publisher and a subscription of {name}" for name in self._wires_missing()]
            return missing or ["the graph to settle"]
        late = [name for name in self._participants if self._seen.get(name, -1) < self._tick]
        if not late and self._expecting and not self.bench.heard():
            late = ["the bytes that the driver has sent"]
        return late

    def _wires_missing(self) -> list[str]:
        clock = [] if self._clock_topic.get_subscription_count() else ["/clock"]
        wires = [name for name in self._given.wires if not self._is_wired(name)]
        absent = [name for name in self._participants if not self.count_publishers(name)]
        return list(dict.fromkeys([*clock, *wires, *absent]))

    def _is_wired(self, name: str) -> bool:
        own = int(name in self._participants)
        return bool(self.count_publishers(name) and self.count_subscribers(name) > own)

    def _step(self) -> None:
        if self._tick == 0:
            now = self._monotonic()
            if self._wires_missing():
                self._ready_since = math.inf
                return
            self._ready_since = min(self._ready_since, now)
            if now - self._ready_since < self._given.settle:
                return
        elif self.waiting_for():
            return
        self.bench.advance(1e-9 * self._period)
        self._tick += self._period
        self._expecting, self._since = False, self._monotonic()
        self._tell(self._tick)
        self._clock_topic.publish(_CLOCK.record(clock=self._tick))

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
        waited = self._monotonic() - self._since
        if self._lockstep and waited > self._given.timeout:
            missing = "; ".join(self.waiting_for()) or "nothing"
            self._diagnostics.report("error", f"time stands still, waiting for {missing}", values)
        elif self._lockstep and self._tick == 0:
            self._diagnostics.report("ok", "time has not begun", values)
        else:
            self._diagnostics.report("ok", "time passes", values)


def main() -> int:
    """Run the node until it is told to stop."""
    return run_node(EmulatedBenchNode)


if __name__ == "__main__":
    sys.exit(main())
