"""How fast a vehicle's whole graph is: six thrusters with observers and inner loops, all nodes in one process or each.

In lockstep at 25 Hz by how much it is faster than real time; in real time how long it takes from an odometry until all
thrusters have their throttles, and how many of them come later than a period, or never.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import rclpy
import yaml
from nav_msgs.msg import Odometry
from rclpy.context import Context
from rclpy.node import Node

from rov_sim.vehicle.graph import Experiment, GraphNode, graph_of
from rov_sim.vehicle.sensors.settings_io import load_sensors
from run_bag.benchmark_row import Row
from thruster_msgs.msg import Throttle, ThrusterEstimate, ThrusterState, ThrustSetpoint
from thruster_runtime.executors import make_executor, spin_until
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import listen

__all__ = ["Answers", "in_lockstep", "in_real_time", "rows"]

_THRUSTERS = 6
_LONGEST_START = 240.0  # s: kernels may have to be compiled first
_LONGEST = 120.0  # s
_WIRES = {ThrusterState: "state", ThrustSetpoint: "thrust_setpoint", ThrusterEstimate: "estimate"}
_NANOSECONDS = 1_000_000_000


class Answers(NamedTuple):
    """In real time: from odometry to the last throttle, median and 99 % [s]; share that came in its period [1]."""

    median: float
    p99: float
    in_time: float


class _Ear(Node):
    """Notes when each odometry came, and when all throttles of its stamp had come; the plant's odometry is the tick.

    It hears the other wires too, as a recorder does: time begins when somebody hears them, and nodes that hand over do
    not.
    """

    def __init__(self, context: Context) -> None:
        super().__init__("ear", context=context)
        self.asked: dict[int, float] = {}
        self.answered: dict[int, list[float]] = {}
        self.latest = 0
        """Latest instant whose throttles are all there [ns], 0 for none."""
        listen(self, Odometry, "rov/odometry", self._on_odometry)
        for i in range(_THRUSTERS):
            listen(self, Throttle, f"thruster_{i}/throttle", self._on_throttle)
            for kind, name in _WIRES.items():
                self.create_subscription(kind, f"thruster_{i}/{name}", lambda data: None, RELIABLE, raw=True)

    def _on_odometry(self, odometry: Any) -> None:
        self.asked[odometry.stamp] = time.perf_counter()

    def _on_throttle(self, throttle: Any) -> None:
        came = self.answered.setdefault(throttle.stamp, [])
        came.append(time.perf_counter())
        if len(came) == _THRUSTERS:
            self.latest = max(self.latest, throttle.stamp)


def _processes(nodes: list[GraphNode], composed: bool, folder: Path, domain_id: int) -> list[subprocess.Popen[bytes]]:
    environment = dict(os.environ, ROS_DOMAIN_ID=str(domain_id), OPENBLAS_NUM_THREADS="1", OMP_NUM_THREADS="1")
    entries = [{"class": n.kind, "name": n.name, "parameters": dict(n.parameters)} for n in nodes]
    started = []
    for k, group in enumerate([entries] if composed else [[entry] for entry in entries]):
        file = folder / f"{k}.yaml"
        file.write_text(yaml.safe_dump({"nodes": group, "hand_over": True}), "utf-8")
        command = [sys.executable, "-m", "thruster_runtime.compose", str(file)]
        started.append(subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL))
    return started


@contextmanager
def _graph(composed: bool, rate: float, lockstep: bool, domain_id: int) -> Iterator[tuple[_Ear, Callable[..., bool]]]:
    """Give who listens to a graph that runs, and what spins it until something has happened."""
    experiment = Experiment(
        thrusters=_THRUSTERS, sensors=load_sensors(), rate=rate, lockstep=lockstep, recorded=False, start_delay=0.5
    )
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain_id)
    ear = _Ear(context)
    executor = make_executor("events", context=context)
    executor.add_node(ear)
    started: list[subprocess.Popen[bytes]] = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            started = _processes(graph_of(experiment), composed, Path(folder), domain_id)

            def until(happened: Callable[[], bool], longest: float = _LONGEST) -> bool:
                ended = [each.args for each in started if each.poll() is not None]
                if ended:
                    raise RuntimeError(f"expected all nodes to run; ended: {ended}")
                return bool(spin_until(executor, happened, longest))

            if not until(lambda: ear.latest > 0, _LONGEST_START):
                raise RuntimeError(f"expected {_THRUSTERS} throttles of one stamp within {_LONGEST_START:g} s")
            yield ear, until
    finally:
        for process in started:
            process.terminate()
        for process in started:
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        executor.remove_node(ear)
        executor.shutdown()
        ear.destroy_node()
        rclpy.try_shutdown(context=context)


def in_lockstep(composed: bool, *, seconds: float = 10.0, domain_id: int = 42) -> float:
    """Return how many times faster than real time the graph dives in lockstep at 25 Hz, over `seconds` of the dive."""
    with _graph(composed, 25.0, True, domain_id) as (ear, until):
        first, begin = ear.latest, time.perf_counter()
        end = first + round(seconds * _NANOSECONDS)
        if not until(lambda: ear.latest >= end):
            raise RuntimeError(f"expected {seconds:g} s of the dive within {_LONGEST:g} s")
        return (ear.latest - first) / _NANOSECONDS / (time.perf_counter() - begin)


def in_real_time(composed: bool, rate: float, *, seconds: float = 6.0, domain_id: int = 43) -> Answers:
    """Measure the graph by the wall's clock over `seconds`; the first second counts for nothing."""
    with _graph(composed, rate, False, domain_id) as (ear, until):
        begin = time.perf_counter() + 1.0
        until(lambda: time.perf_counter() >= begin + seconds)
        asked = {stamp: at for stamp, at in ear.asked.items() if begin <= at < begin + seconds - 0.5}
        waits = []
        for stamp, at in asked.items():
            came = ear.answered.get(stamp, [])
            waits.append(max(came) - at if len(came) == _THRUSTERS else float("inf"))
        ordered = sorted(waits)
        in_time = sum(wait < 1.0 / rate for wait in waits) / max(len(waits), 1)
        return Answers(ordered[len(ordered) // 2], ordered[int(0.99 * (len(ordered) - 1))], in_time)


def rows(seconds: float = 6.0) -> list[Row]:
    """Compare all nodes of the graph in one process with a process each."""
    ours, plain = (in_lockstep(composed, seconds=seconds) for composed in (True, False))
    found = [Row("vehicle's graph in lockstep at 25 Hz", ours, plain, "x real time")]
    for rate in (25.0, 100.0):
        together, apart = (in_real_time(composed, rate, seconds=seconds) for composed in (True, False))
        what = f"vehicle's graph at {rate:g} Hz, by the clock"
        found.append(Row(f"{what}: median", 1e6 * together.median, 1e6 * apart.median, "us"))
        found.append(Row(f"{what}: in time", 100.0 * together.in_time, 100.0 * apart.in_time, "% of ticks"))
    return found
