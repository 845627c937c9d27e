"""The stand-in for `ros2` (its other tests are in the workspace's test/test_scripts.py)."""

import os
import subprocess
from pathlib import Path

import pytest

ROS2 = Path(__file__).parents[2] / "scripts/stand_in/ros2"


@pytest.mark.skipif(not ROS2.is_file(), reason="outside the workspace")
@pytest.mark.parametrize("arguments", [("run", "nothing", "x"), ("pkg", "executables", "nothing")])
def test_an_unknown_package_is_one_sentence(tmp_path, arguments):
    environment = {**os.environ, "AMENT_PREFIX_PATH": str(tmp_path)}
    done = subprocess.run([ROS2, *arguments], env=environment, capture_output=True, text=True, timeout=30, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "Package 'nothing' not found\n")
