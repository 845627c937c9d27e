"""`--help` of every node: purpose, topics and parameters, and then it ends."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

LONGEST = 600.0
"""[s] Deadline: modules with kernels may have to be compiled first."""
NODES = {
    (file.parent.name, executable): module
    for file in Path(__file__).resolve().parents[1].glob("*/setup.py")
    for executable, module in re.findall(r'"(\w+) = ([\w.]+_node):main"', file.read_text(encoding="utf-8"))
}
HELP = """
import contextlib, importlib, io, json, sys
for name, executable, module in json.loads(sys.argv.pop()):
    out, err, sys.argv = io.StringIO(), io.StringIO(), [executable, "--help"]
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = importlib.import_module(module).main()
    except SystemExit as ended:
        status = ended.code
    print(json.dumps([name, [status or 0, out.getvalue(), err.getvalue()]]), flush=True)
"""


@pytest.fixture(scope="module")
def told() -> dict[str, tuple[int, str, str]]:
    """Status, output and errors of every node's help, in one process: a node that goes on running has none."""
    asked = [("/".join(node), node[1], module) for node, module in sorted(NODES.items())]
    done = subprocess.run(
        [sys.executable, "-c", HELP, json.dumps(asked)], capture_output=True, text=True, timeout=LONGEST,
        check=False, stdin=subprocess.DEVNULL,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    return {name: tuple(found) for name, found in map(json.loads, done.stdout.splitlines())}


def test_the_nodes_are_known() -> None:
    assert len(NODES) >= 13


@pytest.mark.parametrize(("package", "executable"), sorted(NODES))
def test_help_prints_and_ends(package: str, executable: str, told: dict[str, tuple[int, str, str]]) -> None:
    status, out, err = told[f"{package}/{executable}"]
    assert (status, err) == (0, "")
    assert out.startswith(f"usage: {executable}")
    if executable != "play":  # its arguments are no parameters
        assert all(f"\n{word}  " in out for word in ("subscribes", "publishes"))
        assert "\nparameters (* may be changed while it runs):\n" in out
