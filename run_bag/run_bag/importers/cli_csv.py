"""`ros2 run run_bag import_csv FILE --map MAP.yaml --out DIR`: a csv becomes a run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ..command_line import exit_status, user_arguments
from ..writer import refuse_existing, write_run
from .column_map import read_map
from .csv_table import Table
from .csv_topics import topics
from .decisions import Decisions, source


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(prog="import_csv", description="Import a csv as a run, by a map of its columns.")
    p.add_argument("file", type=Path, metavar="FILE", help="csv, with or without a header line")
    p.add_argument("--map", required=True, type=Path, metavar="MAP.yaml",
                   help="channel: {column, time_column, unit, scale, offset, nan, time_scale} or {value}")  # fmt: skip
    p.add_argument("--out", required=True, type=Path, metavar="DIR", help="the run to make; must not exist")
    return p


def import_csv(file: Path, map_file: Path, out: Path) -> tuple[list[str], list[str]]:
    """Import one csv; return the names of the channels in the map, and warnings.

    Raises:
        RunError: the target exists or cannot be written, the map or the csv is wrong.
    """
    refuse_existing(out)
    entries = read_map(map_file)
    log = Decisions()
    made, warnings = topics(Table(file), entries, log)
    metadata = {
        "what": "csv, imported",
        "import": {"importer": "csv", "sources": [source(file), source(map_file)], "decisions": log.json()},
    }
    write_run(out, made, metadata)
    return [e.channel for e in entries], warnings


def main(argv: Sequence[str] | None = None) -> int:
    """Import; return 0, or 1 (130: interrupted) with a sentence on standard error."""
    options = parser().parse_args(user_arguments(argv))
    return exit_status("import_csv", lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    channels, warnings = import_csv(options.file, options.map, options.out)
    for sentence in warnings:
        print(f"warning: {sentence}", file=sys.stderr)
    print(f"{options.out}: {len(channels)} channels: {', '.join(channels)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
