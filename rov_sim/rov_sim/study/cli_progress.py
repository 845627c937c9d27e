"""How far a long command is: a bar on a terminal, a line now and then elsewhere, both on standard error."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

__all__ = ["shown_progress"]


@contextmanager
def shown_progress(words: str, unit: str = "parts") -> Iterator[Callable[[int, int], None]]:
    """Yield a function that is told how many of how many are done.

    Args:
        words: what is being done, before the bar.
        unit: what is counted, for the lines where there is no terminal.
    """
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(words, total=None)

        def progress(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total)
            if not console.is_terminal and (done == total or done % max(1, total // 10) == 0):
                print(f"  {done} of {total} {unit}", file=sys.stderr, flush=True)

        yield progress
