import signal
import subprocess
import sys
from pathlib import Path

import pytest
from rclpy.context import Context

from thruster_runtime.compose import CompositionError, builders, main

# Two nodes of one class; each says its name, its parameter and when it stops.
MODULE = """
from rclpy.node import Node

class Subject(Node):
    def __init__(self, **options):
        super().__init__("subject", **options)
        value = self.declare_parameter("value", 0).value
        print(self.get_name(), value, flush=True)

    def on_stop(self):
        print(self.get_name(), "stopped", flush=True)
"""


def test_nodes_of_one_class_get_their_names_and_parameters(
    context: Context, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "composed_subject.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    entries = [{"class": "composed_subject:Subject", "name": name} for name in ("a", "b")]
    entries[1]["parameters"] = {"value": 3}  # type: ignore[assignment]
    nodes = [build() for build in builders({"nodes": entries}, "test", context=context)]
    assert [(node.get_name(), node.get_parameter("value").value) for node in nodes] == [("a", 0), ("b", 3)]
    for node in nodes:
        node.destroy_node()


def test_a_file_of_nodes_runs_in_one_process_and_all_stop_cleanly(tmp_path: Path) -> None:
    (tmp_path / "subject.py").write_text(MODULE, encoding="utf-8")
    file = tmp_path / "two.yaml"
    file.write_text(
        "nodes:\n"
        "- {class: 'subject:Subject', name: a, parameters: {value: 3}}\n"
        "- {class: 'subject:Subject', name: b}\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-m", "thruster_runtime.compose", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        try:
            assert process.stdout is not None
            assert [process.stdout.readline() for _ in range(2)] == ["a 3\n", "b 0\n"]
            process.send_signal(signal.SIGTERM)
            out, _ = process.communicate(timeout=20.0)
        finally:
            process.kill()
    assert process.returncode == 0
    assert out == "b stopped\na stopped\n"


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        (None, "key 'nodes': expected a list of nodes; found none"),
        ({"nodes": [{"name": "a"}]}, r"key 'nodes\[0\]': expected the keys class, name and perhaps parameters"),
        ({"nodes": [{"class": "no.such:Node", "name": "a"}]}, "expected package.module:Class; found 'no.such:Node'"),
        ({"nodes": [{"class": "math:sin", "name": "a"}]}, "expected a node; found 'math:sin'"),
        ({"nodes": [{"class": "rclpy.node:Node", "name": "a", "parameters": 3}]}, "expected a mapping; found 3"),
        ({"nodes": [{"class": "rclpy.node:Node", "name": "a"}] * 2}, "name 'a': given to 2 nodes"),
        (
            {"nodes": [{"class": "rclpy.node:Node", "name": "a"}], "hand_over": 1},
            "key 'hand_over': expected true or false; found 1",
        ),
        (
            {"nodes": [{"class": "rclpy.node:Node", "name": "a"}], "hands": 1},
            "key 'hands': expected one of nodes, hand",
        ),
    ],
    ids=str,
)
def test_a_wrong_composition_is_refused_with_what_is_wrong(document: object, sentence: str) -> None:
    with pytest.raises(CompositionError, match=sentence):
        builders(document, "two.yaml")


def test_a_file_that_is_none_is_refused_with_status_2(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main([str(tmp_path / "none.yaml")]) == 2
    assert "none.yaml" in capfd.readouterr().err
