"""What the executables share: their arguments without those meant for ROS."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence


def user_arguments(argv: Sequence[str] | None = None) -> list[str]:
    """Return the arguments without `--ros-args ...`, where rclpy is installed; without program name."""
    given = list(sys.argv[1:] if argv is None else argv)
    if "--ros-args" not in given:
        return given
    try:
        utilities = importlib.import_module("rclpy.utilities")
    except ImportError:
        return given
    return list(utilities.remove_ros_args(args=["program", *given]))[1:]
