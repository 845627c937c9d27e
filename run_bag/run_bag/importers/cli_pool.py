"""`ros2 run run_bag import_pool FILE.npz... --out DIR`: arrays of ROS 1 topics of a vehicle become runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ..command_line import exit_status, user_arguments
from ..writer import refuse_existing, write_run
from .decisions import Decisions, source
from .pool import read_arrays, topics


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(prog="import_pool", description="Import npz arrays of ROS 1 topics of a pool vehicle.")
    p.add_argument("files", nargs="+", type=Path, metavar="FILE", help="npz, one array per topic")
    p.add_argument("--out", required=True, type=Path, metavar="DIR", help="folder that gets one run per recording")
    p.add_argument("--hold-last", action="store_true", help="the last command holds until the recording ends")
    return p


def import_pool(file: Path, out: Path, *, hold_last: bool = False) -> list[str]:
    """Import one recording; return its topics.

    Raises:
        RunError: the target exists or cannot be written, or the recording is wrong.
    """
    refuse_existing(out)
    log = Decisions()
    made = topics(read_arrays(file), log, hold_last=hold_last)
    record = {"importer": "pool", "sources": [source(file)], "decisions": log.json()}
    write_run(out, made, {"what": "vehicle in a pool, imported", "import": record})
    return [topic.name for topic in made]


def main(argv: Sequence[str] | None = None) -> int:
    """Import; return 0, or 1 (130: interrupted) with a sentence on standard error."""
    options = parser().parse_args(user_arguments(argv))
    return exit_status("import_pool", lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    for file in options.files:
        target = options.out / file.stem
        made = import_pool(file, target, hold_last=options.hold_last)
        print(f"{target}: {', '.join(made)}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
