"""Record topics of the graph to a run:   ros2 run run_bag recorder --ros-args -p out:=DIR

subscribes  what `topics` selects, as it appears in the graph; /parameter_events, for the parameters that are changed
publishes   recorder/recorded: the instants that are complete and recorded, once everything of `wait_for` is heard;
            /diagnostics

A topic of `wait_for` is heard once it has a publisher whose messages come here. In real time one has to have come; in
simulated time, which does not begin before, it has to be connected. Status 1 where nothing at all was recorded.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header

from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.errors import StartRefused
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, declare
from thruster_runtime.qos import RELIABLE

from ..arrivals import Arrivals
from ..command_line import exit_status
from ..errors import CannotWriteError, InvalidRunError, RecordingError, RunError
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
PARAMETERS = (
    Parameter(name="out", default="", description="directory of the run; must not exist"),
    Parameter(name="topics", default=(".*",), description="names or regular expressions of whole names"),
    Parameter(name="exclude", default=("",), description="as `topics`, of those not to record"),
    Parameter(
        name="acknowledge", default=("",), description="topics; an instant that all have delivered is acknowledged"
    ),
    Parameter(
        name="wait_for", default=("",),
        description="topics that have to be heard: which are not is said on /diagnostics, and at the end",
    ),
    Parameter(
        name="reserve", default=100.0, unit="MB", lower=0.0, description="free space at which recording stops"
    ),
    Parameter(name="about", default="", description="YAML mapping to be kept with the run, such as {seed: 3}"),
    Parameter(
        name="files", default=("",), description="text files to be kept with the run, such as parameter sets"
    ),
)  # fmt: skip


class RecorderNode(Node):
    """Records until it is stopped; then the run is made whole under its name."""

    def __init__(self, **options: Any) -> None:
        """Declare the parameters and begin the run.

        Raises:
            RunError: a parameter is wrong, or the directory exists or cannot be made.
        """
        super().__init__("recorder", **options)
        values = declare(self, PARAMETERS)
        topics, exclude, acknowledge, wait_for, files = (
            [text for text in values[name] if text]
            for name in ("topics", "exclude", "acknowledge", "wait_for", "files")
        )
        if not values["out"]:
            raise InvalidRunError("recorder", ["out: expected a directory, such as -p out:=runs/dive, found none"])
        self._directory = Path(values["out"])
        self._reserve = values["reserve"] * MEGABYTE
        self._stopped_for = ""
        self._free()
        selection = Selection(topics, [*exclude, f"{self.get_fully_qualified_name()}/.*"])
        simulated = bool(self.get_parameter("use_sim_time").value)
        self._about = {**said_by_the_user(values["about"], files), "recorder": {**machine(), "topics": topics}}
        self._about["recorder"].update(exclude=exclude, use_sim_time=simulated)
        self.journal = Journal(self._directory, self._about)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._wait_for = [self.resolve_topic_name(name) for name in wait_for]
        self._simulated = simulated
        self._acknowledged = None if wait_for else self.create_publisher(Header, "~/recorded", RELIABLE)
        self.topics = RecordedTopics(
            self,
            self.journal,
            selection,
            now=(lambda: self.get_clock().now().nanoseconds) if simulated else None,
            arrivals=Arrivals(t if t.startswith("/") else f"/{t}" for t in acknowledge),
            acknowledge=self._acknowledge,
        )
        self._node_parameters = NodeParameters(
            self, self._describe, period=LOOK_PERIOD, clock=steady, now=self.topics.now
        )
        self._diagnostics = Diagnostics(self, clock=steady)
        self._reported = (0, time.monotonic())
        self.create_timer(FLUSH_PERIOD, self.journal.flush, clock=steady)
        self.create_timer(LOOK_PERIOD, self._look, clock=steady)
        self.create_timer(REPORT_PERIOD, self._report, clock=steady)
        self._report()

    def _look(self) -> None:
        self.topics.look()
        # Lockstep waits for this publisher to appear, and set points may: so nothing begins that is not heard.
        if self._acknowledged is None and not self._unheard():
            self._acknowledged = self.create_publisher(Header, "~/recorded", RELIABLE)
            self._report()

    def _unheard(self) -> list[str]:
        """Return the topics of `wait_for` that are not heard yet."""
        return [name for name in self._wait_for if not self.topics.hears(name, messages=not self._simulated)]

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
        silent = [name for name in self._wait_for if not self.topics.hears(name, messages=True)]
        silent += [name for name in self.topics.silent if name not in silent]
        if silent:
            self.get_logger().warning(f"nothing came from {', '.join(sorted(silent))}")
        if not done.messages or (self._wait_for and set(self._wait_for) <= set(silent)):
            of = f" of {', '.join(self._wait_for)}" if done.messages else ""
            raise RecordingError(f"{done.directory}: nothing at all{of} was recorded", path=done.directory)

    def _acknowledge(self, stamp: int) -> None:
        if self._acknowledged is None:
            return
        message = Header()
        message.stamp.sec, message.stamp.nanosec = divmod(stamp, NANOSECONDS)
        self._acknowledged.publish(message)

    def _describe(self) -> None:
        parameters = self._node_parameters
        changes = {"parameter_changes": parameters.changes} if parameters.changes else {}
        self.journal.describe({**self._about, "nodes": parameters.found, **changes})

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
        if unheard := self._unheard():
            self._diagnostics.report("warn", f"recording, but waiting for {', '.join(unheard)}", values)
        elif self.topics.lost or self.topics.troubles:
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


def build() -> Node:
    """Return the node; what is wrong with its parameters is a refusal to start."""
    try:
        return RecorderNode()
    except RunError as error:
        raise StartRefused(str(error)) from error


def main() -> int:
    """Record until SIGINT or SIGTERM; return 0, 1 where recording failed, 2 where it was refused."""
    return exit_status("recorder", lambda: node_main(build, __doc__, PARAMETERS))


if __name__ == "__main__":
    sys.exit(main())
