"""`--help` of every node: purpose, topics and parameters, and then it ends."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

LONGEST = 180.0
"""[s] Deadline: modules with kernels may have to be compiled first."""
NODES = {
    (file.parent.name, executable): module
    for file in Path(__file__).resolve().parents[1].glob("*/setup.py")
    for executable, module in re.findall(r'"(\w+) = ([\w.]+_node):main"', file.read_text(encoding="utf-8"))
}


def test_the_nodes_are_known() -> None:
    assert len(NODES) >= 13


@pytest.mark.parametrize(("package", "executable"), sorted(NODES))
def test_help_prints_and_ends(package: str, executable: str) -> None:
    module = NODES[package, executable]
    code = f"import sys; sys.argv = [{executable!r}, '--help']; from {module} import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=LONGEST,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith(f"usage: {executable}")
    if executable != "play":  # its arguments are no parameters
        assert all(f"\n{word}  " in done.stdout for word in ("subscribes", "publishes"))
        assert "\nparameters (* may be changed while it runs):\n" in done.stdout
