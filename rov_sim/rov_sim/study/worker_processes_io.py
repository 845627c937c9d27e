"""Processes that work side by side, and end when they are to."""

import os
import signal
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context

__all__ = ["worker_processes"]

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def worker_processes(count: int) -> Iterator[ProcessPoolExecutor]:
    """Yield so many processes of one thread each, which end at once where the block is left by an exception.

    They are spawned, not forked: compiled code, threads, keys and seeds of this process are in none of them. They pass
    over an interrupt, which a terminal sends to all: this process ends them.
    """
    for threads in _THREADS:
        os.environ.setdefault(threads, "1")  # inherited by the processes, which share the cores
    ignored = (signal.SIGINT, signal.SIG_IGN)
    with ProcessPoolExecutor(
        count, mp_context=get_context("spawn"), initializer=signal.signal, initargs=ignored
    ) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in active_children():
                process.terminate()
            raise
