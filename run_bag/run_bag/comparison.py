"""Two runs side by side: which messages differ, topic by topic, and where they differ most."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .run import Channel, Run
from .selection import Selection

__all__ = ["TopicDifference", "compared"]


class TopicDifference(NamedTuple):
    """How the messages of one topic differ, found by their stamps.

    Attributes:
        topic: without leading slash.
        both: how many stamps are in both runs; one_alone, other_alone: in one of them alone.
        differ: of those in both, how many differ in a channel.
        channel: in which they differ most, "" where none does; largest: by how much, in its unit; NaN where one run has
            measured what the other has not.
    """

    topic: str
    both: int
    one_alone: int
    other_alone: int
    differ: int
    channel: str
    largest: float


def compared(
    one: Run, other: Run, topics: Iterable[str] = (".*",), exclude: Iterable[str] = (), *, tolerance: float = 0.0
) -> list[TopicDifference]:
    """Return the differences of all topics that one of the runs has.

    Args:
        one, other: the runs.
        topics: names or regular expressions; exclude: likewise, of those that do not count.
        tolerance: values that are as near, over their size where that is above 1, count as equal [1].
    """
    chosen = Selection(topics, exclude)
    by_topic: dict[str, tuple[dict[str, Channel], dict[str, Channel]]] = {}
    for side, run in enumerate((one, other)):
        for name in run:
            topic, _, field = name.partition(".")
            if f"/{topic}" in chosen:
                by_topic.setdefault(topic, ({}, {}))[side][field] = run[name]
    return [_topic(topic, *sides, tolerance) for topic, sides in sorted(by_topic.items())]


def _topic(topic: str, one: dict[str, Channel], other: dict[str, Channel], tolerance: float) -> TopicDifference:
    mine, theirs = _stamps(one), _stamps(other)
    both = np.intersect1d(mine, theirs)
    differs = np.zeros(both.size, dtype=bool)
    worst, channel = 0.0, ""
    for field in sorted({*one, *other}):
        a, b = (_at(side.get(field), both) for side in (one, other))
        apart = np.abs(a - b)
        unlike = np.isnan(a) != np.isnan(b)
        here = unlike | (apart > tolerance * np.maximum(1.0, np.abs(a)))
        if not here.any():
            continue
        differs |= here
        largest = float("nan") if unlike.any() else float(np.max(apart[here]))
        if channel == "" or not largest <= worst:
            worst, channel = largest, f"{topic}.{field}"
    alone = (mine.size - both.size, theirs.size - both.size)
    return TopicDifference(topic, both.size, *alone, int(differs.sum()), channel, worst)


def _stamps(channels: dict[str, Channel]) -> NDArray[np.int64]:
    none = np.empty(0, dtype=np.int64)
    return np.unique(np.concatenate([none, *(channel.stamps for channel in channels.values())]))


def _at(channel: Channel | None, stamps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the values at these stamps, the last one where several have the same; NaN where there is none."""
    found = np.full(stamps.size, np.nan)
    if channel is not None and len(channel):
        last = np.searchsorted(channel.stamps, stamps, side="right") - 1
        there = (last >= 0) & (channel.stamps[last] == stamps)
        found[there] = channel.values[last[there]]
    return found
