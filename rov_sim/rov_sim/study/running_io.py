"""Run the shards of a study: in this process, in several, or on a dask cluster. The results are the same."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from urllib.parse import urlsplit

from rov_sim.study.store_io import Scores, Shard, Store
from rov_sim.study.worker_processes_io import worker_processes

__all__ = ["RunShard", "StudyInterrupted", "checked_address", "run_shards"]

_LOOPBACK = ("127.0.0.1", "localhost", "::1")
RunShard = Callable[[str, Shard], Scores]
"""Scores of a shard from the plan's text: a pure function at the top of its module, as workers import it by name."""


class StudyInterrupted(RuntimeError):
    """Workers died; what was finished is kept."""


def checked_address(address: str) -> str:
    """Return the address of a scheduler on this machine; ValueError for any other: the protocol has no protection."""
    try:
        parts = urlsplit(address)
        good = parts.scheme == "tcp" and parts.hostname in _LOOPBACK and parts.port is not None
    except ValueError:
        good = False
    if not good:
        raise ValueError(f"--scheduler: expected tcp://HOST:PORT with a host of this machine; found {address!r}")
    return address


def run_shards(
    store: Store,
    shards: Sequence[Shard],
    run: RunShard,
    *,
    processes: int = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> int:
    """Run the shards that the store has not; return how many that were. Each is saved as soon as it is finished.

    Args:
        store: where results are kept, with the plan's text.
        shards: of the study.
        run: what computes one.
        processes: on this machine; scheduler: address of a dask scheduler in their place.
        progress: told how many of how many are finished.

    Raises:
        StudyInterrupted: workers died more often than they are started again.
        ModuleNotFoundError: a scheduler was given and dask is not installed.
    """
    missing = [shard for shard in shards if not store.has(shard)]
    progress(len(shards) - len(missing), len(shards))
    if scheduler is not None:
        results = _on_cluster(run, store.plan, missing, scheduler)
    elif processes > 1:
        results = _in_processes(run, store.plan, missing, processes)
    else:
        results = ((shard, run(store.plan, shard)) for shard in missing)
    for done, (shard, scores) in enumerate(results, start=len(shards) - len(missing) + 1):
        store.save(shard, scores)
        progress(done, len(shards))
    return len(missing)


def _in_processes(run: RunShard, plan: str, shards: Sequence[Shard], processes: int) -> Iterator[tuple[Shard, Scores]]:
    with worker_processes(processes) as pool:
        futures = {pool.submit(run, plan, shard): shard for shard in shards}
        try:
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BrokenProcessPool as error:
            raise StudyInterrupted("a worker process died; finished shards are kept, start again to resume") from error


def _on_cluster(run: RunShard, plan: str, shards: Sequence[Shard], address: str) -> Iterator[tuple[Shard, Scores]]:
    # an optional requirement, which takes a second to import
    from distributed import Client, KilledWorker
    from distributed import as_completed as finished

    with Client(checked_address(address), timeout=10) as client:
        futures = {client.submit(run, plan, shard, pure=False): shard for shard in shards}
        try:
            for future in finished(list(futures)):
                yield futures[future], future.result()
        except KilledWorker as error:
            raise StudyInterrupted(
                "workers of the cluster died; finished shards are kept, start again to resume"
            ) from error
