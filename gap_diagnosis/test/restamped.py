"""Recordings of the sealed world with the stamps of one topic moved."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from run_bag import Topic

_START = 1.0
"""[s] First stamp of a recording."""


def restamped(topics: Iterable[Topic], of: str, stamp: Callable[[Any], Any]) -> list[Topic]:
    """Return the topics; stamp: of a time since the start [s] what topics ending with `of` have for it."""

    def moved(stamps: Any) -> Any:
        return np.round(1e9 * (stamp(np.asarray(stamps) / 1e9 - _START) + _START)).astype(np.int64)

    return [replace(each, stamps=moved(each.stamps)) if each.name.endswith(of) else each for each in topics]
