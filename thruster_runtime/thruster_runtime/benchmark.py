"""How long a `state` takes to become a `throttle`, for thrusters with an observer and an inner loop each.

Arrangements: all nodes in one process with the events executor, handing their messages to each other, or each through
the middleware; a process for each half of the thrusters, for the two nodes of each thruster (these hand over too), for
each node. In all of them what plays the bench is another process, which publishes state, flow and set point of all
thrusters and receives the throttles. As a real device would, it does not catch up with a tick that it missed.

Beside them stands what the machine itself does to such figures: how long the same work takes in one process by itself.
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
from rclpy.task import Future
from rosgraph_msgs.msg import Clock

from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterState, ThrustSetpoint
from thruster_runtime.executors import make_executor
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import format_of, listen

__all__ = ["ARRANGEMENTS", "Figures", "Row", "alone", "lockstep", "main", "real_time", "rows"]

THRUSTERS = 6
RATES = (25.0, 100.0, 200.0)
_PERIOD = 40_000_000  # ns, in lockstep
_LONGEST_START = 240.0  # s: kernels may have to be compiled first
_LONGEST_ANSWER = 2.0  # s
_CLASSES = {
    "observer": "thruster_estimation.observer_node:ObserverNode",
    "inner_loop": "thruster_control.inner_loop_node:InnerLoopNode",
}
_NODES = THRUSTERS * len(_CLASSES)
ARRANGEMENTS = {
    "handed over": _NODES,
    "one process": _NODES,
    "two processes": _NODES // 2,
    "per thruster": len(_CLASSES),
    "per node": 1,
}
"""How many nodes share a process; all but those of "one process" hand their messages over."""


class Figures(NamedTuple):
    """Of one arrangement at one rate [Hz]: latencies [s], CPU per node and tick [s], share of throttles lost."""

    rate: float
    median: float
    p99: float
    cpu: float
    lost: float


class Row(NamedTuple):
    """One comparison: what, composed and a process each, in `unit`."""

    what: str
    ours: float
    plain: float
    unit: str


class _Bench(Node):
    """Publishes what all thrusters' instruments would, and remembers when each throttle came."""

    def __init__(self, context: Context, thrusters: int) -> None:
        super().__init__("bench", context=context)
        self.thrusters = thrusters
        self.came: dict[tuple[int, int], float] = {}
        self.clock = self.create_publisher(Clock, "/clock", RELIABLE)
        self.outputs = []
        for i in range(thrusters):
            kinds = {"thrust_setpoint": ThrustSetpoint, "flow": FlowVelocity, "state": ThrusterState}
            self.outputs.append([self.create_publisher(t, f"thruster_{i}/{n}", RELIABLE) for n, t in kinds.items()])
            listen(self, Throttle, f"thruster_{i}/throttle", self._noting(i))
        self._receiving = make_executor("events", context=context)
        self._receiving.add_node(self)
        self._never: Future = Future()

    def _noting(self, i: int) -> Callable[[Any], None]:
        def note(throttle: Any) -> None:
            self.came[i, throttle.stamp] = time.perf_counter()

        return note

    def publish(self, stamp: int, *, clock: bool) -> list[float]:
        """Publish everything of a stamp [ns]; return when each thruster's state went out [s]."""
        sent = []
        if clock:
            ticks = format_of(Clock)
            self.clock.publish(ticks.write(ticks.record(clock=stamp)))
        setpoints, flows, states = map(format_of, (ThrustSetpoint, FlowVelocity, ThrusterState))
        messages = (
            setpoints.write(setpoints.record(stamp, "", thrust=5.0)),
            flows.write(flows.record(stamp, "", axial=nan, ambient=0.1, quality=nan, spike=False)),
            states.write(states.record(stamp, "", n=60.0, sign_source=0, supply_voltage=nan, current=nan)),
        )
        for outputs in self.outputs:
            for output, message in zip(outputs, messages, strict=True):
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

    def spin_for(self, seconds: float) -> None:
        """Receive for a time [s], at least what has come."""
        self._receiving.spin_until_future_complete(self._never, timeout_sec=max(seconds, 0.0))

    def answered(self, stamp: int) -> Callable[[], bool]:
        """Return whether all throttles of a stamp [ns] have come, as a function."""
        return lambda: all((i, stamp) in self.came for i in range(self.thrusters))

    def close(self) -> None:
        """Leave the graph."""
        self._receiving.remove_node(self)
        self._receiving.shutdown()
        self.destroy_node()


