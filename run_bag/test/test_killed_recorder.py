"""A recorder that is killed loses next to nothing, and one that cannot write says so. In processes of their own."""

import contextlib
import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from recording_graph import Graph, domain_id, messages

from run_bag.cli_recover import main as recover_main
from run_bag.reader import read_recording
from thruster_msgs.msg import ThrusterState

KILLS = int(os.environ.get("RECORDER_KILLS", "2"))
"""50 in the long run."""
ALLOWED_LOSS = float(os.environ.get("RECORDER_LOSS", "0.5"))
"""[s] of messages before the kill: 0.2 where the machine does nothing else, more where others hold the recorder up."""
RATE = 500


@contextlib.contextmanager
def recording(out: Path, limit: int | None = None) -> Iterator[subprocess.Popen[str]]:
    """Run a recorder of the topic `state`, in which no file may grow beyond `limit` [bytes]."""
    program = "import sys; from run_bag.live.recorder_node import main; sys.exit(main())"
    parameters = ["-p", f"out:={out}", "-p", "topics:=[state]"]
    sizes = (lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))) if limit else None
    environment = {**os.environ, "ROS_DOMAIN_ID": str(domain_id()), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    command = [sys.executable, "-c", program, "--ros-args", *parameters]
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True, preexec_fn=sizes) as process:
        try:
            yield process
        finally:
            process.kill()  # leaving the block waits for it


def published_until(graph: Graph, process: subprocess.Popen[str], seconds: float) -> list[float]:
    """Publish numbered messages at RATE for so long, then kill the process; return when each was published."""
    publisher = graph.publisher(ThrusterState, "state")
    begin, times = time.monotonic(), []
    while time.monotonic() - begin < seconds and process.poll() is None:
        message = ThrusterState(n=float(len(times)))
        publisher.publish(message)
        times.append(time.monotonic())
        time.sleep(max(0.0, begin + len(times) / RATE - time.monotonic()))
    return times


@pytest.mark.parametrize("seed", range(KILLS))
def test_a_killed_recorder_loses_at_most_the_last_moment_and_no_earlier_message(
    graph: Graph, tmp_path: Path, seed: int
) -> None:
    out = tmp_path / "a"
    with recording(out) as process:
        times = published_until(graph, process, random.Random(seed).uniform(0.7, 1.7))
        process.send_signal(signal.SIGKILL)
        killed = time.monotonic()
        process.wait(10.0)
    assert not (out / "metadata.yaml").exists()
    assert recover_main([str(out)]) == 0
    assert (out / "metadata.yaml").exists() and read_recording(out).warnings == ()
    values = [number_of(row[3]) for row in messages(out)]
    assert values == list(range(len(values))), "a message in the midst is missing"
    due = sum(t <= killed - ALLOWED_LOSS for t in times)
    assert len(values) >= due, f"{due - len(values)} messages older than {ALLOWED_LOSS} s are lost"


def number_of(payload: bytes) -> int:
    """Return n of a ThrusterState whose frame id is empty: 4 bytes of encapsulation, then 16 of header with padding."""
    return int(np.frombuffer(payload, dtype="<f8", count=1, offset=4 + 16)[0])


def test_a_recorder_that_cannot_write_any_more_says_so_and_leaves_what_it_has(graph: Graph, tmp_path: Path) -> None:
    out = tmp_path / "a"
    with recording(out, limit=100_000) as process:
        times = published_until(graph, process, 20.0)
        assert process.stderr is not None
        said = process.stderr.read()
        assert process.wait(10.0) == 1
    assert "a_0.mcap: recording stopped: no space is left; the run is readable up to there" in said
    assert "Traceback" not in said
    rows = messages(out)
    assert 100 < len(rows) < len(times) and (out / "a_0.mcap").stat().st_size <= 100_000
    assert [number_of(row[3]) for row in rows] == list(range(len(rows)))
    assert recover_main([str(out), "--out", str(tmp_path / "b")]) == 0
    assert messages(tmp_path / "b") == rows
