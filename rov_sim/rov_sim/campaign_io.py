"""Synthetic bench recordings as runs, in the topics that a real bench would be recorded in."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rov_sim.bench_campaign import BenchRun, Recorded
from run_bag import Topic, write_run

__all__ = ["write_bench_run"]

_EPOCH_NS = 1_000_000_000  # the synthetic clock starts at one second: zero means "no stamp" to some tools
_SIGN_INFERRED = 2  # thruster_msgs/msg/ThrusterState.SIGN_INFERRED
_FRAME = "thruster_0"


def write_bench_run(run: BenchRun, folder: Path, metadata: Mapping[str, object]) -> Path:
    """Write the recording to the new directory `folder`/<name> and return that."""
    signals = run.signals
    speed = signals["speed"]
    state = {"n": speed.values, "sign_source": np.full(speed.values.size, _SIGN_INFERRED)}
    load = {"wrench.force.x": signals["thrust"].values, "wrench.torque.x": signals["torque"].values}
    flow = next(name for name in ("axial", "ambient") if name in signals)
    throttle = {"commanded": signals["throttle"].values}
    topics = [
        _topic("throttle", "thruster_msgs/msg/Throttle", signals["throttle"], throttle),
        _topic("state", "thruster_msgs/msg/ThrusterState", speed, state),
        _topic("load", "geometry_msgs/msg/WrenchStamped", signals["thrust"], load),
        _topic("flow", "thruster_msgs/msg/FlowVelocity", signals[flow], {flow: signals[flow].values}),
    ]
    target = folder / run.name
    write_run(target, topics, dict(metadata))
    return target


def _topic(name: str, kind: str, recorded: Recorded, fields: Mapping[str, NDArray[np.generic]]) -> Topic:
    stamps = _EPOCH_NS + np.round(recorded.time * 1e9).astype(np.int64)
    return Topic(name=f"thruster_0/{name}", type=kind, stamps=stamps, fields=dict(fields), frame=_FRAME)
