"""Damping, effectiveness, lag and bias of a vehicle's attitude rates, fitted to runs, tried on others."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from run_bag import RunError
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import new_folder, write_whole
from thruster_model.attitude_fit.fit import AttitudeFit, FitOptions
from thruster_model.attitude_fit.model import AXES, DEFINITIONS
from thruster_model.attitude_fit.recordings_io import read_recording
from thruster_model.attitude_fit.report_io import build_report
from thruster_model.attitude_fit.scores import Share
from thruster_model.attitude_fit.study import Study, run_study
from thruster_model.attitude_fit.tables import MISSING, markdown
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.progress_io import progress
from thruster_model.vehicle_set_io import load_vehicle_set


def main(arguments: Sequence[str] | None = None) -> int:
    """Fit, write, print; return the exit status."""
    given = _parser().parse_args(user_arguments(arguments))
    try:
        if given.out.exists():
            raise FileExistsError(f"{given.out}: exists and is not overwritten")
        study = _study(given)
        _write(study, given)
    except (ThrusterModelError, RunError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    print(markdown(study), end="")
    print((given.out / "report.html").resolve())
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="attitude_fit", description=__doc__)
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="runs with rov/odometry and throttles")
    parser.add_argument("--vehicle", required=True, metavar="SET", help="vehicle set, by name or YAML file: its layout")
    validate = "runs that are predicted and never fitted, such as those moved by what nothing recorded"
    parser.add_argument("--validate", nargs="+", default=[], type=Path, metavar="RUN", help=validate)
    thruster = "parameter set of the model `force_table`, by name or YAML file: force over the throttle"
    parser.add_argument("--thruster", required=True, metavar="SET", help=thruster)
    parser.add_argument("--out", required=True, type=Path, metavar="DIR", help="folder to write; must not exist")
    piece = "the fit simulates pieces of this length, each from its measured start [s] (default %(default)s)"
    parser.add_argument("--piece", type=float, default=FitOptions().piece, metavar="S", help=piece)
    parser.add_argument("--seed", type=int, default=1, help="of the intervals' draws (default %(default)s)")
    return parser


def _study(given: argparse.Namespace) -> Study:
    if not 0.1 <= given.piece <= 1000.0:
        raise ValueError(f"--piece: expected a time from 0.1 to 1000 s; found {given.piece:g}")
    thruster = load_parameter_set(given.thruster)
    configuration = load_vehicle_set(given.vehicle).configuration
    recordings, others = (
        [read_recording(path, thruster, configuration) for path in paths] for paths in (given.runs, given.validate)
    )
    with progress("fitting") as tell:
        return run_study(recordings, FitOptions(piece=given.piece), given.seed, others, tell)


def _write(study: Study, given: argparse.Namespace) -> None:
    with new_folder(given.out) as partial:
        provenance = {
            "runs": [path.name for path in given.runs],
            "only predicted": [path.name for path in given.validate],
            "vehicle": Path(given.vehicle).name,
            "thruster": Path(given.thruster).name,
            "piece": f"{given.piece:g} s",
            "seed": given.seed,
        }
        text = json.dumps({**_document(study), "provenance": provenance}, indent=1, allow_nan=False)
        write_whole(partial / "attitude_fit.json", text + "\n")
        write_whole(partial / "tables.md", markdown(study))
        build_report(study, provenance).write(partial / "report.html")


def _document(study: Study) -> dict[str, object]:
    names = [each.name for each in study.recordings]
    held = {name: _fitted(fit) for name, fit in zip(names, study.held, strict=False)}
    return {
        "together": _fitted(study.together),
        "left_out": held,
        "shares": {
            "together": dict(zip(names, map(_shares, study.fitted), strict=False)),
            "left_out": dict(zip(names, map(_shares, study.predicted), strict=False)),
            "left_out_pieces": dict(zip(names, map(_shares, study.predicted_pieces), strict=False)),
            "alone": {
                name: dict(zip(names, map(_shares, row), strict=False))
                for name, row in zip(names, study.matrix, strict=False)
            },
        },
        "pushed": {each.name: dict(zip(AXES, each.pushed, strict=True)) for each in study.recordings},
        "missing": list(MISSING),
    }


def _fitted(fit: AttitudeFit) -> dict[str, object]:
    return {
        d.name: {"value": float(v), "unit": d.unit, "standard_deviation": None if np.isnan(s) else float(s)}
        for d, v, s in zip(DEFINITIONS, fit.values, fit.deviations, strict=True)
    }


def _shares(share: Share) -> dict[str, list[float]]:
    return {axis: [float(share.value[k]), float(share.low[k]), float(share.high[k])] for k, axis in enumerate(AXES)}


if __name__ == "__main__":
    sys.exit(main())