def _groups(arrangement: str, thrusters: int, simulated: bool) -> list[list[dict[str, Any]]]:
    """Return the nodes of each process."""
    entries = [
        {"class": kind, "name": f"{name}_{i}", "parameters": {"thruster": i, "use_sim_time": simulated}}
        for i in range(thrusters)
        for name, kind in _CLASSES.items()
    ]
    size = ARRANGEMENTS[arrangement]
    return [entries[k : k + size] for k in range(0, len(entries), size)]


@contextmanager
def _graph(arrangement: str, thrusters: int, simulated: bool, domain_id: int) -> Iterator[tuple[_Bench, list[int]]]:
    """Give the bench and the ids of the processes of the nodes, all of them answering."""
    groups = _groups(arrangement, thrusters, simulated)
    environment = dict(os.environ, ROS_DOMAIN_ID=str(domain_id), OPENBLAS_NUM_THREADS="1")
    processes: list[subprocess.Popen[bytes]] = []
    context = Context()
    rclpy.init(args=[], context=context, domain_id=domain_id)
    bench = _Bench(context, thrusters)
    try:
        with tempfile.TemporaryDirectory() as folder:
            for index, group in enumerate(groups):
                file = Path(folder) / f"{index}.yaml"
                composed = {"nodes": group, "hand_over": arrangement != "one process"}
                file.write_text(yaml.safe_dump(composed), "utf-8")
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
    raise RuntimeError(f"expected {bench.thrusters} throttles within {_LONGEST_START:g} s; the nodes did not answer")


def _cpu(pids: list[int]) -> float:
    """Return the time that processes have used so far [s]."""
    ticks = 0
    for pid in pids:
        fields = Path(f"/proc/{pid}/stat").read_text("ascii").rpartition(")")[2].split()
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")


def real_time(arrangement: str, *, seconds: float = 5.0, domain_id: int = 40) -> list[Figures]:
    """Measure latencies from each `state` to its `throttle` at the rates of `RATES`, `seconds` each."""
    found = []
    with _graph(arrangement, THRUSTERS, False, domain_id) as (bench, pids):
        for rate in RATES:
            latencies: list[float] = []
            bench.came.clear()
            sent: dict[int, list[float]] = {}
            before, due = _cpu(pids), time.perf_counter()
            for _ in range(int(seconds * rate)):
                stamp = time.time_ns()
                sent[stamp] = bench.publish(stamp, clock=False)
                due = max(due + 1.0 / rate, time.perf_counter())
                bench.spin_for(due - time.perf_counter())
            bench.spin_until(time.perf_counter() + _LONGEST_ANSWER, bench.answered(stamp))
            used = _cpu(pids) - before
            for stamp, instants in sent.items():
                latencies += [bench.came[i, stamp] - at for i, at in enumerate(instants) if (i, stamp) in bench.came]
            lost = 1.0 - len(latencies) / (len(sent) * THRUSTERS)
            found.append(Figures(rate, *_median_and_p99(latencies), used / len(sent) / _NODES, lost))
    return found


