"""`ros2 run run_bag recorder --ros-args -p out:=DIR`: record topics of the graph to a run."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.errors import StartRefused
from thruster_runtime.node_main import run_node
from thruster_runtime.qos import RELIABLE

from ..arrivals import Arrivals
from ..command_line import exit_status
from ..errors import CannotWriteError, InvalidRunError, RunError
from ..finishing import finish
from ..journal import Journal, free_bytes
from ..provenance import machine, said_by_the_user
from ..selection import Selection
from .node_parameters import NodeParameters
from .recorded_topics import RecordedTopics

FLUSH_PERIOD = 0.05
"""[s] What a killed process loses at most, and once more while the flush waits for its turn."""
LOOK_PERIOD = 0.1
"""[s] Between two looks at the graph for new topics and nodes."""
REPORT_PERIOD = 1.0
MEGABYTE = 1_000_000
NANOSECONDS = 1_000_000_000


class RecorderNode(Node):
    """Records until it is stopped; then the run is made whole under its name."""

    def __init__(self, **options: Any) -> None:
        """Declare the parameters and begin the run.

        Raises:
            RunError: a parameter is wrong, or the directory exists or cannot be made.
        """
        super().__init__("recorder", **options)
        out = str(self._parameter("out", "", "directory of the run; must not exist"))
        topics = self._strings("topics", [".*"], "names or regular expressions of whole names")
        exclude = self._strings("exclude", [""], "as `topics`, of those not to record")
        acknowledge = self._strings("acknowledge", [""], "topics; an instant that all have delivered is acknowledged")
        reserve = float(self._parameter("reserve", 100.0, "free space [MB] at which recording stops; >= 0"))
        about = str(self._parameter("about", "", "YAML mapping to be kept with the run, such as {seed: 3}"))
        files = self._strings("files", [""], "text files to be kept with the run, such as parameter sets")
        problems = [] if out else ["out: expected a directory, such as -p out:=runs/dive, found none"]
        problems += [] if reserve >= 0 else [f"reserve: expected 0 or more [MB], found {reserve:g}"]
        if problems:
            raise InvalidRunError("recorder", problems)
        self._directory = Path(out)
        self._reserve = reserve * MEGABYTE
        self._stopped_for = ""
        self._free()
        selection = Selection(topics, [*exclude, f"{self.get_fully_qualified_name()}/.*"])
        simulated = bool(self.get_parameter("use_sim_time").value)
        self._about = {**said_by_the_user(about, files), "recorder": {**machine(), "topics": topics}}
        self._about["recorder"].update(exclude=exclude, use_sim_time=simulated)
        self.journal = Journal(self._directory, self._about)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._acknowledged = self.create_publisher(Header, "~/recorded", RELIABLE)
        self.topics = RecordedTopics(
            self,
            self.journal,
            selection,
            now=(lambda: self.get_clock().now().nanoseconds) if simulated else None,
            arrivals=Arrivals(t if t.startswith("/") else f"/{t}" for t in acknowledge),
            acknowledge=self._acknowledge,
        )
        self._node_parameters = NodeParameters(self, self._describe, period=LOOK_PERIOD, clock=steady)
        self._diagnostics = Diagnostics(self, clock=steady)
        self._reported = (0, time.monotonic())
        self.create_timer(FLUSH_PERIOD, self.journal.flush, clock=steady)
        self.create_timer(LOOK_PERIOD, self.topics.look, clock=steady)
        self.create_timer(REPORT_PERIOD, self._report, clock=steady)
        self._report()

    def on_stop(self) -> None:
        """Finish the run; a run that cannot be finished stays readable as it is."""
        if not self.journal.failed:
            self.topics.finish()
        self.journal.close()
        if self.journal.failed:
            return
        try:
            done = finish(self._directory)
        except CannotWriteError as error:
            if not self._stopped_for:
                raise
            self.get_logger().error(str(error))  # the reason for which it stopped is on its way already
            return
        lost = f", {self.topics.lost} lost on the way" if self.topics.lost else ""
        self.get_logger().info(f"{done.directory}: {done.messages} messages{lost}")

    def _acknowledge(self, stamp: int) -> None:
        message = Header()
        message.stamp.sec, message.stamp.nanosec = divmod(stamp, NANOSECONDS)
        self._acknowledged.publish(message)

    def _describe(self) -> None:
        self.journal.describe({**self._about, "nodes": self._node_parameters.found})

    def _report(self) -> None:
        count, now, free = self.journal.messages, time.monotonic(), self._free()
        before, then = self._reported
        self._reported = (count, now)
        values = {
            "topics": len(self.topics),
            "messages": count,
            "rate [messages/s]": round((count - before) / max(now - then, 1e-9), 1),
            "lost": self.topics.lost,
            "size [bytes]": self.journal.size,
            "disk left [bytes]": free,
            **{f"not recorded: {name}": why for name, why in self.topics.troubles.items()},
        }
        if self.topics.lost or self.topics.troubles:
            self._diagnostics.report("warn", "recording, but not everything", values)
        else:
            self._diagnostics.report("ok", "recording", values)

    def _free(self) -> int:
        """Return the space left on the disk [bytes].

        Raises:
            CannotWriteError: it is less than what is to stay free.
        """
        free = free_bytes(self._directory)
        if free < self._reserve:
            left = f"{free / MEGABYTE:.1f} MB are left on the disk, {self._reserve / MEGABYTE:.1f} MB are to stay free"
            self._stopped_for = f"{self._directory}: no recording: {left}"
            raise CannotWriteError(self._stopped_for, path=self._directory, expected=self._reserve, found=free)
        return free

    def _parameter(self, name: str, default: object, description: str) -> Any:
        descriptor = ParameterDescriptor(description=description, read_only=True)
        return self.declare_parameter(name, default, descriptor).value

    def _strings(self, name: str, default: list[str], description: str) -> list[str]:
        return [text for text in self._parameter(name, default, description) if text]


def build() -> Node:
    """Return the node; what is wrong with its parameters is a refusal to start."""
    try:
        return RecorderNode()
    except RunError as error:
        raise StartRefused(str(error)) from error


def main() -> int:
    """Record until SIGINT or SIGTERM; return 0, 1 where recording failed, 2 where it was refused."""
    return exit_status("recorder", lambda: run_node(build))


if __name__ == "__main__":
    sys.exit(main())
