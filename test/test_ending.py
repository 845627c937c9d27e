"""How scripts end the nodes that they started: what commands a throttle first, and nothing stays.

The nodes are shell scripts that write down what they are told; the `ros2 run` between them and the script hands no
signal on and starts each in a session of its own.
"""

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
LONGEST = 60.0
"""[s] Deadline of what takes a second or two on a machine of its own."""
SCRIPT = """
set -euo pipefail
root={root} folder={folder}
. "$root/scripts/workspace/processes.sh"
stopping_order=('inner_loop driver' 'observer' recorder)
for name in recorder observer inner_loop driver; do start $name {folder}/ros2 $name; done
touch {folder}/started
while :; do nap 0.2; done
"""
NODE = """
told() {{ printf '%s\\n' "$1" >>{folder}/told; exit 0; }}
trap 'told {name}' TERM
printf '%s\\n' $$ >>{folder}/pids
while kill -0 $THRUSTER_ENDS_WITH 2>/dev/null; do sleep 0.05; done
"""
DEAF = """#!/usr/bin/env bash
trap : TERM INT
setsid bash {folder}/$1.sh &
child=$!
while kill -0 $child 2>/dev/null; do wait $child || true; done
"""


def until(predicate: Callable[[], bool]) -> None:
    deadline = time.monotonic() + LONGEST
    while not predicate():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def running(pids: list[int]) -> list[int]:
    return [pid for pid in pids if Path(f"/proc/{pid}/stat").exists() and " Z " not in _stat(pid)]


def _stat(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    except OSError:
        return " Z "


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_a_script_that_ends_leaves_nothing_behind_whatever_stands_between(how: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    names = ("recorder", "observer", "inner_loop", "driver")
    for name in names:
        (tmp_path / f"{name}.sh").write_text(NODE.format(folder=tmp_path, name=name), encoding="utf-8")
    (tmp_path / "ros2").write_text(DEAF.format(folder=tmp_path), encoding="utf-8")
    (tmp_path / "ros2").chmod(0o755)
    script = tmp_path / "script.sh"
    script.write_text(SCRIPT.format(root=ROOT, folder=tmp_path), encoding="utf-8")
    pids: list[int] = []
    with subprocess.Popen(["bash", str(script)], cwd=tmp_path) as process:
        try:
            listed = tmp_path / "pids"
            until(lambda: listed.exists() and len(listed.read_text().split()) == 4 and (tmp_path / "started").exists())
            pids += map(int, listed.read_text().split())
            process.send_signal(how)
            process.wait(LONGEST)
            until(lambda: not running(pids))
        finally:
            process.kill()
            for pid in running(pids):
                os.kill(pid, signal.SIGKILL)
    if how != signal.SIGKILL:
        told = (tmp_path / "told").read_text(encoding="utf-8").split()
        assert set(told[:2]) == {"inner_loop", "driver"}
        assert told[2:] == ["observer", "recorder"]