def alone(work: float, rate: float, *, seconds: float = 5.0) -> tuple[float, float]:
    """Return the median and the 99th percentile of how long [s] work takes that nothing but the machine disturbs.

    Args:
        work: how long it takes at best [s].
        rate: how often it is done [Hz].
        seconds: for how long.
    """

    def count(turns: int) -> float:
        begin = time.perf_counter()
        for _ in range(turns):
            pass
        return time.perf_counter() - begin

    turns = round(work / min(count(10_000) for _ in range(200)) * 10_000)
    found = []
    for _ in range(int(seconds * rate)):
        due = time.perf_counter() + 1.0 / rate
        found.append(count(turns))
        time.sleep(max(due - time.perf_counter(), 0.0))
    return _median_and_p99(found)


def _median_and_p99(latencies: list[float]) -> tuple[float, float]:
    ordered = sorted(latencies)
    return ordered[int(0.5 * (len(ordered) - 1))], ordered[int(0.99 * (len(ordered) - 1))]


def lockstep(arrangement: str, *, thrusters: int = THRUSTERS, periods: int = 500, domain_id: int = 41) -> float:
    """Return how many times faster than real time, at 25 Hz, all thrusters answer in lockstep with /clock.

    Raises:
        RuntimeError: with the thrusters whose throttle did not come.
    """
    with _graph(arrangement, thrusters, True, domain_id) as (bench, _):
        begin, stamp = time.perf_counter(), 10**12
        for _ in range(periods):
            stamp += _PERIOD
            bench.publish(stamp, clock=True)
            if not bench.spin_until(time.perf_counter() + _LONGEST_ANSWER, bench.answered(stamp)):
                missing = [i for i in range(thrusters) if (i, stamp) not in bench.came]
                raise RuntimeError(f"expected a throttle of each thruster at {stamp} ns; missing: {missing}")
        return periods * _PERIOD / 1e9 / (time.perf_counter() - begin)


def rows(seconds: float = 5.0, periods: int = 500) -> list[Row]:
    """Compare all nodes in one process with a process each."""
    one, *_, each = ARRANGEMENTS
    found = []
    for thrusters, what in ((1, "one thruster"), (THRUSTERS, "six thrusters")):
        ours, plain = (lockstep(arrangement, thrusters=thrusters, periods=periods) for arrangement in (one, each))
        found.append(Row(f"{what} in lockstep at 25 Hz", ours, plain, "x real time"))
    together, apart = (real_time(arrangement, seconds=seconds) for arrangement in (one, each))
    for a, b in zip(together, apart, strict=True):
        at = f"at {a.rate:g} Hz"
        found.append(Row(f"state to throttle {at}, median", 1e6 * a.median, 1e6 * b.median, "us"))
        found.append(Row(f"state to throttle {at}, 99 %", 1e6 * a.p99, 1e6 * b.p99, "us"))
        found.append(Row(f"CPU of a node per tick {at}", 1e6 * a.cpu, 1e6 * b.cpu, "us"))
        machine = alone(_NODES * a.cpu, a.rate, seconds=seconds)[1]
        found.append(Row(f"99 % {at}, over the same work alone", 1e6 * a.p99, 1e6 * machine, "us"))
    return found


def main() -> None:
    """Print the figures of every arrangement."""
    for arrangement in ARRANGEMENTS:
        one, six = (lockstep(arrangement, thrusters=thrusters) for thrusters in (1, THRUSTERS))
        sys.stdout.write(f"{arrangement:<14}in lockstep at 25 Hz: {one:.1f} x real time, six thrusters {six:.1f} x\n")
        for rate, median, p99, cpu, lost in real_time(arrangement):
            sys.stdout.write(
                f"{arrangement:<14}{rate:>4.0f} Hz: state to throttle {1e3 * median:6.2f} ms, 99 % {1e3 * p99:7.2f} ms"
                f", CPU of a node per tick {1e6 * cpu:4.0f} us, lost {100.0 * lost:.2f} %"
                f"; the same work alone, 99 % {1e3 * alone(_NODES * cpu, rate)[1]:.2f} ms\n"
            )


if __name__ == "__main__":
    main()
