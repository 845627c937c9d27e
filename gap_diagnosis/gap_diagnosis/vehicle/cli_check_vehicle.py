"""What a vehicle's runs are good for, before any fit: sensors, excitation, wiring, what could be told."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.cli_check import printed
from gap_diagnosis.vehicle.arguments_io import add_sets, told
from gap_diagnosis.vehicle.check_io import check_vehicle
from gap_diagnosis.vehicle.diagnosis_io import load_model
from run_bag.command_line import described, user_arguments
from thruster_model.compilation import told_of_compiling

__all__ = ["main"]
EXAMPLES = """
  %(prog)s runs/dive --vehicle own.yaml
  %(prog)s runs/* --vehicle bluerov2_heavy && echo usable"""


def main(arguments: Sequence[str] | None = None, program: str = "check_vehicle") -> int:
    """Print a line for each finding; return 0 where the runs are usable, 1 where something would be refused."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs of one vehicle")
    add_sets(parser)
    given = parser.parse_args(user_arguments(arguments))
    with told_of_compiling(told):
        return printed(lambda: check_vehicle(given.runs, load_model(given.vehicle, given.set, given.sensors)))


if __name__ == "__main__":
    sys.exit(main())
