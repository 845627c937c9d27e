"""How many messages a second the recorder takes without loss: `python -m run_bag.live.benchmark [RATE [SECONDS]]`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import rclpy
from geometry_msgs.msg import WrenchStamped
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.serialization import serialize_message

from thruster_runtime.qos import RECORDER

from ..benchmark_row import Row
from ..reader import read_recording

TOPICS = 15
DISCOVERY_TIMEOUT = 30.0
"""[s] For the recorder to start and to hear all topics."""
ACKNOWLEDGED_WITHIN = Duration(seconds=30)
STOP_TIMEOUT = 120.0
SLICE = 0.005
"""[s] The publisher sends what is due this often."""
RECORDER_PROGRAM = "import sys; from run_bag.live.recorder_node import main; sys.exit(main())"


class Throughput(NamedTuple):
    """What was measured: messages, time of publishing [s], share of a core that the recorder took."""

    published: int
    recorded: int
    seconds: float
    core: float

    @property
    def lost(self) -> int:
        """Messages that are not in the run."""
        return self.published - self.recorded

    @property
    def rate(self) -> float:
        """Messages a second that were published."""
        return self.published / self.seconds


def measure(rate: float = 16_000.0, seconds: float = 6.0) -> Throughput:
    """Publish WrenchStamped on 15 topics to a recorder in a process of its own.

    Args:
        rate: messages a second over all topics.
        seconds: how long.

    Raises:
        TimeoutError: the recorder did not come.
    """
    context = Context()
    rclpy.init(args=[], context=context)
    node = Node("benchmark", context=context)
    publishers = [node.create_publisher(WrenchStamped, f"benchmark/t{i}", RECORDER) for i in range(TOPICS)]
    payload = serialize_message(WrenchStamped())
    try:
        with TemporaryDirectory() as folder:
            out = Path(folder) / "run"
            arguments = ["--ros-args", "-p", f"out:={out}", "-p", "topics:=[benchmark/.*]"]
            with subprocess.Popen([sys.executable, "-c", RECORDER_PROGRAM, *arguments]) as recorder:
                try:
                    deadline = time.monotonic() + DISCOVERY_TIMEOUT
                    while not all(p.get_subscription_count() for p in publishers):
                        if time.monotonic() > deadline:
                            raise TimeoutError(f"no recorder within {DISCOVERY_TIMEOUT:g} s")
                        time.sleep(0.1)
                    before, begin, sent = _core_seconds(recorder.pid), time.monotonic(), 0
                    while (passed := time.monotonic() - begin) < seconds:
                        while sent < passed * rate:
                            publishers[sent % TOPICS].publish(payload)
                            sent += 1
                        time.sleep(SLICE)
                    passed = time.monotonic() - begin
                    core = (_core_seconds(recorder.pid) - before) / passed
                    for publisher in publishers:
                        publisher.wait_for_all_acked(ACKNOWLEDGED_WITHIN)
                    recorder.send_signal(signal.SIGINT)
                    recorder.wait(STOP_TIMEOUT)
                finally:
                    recorder.kill()
            recorded = sum(one.message_count for one in read_recording(out, set()).scans)
            return Throughput(sent, recorded, passed, core)
    finally:
        node.destroy_node()
        rclpy.try_shutdown(context=context)


def rows(rate: float = 16_000.0, seconds: float = 4.0) -> list[Row]:
    """Measure what arrives in the run of what is published at `rate` [messages/s] over all topics."""
    result = measure(rate, seconds)
    return [
        Row("recorder: messages recorded of published", result.recorded / result.seconds, result.rate, "messages/s"),
        Row("recorder: core per message", 1e9 * result.core / result.rate, 1e9 / result.rate, "ns"),
    ]


def _core_seconds(pid: int) -> float:
    """Return the processor time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> int:
    """Measure and print."""
    result = measure(*(float(text) for text in sys.argv[1:3]))
    sys.stdout.write(
        f"{result.published} messages at {result.rate:.0f} messages/s, {result.lost} lost, "
        f"recorder {100 * result.core:.0f} % of a core\n"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
