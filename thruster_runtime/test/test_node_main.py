import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Float64

from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import EXECUTOR_KINDS
from thruster_runtime.node_main import ENDS_WITH, LAST_WORDS, REFUSED, STOPPED, run_node
from thruster_runtime.qos import RELIABLE

# A node in a process of its own: says when it spins, and whether it could still publish when it stopped.
PROGRAM = """
import sys
from rclpy.node import Node
from std_msgs.msg import Float64
from thruster_runtime.node_main import run_node

class Subject(Node):
    def __init__(self):
        super().__init__("subject")
        self.publisher = self.create_publisher(Float64, "value", 1)
        self.create_timer(0.01, self.tick)
        self.ticks = 0

    def tick(self):
        self.ticks += 1
        if self.ticks == 1:
            print("spinning", flush=True)

    def on_stop(self):
        self.publisher.publish(Float64(data=0.0))
        print("stopped", flush=True)

sys.exit(run_node(Subject))
"""


@pytest.fixture(params=EXECUTOR_KINDS)
def arguments(request: pytest.FixtureRequest) -> list[str]:
    return ["--ros-args", "-p", f"executor:={request.param}"]


@pytest.fixture
def private() -> Iterator[Context]:
    """A context that is not yet initialised: run_node does that."""
    yield Context()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_process_with_status_0_after_its_last_word(
    arguments: list[str], number: signal.Signals, tmp_path: Path
) -> None:
    program = tmp_path / "subject.py"
    program.write_text(PROGRAM, encoding="utf-8")
    command = [sys.executable, str(program), *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "spinning\n"
            process.send_signal(number)
            out, err = process.communicate(timeout=10.0)
        finally:
            process.kill()  # leaving the block waits for the process, without a deadline
    assert (out, err, process.returncode) == ("stopped\n", "", STOPPED)


@pytest.mark.parametrize("how", ["killed", "gone before"])
def test_a_process_ends_cleanly_when_the_one_is_gone_without_which_it_is_to_end(how: str, tmp_path: Path) -> None:
    program = tmp_path / "subject.py"
    program.write_text(PROGRAM, encoding="utf-8")
    with subprocess.Popen(["sleep", "100"]) as keeper:
        if how != "killed":
            keeper.kill()
            keeper.wait()
        environment = {**os.environ, ENDS_WITH: str(keeper.pid)}
        command = [sys.executable, str(program)]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
            try:
                if how == "killed":
                    assert process.stdout is not None
                    assert process.stdout.readline() == "spinning\n"
                    keeper.kill()  # nobody collects it yet: a zombie is gone all the same
                out, _ = process.communicate(timeout=30.0)
            finally:
                process.kill()
                keeper.kill()
    assert (out, process.returncode) == ("stopped\n", STOPPED)


class Subject(Node):
    """Runs `step` in a timer and remembers what happened."""

    def __init__(self, context: Context, step: object, heard: list[str]) -> None:
        super().__init__("subject", context=context)
        self.heard = heard
        self.create_timer(0.001, step)

    def on_stop(self) -> None:
        self.heard.append("on_stop")

    def destroy_node(self) -> None:
        self.heard.append("destroyed")
        super().destroy_node()


def test_the_stop_event_ends_the_node_and_the_context(private: Context, arguments: list[str]) -> None:
    stop = threading.Event()
    heard: list[str] = []
    assert run_node(lambda: Subject(private, stop.set, heard), args=arguments, context=private, stop=stop) == STOPPED
    assert heard == ["on_stop", "destroyed"]
    assert not private.ok()


def test_a_node_stays_until_its_last_word_has_arrived(private: Context, monkeypatch: pytest.MonkeyPatch) -> None:
    heard: list[str] = []
    waited = Publisher.wait_for_all_acked

    def wait(publisher: Publisher, timeout: Duration) -> bool:
        heard.append(f"waits for {publisher.topic_name}")
        assert 0.0 <= timeout.nanoseconds * 1e-9 <= LAST_WORDS
        return bool(waited(publisher, timeout))

    class Speaker(Subject):
        def __init__(self) -> None:
            super().__init__(private, stop.set, heard)
            self.last = self.create_publisher(Float64, "value", RELIABLE)

    stop = threading.Event()
    monkeypatch.setattr(Publisher, "wait_for_all_acked", wait)
    assert run_node(Speaker, args=[], context=private, stop=stop) == STOPPED
    assert heard.index("on_stop") < heard.index("waits for /value") < heard.index("destroyed")


def test_an_error_in_a_callback_still_stops_cleanly_and_is_raised(private: Context, arguments: list[str]) -> None:
    heard: list[str] = []

    def fail() -> None:
        raise RuntimeError("evidence")

    with pytest.raises(RuntimeError, match="evidence"):
        run_node(lambda: Subject(private, fail, heard), args=arguments, context=private)
    assert heard == ["on_stop", "destroyed"]
    assert not private.ok()


def test_a_refusal_is_one_sentence_and_status_2(private: Context, capfd: pytest.CaptureFixture[str]) -> None:
    def build() -> Node:
        raise StartRefused("rate: expected a positive number [Hz], got -1")

    assert run_node(build, args=[], context=private) == REFUSED
    assert capfd.readouterr().err == "rate: expected a positive number [Hz], got -1\n"
    assert not private.ok()


def test_errors_named_as_refusals_are_refusals_and_others_are_raised(private: Context) -> None:
    def build() -> Node:
        raise LookupError("no such parameter set")

    assert run_node(build, args=[], context=private, refusals=(LookupError,)) == REFUSED
    with pytest.raises(LookupError, match="no such parameter set"):
        run_node(build, args=[], context=Context())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--ros-args", "-p", "executor:=multi"], "expected one of events, single, got 'multi'"),
        (["--ros-args", "--no-such-option"], "no-such-option"),
    ],
)
def test_bad_arguments_are_refused(
    private: Context, arguments: list[str], sentence: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert run_node(lambda: Node("subject", context=private), args=arguments, context=private) == REFUSED
    assert sentence in capfd.readouterr().err


def test_a_callback_that_the_events_executor_cannot_run_is_refused_with_the_way_out(
    private: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    def build() -> Node:
        async def later(message: Float64) -> None: ...

        node = Node("subject", context=private)
        node.create_subscription(Float64, "value", later, RELIABLE)
        return node

    assert run_node(build, args=[], context=private) == REFUSED
    said = capfd.readouterr().err
    assert "the callback of topic /value is async" in said
    assert "-p executor:=single" in said


def test_a_node_that_cannot_be_protected_does_not_run_unprotected(tmp_path: Path) -> None:
    secure = {"ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce", "ROS_SECURITY_KEYSTORE": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, "--ros-args", "--enclave", "/none"],
        env={**os.environ, **secure}, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert done.returncode == REFUSED and done.stdout == ""
    assert done.stderr.startswith("ROS_SECURITY_ENABLE=true: expected ") and "Traceback" not in done.stderr
