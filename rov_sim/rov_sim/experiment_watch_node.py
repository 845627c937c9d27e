"""Wait until an experiment is over: exit status 0 when its set point has been followed to the end, else 1.

subscribes  /diagnostics and the set point: thruster_i/thrust_setpoint, whose run has a length, or rov/setpoint,
            whose run is over when it is taken back
publishes   nothing

On failure it says what it waited for, and what is the matter
with the nodes that are not well. Time is the wall's: in lockstep simulated time may stand still.
"""

import sys
import threading
import time
from collections.abc import Callable
from math import isnan
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from thruster_control.references import DURATION
from thruster_msgs.msg import ThrustSetpoint, VehicleSetpoint
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, declare
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamps import nanoseconds

__all__ = ["PARAMETERS", "ExperimentWatch", "main"]

PARAMETERS = (
    Parameter(name="thruster", default=0, lower=0, upper=99, description="index of the thruster"),
    Parameter(name="vehicle", default=False, description="whether the set point is the vehicle's, not the thruster's"),
    Parameter(
        name="start_delay", default=0.0, unit="s", lower=0.0, upper=3600.0,
        description="thruster: between the first set point and the run, as the reference's",
    ),
    Parameter(name="tail", default=0.5, unit="s", lower=0.0, upper=3600.0, description="to be recorded after the run"),
    Parameter(
        name="begin", default=60.0, unit="s", lower=0.0, above=True, upper=3600.0,
        description="wall time within which the first set point has to come",
    ),
    Parameter(
        name="stall", default=30.0, unit="s", lower=0.0, above=True, upper=3600.0,
        description="wall time within which the next set point has to come",
    ),
    Parameter(
        name="deadline", default=300.0, unit="s", lower=0.0, above=True, upper=36000.0,
        description="wall time within which the run has to be over",
    ),
)  # fmt: skip


class ExperimentWatch(Node):
    """Sets `stop` when there is nothing left to wait for; `trouble` is empty after a whole run."""

    def __init__(
        self, stop: threading.Event, *, monotonic: Callable[[], float] = time.monotonic, **options: Any
    ) -> None:
        """Refuse wrong parameters, then wait; `monotonic`: the wall's clock [s]; `options` are those of Node."""
        super().__init__("experiment_watch", **options)
        self._values = declare(self, PARAMETERS)
        self._stop, self._monotonic = stop, monotonic
        self.trouble = "it was stopped before the run was over"
        self._statuses: dict[str, DiagnosticStatus] = {}
        self._first: int | None = None
        self._taken_back: int | None = None
        self._begun = self._last = monotonic()
        length = self._values["start_delay"] + DURATION + self._values["tail"]
        self._length = round(1e9 * length)
        if self._values["vehicle"]:
            self.create_subscription(VehicleSetpoint, "rov/setpoint", self._on_vehicle, RELIABLE)
        else:
            topic = f"thruster_{self._values['thruster']}/thrust_setpoint"
            self.create_subscription(ThrustSetpoint, topic, self._on_thruster, RELIABLE)
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_diagnostics, RELIABLE)
        self.create_timer(0.1, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_thruster(self, message: ThrustSetpoint) -> None:
        stamp = nanoseconds(message.header.stamp)
        self._last = self._monotonic()
        if isnan(message.thrust):  # none yet, or taken back
            return
        self._first = stamp if self._first is None else self._first
        if stamp - self._first >= self._length:
            self._end("")

    def _on_vehicle(self, message: VehicleSetpoint) -> None:
        stamp, there = nanoseconds(message.header.stamp), not isnan(message.attitude[0])
        self._last = self._monotonic()
        # A script's set point is there from the first instant on: a watch that comes late may hear its end alone.
        self._first = stamp if self._first is None else self._first
        if there:
            self._taken_back = None
        else:
            self._taken_back = stamp if self._taken_back is None else self._taken_back
            if stamp - self._taken_back >= round(1e9 * self._values["tail"]):
                self._end("")

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        self._statuses |= {status.name: status for status in message.status}

    def _look(self) -> None:
        now, values = self._monotonic(), self._values
        if self._first is None and now - self._begun > values["begin"]:
            self._end(f"no set point within {values['begin']:g} s")
        elif self._first is not None and now - self._last > values["stall"]:
            self._end(f"no further set point within {values['stall']:g} s")
        elif now - self._begun > values["deadline"]:
            self._end(f"the run was not over within {values['deadline']:g} s")

    def _end(self, trouble: str) -> None:
        if not self._stop.is_set():
            self.trouble = trouble
            self._stop.set()

    def unwell(self) -> list[str]:
        """Return a sentence for each node that last said that it is not well."""
        ok = DiagnosticStatus.OK
        return [f"{name}: {status.message}" for name, status in self._statuses.items() if status.level != ok]


def main() -> int:
    """Wait; return the exit status."""
    stop, built = threading.Event(), []

    def build() -> ExperimentWatch:
        built.append(ExperimentWatch(stop))
        return built[0]

    status = node_main(build, __doc__, PARAMETERS, stop=stop)
    if status != 0 or not built or not built[0].trouble:
        return status
    for sentence in (f"experiment_watch: {built[0].trouble}", *built[0].unwell()):
        sys.stderr.write(f"{sentence}\n")
    return 1


if __name__ == "__main__":
    sys.exit(main())
