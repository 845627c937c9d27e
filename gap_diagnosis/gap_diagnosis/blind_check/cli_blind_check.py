"""Cases with sealed keys, diagnosed from their recordings alone, then opened and scored."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from gap_diagnosis.blind_check.cases import KINDS, MODELS, Plan, plan
from gap_diagnosis.blind_check.docs_io import summary_rows, write_page
from gap_diagnosis.blind_check.opened import Opened
from gap_diagnosis.blind_check.opened_io import read_opened, write_opened
from gap_diagnosis.blind_check.running_io import diagnose_all, opened_cases
from gap_diagnosis.blind_check.scoring import score
from gap_diagnosis.blind_check.sealing import BrokenSealError, hash_of_all
from gap_diagnosis.blind_check.store_io import Store
from rov_sim.study.worker_processes_io import worker_processes
from run_bag.command_line import user_arguments

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Seal, diagnose, open, score; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    console = Console()
    try:
        return _run(given, console)
    except (BrokenSealError, ValueError, OSError) as error:
        print(f"blind_check: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="blind_check", description=__doc__)
    parser.add_argument("--cases", type=int, required=True, metavar="N", help="number of cases")
    parser.add_argument("--seed", type=int, required=True, metavar="S", help="of all that is drawn")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder of the check; resumed if it is there"
    )
    parser.add_argument("--kinds", nargs="+", default=[], choices=list(KINDS), help="kinds of case; default: all")
    parser.add_argument("--effects", nargs="+", default=[], metavar="ID", help="effects to play with; default: all")
    parser.add_argument("--model", choices=list(MODELS), help="one thruster model for all; default: drawn")
    parser.add_argument("--processes", type=int, default=2, metavar="P", help="processes that diagnose; default: 2")
    parser.add_argument("--keep-runs", action="store_true", help="keep the recordings of finished cases")
    parser.add_argument(
        "--opened", nargs="+", type=Path, default=[], metavar="FILE",
        help="opened.jsonl.gz of other folders of this check: not diagnosed again, scored with the rest",
    )  # fmt: skip
    parser.add_argument("--so-far", action="store_true", help="diagnose nothing more: score what is finished")
    parser.add_argument("--docs", type=Path, metavar="FILE", help="Markdown file for the figures, pictures beside it")
    return parser


def _run(given: argparse.Namespace, console: Console) -> int:
    if given.cases < 1 or given.processes < 1:
        raise ValueError(f"--cases and --processes: expected 1 or more, found {given.cases} and {given.processes}")
    plans = plan(given.cases, given.seed, kinds=given.kinds, effects=given.effects, model=given.model)
    store = Store(given.out, given.seed)
    for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(threads, "1")  # the processes share the cores; inherited by those started below
    elsewhere = _elsewhere(given.opened, plans, store)
    own = [each for each in plans if each.name not in elsewhere]
    with _progress(console) as progress:
        task = progress.add_task("sealing", total=len(own))
        hashes = store.publish(own, lambda _: progress.advance(task))
    hashes |= {name: case.seal for name, case in elsewhere.items()}
    published = hash_of_all(hashes[each.name] for each in plans)
    console.print(
        f"{len(own)} keys sealed, hashes in {given.out / 'hashes.txt'}; hash of all: [bold]{published}[/bold]"
    )
    if not given.so_far:
        _diagnose(store, own, given, console)
    failed = [each.name for each in own if store.failed(each.name)]
    if failed:
        print(f"{len(failed)} of {len(own)} diagnoses failed; they count as wrong, and are tried again on resuming")
    opened = elsewhere | {str(case.key["case"]): case for case in opened_cases(store, own)}
    cases = [opened[each.name] for each in plans if each.name in opened]
    if not cases:
        raise ValueError(f"{given.out}: expected finished cases; found none")
    write_opened(cases, given.out / "opened.jsonl.gz")
    _report(cases, published, given, console)
    return 1 if failed else 0


def _report(cases: Sequence[Opened], published: str, given: argparse.Namespace, console: Console) -> None:
    """Print the figures and write the page if asked for; `published`: hash of all sealed keys."""
    scores = score(cases, np.random.default_rng([given.seed, 4]))
    table = Table("figure", "value", "target", title=f"Blind check, {len(cases)} cases, seed {given.seed}")
    for row in summary_rows(scores):
        table.add_row(*row)
    console.print(table)
    if given.docs is not None:
        kinds = ", ".join(dict.fromkeys(str(case.key["kind"]) for case in cases))
        beside = given.docs.with_name(f"{given.docs.stem}_cases.jsonl.gz")
        provenance = (
            f"{len(cases)} cases of {given.cases}, seed {given.seed}, kinds {kinds}; hash of all sealed keys "
            f"`{published}`. Made by `blind_check`; every case, opened: [{beside.name}]({beside.name})."
        )
        files = write_page(scores, given.docs, provenance)
        write_opened(cases, beside)
        console.print("written: " + ", ".join(str(file) for file in (*files, beside)))


def _elsewhere(files: Sequence[Path], plans: Sequence[Plan], store: Store) -> dict[str, Opened]:
    """Return the cases that were opened elsewhere and are not finished here, by name."""
    planned = {each.name: each for each in plans}
    found = {}
    for file in files:
        for case in read_opened(file):
            name = str(case.key["case"])
            if name not in planned:
                raise ValueError(
                    f"{file}: expected cases of this check; found {name}, which is not one of {len(plans)}"
                )
            store.check_key(planned[name], case.key, file)
            if not store.finished(name):
                found[name] = case
    return found


def _diagnose(store: Store, plans: Sequence[Plan], given: argparse.Namespace, console: Console) -> None:
    with _progress(console) as progress, worker_processes(given.processes) as executor:
        done = sum(store.finished(each.name) for each in plans)
        task = progress.add_task("diagnosing", total=len(plans), completed=done)
        failed = diagnose_all(
            store,
            plans,
            executor,
            keep_runs=given.keep_runs,
            ahead=2 * given.processes,
            progress=lambda *_: progress.advance(task),
        )
    for name, reason in list(failed.items())[:5]:
        print(f"{name}: {reason}", file=sys.stderr)


def _progress(console: Console) -> Progress:
    shown = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    return Progress(*shown, console=console)


if __name__ == "__main__":
    sys.exit(main())
