"""`ros2 run run_bag info PATH...`: what is in a run."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .command_line import exit_status, printable, user_arguments
from .errors import RunError
from .reader import Recording, read_recording, read_run
from .run import Channel


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    p = argparse.ArgumentParser(prog="info", description="Print topics, channels, decisions and warnings of runs.")
    p.add_argument(
        "paths", nargs="+", type=Path, metavar="PATH", help="rosbag2 directories, .mcap files, or folders of runs"
    )
    where = "only runs whose metadata says so, for example experiment='open loop' or experiment!='in air'"
    p.add_argument("--where", action="append", default=[], metavar="KEY=VALUE", help=where)
    p.add_argument("--list", action="store_true", help="print the paths alone, one a line")
    return p


def runs_in(path: Path) -> list[Path]:
    """Return the runs in a folder of runs, or the path itself where it is none."""
    if not path.is_dir() or any(path.glob("*.mcap")):
        return [path]
    return sorted(d for d in path.iterdir() if d.is_dir() and any(d.glob("*.mcap"))) or [path]


def matches(metadata: Mapping[str, Any], condition: str) -> bool:
    """Tell whether metadata fulfil KEY=VALUE or KEY!=VALUE; keys of nested records are joined by dots.

    Raises:
        RunError: the condition has another form.
    """
    key, sign, wanted = condition.partition("=")
    if not sign or not key.strip("!"):
        raise RunError(f"--where {condition}: expected KEY=VALUE or KEY!=VALUE")
    found: Any = metadata
    for part in key.removesuffix("!").split("."):
        found = found.get(part) if isinstance(found, Mapping) else None
    text = found if isinstance(found, str) else json.dumps(found)
    return (text == wanted) != key.endswith("!")


def describe(path: Path) -> str:
    """Return the description of one run, over several lines.

    Raises:
        RunError: it cannot be read.
    """
    recording = read_recording(path, set())
    run = read_run(path)
    by_topic: dict[str, list[Channel]] = {}
    for c in run.channels.values():
        by_topic.setdefault(c.name.partition(".")[0], []).append(c)
    lines = [f"{path}: {run.duration:.6g} s, {_total(recording)} messages, {len(run.channels)} channels"]
    for topic, (kind, count) in sorted(_topics(recording).items()):
        lines.append(f"  {topic}  {kind}  {count}")
        for c in by_topic.get(topic.strip("/"), []):
            where = f"  in {c.frame}" if c.frame else ""
            lines.append(f"    {c.name}  [{c.unit or 'unit unknown'}]{where}")
    lines += _metadata(dict(run.metadata))
    lines += [f"  warning: {w}" for w in run.warnings]
    return "\n".join(map(printable, lines))


def _total(recording: Recording) -> int:
    return sum(s.message_count for s in recording.scans)


def _topics(recording: Recording) -> dict[str, tuple[str, int]]:
    found: dict[str, tuple[str, int]] = {}
    for scan in recording.scans:
        for raw in scan.topics.values():
            kind = raw.schema.name if raw.schema else "no schema"
            found[raw.topic] = (kind, found.get(raw.topic, (kind, 0))[1] + raw.count)
    return found


def _metadata(metadata: dict[str, Any]) -> list[str]:
    imported = metadata.pop("import", None)
    lines = [f"  {key}: {json.dumps(value, ensure_ascii=False)}" for key, value in metadata.items()]
    if not lines and imported is None:
        return ["  nothing says what was run: the recording carries no metadata of a run"]
    if not isinstance(imported, dict):
        return lines if imported is None else [*lines, f"  import: {json.dumps(imported, ensure_ascii=False)}"]
    for source in _records(imported, "sources"):
        lines.append(f"  from {source.get('file')} ({source.get('bytes')} bytes, sha256 {source.get('sha256')})")
    for d in _records(imported, "decisions"):
        spread = "" if d.get("standard_deviation") is None else f" +- {d['standard_deviation']}"
        unit = f" {d['unit']}" if d.get("unit") not in (None, "", "1") else ""
        lines.append(f"  {d.get('what')}: {json.dumps(d.get('value'))}{spread}{unit} ({d.get('how')})")
    return lines


def _records(imported: Mapping[str, Any], key: str) -> list[Mapping[str, Any]]:
    found = imported.get(key)
    return [each for each in found if isinstance(each, Mapping)] if isinstance(found, list) else []


def main(argv: Sequence[str] | None = None) -> int:
    """Print; return 0, or 1 if one of the runs could not be read."""
    options = parser().parse_args(user_arguments(argv))
    return exit_status("info", lambda: _told(options))


def _told(options: argparse.Namespace) -> int:
    status = 0
    for path in [run for given in options.paths for run in runs_in(given)]:
        try:
            recording = read_recording(path, set())
            if all(matches(recording.metadata, condition) for condition in options.where):
                print(path if options.list else describe(path))
        except RunError as error:
            print(printable(str(error)), file=sys.stderr)
            status = 1
    return status


if __name__ == "__main__":
    sys.exit(main())
