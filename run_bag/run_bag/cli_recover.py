"""`ros2 run run_bag recover PATH`: make a recording that was cut off whole again."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from .command_line import exit_status, user_arguments
from .finishing import Finished, finish, recover


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(
        prog="recover",
        description="Make a recording that was cut off a whole run: indexed, compressed, with metadata.yaml.",
    )
    p.add_argument("path", type=Path, metavar="PATH", help="rosbag2 directory or .mcap file")
    p.add_argument("--out", type=Path, help="directory for the new run; without it the run is finished in place")
    return p


def describe(done: Finished) -> str:
    """Return what was done, over one or more lines."""
    if done.untouched:
        return f"{done.directory}: whole already, {done.messages} messages; nothing was changed"
    lines = [f"{done.directory}: {done.messages} messages"]
    return "\n".join([*lines, *(f"  warning: {w}" for w in done.warnings)])


def main(argv: Sequence[str] | None = None) -> int:
    """Recover; return 0, or 1 if nothing could be done."""
    options = parser().parse_args(user_arguments(argv))

    def work() -> int:
        print(describe(finish(options.path) if options.out is None else recover(options.path, options.out)))
        return 0

    return exit_status("recover", work)


if __name__ == "__main__":
    sys.exit(main())
