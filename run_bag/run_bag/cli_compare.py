"""`ros2 run run_bag compare RUN OTHER`: which messages of two runs differ, and by how much."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from .command_line import exit_status, user_arguments
from .comparison import TopicDifference, compared
from .errors import EmptyRunError
from .reader import read_run


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(prog="compare", description="Compare two runs message by message, by their stamps.")
    p.add_argument("run", type=Path, metavar="RUN", help="rosbag2 directory or .mcap file")
    p.add_argument("other", type=Path, metavar="OTHER", help="another one")
    p.add_argument("--topics", nargs="+", default=[".*"], metavar="NAME", help="names or regular expressions")
    p.add_argument("--exclude", nargs="+", default=[], metavar="NAME", help="likewise, of those that do not count")
    near = "values as near as that, over their size where it is above 1, are equal (default 0: to the last bit)"
    p.add_argument("--tolerance", type=float, default=0.0, help=near)
    p.add_argument("--within", action="store_true", help="messages that are in one run alone do not count")
    return p


def _line(found: TopicDifference) -> str:
    alone = f"{found.one_alone:>8}{found.other_alone:>8}"
    where = f"  {found.channel} by {found.largest:.3g}" if found.differ else ""
    return f"{found.topic:<32}{found.both:>8}{found.differ:>8}{alone}{where}"


def _compare(given: argparse.Namespace) -> int:
    found = compared(read_run(given.run), read_run(given.other), given.topics, given.exclude, tolerance=given.tolerance)
    if not any(each.both for each in found):
        raise EmptyRunError(f"{given.run}, {given.other}: no message of one stamp and topic is in both", found=0)
    print(f"{'topic':<32}{'in both':>8}{'differ':>8}{'only 1':>8}{'only 2':>8}  most")
    for each in found:
        print(_line(each))
    alone = 0 if given.within else sum(each.one_alone + each.other_alone for each in found)
    differ = sum(each.differ for each in found)
    equal = not differ and not alone
    print("equal" if equal else f"{differ} messages differ" + (f", {alone} are in one run alone" if alone else ""))
    return 0 if equal else 1


def main(argv: Sequence[str] | None = None) -> int:
    """Print; return 0 where the runs are equal, 1 where they differ or cannot be read."""
    given = parser().parse_args(user_arguments(argv))
    return exit_status("compare", lambda: _compare(given))


if __name__ == "__main__":
    sys.exit(main())
