"""What a node's executable does with its command line."""

import threading
from pathlib import Path

import pytest
from rclpy.context import Context
from rclpy.node import Node

from thruster_runtime.node_main import REFUSED, STOPPED, node_main, run_node
from thruster_runtime.parameters import Parameter, declare

TABLE = (
    Parameter(name="throttle_limit", default=3.0, unit="V", lower=0.0, upper=5.0, live=True, description="the limit"),
    Parameter(name="kind", default="", choices=("", "step"), description="what kind"),
)
DOC = """Does something.

subscribes  /in
"""


def never() -> Node:
    raise AssertionError("no node is built")


@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_help_tells_purpose_topics_and_parameters_and_ends(flag: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert node_main(never, DOC, TABLE, argv=["/lib/some_node", flag]) == STOPPED
    told = capsys.readouterr().out
    assert told.startswith("usage: some_node [--ros-args")
    assert "Does something.\n\nsubscribes  /in" in told
    assert "throttle_limit *     a finite number from 0 up to 5 [V]; default 3\n      the limit" in told
    assert "kind                 one of (empty), step; default (empty)" in told
    assert "use_sim_time" in told and "executor" in told


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["throtle_limit:=2"], "argument 'throtle_limit:=2': expected --ros-args before what a node is told; perhaps"
         " --ros-args -p throttle_limit:=2"),
        (["--ros-args", "-p", "kind:=step", "--", "stray"], "argument 'stray': expected --ros-args"),
        (["--verbose"], "argument '--verbose': expected --ros-args before what a node is told; --help tells"),
    ],
)  # fmt: skip
def test_stray_arguments_are_refused_with_the_nearest_name(
    arguments: list[str], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert node_main(never, DOC, TABLE, argv=["node", *arguments]) == REFUSED
    assert sentence in capsys.readouterr().err


def refusal(args: list[str], capfd: pytest.CaptureFixture[str]) -> str:
    context, stop = Context(), threading.Event()

    def build() -> Node:
        node = Node("subject", context=context)
        declare(node, TABLE)
        node.create_timer(0.01, stop.set)  # where nothing is refused it ends
        return node

    status = run_node(build, args=args, context=context, stop=stop)
    said = capfd.readouterr().err
    assert status == (REFUSED if said else STOPPED)
    return said


def test_a_parameter_that_no_node_knows_is_refused_with_the_nearest_name(capfd: pytest.CaptureFixture[str]) -> None:
    assert refusal(["--ros-args", "-p", "throtle_limit:=2.0"], capfd) == (
        "/subject: parameter throtle_limit: expected one that this node has; found none of that name; "
        "the nearest is throttle_limit\n"
    )


@pytest.mark.parametrize(("key", "refused"), [("/**", False), ("subject", True)])
def test_a_file_may_tell_all_nodes_what_one_does_not_know(
    key: str, refused: bool, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text(f"{key}: {{ros__parameters: {{kind: step, other: 3}}}}\n", encoding="utf-8")
    said = refusal(["--ros-args", "--params-file", str(file)], capfd)
    assert ("parameter other: expected one that this node has" in said) is refused


def test_a_parameter_whose_last_value_ros_would_pass_over_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "parameters.yaml"
    file.write_text("/**: {ros__parameters: {throttle_limit: 2}}\n", encoding="utf-8")
    told = "/subject: parameter throttle_limit: expected one value, or values of one kind; found "
    for given, found in [
        (["-p", "throttle_limit:=2.0", "-p", "throttle_limit:=x"], "'x' after 2.0, which ROS would keep\n"),
        (
            ["-p", "subject:throttle_limit:=2", "-p", "subject:throttle_limit:=2.5"],
            "2.5 after 2, which ROS would keep\n",
        ),
        (["--params-file", str(file), "-p", "throttle_limit:=2.5"], "2.5 after 2, which ROS would keep\n"),
    ]:
        assert refusal(["--ros-args", *given], capfd) == told + found


def test_a_parameter_given_again_counts_as_it_was_given_last(capfd: pytest.CaptureFixture[str]) -> None:
    assert refusal(["--ros-args", "-p", "throttle_limit:=2.0", "-p", "throttle_limit:=3.5"], capfd) == ""
    assert refusal(["--ros-args", "-p", "throttle_limit:=2.0", "-p", "other:throttle_limit:=x"], capfd) == ""
    assert "found 6" in refusal(["--ros-args", "-p", "throttle_limit:=2.0", "-p", "throttle_limit:=6"], capfd)
