"""One clock for a run: wall time and simulated time beside each other make a recording of decades."""

from __future__ import annotations

from datetime import datetime, timezone
from pathlib import Path

from .errors import ClockError
from .known_topics import topic_type
from .run import Channel

APART = 300_000_000_000_000_000
"""[ns], ten years: no recording has such a hole, two clocks do."""


def of_one_clock(path: Path, channels: dict[str, Channel], warnings: list[str], *, asked: bool) -> dict[str, Channel]:
    """Return the channels that are on the clock of the topics that are used; what is left out becomes a warning.

    `asked`: the user named the topics, so that all of them are used; otherwise those that are known here are.

    Raises:
        ClockError: the topics that are used are on two clocks, or none of them tells which clock it is.
    """
    starts: dict[str, int] = {}
    for name, channel in channels.items():
        topic = name.partition(".")[0]
        starts[topic] = min(starts.get(topic, int(channel.stamps[0])), int(channel.stamps[0]))
    groups: list[list[str]] = []
    last = 0
    for topic in sorted(starts, key=lambda t: (starts[t], t)):
        if not groups or starts[topic] - last > APART:
            groups.append([])
        groups[-1].append(topic)
        last = starts[topic]
    if len(groups) < 2:
        return channels
    used = [group for group in groups if asked or any(topic_type(t) and t not in _EVERYONES for t in group)]
    told = " and ".join(f"{_named(g)} from {_moment(starts[g[0]])} on" for g in groups)
    if len(used) != 1:
        text = f"{path}: expected one clock, found {len(groups)}: {told}; read the topics of one of them"
        raise ClockError(text, path=path, expected=1, found=[g[0] for g in groups])
    if not all(t in _EVERYONES for group in groups if group is not used[0] for t in group):
        warnings.append(f"{len(groups)} clocks: {told}; only what shares that of {used[0][0]} is used")
    return {name: c for name, c in channels.items() if name.partition(".")[0] in used[0]}


_EVERYONES = ("clock", "diagnostics", "tf")


def _named(topics: list[str]) -> str:
    return ", ".join(f"/{t}" for t in topics[:3]) + (f" and {len(topics) - 3} more" if len(topics) > 3 else "")


def _moment(stamp: int) -> str:
    seconds = stamp / 1e9
    if seconds > 9e8:
        return f"{datetime.fromtimestamp(seconds, timezone.utc):%Y-%m-%d %H:%M:%S} (wall time)"
    return f"{seconds:.3f} s (simulated time)"
