"""Throttle programmes as files, and synthetic bench recordings as runs, in a real bench's topics."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rov_sim.bench_campaign import BenchRun
from run_bag import Topic, write_run

__all__ = ["read_programme", "write_bench_run"]

Array = NDArray[np.float64]

_SIGN_INFERRED = 2  # thruster_msgs/msg/ThrusterState.SIGN_INFERRED


def read_programme(file: Path) -> tuple[Array, Array]:
    """Return the instants [s] and commands [V], each (N,), of a csv with the columns time_s and throttle_V.

    Raises:
        ValueError: it has other columns, no rows, or something in them that is no number.
    """
    header, *lines = file.read_text(encoding="utf-8").split() or [""]
    if header != "time_s,throttle_V" or not lines:
        raise ValueError(
            f"{file}: expected a header time_s,throttle_V and rows; found {header!r} and {len(lines)} rows"
        )
    table = np.empty((len(lines), 2))
    for row, line in enumerate(lines):
        try:
            table[row] = [float(cell) for cell in line.split(",")]
        except ValueError:
            raise ValueError(f"{file}, row {row + 1}: expected two numbers; found {line!r}") from None
    if not np.all(np.isfinite(table)):
        raise ValueError(f"{file}: expected finite numbers; found others in {int(np.sum(~np.isfinite(table)))} cells")
    return table[:, 0], table[:, 1]


def write_bench_run(run: BenchRun, folder: Path, metadata: Mapping[str, object]) -> Path:
    """Write the recording to the new directory `folder`/<name> and return that."""
    signals = run.signals
    speed = signals["speed"]
    state = {"n": speed.values, "sign_source": np.full(speed.values.size, _SIGN_INFERRED)}
    load = {"wrench.force.x": signals["thrust"].values, "wrench.torque.x": signals["torque"].values}
    flow = next(name for name in ("axial", "ambient") if name in signals)
    throttle = {"commanded": signals["throttle"].values}
    topics = [
        Topic.of_thruster(0, "throttle", signals["throttle"].time, throttle),
        Topic.of_thruster(0, "state", speed.time, state),
        Topic.of_thruster(0, "load", signals["thrust"].time, load),
        Topic.of_thruster(0, "flow", signals[flow].time, {flow: signals[flow].values}),
    ]
    target = folder / run.name
    write_run(target, topics, dict(metadata))
    return target
