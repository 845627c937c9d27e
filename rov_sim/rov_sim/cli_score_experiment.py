"""Score a recorded tracking experiment, as the published scores are, and write its report."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rov_sim.experiment_report_io import build_report, dump_scores, read_experiment
from rov_sim.experiment_scores import KINDS
from run_bag import RunError
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder, write_whole

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
    about = {"run": given.run.resolve().name, "reference": given.reference, "strategy": given.strategy}
    try:
        expect_new_folder(out)
        run, found = read_experiment(given.run, given.reference, thruster=given.thruster)
        report = build_report(run, found, about, thruster=given.thruster)
        with new_folder(out) as partial:
            write_whole(partial / "scores.json", dump_scores(found, about))
            report.write(partial / "report.html")
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
