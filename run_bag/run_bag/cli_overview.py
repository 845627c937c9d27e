"""`ros2 run run_bag overview PATH...`: one page that links the reports and runs that are there."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from .command_line import described, exit_status, user_arguments
from .errors import RunError, RunExistsError
from .overview import is_run, overview

EXAMPLES = """
  %(prog)s runs/mine                       # fits, diagnoses, drawn runs: runs/mine/overview.html
  %(prog)s runs/log                        # a run, and the pages beside it that have its name
  %(prog)s runs/fit runs/diagnosis --out mine.html"""


def parser(program: str = "overview") -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    purpose = "Make one page that links the reports and runs of a folder, and says what each report found."
    p = argparse.ArgumentParser(prog=program, **described(purpose, EXAMPLES))
    p.add_argument("paths", nargs="+", type=Path, metavar="PATH", help="folder of results, run, or report")
    p.add_argument(
        "--out", type=Path, metavar="FILE.html",
        help="file to write; must not exist (default of one folder: overview.html in it; of a run: RUN_overview.html)",
    )  # fmt: skip
    p.add_argument("--title", default="", help="of the page")
    return p


def main(argv: Sequence[str] | None = None, program: str = "overview") -> int:
    """Write the page; return 0, or 1 (2: wrong usage) with a sentence on standard error."""
    options = parser(program).parse_args(user_arguments(argv))
    if options.out is None and len(options.paths) > 1:
        print(f"{program}: expected --out FILE.html, as there are {len(options.paths)} paths", file=sys.stderr)
        return 2
    return exit_status(program, lambda: _run(options))


def _run(options: argparse.Namespace) -> int:
    out = options.out or _default(options.paths[0].absolute())
    if out.exists():
        raise RunExistsError(f"{out} exists; nothing is overwritten: say another --out", path=out)
    if not out.parent.is_dir():
        raise RunError(f"{out}: expected an existing folder {out.parent}, found none", path=out)
    print(overview(options.paths, out, options.title).write(out).absolute())
    return 0


def _default(path: Path) -> Path:
    if path.is_dir() and not is_run(path):
        return path / "overview.html"
    return path.with_name(f"{path.name.removesuffix('.mcap').removesuffix('.html')}_overview.html")


if __name__ == "__main__":
    sys.exit(main())
