"""Import recordings of the thruster bench: find the files that belong together and write one run for each."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import RecordingError
from ..topic import Topic
from ..writer import refuse_existing, write_run
from .bench_files import CSV_COLUMNS, data_start, read_controller, read_load_cell, read_text, read_velocimeter
from .closed_loop import closed_loop_topics
from .decisions import Decisions, source
from .open_loop import open_loop_topics
from .options import BenchOptions

KINDS = {".csv.xz": "csv", ".csv": "csv", ".dat": "dat", ".mat": "mat"}
_AIR = re.compile(r"(?<![a-z])air(?![a-z])", re.IGNORECASE)


@dataclass
class Group:
    """Files of one recording: kind -> path."""

    stem: str
    files: dict[str, Path] = field(default_factory=dict)


@dataclass
class Plan:
    """Recordings found, and files that are none with the reason."""

    groups: list[Group] = field(default_factory=list)
    skipped: list[tuple[Path, str]] = field(default_factory=list)


@dataclass(frozen=True)
class Imported:
    """One recording that became a run."""

    directory: Path
    duration: float
    topics: tuple[str, ...]
    decisions: Decisions


def split_name(path: Path) -> tuple[str, str] | None:
    """Return (stem, kind) of a file of the bench, None for others."""
    for suffix, kind in KINDS.items():
        if path.name.lower().endswith(suffix):
            return path.name[: -len(suffix)], kind
    return None


def find(paths: Iterable[Path]) -> Plan:
    """Group files by folder and name without regard to case; folders are searched recursively.

    Raises:
        RecordingError: a path does not exist.
    """
    plan = Plan()
    groups: dict[tuple[Path, str], Group] = {}
    for path in dict.fromkeys(f for p in paths for f in _files(p)):
        named = split_name(path)
        if named is None:
            plan.skipped.append((path, "neither csv, csv.xz, dat nor mat"))
            continue
        stem, kind = named
        group = groups.setdefault((path.parent, stem.lower()), Group(stem))
        if kind in group.files:
            plan.skipped.append((path, f"{group.files[kind].name} is the same recording"))
            continue
        group.files[kind] = path
        if kind == "csv":
            group.stem = stem
    for group in groups.values():
        if "csv" not in group.files:
            plan.skipped += [(f, "no csv of the same name beside it") for f in group.files.values()]
        elif (reason := _no_recording(group.files["csv"])) is not None:
            plan.skipped += [(f, reason) for f in group.files.values()]
        else:
            plan.groups.append(group)
    plan.groups.sort(key=lambda g: g.files["csv"])
    return plan


def _files(path: Path) -> Iterator[Path]:
    if path.is_dir():
        yield from sorted(f for f in path.rglob("*") if f.is_file())
    elif path.is_file():
        # a file named alone brings those that belong to it
        named = split_name(path)
        yield path
        if named is not None:
            for other in sorted(path.parent.iterdir()):
                beside = split_name(other)
                if beside is not None and beside[0].lower() == named[0].lower():
                    yield other
    else:
        raise RecordingError(f"{path}: no such file or directory", path=path)


def _no_recording(path: Path) -> str | None:
    """Say why a csv is no recording of the bench (another number of columns), None if it is one."""
    try:
        lines = read_text(path)
    except RecordingError:
        return None  # importing it says what is wrong
    first = data_start(lines)
    columns = {line.count(",") + 1 for line in lines[first : first + 5] if line.strip()}
    if CSV_COLUMNS in columns:
        return None
    found = "no line" if not columns else f"{min(columns)} columns"
    return f"no recording: expected {CSV_COLUMNS} columns, found {found}"


def import_recording(group: Group, out: Path, options: BenchOptions) -> Imported:
    """Import one recording into out/<stem>.

    Raises:
        RunExistsError: that run exists.
        RecordingError: a file is malformed, or something cannot be decided.
    """
    target = out / group.stem
    refuse_existing(target)
    log = Decisions()
    csv = read_load_cell(group.files["csv"])
    dat = read_velocimeter(group.files["dat"]) if "dat" in group.files else None
    topics: list[Topic]
    if "mat" in group.files:
        topics = closed_loop_topics(group.stem, csv, read_controller(group.files["mat"]), options, log)
    else:
        in_air = any(_AIR.search(name) for name in (group.stem, group.files["csv"].parent.name))
        topics = open_loop_topics(group.stem, csv, dat, options, log, in_air)
        if dat is None:
            log.add("velocimeter", None, "", "no .dat beside the csv: no flow")
    metadata = {
        "what": "recording of the thruster bench, imported",
        "experiment": _experiment("mat" in group.files, log),
        "water": log.value("water"),
        # How far clocks may be off [s]: who fits these recordings adjusts them within this.
        "clock_deviation": {
            "throttle": log.deviation("throttle switched on"),
            "flow": log.deviation("offset of the velocimeter's clock"),
        },
        "import": {
            "importer": "bench",
            "sources": [source(f) for _, f in sorted(group.files.items())],
            "decisions": log.json(),
        },
    }
    write_run(target, topics, metadata)
    duration = float(csv.time[-1] - csv.time[0])
    return Imported(target, duration, tuple(t.name for t in topics), log)


def _experiment(controlled: bool, log: Decisions) -> str:
    """Return what kind of experiment it was: only the first kind was made to identify the thruster in water."""
    if controlled:
        return "closed loop"
    if log.value("last column") == "throttle":
        return "reversal"
    return "open loop" if log.value("water") else "in air"
