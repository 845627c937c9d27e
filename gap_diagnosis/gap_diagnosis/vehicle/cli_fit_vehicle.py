"""A vehicle's mass, added mass, drag, centres and thrusters fitted to runs; what these do not tell."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.vehicle.arguments_io import add_longest, add_sets, told
from gap_diagnosis.vehicle.diagnosis_io import load_model, provenance_of
from gap_diagnosis.vehicle.fit import fitted_vehicle
from gap_diagnosis.vehicle.fit_io import summary_of, written
from gap_diagnosis.vehicle.log_io import read_logs
from run_bag import RunError
from run_bag.command_line import described, user_arguments
from safe_files.whole_files_io import expect_new_folder
from thruster_model.errors import ThrusterModelError

__all__ = ["main"]

EXAMPLES = """
  thruster fit runs/* --vehicle own.yaml --sensors mine.yaml --out vehicle_fit"""


def main(arguments: Sequence[str] | None = None, program: str = "fit_vehicle") -> int:
    """Fit a vehicle's numbers to its runs; return the exit status."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="runs; two or more predict each other")
    add_sets(parser)
    parser.add_argument("--out", type=Path, default=Path("vehicle_fit"), help="new or empty folder")
    parser.add_argument("--period", type=float, help="of the filter [s] (default: one near 0.04 that commands keep)")
    add_longest(parser)
    given = parser.parse_args(user_arguments(arguments))
    try:
        expect_new_folder(given.out)
        model = load_model(given.vehicle, given.set, given.sensors)
        logs, model = read_logs(given.runs, model, given.period)
        fit = fitted_vehicle(model, logs, told, given.longest)
        provenance = provenance_of(given.runs, model)
        paths = written(model, fit, provenance, given.out)
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return 130
    print(summary_of(fit))
    for path in paths:
        print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main())
