"""Calibrate the load cell of recorded runs, identify its resonance and recover the thrust it hides."""

import argparse
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from rich.console import Console

from run_bag import RunError
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder
from thruster_model.errors import ThrusterModelError, UnfitDataError
from thruster_model.load_cell.recordings_io import read_recordings, write_recovered
from thruster_model.load_cell.report_io import build_report
from thruster_model.load_cell.study import RecoveryStudy, calibrate_recordings, recover_recordings
from thruster_model.load_cell.yaml_io import write_load_cell


def main(arguments: Sequence[str] | None = None) -> int:
    """Calibrate, recover, write matrix, report and runs; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        expect_new_folder(given.out)
        _run(given)
    except (ThrusterModelError, RunError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="load_cell", description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs (rosbag2 directories)")
    parser.add_argument("--out", type=Path, required=True, help="new or empty folder for the results")
    parser.add_argument("--thruster", type=int, default=0, help="index of the thruster (default 0)")
    parser.add_argument("--calibrate-only", action="store_true", help="leave the resonance and the thrust alone")
    return parser


def _run(given: argparse.Namespace) -> None:
    console = Console(stderr=True)
    with console.status("reading") as status:
        pairs = read_recordings(given.runs, given.thruster)
        recordings = {recording.name: recording for _, recording in pairs}
        status.update("calibrating")
        calibrated = calibrate_recordings(list(recordings.values()))
        recovered, why_not = _recovered(given, pairs, set(calibrated.other if calibrated else ()), status.update)
        if calibrated is None and recovered is None:
            raise UnfitDataError([f"no run holds gauges to calibrate with, and no thrust was recovered: {why_not}"])
        status.update("writing")
        provenance = {"runs": [p.resolve().name for p in given.runs], "version": _version(), "seed": 1}
        report = build_report(recordings, calibrated, recovered, why_not, provenance)
        with new_folder(given.out) as folder:
            if recovered is not None:
                _write_runs(folder / "recovered", given, pairs, recovered)
            write_load_cell(folder / "load_cell.yaml", calibrated, recovered)
            report.write(folder / "report.html")
    if calibrated is not None:
        worst = max(calibrated.reproduced.values(), key=lambda r: max(r.force, r.moment))
        which = "runs left out" if len(calibrated.reproduced) > 1 else "the run itself"
        print(f"wrench of {which}, worst relative error: force {worst.force:.1e}, moment {worst.moment:.1e}")
    if recovered is not None:
        mode, deviation = recovered.resonance.mode, recovered.resonance.deviation
        print(f"mode: {mode.frequency:.1f} ± {deviation['frequency']:.1f} Hz at 1 N, damping {mode.damping:.3f}")
        for name in recovered.of_thesis:
            saved = recovered.saved[name]
            print(f"{name}: {100 * saved.below_one:.0f} % of {saved.cells} cells recovered within 1 N (1 sigma)")
    print((given.out / "report.html").resolve())


def _recovered(given, pairs, other, progress) -> tuple[RecoveryStudy | None, str]:  # type: ignore[no-untyped-def]
    if given.calibrate_only:
        return None, "It was not asked for."
    fit = [r for run, r in pairs if r.name not in other and run.metadata.get("water") is not False]
    if not fit:
        return None, "No run in water obeys the matrix of the others."
    try:
        return recover_recordings(fit, progress), ""
    except UnfitDataError as error:
        return None, str(error)


def _write_runs(folder: Path, given, pairs, study: RecoveryStudy) -> None:  # type: ignore[no-untyped-def]
    mode = {name: float(value) for name, value in vars(study.resonance.mode).items()}
    folder.mkdir()
    for run, recording in pairs:
        if recording.name in study.recovered:
            record = {
                "method": "Kalman smoother, force and moment, one structural mode, means over 0.04 s",
                "mode": mode,
                "lever_arm_m": float(study.arm),
                "version": _version(),
            }
            write_recovered(folder / recording.name, run, study.recovered[recording.name], record, given.thruster)


def _version() -> str:
    try:
        return version("thruster_model")
    except PackageNotFoundError:
        return "source"


if __name__ == "__main__":
    sys.exit(main())
