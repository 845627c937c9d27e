"""`ros2 run run_bag import_csv FILE --map MAP.yaml --out DIR`: a csv becomes a run."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ..command_line import user_arguments
from ..errors import RunError
from ..writer import refuse_existing, write_run
from .column_map import Table, read_map, topics
from .decisions import Decisions, source


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(prog="import_csv", description="Import a csv as a run, by a map of its columns.")
    p.add_argument("file", type=Path, metavar="FILE", help="csv, with or without a header line")
    p.add_argument("--map", required=True, type=Path, metavar="MAP.yaml",
                   help="channel: {column, time_column, unit, scale, offset, nan, time_scale}")  # fmt: skip
    p.add_argument("--out", required=True, type=Path, metavar="DIR", help="the run to make; must not exist")
    return p


def import_csv(file: Path, map_file: Path, out: Path) -> list[str]:
    """Import one csv; return the names of the channels.

    Raises:
        RunError: the target exists, the map or the csv is wrong.
    """
    refuse_existing(out)
    columns = read_map(map_file)
    made = topics(Table(file), columns)
    log = Decisions()
    for c in columns:
        how = f"column {c.column!r} at {c.time_column!r}; value = {c.scale:g} * cell + {c.offset:g}"
        log.add(c.channel, c.column, c.unit, how)
    metadata = {
        "what": "csv, imported",
        "import": {"importer": "csv", "sources": [source(file), source(map_file)], "decisions": log.json()},
    }
    write_run(out, made, metadata)
    return [c.channel for c in columns]


def main(argv: Sequence[str] | None = None) -> int:
    """Import; return 0, or 1 with a sentence on standard error."""
    options = parser().parse_args(user_arguments(argv))
    try:
        channels = import_csv(options.file, options.map, options.out)
    except RunError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{options.out}: {len(channels)} channels: {', '.join(channels)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
