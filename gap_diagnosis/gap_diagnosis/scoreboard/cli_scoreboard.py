"""How often the diagnosis is right on generators that share no code.

scoreboard run SET DIR        diagnose the cases of a set (smoke, quick, reported), those in DIR not again; the table
scoreboard table DIR          the table of what DIR holds
scoreboard compare DIR DIR    the table of the second one, and the cases that the two answer differently
scoreboard ablate SET         the cases judged anew with one rule of judgement changed at a time
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from gap_diagnosis.scoreboard.figures import differences, table
from gap_diagnosis.scoreboard.generators import GENERATORS
from gap_diagnosis.scoreboard.plans import SETS, planned
from gap_diagnosis.scoreboard.running_io import read_answers, run_cases
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import write_whole

__all__ = ["main"]

_COLUMNS = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, show or compare; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    console = Console(width=None if sys.stdout.isatty() else 200)
    try:
        return int(given.does(given, console))
    except (OSError, ValueError) as error:
        print(f"scoreboard: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        kept = (
            "cases that were finished are kept, the same command goes on" if given.does is _run else "nothing was kept"
        )
        print(f"interrupted: {kept}", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    formatter = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="scoreboard", description=__doc__, formatter_class=formatter)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    run = commands.add_parser("run", help="diagnose the cases of a set")
    run.add_argument("set", choices=list(SETS), help="which cases")
    run.add_argument("folder", type=Path, metavar="DIR", help="for the answers; resumed if it is there")
    run.add_argument("--generators", nargs="+", default=list(GENERATORS), choices=list(GENERATORS), metavar="NAME")
    run.add_argument("--first", type=int, default=0, metavar="N", help="begin with the N-th case, from 0; default: 0")
    run.add_argument("--count", type=int, metavar="M", help="so many cases of the set; default: all that follow")
    run.add_argument("--processes", type=int, default=2, metavar="P", help="processes that diagnose; default: 2")
    run.add_argument("--docs", type=Path, metavar="FILE", help="Markdown file for the table")
    run.set_defaults(does=_run)
    show = commands.add_parser("table", help="the table of a folder")
    show.add_argument("folder", type=Path, metavar="DIR")
    show.add_argument("--docs", type=Path, metavar="FILE", help="Markdown file for the table")
    show.set_defaults(does=_show)
    compare = commands.add_parser("compare", help="the cases that two folders answer differently")
    compare.add_argument("before", type=Path, metavar="BEFORE")
    compare.add_argument("folder", type=Path, metavar="AFTER")
    compare.set_defaults(does=_compare, docs=None)
    ablate = commands.add_parser("ablate", help="what each rule of judgement is worth")
    ablate.add_argument("set", choices=list(SETS), help="which cases")
    ablate.add_argument("--cases", type=int, default=30, metavar="N", help="the first so many of them; default: 30")
    ablate.add_argument("--processes", type=int, default=2, metavar="P", help="processes that diagnose; default: 2")
    ablate.add_argument("--docs", type=Path, metavar="FILE", help="Markdown file for the table")
    ablate.set_defaults(does=_ablate)
    return parser


def _run(given: argparse.Namespace, console: Console) -> int:
    if given.processes < 1:
        raise ValueError(f"--processes: expected 1 or more; found {given.processes}")
    if given.first < 0 or (given.count is not None and given.count < 1):
        raise ValueError(f"--first, --count: expected 0 or more, 1 or more; found {given.first}, {given.count}")
    every = planned(given.set, tuple(given.generators))
    plans = every[given.first :][: given.count]
    if not plans:
        raise ValueError(f"--first: expected 0 to {len(every) - 1}, a case of the set {given.set}; found {given.first}")
    with Progress(*_COLUMNS, console=console) as progress:
        task = progress.add_task("diagnosing", total=len(plans), completed=0)
        held = {answer.case for answer in read_answers(given.folder)}
        progress.advance(task, sum(each.name in held for each in plans))
        run_cases(plans, given.folder, given.processes, lambda _: progress.advance(task))
    return _show(given, console)


def _ablate(given: argparse.Namespace, console: Console) -> int:
    from gap_diagnosis.scoreboard.ablation import rows_of  # kernels take seconds to load
    from gap_diagnosis.scoreboard.ablation_io import judged_cases

    plans = planned(given.set, tuple(GENERATORS))[: given.cases]
    with Progress(*_COLUMNS, console=console) as progress:
        task = progress.add_task("judging", total=len(plans))
        found = judged_cases(plans, given.processes, lambda: progress.advance(task))
    _tell(rows_of(found), f"rules changed one at a time, {_cases(len(found))} of {given.set}", given.docs, console)
    return 0


def _show(given: argparse.Namespace, console: Console) -> int:
    answers = read_answers(given.folder)
    if not answers:
        raise ValueError(f"{given.folder}: expected answers of `scoreboard run`; found none")
    _tell(table(answers), f"{_cases(len(answers))} in {given.folder}", given.docs, console)
    return 0


def _cases(count: int) -> str:
    """Return "1 case", "2 cases"."""
    return f"{count} case{'' if count == 1 else 's'}"


def _tell(rows: list[list[str]], title: str, docs: Path | None, console: Console) -> None:
    _print(console, rows, title)
    if docs is not None:
        lines = ["| " + " | ".join(row) + " |" for row in rows]
        lines.insert(1, "|" + "---|" * len(rows[0]))
        write_whole(docs, ("\n".join(lines) + "\n").encode(), replace=True)
        print(f"written: {docs}")


def _compare(given: argparse.Namespace, console: Console) -> int:
    before, after = read_answers(given.before), read_answers(given.folder)
    both = len({each.case for each in before} & {each.case for each in after})
    if not both:
        found = f"{_cases(len(before))} and {_cases(len(after))}, none of them in both"
        raise ValueError(f"{given.before}, {given.folder}: expected answers to the same cases; found {found}")
    rows = differences(before, after)
    _show(given, console)
    _print(console, rows, f"{len(rows) - 1} of {_cases(both)} in both answered otherwise than in {given.before}")
    return 0


def _print(console: Console, rows: list[list[str]], title: str) -> None:
    console.print(title, highlight=False, soft_wrap=True)
    shown = Table(*rows[0])
    for row in rows[1:]:
        shown.add_row(*row)
    console.print(shown)


if __name__ == "__main__":
    sys.exit(main())
