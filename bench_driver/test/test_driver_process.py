"""The driver as a process on a pseudo-terminal in real time: however it ends, the thruster gets zero."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bench_driver.device import Inputs, Outputs
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.pty_device_io import PtyDevice
from thruster_msgs.msg import Throttle
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.qos import RELIABLE

LONGEST = 30.0  # s, a busy machine included
IDLE = Inputs(tachometer_counts=(0,), flow_counts=(512,), load_counts=(512,) * 6)


class Bench:
    """A device on a pseudo-terminal, served by a thread; the driver's process; throttles of 1.5 V all the time."""

    def __init__(self, context: Context, domain: int, log: Path) -> None:
        self.log = log.open("w+")
        self.served = PtyDevice(EmulatedDevice(line_speed=115200), lambda period, outputs: IDLE, IDLE)
        self._stop = threading.Event()
        self._thread = threading.Thread(
            target=self.served.run, args=(self._stop.is_set, time.monotonic, self._stop.wait), daemon=True
        )
        self._thread.start()
        given = ["-p", f"port:='{self.served.path}'", "-p", "protocol:=frames", "-p", "quiet:=0.0"]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "bench_driver.driver_node", "--ros-args", *given],
            env={**os.environ, "ROS_DOMAIN_ID": str(domain)}, stdout=self.log, stderr=subprocess.STDOUT,
        )  # fmt: skip
        self.node = Node("commander", context=context)
        self.commands = self.node.create_publisher(Throttle, "thruster_0/throttle", RELIABLE)
        self.node.create_timer(0.02, self._command)
        self.executor = make_executor("single", context=context)
        self.executor.add_node(self.node)

    def _command(self) -> None:
        message = Throttle(commanded=1.5, sent=math.nan)
        message.header.stamp = self.node.get_clock().now().to_msg()
        self.commands.publish(message)

    @property
    def outputs(self) -> Outputs:
        assert self.served.outputs is not None
        return self.served.outputs

    def until(self, driven: bool, longest: float = LONGEST) -> bool:
        """Command until the thruster is driven, or not driven."""
        return spin_until(
            self.executor,
            lambda: self.served.outputs is not None and (self.outputs.throttles[0] > 1.0) is driven,
            longest,
        )

    def close(self) -> None:
        self.process.kill()
        self.process.wait()
        self._stop.set()
        self._thread.join()
        self.served.close()
        self.executor.shutdown()
        self.node.destroy_node()
        self.log.close()


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    domain = int(os.environ["ROS_DOMAIN_ID"])
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain)
    made = Bench(context, domain, tmp_path / "log.txt")
    yield made
    made.close()
    rclpy.try_shutdown(context=context)


def said(bench: Bench) -> str:
    bench.log.seek(0)
    return bench.log.read()


def test_a_node_that_is_killed_leaves_the_device_to_its_watchdog(bench: Bench) -> None:
    assert bench.until(True), said(bench)
    bench.process.kill()
    assert bench.until(False, 5.0), "though throttles are still published"
    assert bench.outputs.enabled == (False,)


def test_a_node_that_is_told_to_stop_sets_zero_itself(bench: Bench) -> None:
    assert bench.until(True), said(bench)
    bench.process.send_signal(signal.SIGTERM)
    assert bench.until(False, 5.0)
    assert bench.process.wait(LONGEST) == 0, said(bench)


def test_an_unplugged_device_is_survived(bench: Bench) -> None:
    assert bench.until(True), said(bench)
    bench._stop.set()
    bench._thread.join()
    bench.served.close()
    spin_until(bench.executor, lambda: False, 1.0)
    assert bench.process.poll() is None, said(bench)
