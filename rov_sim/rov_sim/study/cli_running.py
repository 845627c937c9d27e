"""What the studies' command lines share: arguments about running, the progress, and how failures end."""

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

from rov_sim.study.cli_progress import shown_progress
from rov_sim.study.running_io import RunShard, StudyInterrupted, checked_address, run_shards
from rov_sim.study.store_io import Shard, Store
from thruster_control.errors import ThrusterControlError
from thruster_model.errors import ThrusterModelError

__all__ = ["FAILURES", "add_running_arguments", "failed", "problems", "run_with_progress", "version_here"]

FAILURES = (
    StudyInterrupted, ModuleNotFoundError, ThrusterModelError, ThrusterControlError, OSError, ValueError,
    KeyboardInterrupt,
)  # fmt: skip
"""What ends a study with a sentence."""


def add_running_arguments(p: argparse.ArgumentParser) -> None:
    """Add --processes and --scheduler."""
    p.add_argument("--processes", type=int, default=1, help="on this machine (default 1)")
    p.add_argument("--scheduler", metavar="tcp://…", help="address of a dask scheduler on this machine")


def problems(given: argparse.Namespace, least: Sequence[tuple[str, int]]) -> list[str]:
    """Return what is wrong with the arguments about running and with the integers of `least` (option, least value)."""
    wrong = [
        f"--{option}: expected {smallest} or more; found {getattr(given, option)}"
        for option, smallest in (*least, ("processes", 1))
        if getattr(given, option) < smallest
    ]
    if given.scheduler is not None:
        try:
            checked_address(given.scheduler)
        except ValueError as error:
            wrong.append(str(error))
    return wrong


def run_with_progress(store: Store, shards: Sequence[Shard], run: RunShard, given: argparse.Namespace) -> None:
    """Run what is missing; show how far it is on standard error."""
    with shown_progress("experiments") as progress:
        run_shards(store, shards, run, processes=given.processes, scheduler=given.scheduler, progress=progress)


def failed(error: BaseException) -> int:
    """Return the exit status after an error of a study, its reason on standard error."""
    if isinstance(error, KeyboardInterrupt):
        print("interrupted: what was finished is kept, the same command resumes", file=sys.stderr)
        return 130
    if isinstance(error, ModuleNotFoundError):
        print(f"--scheduler: expected dask.distributed to be installed; found {error}", file=sys.stderr)
        return 1
    print(error, file=sys.stderr)
    return 1


def version_here() -> str:
    """Return the installed version, or "source"."""
    try:
        return version("rov_sim")
    except PackageNotFoundError:
        return "source"
