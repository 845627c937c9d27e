"""Command line: score a recorded tracking experiment, as the published scores are, and write its report."""

import argparse
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rov_sim.experiment_report_io import build_report, dump_scores, read_experiment
from rov_sim.experiment_scores import KINDS
from run_bag import RunError
from run_bag.command_line import user_arguments

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the scores and the report's path; return the exit status."""
    parser = argparse.ArgumentParser(prog="score_experiment", description=__doc__)
    parser.add_argument("run", type=Path, help="the recording")
    parser.add_argument("--reference", required=True, choices=KINDS, help="the set point that was to be followed")
    parser.add_argument("--strategy", default="", help="name of the controller, for the report")
    parser.add_argument("--thruster", type=int, default=0, help="index of the thruster (default 0)")
    parser.add_argument("--out", type=Path, help="new folder for report.html and scores.json (default: RUN_scores)")
    given = parser.parse_args(user_arguments(arguments))
    out = given.out or given.run.with_name(f"{given.run.name}_scores")
    about = {"run": str(given.run), "reference": given.reference, "strategy": given.strategy}
    try:
        if out.exists() and (not out.is_dir() or any(out.iterdir())):
            raise FileExistsError(f"{out}: expected a new or empty folder; found something there")
        run, found = read_experiment(given.run, given.reference, thruster=given.thruster)
        report = build_report(run, found, about, thruster=given.thruster)
        out.parent.mkdir(parents=True, exist_ok=True)
        partial = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
        try:
            (partial / "scores.json").write_text(dump_scores(found, about), "utf-8")
            report.write(partial / "report.html")
            partial.chmod(0o755)
            partial.replace(out)
        except BaseException:
            shutil.rmtree(partial, ignore_errors=True)
            raise
    except (RunError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    for name, scores in (("load cell", found.scores), ("truth", found.true_scores)):
        if scores.samples:
            print(
                f"{given.strategy or 'run':<12} {given.reference:<9} RMSE {scores.rmse:6.3f} N ({name}), "
                f"largest {scores.largest:6.3f} N, travel of the throttle {scores.chatter:7.2f} V"
            )
    print((out / "report.html").resolve())
    return 0


if __name__ == "__main__":
    sys.exit(main())
