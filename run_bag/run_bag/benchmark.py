"""How fast runs are written and read, against the rosbags library used message by message."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer

from .benchmark_row import Row
from .definitions import definitions
from .reader import read_run
from .topic import Topic
from .writer import write_run

START_NS = 1_000_000_000
PERIOD_NS = 1_000_000


def bench_topics(samples: int, seed: int = 0) -> list[Topic]:
    """Return a run like the bench's: state, throttle, load and gauges at 1 kHz."""
    random = np.random.default_rng(seed)
    stamps = START_NS + PERIOD_NS * np.arange(samples, dtype=np.int64)
    noise = random.normal(size=(samples, 8))
    wrench = {f"wrench.{kind}.{axis}": noise[:, i] for i, (kind, axis) in enumerate(
        (k, a) for k in ("force", "torque") for a in "xyz")}  # fmt: skip
    sign = np.full(samples, 2)
    gauges = {"voltage": noise[:, :6], "force": noise[:, 2:]}
    return [
        Topic(name="/thruster_0/state", type="thruster_msgs/msg/ThrusterState", stamps=stamps,
              fields={"n": noise[:, 0], "sign_source": sign}, frame="thruster_0"),
        Topic(name="/thruster_0/throttle", type="thruster_msgs/msg/Throttle", stamps=stamps,
              fields={"commanded": noise[:, 1]}, frame="thruster_0"),
        Topic(name="/thruster_0/load", type="geometry_msgs/msg/WrenchStamped", stamps=stamps, fields=wrench,
              frame="thruster_0"),
        Topic(name="/thruster_0/gauges", type="thruster_msgs/msg/LoadCellGauges", stamps=stamps,
              fields=gauges, frame="thruster_0"),
    ]  # fmt: skip


def rows(samples: int = 10_000) -> list[Row]:
    """Measure writing and reading of 4 x `samples` messages in a temporary folder; best of two rounds."""
    topics = bench_topics(samples)
    count = len(topics) * samples
    with TemporaryDirectory() as folder:
        base = Path(folder)
        write = _best(lambda i: write_run(base / f"ours{i}", topics), count)
        library_write = _best(lambda i: _library_write(base / f"library{i}", topics), count)
        read = _best(lambda _: read_run(base / "ours0"), count)
        library_read = _best(lambda _: _library_read(base / "ours0"), count)
    return [
        Row("write a bench run", write, library_write, "messages/s"),
        Row("read a bench run into arrays", read, library_read, "messages/s"),
    ]


def _best(action: Callable[[int], object], count: int) -> float:
    speeds = []
    for i in range(2):
        begin = time.perf_counter()
        action(i)
        speeds.append(count / (time.perf_counter() - begin))
    return max(speeds)


def _library_write(folder: Path, topics: list[Topic]) -> None:
    known = definitions()
    for topic in topics:
        known.require(topic.type)
    store: Any = known.store
    types = store.types
    header, stamp = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    vector, wrench = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Wrench"]
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections = [writer.add_connection(t.name, t.type, typestore=store) for t in topics]
        f = [t.fields for t in topics]
        for i, ns in enumerate(np.asarray(topics[0].stamps).tolist()):
            head = header(stamp(ns // 10**9, ns % 10**9), "thruster_0")
            force, torque = (vector(*(f[2][f"wrench.{kind}.{a}"][i] for a in "xyz")) for kind in ("force", "torque"))
            messages = [
                types[topics[0].type](head, f[0]["n"][i], f[0]["sign_source"][i], np.nan, np.nan),
                types[topics[1].type](head, f[1]["commanded"][i], np.nan),
                types[topics[2].type](head, wrench(force, torque)),
                types[topics[3].type](head, f[3]["voltage"][i], f[3]["force"][i]),
            ]
            for connection, message in zip(connections, messages, strict=True):
                writer.write(connection, ns, store.serialize_cdr(message, connection.msgtype))


def _library_read(folder: Path) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {}
    with AnyReader([folder]) as reader:
        for connection, _, raw in reader.messages():
            message: Any = reader.deserialize(raw, connection.msgtype)
            sink = columns.setdefault(connection.topic, [])
            stamp = message.header.stamp
            sink.append(stamp.sec * 10**9 + stamp.nanosec)
            if connection.topic.endswith("state"):
                sink.append((message.n, message.sign_source, message.supply_voltage, message.current))
            elif connection.topic.endswith("throttle"):
                sink.append((message.commanded, message.sent))
            elif connection.topic.endswith("load"):
                force, torque = message.wrench.force, message.wrench.torque
                sink.append((force.x, force.y, force.z, torque.x, torque.y, torque.z))
            else:
                sink.append((*message.voltage, *message.force))
    return columns
