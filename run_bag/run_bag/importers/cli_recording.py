"""`ros2 run run_bag import_recording FILE... --map MAP.yaml --out RUN`: tables, bags and logs become a run."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..bag_folder import bag_files
from ..budget import VARIABLE
from ..command_line import described, exit_status, user_arguments
from ..errors import RecordingError
from ..topic import Topic
from ..writer import refuse_existing, write_run
from .advice import advice
from .bag_source import BagSource
from .checked_map import read_map
from .csv_source import CsvSource
from .decisions import Decisions, source
from .guess import guess
from .log_source import LOGS, LogSource
from .mapped_topics import mapped_topics
from .recording_map import ASKED, Constant, RecordingMap
from .sources import Source
from .thrusters_alike import thrusters_alike

BAGS = (".mcap", ".db3", ".bag", ".zstd")
EXAMPLES = """
  %(prog)s log.csv --guess > map.yaml     # then read and correct map.yaml
  %(prog)s log.csv --map map.yaml --out runs/log
  %(prog)s 00000042.BIN --map map.yaml --out runs/dive"""


def parser(program: str = "import_recording") -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    purpose = (
        "Import a recording as a run, by a map of its columns or fields: tables of text (csv), rosbag2 of\n"
        "any storage, MCAP, ROS 1 bags, logs of ArduPilot's vehicles (.BIN, .tlog).\n"
        "Warnings leave the exit status at 0."
    )
    p = argparse.ArgumentParser(prog=program, **described(purpose, EXAMPLES))
    files = "all files of one recording, on one clock, or brought to it by the map"
    p.add_argument("files", nargs="+", type=Path, metavar="FILE", help=files)
    p.add_argument(
        "--map", type=Path, metavar="MAP.yaml", help="channel: {column or field, unit, scale, sign, hold, ...}"
    )
    p.add_argument("--out", type=Path, metavar="RUN", help="the run to make, with the folders above it; must not exist")
    p.add_argument(
        "--guess", action="store_true", help="print a map that names, units and ranges suggest, import nothing"
    )
    p.add_argument(
        "--larger", type=float, default=None, metavar="N", help="raise the limits of what a file may cost by N"
    )
    return p


def open_source(path: Path, told: RecordingMap | None) -> Source:
    """Open a recording by what it is.

    Raises:
        RunError: it cannot be read.
    """
    if path.suffix.lower() in LOGS:
        return LogSource(path)
    if path.is_dir() or path.suffix.lower() in BAGS:
        topics = None if told is None else {e.topic_of_field for e in told.mapped if e.is_field}
        return BagSource(path, topics)
    return CsvSource(path, told)


def import_recording(files: Sequence[Path], map_file: Path, out: Path) -> tuple[list[Topic], list[str], RecordingMap]:
    """Import a recording; return its topics, warnings, and its map.

    Raises:
        RunError: the target exists or cannot be written, the map or the recording is wrong.
    """
    refuse_existing(out)
    told = read_map(map_file)
    sources = [open_source(file, told) for file in files]
    log = Decisions()
    made, warnings = mapped_topics(sources, told, log)
    holds = told.holds()
    metadata: dict[str, Any] = {
        "what": "recording, imported",
        "import": {
            "importer": "recording",
            "sources": [source(part) for file in [*files, map_file] for part in _parts(file)],
            "decisions": log.json(),
        },
    }
    if holds:
        metadata["hold"] = holds
    if clocks := told.clock_deviations():
        metadata["clock_deviation"] = clocks
    write_run(out, made, metadata)
    lost = [w for s in sources for w in getattr(s, "warnings", ())]
    clocks_told = [_of_two_clocks(each, told) for each in sources if isinstance(each, BagSource)]
    return made, [*lost, *warnings, *filter(None, clocks_told), *advice(made, holds)], told


def _of_two_clocks(source: BagSource, told: RecordingMap) -> str:
    """Return what is odd where some of a bag's times are of sensors and some of the recorder, "" where they are not."""
    used = {e.topic_of_field for e in told.mapped if source.has(e)}
    by_recorder = {topic for topic in used if not source.stamped(topic)}
    stated = {e.topic_of_field for e in told.mapped if e.clock_deviation}
    if len(by_recorder) == len(used) or by_recorder <= stated:
        return ""
    return (
        f"messages of {', '.join(sorted(by_recorder - stated))} have no header: their times are those at which the "
        "recorder got them, beside others' own stamps; the way to the recorder is a delay of theirs"
    )


def _parts(file: Path) -> list[Path]:
    return bag_files(file, others=True)[0] if file.is_dir() else [file]


def main(argv: Sequence[str] | None = None, program: str = "import_recording") -> int:
    """Import; return 0, or 1 (2: wrong usage, 130: interrupted) with a sentence on standard error."""
    options = parser(program).parse_args(user_arguments(argv))
    if options.guess == (options.map is not None or options.out is not None) or (
        not options.guess and (options.map is None or options.out is None)
    ):
        print(f"{program}: expected --map MAP.yaml and --out RUN, or --guess alone", file=sys.stderr)
        return 2
    if options.larger is not None:
        os.environ[VARIABLE] = str(options.larger)
    return exit_status(program, lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    if options.guess:
        if len({f.name for f in options.files}) < len(options.files):
            raise RecordingError("expected files of different names, since a map tells them apart by these")
        sources = [open_source(file, None) for file in options.files]
        for table in sources:
            if isinstance(table, CsvSource):
                table.refuse_one_column()
        text = guess(sources)
        print(text, end="")
        if asked := text.count(f"unit: '{ASKED}'"):
            print(f"note: units to be written by you, where neither name nor values tell: {asked}", file=sys.stderr)
        return 0
    made, warnings, told = import_recording(options.files, options.map, options.out)
    for sentence in warnings:
        print(f"warning: {options.out}: {sentence}", file=sys.stderr)
    print(f"{options.out}:")
    constant = {(e.topic, e.path) for e in told.entries if isinstance(e, Constant)}
    told_of = [(t.name, _told(t, {path for name, path in constant if name == t.name})) for t in made]
    print("\n".join(f"  {line}" for line in thrusters_alike(told_of)))
    return 0


def _told(topic: Topic, constant: Collection[str]) -> str:
    """Return what was imported as a topic, with rates: a wrong unit of time shows there.

    constant: fields that have one value in all messages, as the map says; the sign of a speed may have, as well.
    """
    seconds = np.asarray(topic.stamps) * 1e-9
    alike: dict[tuple[int, float], list[str]] = {}
    same = []
    for name, values in topic.fields.items():
        numbers = np.asarray(values)
        if numbers.size and (name in constant or (name == "sign_source" and np.ptp(numbers) == 0)):
            same.append(f"; {name}: {numbers[0]:g} in all of them")
            continue
        at = seconds[np.isfinite(numbers)] if numbers.dtype.kind == "f" and numbers.ndim == 1 else seconds
        alike.setdefault((at.size, float(np.ptp(at)) if at.size else 0.0), []).append(name)
    return "; ".join(
        f"{', '.join(names)}: {count} readings in {lasts:.1f} s"
        + (f", {float(f'{(count - 1) / lasts:.3g}'):g} Hz" if lasts else "")
        for (count, lasts), names in alike.items()
    ) + "".join(same)


if __name__ == "__main__":
    sys.exit(main())
