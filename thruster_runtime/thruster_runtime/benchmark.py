"""How long a `state` takes to become a `throttle`, for six thrusters with an observer and an inner loop each.

Composed: the twelve nodes in one process with the events executor. Apart: a process each. In both, what plays the
bench is another process, which publishes state, flow and set point of all thrusters and receives the throttles.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import nan
from pathlib import Path
from typing import Any, NamedTuple

import rclpy
import yaml
from rclpy.context import Context
from rclpy.node import Node
from rosgraph_msgs.msg import Clock

from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterState, ThrustSetpoint
from thruster_runtime.executors import make_executor
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamp_join import nanoseconds

__all__ = ["Figures", "Row", "lockstep", "main", "real_time", "rows"]

THRUSTERS = 6
RATES = (25.0, 100.0, 200.0)
_PERIOD = 40_000_000  # ns, in lockstep
_LONGEST_START = 240.0  # s: kernels may have to be compiled first
_LONGEST_ANSWER = 2.0  # s
_CLASSES = {
    "observer": "thruster_estimation.observer_node:ObserverNode",
    "inner_loop": "thruster_control.inner_loop_node:InnerLoopNode",
}


class Figures(NamedTuple):
    """Of one arrangement at one rate [Hz]: latencies [s], CPU per node [share of a core], share of throttles lost."""

    rate: float
    median: float
    p99: float
    cpu_per_node: float
    lost: float


class Row(NamedTuple):
    """One comparison: what, composed and a process each, in `unit`."""

    what: str
    ours: float
    plain: float
    unit: str


class _Bench(Node):
    """Publishes what all thrusters' instruments would, and remembers when each throttle came."""

    def __init__(self, context: Context) -> None:
        super().__init__("bench", context=context)
        self.came: dict[tuple[int, int], float] = {}
        self.clock = self.create_publisher(Clock, "/clock", RELIABLE)
        self.outputs = []
        for i in range(THRUSTERS):
            kinds = {"thrust_setpoint": ThrustSetpoint, "flow": FlowVelocity, "state": ThrusterState}
            self.outputs.append([self.create_publisher(t, f"thruster_{i}/{n}", RELIABLE) for n, t in kinds.items()])
            self.create_subscription(Throttle, f"thruster_{i}/throttle", self._noting(i), RELIABLE)
        self._receiving = make_executor("events", context=context)
        self._receiving.add_node(self)

    def _noting(self, i: int) -> Callable[[Throttle], None]:
        def note(message: Throttle) -> None:
            self.came[i, nanoseconds(message.header.stamp)] = time.perf_counter()

        return note

    def publish(self, stamp_ns: int, *, clock: bool) -> list[float]:
        """Publish everything of a stamp; return when each thruster's state went out [s]."""
        sent = []
        if clock:
            message = Clock()
            message.clock.sec, message.clock.nanosec = divmod(stamp_ns, 10**9)
            self.clock.publish(message)
        for outputs in self.outputs:
            messages = (ThrustSetpoint(thrust=5.0), FlowVelocity(axial=nan, ambient=0.1), ThrusterState(n=60.0))
            for output, message in zip(outputs, messages, strict=True):
                message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
                sent_at = time.perf_counter()
                output.publish(message)
            sent.append(sent_at)
        return sent

    def spin_until(self, deadline: float, done: Callable[[], bool] = lambda: False) -> bool:
        """Receive until `done()` or the deadline of the monotonic clock [s]; return whether it is done."""
        while not done():
            left = deadline - time.perf_counter()
            if left <= 0.0:
                return False
            self._receiving.spin_once(timeout_sec=min(left, 0.05))
        return True

    def answered(self, stamp_ns: int) -> Callable[[], bool]:
        """Return whether all throttles of a stamp have come, as a function."""
        return lambda: all((i, stamp_ns) in self.came for i in range(THRUSTERS))

    def close(self) -> None:
        """Leave the graph."""
        self._receiving.remove_node(self)
        self._receiving.shutdown()
        self.destroy_node()


def _entries(simulated: bool) -> list[dict[str, Any]]:
    common = {"use_sim_time": simulated}
    return [
        {"class": kind, "name": f"{name}_{i}", "parameters": {"thruster": i, **common}}
        for i in range(THRUSTERS)
        for name, kind in _CLASSES.items()
    ]


