"""`ros2 run run_bag import_bench PATH... --out DIR`: recordings of the thruster bench become runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from ..command_line import exit_status, user_arguments
from ..errors import CannotWriteError, RunError
from .bench import Group, Imported, find, import_recording
from .options import THROTTLE_LIMIT, BenchOptions

TOLD = (
    "throttle at the plateau", "start of the ramp", "duration of the ramp", "shutdown", "last column",
    "load cell turned round", "flow measured", "offset of the velocimeter's clock",
    "start of the controller's recording", "water",
)  # fmt: skip


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    purpose = (
        "Import recordings of the thesis' bench as runs: its csv or csv.xz, with dat or mat beside them. "
        "Those of a bench of your own: thruster import."
    )
    p = argparse.ArgumentParser(prog="import_bench", description=purpose)
    p.add_argument("paths", nargs="+", type=Path, metavar="PATH", help="files, or folders searched recursively")
    p.add_argument("--out", required=True, type=Path, metavar="DIR", help="folder that gets one run per recording")
    p.add_argument("--throttle-set", type=float, metavar="VOLTS", help="signed throttle at the plateau [V]")
    p.add_argument("--adv", choices=["axial", "ambient"], help="what the velocimeter measured")
    p.add_argument("--adv-offset", type=float, metavar="SECONDS", help="first velocimeter sample after the first csv's")
    p.add_argument("--load-cell", choices=["auto", "as-recorded", "reversed"], default="auto")
    p.add_argument(
        "--dead-zone-edge",
        nargs=2,
        type=float,
        metavar=("LO", "HI"),
        default=(-0.83, 0.86),
        help="throttle at which the rotor starts, backward and forward [V] (default: %(default)s)",
    )
    p.add_argument(
        "--throttle-limit",
        type=float,
        metavar="VOLTS",
        default=THROTTLE_LIMIT,
        help="largest throttle that the device takes [V] (default: %(default)s)",
    )
    p.add_argument("--water", choices=["yes", "no"], help="whether the thruster was in water")
    return p


def line(run: Imported) -> str:
    """Return one line about an imported recording."""
    told = []
    for d in run.decisions.items:
        if d.what in TOLD and d.value is not None:
            value = f"{d.value:.4g}" if isinstance(d.value, float) else str(d.value)
            spread = "" if d.standard_deviation is None else f" +- {d.standard_deviation:.2g}"
            told.append(f"{d.what} {value}{spread}{' ' + d.unit if d.unit not in ('', '1') else ''}")
            if d.what == "load cell turned round" and d.value:
                told[-1] += f" ({d.how})"
    return f"{run.directory.name}: {run.duration:.3f} s; {', '.join(run.topics)}; {'; '.join(told)}"


def main(argv: Sequence[str] | None = None) -> int:
    """Import; return 0 if every recording became a run, else 1 (2: wrong usage, 130: interrupted)."""
    options = parser().parse_args(user_arguments(argv))
    lo, hi = options.dead_zone_edge
    if not lo < 0 < hi:
        print(f"--dead-zone-edge: expected LO < 0 < HI in volts, found {lo:g} {hi:g}", file=sys.stderr)
        return 2
    chosen = BenchOptions(
        throttle_set=options.throttle_set, adv=options.adv, adv_offset=options.adv_offset,
        load_cell=options.load_cell, dead_zone_edge=(lo, hi),
        throttle_limit=options.throttle_limit,
        water=None if options.water is None else options.water == "yes",
    )  # fmt: skip
    return exit_status("import_bench", lambda: _run(options.paths, options.out, chosen))


def _run(paths: list[Path], out: Path, options: BenchOptions) -> int:
    plan = find(paths)
    for path, reason in plan.skipped:
        print(f"skipped {path}: {reason}")
    failed = _import_all(plan.groups, out, options)
    done = len(plan.groups) - len(failed)
    print(f"{done} imported, {len(failed)} failed, {len(plan.skipped)} files skipped")
    for sentence in failed:
        print(f"failed: {sentence}", file=sys.stderr)
    if not plan.groups:
        expected = "expected recordings of the bench: csv of its load cell, dat of a velocimeter, mat of a controller"
        print(f"{', '.join(map(str, paths))}: {expected}; found none", file=sys.stderr)
    return 1 if failed or not done else 0


def _import_all(groups: list[Group], out: Path, options: BenchOptions) -> list[str]:
    console = Console(stderr=True)
    failed = []
    with Progress(console=console, transient=True, disable=not console.is_terminal or len(groups) < 3) as progress:
        task = progress.add_task("importing", total=len(groups))
        for group in groups:
            progress.update(task, description=group.stem)
            try:
                print(line(import_recording(group, out, options)), flush=True)
            except CannotWriteError:
                raise  # the others would fail in the same way
            except RunError as error:
                failed.append(str(error))
            progress.advance(task)
    return failed


if __name__ == "__main__":
    sys.exit(main())
