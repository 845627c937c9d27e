"""A node of ours under the stock `ros2` command: run, listed, asked, tuned, refused; skipped without the command."""

import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import pytest

LONGEST = 120.0
"""[s] Deadline of a command that takes a second or three on a machine of its own."""
ENVIRONMENT = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "PYTHONUNBUFFERED": "1"}
TOPIC = "/thruster_0/thrust_setpoint"
REFERENCE = ["thruster_control", "reference", "--ros-args", "-p", "trigger:=timer"]


def ros2(*words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["ros2", *words], env=ENVIRONMENT, capture_output=True, text=True, timeout=LONGEST, check=False
    )


@pytest.fixture(scope="module", autouse=True)
def stock() -> None:
    """Skip without the stock command; the stand-in for the wheels knows `run` and `pkg` alone."""
    if shutil.which("ros2") is None or ros2("topic", "--help").returncode != 0:
        pytest.skip("the stock ros2 command is not here: it comes with an installation of ROS 2, not with the wheels")


@contextmanager
def running(thruster: int, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """Give a `ros2 run` of a reference whose topic others have found."""
    with subprocess.Popen(
        ["ros2", "run", *REFERENCE, "-p", f"thruster:={thruster}", *arguments], env=ENVIRONMENT, text=True,
        start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    ) as process:  # fmt: skip
        try:
            until(lambda: ros2("topic", "echo", "--once", "--timeout", "5", TOPIC.replace("0", str(thruster))).stdout)
            yield process
        finally:
            with suppress(ProcessLookupError):  # it has ended
                os.killpg(process.pid, signal.SIGKILL)


def until(told: Callable[[], object]) -> None:
    deadline = time.monotonic() + LONGEST
    while not told():
        assert time.monotonic() < deadline


@pytest.fixture(scope="module")
def reference() -> Iterator[None]:
    """A reference that asks for 2 N without end; the daemon, which answers for the graph, ends with it."""
    try:
        with running(0, "-p", "level:=2.0", "-p", "repeats:=0"):
            until(lambda: "/reference" in ros2("node", "list").stdout.split())
            yield
    finally:
        ros2("daemon", "stop")


def test_node_topics_and_services_are_listed(reference: None) -> None:
    assert "/reference" in ros2("node", "list").stdout.split()
    about = ros2("node", "info", "/reference").stdout
    assert "/thruster_0/thrust_setpoint: thruster_msgs/msg/ThrustSetpoint" in about
    assert "/reference/set_parameters: rcl_interfaces/srv/SetParameters" in about
    assert "/thruster_0/thrust_setpoint [thruster_msgs/msg/ThrustSetpoint]" in ros2("topic", "list", "-t").stdout
    assert "/reference/get_parameters" in ros2("service", "list").stdout


def test_messages_are_shown_and_come_at_their_rate(reference: None) -> None:
    shown = ros2("topic", "echo", "--once", TOPIC).stdout
    assert re.search(r"^thrust: 2.0$", shown, re.MULTILINE) and "stamp:" in shown
    command = ["timeout", "-s", "INT", "8", "ros2", "topic", "hz", TOPIC]
    told = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True, timeout=LONGEST, check=False).stdout
    rates = [float(rate) for rate in re.findall(r"average rate: ([\d.]+)", told)]
    assert rates and rates[-1] == pytest.approx(25.0, rel=0.02)
    assert "float64 thrust" in ros2("interface", "show", "thruster_msgs/msg/ThrustSetpoint").stdout


def test_parameters_are_described_read_tuned_and_refused_with_a_sentence(reference: None) -> None:
    names = ros2("param", "list", "/reference").stdout.split()
    assert {"kind", "level", "repeats", "period"} <= set(names)
    described = ros2("param", "describe", "/reference", "level").stdout
    assert "thrust of the constant" in described and "Max value: 1000.0" in described
    assert "Double value is: 2.0" in ros2("param", "get", "/reference", "level").stdout
    assert "Set parameter successful" in ros2("param", "set", "/reference", "level", "3.5").stdout
    assert "thrust: 3.5" in ros2("topic", "echo", "--once", TOPIC).stdout
    fixed = ros2("param", "set", "/reference", "period", "0.1")
    assert "period: fixed at start" in fixed.stdout + fixed.stderr
    wrong = ros2("param", "set", "/reference", "level", "2000.0")
    assert "level" in wrong.stdout + wrong.stderr and "successful" not in wrong.stdout
    assert "level: 3.5" in ros2("param", "dump", "/reference").stdout


@pytest.mark.parametrize(
    ("parameter", "said"),
    [("kind:=stairs", "parameter kind: expected one of step, sine"), ("level:=x", "level [N]: expected a number"),
     ("levle:=3.0", "found none of that name; the nearest is level")],
)  # fmt: skip
def test_a_wrong_parameter_ends_ros2_run_with_a_sentence_and_status_2(parameter: str, said: str) -> None:
    done = ros2("run", *REFERENCE, "-p", parameter)
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr


def test_ctrl_c_at_ros2_run_ends_the_node_with_status_0() -> None:
    with running(1) as process:
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
        said, _ = process.communicate(timeout=LONGEST)
    assert process.returncode == 0 and "Traceback" not in said
