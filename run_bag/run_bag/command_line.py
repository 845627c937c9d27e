"""What the executables share: their arguments without those meant for ROS, and how they fail."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

from .errors import RunError

INTERRUPTED, UNREAD = 130, 141  # 128 + SIGINT, + SIGPIPE, as shells have them


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


def of_a_vehicle(arguments: Sequence[str]) -> bool:
    """Return whether arguments name a vehicle's set, and with it another parser."""
    return any(each.split("=")[0] == "--vehicle" for each in arguments)


_OF_VEHICLE = "of a vehicle, its set, in place of --set; what else there is then: --vehicle SET --help"


def offer_vehicle(parser: argparse.ArgumentParser, text: str = _OF_VEHICLE) -> None:
    """Add the option of a vehicle's set to the help of a program that hands such arguments over before it parses."""

    def refused(_: str) -> str:  # an abbreviation alone comes here
        raise argparse.ArgumentTypeError("expected to be written in full")

    parser.add_argument("--vehicle", metavar="SET", type=refused, help=text)


def described(description: str | None, examples: str) -> dict[str, Any]:
    """Return what a parser says of its program: its purpose and lines of examples.

    In examples `%(prog)s` is the name under which the program was started.
    """
    formatter = argparse.RawDescriptionHelpFormatter
    return {"description": description, "epilog": f"examples:{examples}", "formatter_class": formatter}


def printable(text: str) -> str:
    """Return a text whose control characters, which a terminal would obey, are written as Python writes them."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def exit_status(program: str, work: Callable[[], int]) -> int:
    """Return what `work` returns; 1 or, interrupted, 130 with one sentence on standard error where it fails."""
    try:
        status = work()
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        sys.stderr.write(f"{program}: interrupted; what is there is whole, no half-written run was left\n")
        return INTERRUPTED
    except BrokenPipeError:  # who read, as `head` does, has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what is flushed at the end
        return UNREAD
    except RunError as error:
        sys.stderr.write("\n".join(map(printable, str(error).split("\n"))) + "\n")
    except OSError as error:
        where = "" if error.filename is None else f"{error.filename}: "
        sys.stderr.write(f"{program}: {where}{error.strerror or error}\n")
    return 1
