"""`ros2 run run_bag play RUN`: what its command line says. The player itself is a node."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from .command_line import user_arguments


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(prog="play", description="Publish the messages of a run, with /clock.")
    p.add_argument("run", type=Path, metavar="RUN", help="rosbag2 directory or .mcap file")
    how = p.add_mutually_exclusive_group()
    how.add_argument("--rate", type=_positive, default=1.0, help="seconds of the run per second (default 1)")
    how.add_argument("--fast", action="store_true", help="without waiting; slow subscribers may lose messages")
    how.add_argument(
        "--step", action="store_true", help="lockstep: the next instant when all of --wait-for have answered this one"
    )
    p.add_argument(
        "--wait-for",
        nargs="+",
        default=[],
        metavar="OUTPUT[:INPUT,…]",
        help="topics that answer each instant, or those with a message on INPUT, by one of its stamp; not played",
    )
    p.add_argument("--timeout", type=_positive, default=5.0, help="for an answer [s] (default 5)")
    p.add_argument("--topics", nargs="+", default=[".*"], metavar="NAME", help="names or regular expressions")
    p.add_argument("--exclude", nargs="+", default=[], metavar="NAME", help="likewise, of those not to play")
    p.add_argument("--start", type=float, default=0.0, help="from so many seconds after the first message on")
    p.add_argument("--end", type=float, default=None, help="until so many seconds after the first message")
    p.add_argument("--loop", choices=("no", "yes"), default="no", help="from the start again until stopped")
    by = "time of the messages: when they were logged, or their header's stamp (default; of --step: stamp)"
    p.add_argument("--by", choices=("log", "stamp"), help=by.replace("(default; ", "(default: log; "))
    p.add_argument("--no-clock", action="store_true", help="publish no /clock")
    now = "stamp messages with the time at which they are published, for devices that act now; no /clock"
    p.add_argument("--restamp", action="store_true", help=now)
    p.add_argument(
        "--clock-period", type=_positive, default=0.01, help="of /clock between messages [s of the run] (default 0.01)"
    )
    delay = "start when no subscription has come or gone for so long [s] (default 3, with --wait-for 0.5)"
    p.add_argument("--delay", type=_positive, help=delay)
    return p


def options(argv: Sequence[str] | None = None) -> argparse.Namespace:
    """Return what the command line says; ends the process where it makes no sense."""
    p = parser()
    given = p.parse_args(user_arguments(argv))
    if given.wait_for and not given.step:
        p.error("--wait-for belongs to --step")
    if given.restamp and given.step:
        p.error("--restamp: expected a pace of its own; --step waits for the recorded stamps")
    given.no_clock = given.no_clock or given.restamp
    # A subscriber is discovered after 0.5 s, but after 2.5 s where a killed process has left its locks.
    given.delay = given.delay or (0.5 if given.wait_for else 3.0)
    given.by = given.by or ("stamp" if given.step else "log")
    return given


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"expected a positive number, found {text}")
    return value
