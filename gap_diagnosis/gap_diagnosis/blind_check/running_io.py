"""Run a blind check: seal all cases, publish their hashes, diagnose in several processes, open the seals."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from itertools import islice
from pathlib import Path
from typing import Any

from gap_diagnosis.blind_check.cases import Plan
from gap_diagnosis.blind_check.opened import Opened
from gap_diagnosis.blind_check.sealing import BrokenSealError
from gap_diagnosis.blind_check.store_io import Store

__all__ = ["diagnose_all", "diagnose_by_library", "opened_cases"]

Diagnose = Callable[..., Mapping[str, Any]]


def diagnose_by_library(
    paths: list[Path], parameter_set_path: Path, excluded: tuple[str, ...] = ()
) -> Mapping[str, Any]:
    """Return what the diagnosis says about runs."""
    from gap_diagnosis.diagnose_io import diagnose_paths  # kernels load once a process, and not to seal

    return diagnose_paths(paths, parameter_set_path, excluded=excluded)


def diagnose_all(
    store: Store,
    plans: Sequence[Plan],
    executor: Executor,
    *,
    diagnose: Diagnose = diagnose_by_library,
    keep_runs: bool = False,
    ahead: int = 4,
    progress: Callable[[Plan, str | None], None] = lambda *_: None,
) -> dict[str, str]:
    """Diagnose all cases that are not finished.

    What diagnoses is given paths and the list of excluded effects, nothing else: runs are made and diagnoses are kept
    on this side of the executor.

    Args:
        store: of the check, its hashes published.
        plans: the cases.
        executor: where each case is diagnosed.
        diagnose: (paths, parameter set, excluded=) -> content of diagnosis.json.
        keep_runs: keep the recordings of finished cases.
        ahead: how many cases wait or are being diagnosed at once.
        progress: called with each case as it ends, and with what went wrong, or None.

    Returns:
        What went wrong, by case. Such a case is not finished; it is tried again when the check is resumed.
    """
    failed: dict[str, str] = {}
    remaining = (plan for plan in plans if not store.finished(plan.name))
    waiting: dict[Future[Mapping[str, Any]], Plan] = {}

    def end(plan: Plan, error: BaseException | None) -> None:
        if error is not None:
            failed[plan.name] = f"{type(error).__name__}: {error}"
            store.note_failure(plan.name, failed[plan.name])
        progress(plan, failed.get(plan.name))

    while True:
        for plan in islice(remaining, ahead - len(waiting)):
            try:
                runs, parameter_set, excluded = store.prepare(plan)
            except (BrokenSealError, OSError) as error:
                end(plan, error)
                continue
            waiting[executor.submit(diagnose, runs, parameter_set, excluded=excluded)] = plan
        if not waiting:
            return failed
        for future in wait(waiting, return_when=FIRST_COMPLETED).done:
            plan, broke = waiting.pop(future), future.exception()
            if broke is None:
                store.keep(plan.name, future.result(), keep_runs=keep_runs)
            end(plan, broke)


def opened_cases(store: Store, plans: Sequence[Plan]) -> list[Opened]:
    """Open the seals of all finished cases; one whose diagnosis failed counts as a diagnosis that is wrong.

    Raises:
        BrokenSealError: a seal does not have its published hash.
    """
    found, hashes = [], store.hashes()
    for plan in plans:
        if store.finished(plan.name):
            found.append(Opened.of(*store.opened(plan.name), seal=hashes[plan.name]))
        elif store.failed(plan.name):
            found.append(Opened.of(store.key(plan.name), {"verdict": "failed"}, {}, seal=hashes[plan.name]))
    return found
