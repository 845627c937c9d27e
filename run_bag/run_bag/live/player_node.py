"""`ros2 run run_bag play RUN`: publish the messages of a run."""

from __future__ import annotations

import sys
import threading
import time
from argparse import Namespace
from collections.abc import Sequence
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rosgraph_msgs.msg import Clock as ClockMessage

from thruster_runtime.errors import StartRefused
from thruster_runtime.node_main import run_node
from thruster_runtime.qos import RECORDER

from ..cli_play import options
from ..command_line import exit_status
from ..definitions import definitions
from ..errors import MissingParticipantError, RunError, SchemaError
from ..playback import Lockstep, Played, participants, play, with_ticks
from ..rosbag2 import LATCHED_QOS
from ..run_metadata import TOPIC, TYPE
from ..selection import Selection
from ..stamps import has_header, header_stamp, restamped
from ..timeline import CLOCK, Instant, read_timeline
from .qos import offer, request
from .raw_topic import Arrival, RawTopic, message_class

LOOK_PERIOD = 0.05
NANOSECONDS = 1_000_000_000


class PlayerNode(Node):
    """Plays a run once its subscribers are there; sets `stop` when it is done."""

    def __init__(self, given: Namespace, stop: threading.Event, **node_options: Any) -> None:
        """Read the run and offer its topics.

        Args:
            given: the command line (`cli_play.options`).
            stop: ends the player; it sets it at the end of the run.
            node_options: as Node.

        Raises:
            RunError: the run cannot be read, or a topic that was named cannot be played.
        """
        super().__init__("player", **node_options)
        self._given, self._stop = given, stop
        self._outputs = participants(given.wait_for)
        exclude = [*given.exclude, *self._outputs]
        chosen = Selection(given.topics, exclude)
        self._timeline = read_timeline(given.run, chosen, order=given.by, start=given.start, end=given.end)
        for sentence in self._timeline.left_out:
            self.get_logger().warning(sentence)
        self._publishers = [
            self.create_publisher(message_class(t.type), t.name, offer(t.offers)) for t in self._timeline.topics
        ]
        if self._timeline.told:
            latched = message_class(TYPE)
            self._telling = self.create_publisher(latched, TOPIC, offer((LATCHED_QOS,)))
            self._telling.publish(latched(data=self._timeline.told))
        kinds = [t.type for t in self._timeline.topics]
        self._restamps = [given.restamp and has_header(definitions().fields(kind), kind) for kind in kinds]
        self._clock_publisher = None if given.no_clock else self.create_publisher(ClockMessage, CLOCK, RECORDER)
        self._lockstep = Lockstep(self._outputs, given.timeout)
        self._heard: dict[str, RawTopic] = {}
        self._error: RunError | None = None
        self.played = Played()
        self._thread = threading.Thread(target=self._run, name="player")
        self._seen = (-1, time.monotonic())
        self._created = time.monotonic()
        self._timer = self.create_timer(LOOK_PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def on_stop(self) -> None:
        """End the playing and say how it went.

        Raises:
            RunError: why it ended before its time.
        """
        self._stop.set()
        self._lockstep.wake()
        if self._thread.ident is not None:
            self._thread.join()
        if self._error is not None:
            raise self._error
        late = "" if self._given.step or self._given.fast else f", at most {self.played.latest * 1e3:.1f} ms late"
        self.get_logger().info(f"{self._given.run}: {self.played.messages} messages played{late}")

    def _look(self) -> None:
        """Begin when every participant is there and the graph has been quiet for a while."""
        missing = [name for name in self._outputs if name not in self._heard and not self._hear(name)]
        matched = sum(p.get_subscription_count() for p in self._publishers)
        there = sum(self.count_subscribers(t.name) for t in self._timeline.topics)
        now = time.monotonic()
        if matched != self._seen[0] or missing:
            self._seen = (matched, now)
        waited = now - self._created
        if missing and waited > self._given.timeout + self._given.delay:
            text = f"nobody publishes {', '.join(missing)}, waited {waited:.1f} s"
            self._end(MissingParticipantError(text, topic=missing[0], found=tuple(missing)))
        elif not missing and now - self._seen[1] >= self._given.delay:
            if matched < there and waited <= self._given.timeout + self._given.delay:
                return
            if matched < there:
                self.get_logger().warning(f"{there - matched} subscriptions do not fit what is offered (QoS)")
            self._timer.cancel()
            self._thread.start()

    def _hear(self, name: str) -> bool:
        """Subscribe to a participant's output, once it is there."""
        publishers = self.get_publishers_info_by_topic(name)
        if not publishers:
            return False
        kind = publishers[0].topic_type
        if not has_header(definitions().fields(kind), kind):
            raise SchemaError(f"{name}: {kind} has no header, so that it cannot answer an instant", topic=name)

        def receive(arrival: Arrival) -> None:
            self._lockstep.arrived(name, header_stamp(arrival.payload))

        self._heard[name] = RawTopic(self, name, kind, request([p.qos_profile for p in publishers]), receive)
        return True

    def _run(self) -> None:
        given = self._given
        # In lockstep only instants count; between them a clock would tell participants of time that has no inputs yet.
        period = 0 if given.step else round(given.clock_period * NANOSECONDS)
        names = [t.name for t in self._timeline.topics]
        try:
            while True:
                self.played = play(
                    with_ticks(self._timeline.instants(), period),
                    self._publish,
                    rate=None if given.step or given.fast else given.rate,
                    monotonic=time.monotonic,
                    sleep=self._stop.wait,
                    acknowledged=lambda instant: self._lockstep.wait(
                        instant.time, {names[i] for i, _ in instant.messages}, self._stop.is_set
                    ),
                )
                if given.loop == "no" or self._stop.is_set():
                    break
                self._lockstep.again()
            self._end(None)
        except RunError as error:
            self._end(error)

    def _publish(self, instant: Instant) -> None:
        if self._clock_publisher is not None:
            message = ClockMessage()
            message.clock.sec, message.clock.nanosec = divmod(instant.time, NANOSECONDS)
            self._clock_publisher.publish(message)
        for index, payload in instant.messages:
            now = self.get_clock().now().nanoseconds if self._restamps[index] else None
            self._publishers[index].publish(payload if now is None else restamped(payload, now))

    def _end(self, error: RunError | None) -> None:
        self._error = error
        self._stop.set()


def main(argv: Sequence[str] | None = None) -> int:
    """Play; return 0, 1 where the playing failed, 2 where it was refused."""
    given = options(argv)
    stop = threading.Event()

    def build() -> Node:
        try:
            return PlayerNode(given, stop)
        except RunError as error:
            raise StartRefused(str(error)) from error

    return exit_status("play", lambda: run_node(build, args=argv, stop=stop))


if __name__ == "__main__":
    sys.exit(main())
