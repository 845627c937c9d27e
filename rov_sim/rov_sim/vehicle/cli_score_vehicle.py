"""Score recorded runs of a vehicle as section 5.2 does, and write their report."""

import argparse
import json
import sys
from collections.abc import Sequence
from math import inf, isfinite
from pathlib import Path

from rov_sim.study.cli_progress import shown_progress
from rov_sim.study.cli_running import version_here
from rov_sim.vehicle.recording_io import read_vehicle
from rov_sim.vehicle.run_failures_io import failures_in_words, failures_of, losses_of
from rov_sim.vehicle.run_report_io import Scored, build_report
from rov_sim.vehicle.run_scores_io import as_mapping, score_run
from rov_sim.vehicle.scores import DEGREES_OF_FREEDOM
from run_bag import RunError
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder, write_whole

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the scores and the report's path; return the exit status."""
    parser = argparse.ArgumentParser(prog="score_vehicle", description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="the recordings")
    parser.add_argument("--out", type=Path, help="new folder for report.html and scores.json (default: RUN_scores)")
    parser.add_argument("--begin", type=float, default=0.0, help="scored from here on [s since the run's start]")
    parser.add_argument("--end", type=float, default=inf, help="scored up to here [s since the run's start]")
    given = parser.parse_args(user_arguments(arguments))
    first = given.runs[0]
    out = given.out or first.with_name(f"{first.name}_scores")
    about = {"runs": _names(given.runs), "begin": given.begin, "version": version_here()}
    about |= {} if given.end == inf else {"end": given.end}
    try:
        expect_new_folder(out)
        scored: list[Scored] = []
        names = _names(given.runs)
        with shown_progress("runs", "runs") as progress:
            for run in given.runs:
                recording = read_vehicle(run)
                scored.append((names[len(scored)], recording, score_run(recording, begin=given.begin, end=given.end)))
                progress(len(scored), len(given.runs))
        _write(out, scored, about)
    except (RunError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    for name, recording, scores in scored:
        for each in DEGREES_OF_FREEDOM:
            one = scores.tracking.get(each.id)
            if one is not None and isfinite(one.normalised):
                share = f"{100.0 * one.normalised:.1f} % of the mean |set point|"
                print(f"{name:<20} {each.words:<11} RMSE {one.rmse:.4g} {each.unit}, {share}")
        for sentence in failures_in_words(recording):
            print(f"{name:<20} {sentence}")
    print((out / "report.html").resolve())
    return 0


def _names(runs: Sequence[Path]) -> list[str]:
    """Return a name for each run: the last parts of its path that tell it from the others, numbered where none does."""
    parts = [run.resolve().parts[1:] for run in runs]
    for length in range(1, max(map(len, parts)) + 1):
        names = ["/".join(each[-length:]) for each in parts]
        if len(set(names)) == len(set(parts)):
            break
    return [name if names.index(name) == k else f"{name} ({k + 1})" for k, name in enumerate(names)]


def _write(out: Path, scored: Sequence[Scored], about: dict[str, object]) -> None:
    """Write both files into a folder that gets its name when they are complete."""
    report = build_report(scored, about)
    runs = [
        {
            "name": name,
            **as_mapping(scores),
            "failures": [each.content() for each in failures_of(recording)],
            "silent": losses_of(recording),
        }
        for name, recording, scores in scored
    ]
    content = {**about, "runs": runs}
    with new_folder(out) as partial:
        report.write(partial / "report.html")
        write_whole(partial / "scores.json", json.dumps(content, indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    sys.exit(main())
