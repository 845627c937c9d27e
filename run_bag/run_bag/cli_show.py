"""`ros2 run run_bag show RUN`: the channels of a run as plots in one HTML file."""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .command_line import described, exit_status, user_arguments
from .errors import RunError, RunExistsError
from .reader import read_run
from .report import Axis, Column, Panel, Report, Series, time_series
from .run import Channel, Run

DRAWN = 60_000
"""Points of all lines together."""
PANELS = 12
"""Panels of one figure."""
_PART = re.compile(r"(\[\d+\]|\.(x|y|z|w))$")
_NO_SIGNAL = re.compile(r"covariance|\.(sec|nanosec)$")


def parser(program: str = "show") -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    told = described("Draw the channels of a run, in one HTML file.", "\n  %(prog)s runs/log --out log.html")
    p = argparse.ArgumentParser(prog=program, **told)
    p.add_argument("run", type=Path, metavar="RUN", help="rosbag2 directory, .mcap, .db3 or .bag")
    p.add_argument("--out", type=Path, metavar="FILE.html", help="file to write; must not exist (default: RUN.html)")
    p.add_argument("--topics", nargs="+", metavar="TOPIC", help="only these topics")
    return p


def show(run: Run) -> Report:
    """Return the page of a run."""
    report = Report(
        f"Run {run.name}",
        f"{run.duration:.6g} s, {len(run.channels)} channels; time from the first stamp on",
        {"run": run.name, "duration [s]": round(run.duration, 6), **_told(run.metadata)},
    )
    for warning in run.warnings:
        report.warning(warning)
    still = {name for name, c in run.channels.items() if _NO_SIGNAL.search(name) or _constant(c)}
    moving = [name for name in run.channels if name not in still]
    points = int(np.clip(DRAWN / max(1, len(moving)), 150, 1500))
    by_space: dict[str, dict[tuple[str, str], list[str]]] = {}
    for name in moving:
        topic, _, path = name.partition(".")
        space, _, last = topic.rpartition("/")
        title = f"{last}.{_PART.sub('', path)}"
        by_space.setdefault(space or "other topics", {}).setdefault((title, run[name].unit), []).append(name)
    for space in sorted(by_space):
        report.section(space)
        panels = [_panel(run, title, unit, names) for (title, unit), names in by_space[space].items()]
        for first in range(0, len(panels), PANELS):
            shown = panels[first : first + PANELS]
            drawn = ", ".join(p.axis.name for p in shown)
            report.figure(
                time_series(shown, max_points=points, panel_height=110),
                caption=f"{space}: as recorded; lines break where nothing was measured.",
                alt=f"Over time: {drawn}.",
            )
    report.section("All channels")
    rate = Column(name="rate", unit="Hz")
    columns: list[Column | str] = ["channel", "unit", "samples", rate, "smallest", "mean", "largest", "not measured"]
    report.table(
        columns,
        [_row(c) for c in run.channels.values()],
        caption="Every channel; those that never move, and covariances, are not drawn.",
    )
    return report


def _told(metadata: Mapping[str, Any]) -> dict[str, Any]:
    """Return what was run, long texts shortened."""
    return {k: v if len(json.dumps(v)) < 20_000 else "too long to be shown" for k, v in metadata.items()}


def _constant(channel: Channel) -> bool:
    known = channel.values[np.isfinite(channel.values)]
    return known.size == 0 or bool(np.ptp(known) == 0.0)


def _panel(run: Run, title: str, unit: str, names: list[str]) -> Panel:
    lines = []
    for name in names:
        part = _PART.search(name)
        values = np.where(np.isinf(run[name].values), np.nan, run[name].values)
        label = part[1].strip(".") if part and len(names) > 1 else "recorded"
        lines.append(Series(name=label, x=run.time(name), y=values, role="fit" if len(names) > 1 else "data"))
    told = {"1": "–", "": "unit unknown"}.get(unit, unit)
    last = title.rpartition(".")[2]  # the whole name, which stands above the panel, is longer than a panel is high
    return Panel(axis=Axis(name=title, unit=told, symbol=last), series=lines)


def _row(channel: Channel) -> list[object]:
    known = channel.values[np.isfinite(channel.values)]
    span = (channel.stamps[-1] - channel.stamps[0]) * 1e-9
    rate = (len(channel) - 1) / span if span > 0 else None
    numbers = [float(f(known)) for f in (np.min, np.mean, np.max)] if known.size else [None] * 3
    unit = channel.unit or "unknown"
    return [channel.name, unit, len(channel), rate, *numbers, len(channel) - known.size]


def main(argv: Sequence[str] | None = None, program: str = "show") -> int:
    """Draw; return 0, or 1 with a sentence on standard error."""
    options = parser(program).parse_args(user_arguments(argv))
    return exit_status(program, lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    given = options.run
    out = options.out or given.resolve().with_name(f"{given.resolve().name.removesuffix('.mcap')}.html")
    if out.exists():
        raise RunExistsError(f"{out} exists; nothing is overwritten: say another --out", path=out)
    if not out.parent.is_dir():
        raise RunError(f"{out}: expected an existing folder {out.parent}, found none", path=out)
    run = read_run(given, options.topics)
    for warning in run.warnings:
        print(f"warning: {warning}", file=sys.stderr)
    print(show(run).write(out))
    return 0


if __name__ == "__main__":
    sys.exit(main())