@contextmanager
def _graph(composed: bool, simulated: bool, domain_id: int) -> Iterator[tuple[_Bench, list[int]]]:
    """Give the bench and the ids of the processes of the nodes, all of them answering."""
    entries = _entries(simulated)
    groups = [entries] if composed else [[entry] for entry in entries]
    environment = dict(os.environ, ROS_DOMAIN_ID=str(domain_id), OPENBLAS_NUM_THREADS="1")
    processes: list[subprocess.Popen[bytes]] = []
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain_id)
    bench = _Bench(context)
    try:
        with tempfile.TemporaryDirectory() as folder:
            for index, group in enumerate(groups):
                file = Path(folder) / f"{index}.yaml"
                file.write_text(yaml.safe_dump({"nodes": group}), "utf-8")
                command = [sys.executable, "-m", "thruster_runtime.compose", str(file)]
                processes.append(subprocess.Popen(command, env=environment))
            _wait(bench, processes)
            yield bench, [process.pid for process in processes]
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            try:
                process.wait(10.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        bench.close()
        rclpy.try_shutdown(context=context)


def _wait(bench: _Bench, processes: list[subprocess.Popen[bytes]]) -> None:
    deadline = time.perf_counter() + _LONGEST_START
    stamp = 0
    while time.perf_counter() < deadline:
        if ended := [process.args for process in processes if process.poll() is not None]:
            raise RuntimeError(f"expected all nodes to run; ended: {ended}")
        stamp += _PERIOD
        bench.publish(stamp, clock=True)
        if bench.spin_until(time.perf_counter() + 0.5, bench.answered(stamp)):
            return
    raise RuntimeError(f"expected {THRUSTERS} throttles within {_LONGEST_START:g} s; the nodes did not answer")


def _cpu(pids: list[int]) -> float:
    """Return the time that processes have used so far [s]."""
    ticks = 0
    for pid in pids:
        fields = Path(f"/proc/{pid}/stat").read_text("ascii").rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def real_time(*, composed: bool, seconds: float = 5.0, domain_id: int = 40) -> list[Figures]:
    """Measure latencies from each `state` to its `throttle` at the rates of `RATES`, `seconds` each."""
    found = []
    with _graph(composed, False, domain_id) as (bench, pids):
        for rate in RATES:
            count, latencies = int(seconds * rate), []
            bench.came.clear()
            sent: dict[int, list[float]] = {}
            before, begin = _cpu(pids), time.perf_counter()
            for k in range(count):
                bench.spin_until(begin + k / rate)
                stamp = time.time_ns()
                sent[stamp] = bench.publish(stamp, clock=False)
            bench.spin_until(time.perf_counter() + 1.0 / rate)
            used, elapsed = _cpu(pids) - before, time.perf_counter() - begin
            bench.spin_until(time.perf_counter() + _LONGEST_ANSWER, bench.answered(stamp))
            for stamp, instants in sent.items():
                latencies += [bench.came[i, stamp] - at for i, at in enumerate(instants) if (i, stamp) in bench.came]
            latencies.sort()
            lost = 1.0 - len(latencies) / (count * THRUSTERS)
            median, p99 = (latencies[int(share * (len(latencies) - 1))] for share in (0.5, 0.99))
            found.append(Figures(rate, median, p99, used / elapsed / (2 * THRUSTERS), lost))
    return found


def lockstep(*, composed: bool, periods: int = 500, domain_id: int = 41) -> float:
    """Return how many times faster than real time, at 25 Hz, all thrusters answer in lockstep with /clock.

    Raises:
        RuntimeError: with the thrusters whose throttle did not come.
    """
    with _graph(composed, True, domain_id) as (bench, _):
        begin, stamp = time.perf_counter(), 10**12
        for _ in range(periods):
            stamp += _PERIOD
            bench.publish(stamp, clock=True)
            if not bench.spin_until(time.perf_counter() + _LONGEST_ANSWER, bench.answered(stamp)):
                missing = [i for i in range(THRUSTERS) if (i, stamp) not in bench.came]
                raise RuntimeError(f"expected a throttle of each thruster at {stamp} ns; missing: {missing}")
        return periods * _PERIOD / 1e9 / (time.perf_counter() - begin)


def rows(seconds: float = 5.0, periods: int = 500) -> list[Row]:
    """Compare the twelve nodes composed with a process each."""
    together, apart = (lockstep(composed=c, periods=periods) for c in (True, False))
    found = [Row("six thrusters in lockstep", together, apart, "x real")]
    ours, plain = (real_time(composed=c, seconds=seconds) for c in (True, False))
    for a, b in zip(ours, plain, strict=True):
        at = f"{a.rate:g} Hz"
        found.append(Row(f"state to throttle at {at}, median", 1e6 * a.median, 1e6 * b.median, "us"))
        found.append(Row(f"state to throttle at {at}, 99 %", 1e6 * a.p99, 1e6 * b.p99, "us"))
        found.append(Row(f"CPU per node at {at}", 1e6 * a.cpu_per_node, 1e6 * b.cpu_per_node, "us/s"))
        found.append(Row(f"throttles lost at {at}", 1e6 * a.lost, 1e6 * b.lost, "1e-6"))
    return found


def main() -> None:
    """Print the rows."""
    sys.stdout.write(f"{'what':<42}{'unit':<10}{'composed':>12}{'apart':>12}\n")
    for row in rows():
        sys.stdout.write(f"{row.what:<42}{row.unit:<10}{row.ours:>12,.1f}{row.plain:>12,.1f}\n")


if __name__ == "__main__":
    main()
