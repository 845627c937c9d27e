"""Runs of the filter beside each other: kernels leave Python to other threads, so that threads use all cores."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

import numba

__all__ = ["side_by_side"]

Given = TypeVar("Given")
Result = TypeVar("Result")


def side_by_side(work: Callable[[Given], Result], given: Sequence[Given]) -> list[Result]:
    """Return the results of independent work in order, on as many cores as numba uses (NUMBA_NUM_THREADS)."""
    threads = min(int(numba.config.NUMBA_NUM_THREADS), len(given))
    if threads < 2:
        return [work(each) for each in given]
    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(work, given))
