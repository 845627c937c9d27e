"""The simulated vehicle as a node: throttles in; truth, sensors and states out; owner of time in lockstep.

publishes   rov/truth, thruster_i/truth; thruster_i/state, rov/imu, rov/velocity, rov/depth, rov/battery, stamped with
            the instants of measurement; rov/odometry where the feedback is the truth with noise; rov/thruster_failure;
            /clock in lockstep; /diagnostics
subscribes  thruster_i/throttle and the participants of the parameter; of a thruster that is elsewhere
            thruster_i/throttle_sent and thruster_i/state

From t_k to t_k+1 each thruster holds the throttle that came for t_k. In lockstep t_k+1 comes when all throttles and a
word of each participant are there. In real time it comes by the wall's clock; a throttle that stays away is zero then,
and so are all of them where a participant is silent.
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from math import floor
from typing import Any

from geometry_msgs.msg import WrenchStamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from rov_sim.vehicle import messages
from rov_sim.vehicle.held_throttles import HeldThrottles
from rov_sim.vehicle.live import Instant, LiveVehicle
from rov_sim.vehicle.plant_parameters import PARAMETERS, settings_of
from rov_sim.vehicle.sensor_messages import SensorPublishers
from thruster_msgs.msg import (
    FlowVelocity,
    Throttle,
    ThrusterEstimate,
    ThrusterFailure,
    ThrusterState,
    ThrusterTruth,
    ThrustSetpoint,
    VehicleSetpoint,
)
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.lockstep import Lockstep, known_participants
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import refused
from thruster_runtime.records import RecordPublisher, listen

__all__ = ["PlantNode", "main"]

_TYPES = {
    "rov/setpoint": VehicleSetpoint, "rov/wrench": WrenchStamped, "rov/odometry": Odometry, "recorded": Header,
    "watched": Header, "throttle": Throttle, "throttle_sent": Throttle, "estimate": ThrusterEstimate,
    "flow": FlowVelocity, "thrust_setpoint": ThrustSetpoint,
}  # fmt: skip
_POLL = {True: 0.001, False: 0.002}  # s, in lockstep or not
_LATE = 0.25  # s of the wall that are lost rather than caught up with


class PlantNode(Node):
    """Compiles its kernels, then waits for the graph."""

    def __init__(self, *, monotonic: Callable[[], float] = time.monotonic, **options: Any) -> None:
        """Refuse wrong parameters; `monotonic`: the wall's clock [s]; `options` are those of Node."""
        super().__init__("plant", **options)
        given = self._given = settings_of(self)
        kinds, problems = known_participants(given.participants, _TYPES)
        if problems:
            raise refused(self, problems)
        count = given.live.thrusters
        LiveVehicle(given.live).advance(count * [0.0])  # beside the vehicle: the first message waits for no compiler
        self.vehicle = LiveVehicle(given.live)
        self._monotonic, self._period = monotonic, round(1e9 * given.live.period)
        self._publish_all()
        throttles = {f"thruster_{i}/throttle": i for i in range(count) if i not in given.elsewhere}
        self._held = HeldThrottles(count, given.silence)
        self._topics = throttles
        self._told: dict[int, float] = {}
        for i in given.elsewhere:
            listen(self, Throttle, f"thruster_{i}/throttle_sent", partial(self._on_sent, i))
            listen(self, ThrusterState, f"thruster_{i}/state", partial(self._on_state, i))
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._diagnostics = Diagnostics(self, clock=wall)
        self._time: Lockstep | None = None
        if given.lockstep:
            self._time = Lockstep(
                self, period=self._period, pass_until=self._pass_until, wires=given.wires, settle=given.settle,
                participants={**dict.fromkeys(throttles, Throttle), **kinds}, timeout=given.timeout,
                heard=self._on_word, monotonic=monotonic,
            )  # fmt: skip
        else:
            kinds.pop("recorder/recorded", None)
            self._held.watch(kinds)
            for name, kind in {**dict.fromkeys(throttles, Throttle), **kinds}.items():
                listen(self, kind, name, partial(self._on_word, name))
            self._begin()
        poll = self._catch_up if self._time is None else self._time.look
        self.create_timer(_POLL[given.lockstep], poll, clock=wall)
        self.create_timer(0.1, self._report, clock=wall)

    def _publish_all(self) -> None:
        given = self._given
        kinds = {"truth": Odometry, "thruster_failure": ThrusterFailure}
        if given.from_truth:
            kinds["odometry"] = Odometry
        self._rov = {name: RecordPublisher(self, kind, f"rov/{name}") for name, kind in kinds.items()}
        thrusters = range(given.live.thrusters)
        self._truths = [RecordPublisher(self, ThrusterTruth, f"thruster_{i}/truth") for i in thrusters]
        self._sensors = SensorPublishers(self, given.live.sensors, given.live.thrusters)

    def waiting_for(self) -> list[str]:
        """Return what the next instant waits for in lockstep, in words."""
        return [] if self._time is None else self._time.waiting_for()

    def _on_word(self, name: str, record: Any) -> None:
        thruster = self._topics.get(name)
        if thruster is not None:
            self._held.hold(thruster, record.commanded, self._monotonic())
        elif name != "rov/wrench" or record.wrench_force_x == record.wrench_force_x:  # NaN: nobody steers
            self._held.heard(name, self._monotonic())

    def _on_sent(self, thruster: int, throttle: Any) -> None:
        self._held.hold(thruster, throttle.sent, self._monotonic())

    def _on_state(self, thruster: int, state: Any) -> None:
        if state.n == state.n:
            backwards = state.sign_source == ThrusterState.SIGN_UNKNOWN and self._held.values[thruster] < 0.0
            self._told[thruster] = -abs(state.n) if backwards else state.n

    def _pass_until(self, stamp: int) -> None:
        self._tell(stamp, self.vehicle.advance(self._held.values))

    # In real time

    def _begin(self) -> None:
        self._start_wall, self._start = self._monotonic(), int(self.get_clock().now().nanoseconds)

    def _catch_up(self) -> None:
        now = self._monotonic()
        late = now - self._start_wall - 1e-9 * self.vehicle.time
        if late > _LATE:
            self._start_wall += late - _LATE
            self._start += round(1e9 * (late - _LATE))
            late = _LATE
        for _ in range(floor(1e9 * late / self._period)):
            self._tell(
                self._start + self.vehicle.time + self._period, self.vehicle.advance(self._held.at(now), self._told)
            )

    # What is told

    def _tell(self, stamp: int, now: Instant) -> None:
        for failing in now.failed if self._given.report_failures else ():
            self._rov["thruster_failure"].publish(messages.failure(stamp, failing))
        elsewhere = self._given.elsewhere
        readings = [each for each in now.readings if each.sensor != "tachometer" or each.thruster not in elsewhere]
        self._sensors.publish(readings, stamp - now.time)
        self._rov["truth"].publish(messages.truth(stamp, now.truth))
        for publisher, record in zip(self._truths, messages.thruster_truths(stamp, now.truth), strict=True):
            publisher.publish(record)
        if self._given.from_truth:
            self._rov["odometry"].publish(messages.odometry(stamp, now.odometry, self._given.live.noise))

    def _report(self) -> None:
        values = {"time [s]": f"{1e-9 * self.vehicle.time:.3f}"}
        if self._time is not None and (trouble := self._time.standstill()):
            self._diagnostics.report("error", trouble, values)
        elif self._time is not None and self._time.now == 0:
            self._diagnostics.report("ok", "time has not begun", values)
        elif self._time is None and (silent := self._held.silent(self._monotonic())):
            self._diagnostics.report("error", f"throttles at zero: nothing heard of {', '.join(silent)}", values)
        else:
            self._diagnostics.report("ok", "time passes", values)


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(PlantNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
