"""Run a blind check: seal all cases, publish their hashes, diagnose in several processes, open the seals."""

import multiprocessing
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from gap_diagnosis.blind_check.cases import Plan
from gap_diagnosis.blind_check.scoring import Opened
from gap_diagnosis.blind_check.store_io import Store

__all__ = ["diagnose_all", "diagnose_by_library", "opened_cases", "pool"]

Diagnose = Callable[..., Mapping[str, Any]]


def diagnose_by_library(
    paths: list[Path], parameter_set_path: Path, excluded: tuple[str, ...] = (), seed: int = 0
) -> Mapping[str, Any]:
    """Return what the diagnosis says about runs."""
    from gap_diagnosis.diagnose_io import diagnose_paths  # kernels load once a process, and not to seal

    return diagnose_paths(paths, parameter_set_path, excluded=excluded, seed=seed)


def pool(processes: int) -> Executor:
    """Return that many processes, each started afresh: nothing of a key is in their memory."""
    return ProcessPoolExecutor(processes, mp_context=multiprocessing.get_context("spawn"))


def diagnose_all(
    store: Store,
    plans: Sequence[Plan],
    executor: Executor,
    *,
    diagnose: Diagnose = diagnose_by_library,
    keep_runs: bool = False,
    progress: Callable[[Plan, str | None], None] = lambda *_: None,
) -> dict[str, str]:
    """Diagnose all cases that are not finished.

    Args:
        store: of the check, its hashes published.
        plans: the cases.
        executor: where each case is diagnosed.
        diagnose: (paths, parameter set, excluded=, seed=) -> content of diagnosis.json.
        keep_runs: keep the recordings of finished cases.
        progress: called with each case as it ends, and with what went wrong, or None.

    Returns:
        What went wrong, by case. Such a case is not finished; it is tried again when the check is resumed.
    """
    failed: dict[str, str] = {}
    waiting = {
        executor.submit(store.diagnose, plan, diagnose, keep_runs=keep_runs): plan
        for plan in plans
        if not store.finished(plan.name)
    }
    for future in as_completed(waiting):
        plan, error = waiting[future], future.exception()
        if error is not None:
            failed[plan.name] = f"{type(error).__name__}: {error}"
        progress(plan, failed.get(plan.name))
    return failed


def opened_cases(store: Store, plans: Sequence[Plan], failed: Mapping[str, str]) -> list[Opened]:
    """Open the seals of all finished cases; a failed one counts as a diagnosis that is wrong.

    Raises:
        BrokenSealError: a seal does not have its published hash.
    """
    found = []
    for plan in plans:
        if store.finished(plan.name):
            key, diagnosis, clean = store.opened(plan.name)
            found.append(Opened(key=key, diagnosis=diagnosis, clean=clean))
        elif plan.name in failed:
            found.append(Opened(key=store.key(plan.name), diagnosis={"verdict": "failed"}))
    return found
