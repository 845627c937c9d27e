"""What runs are good for, before any fit: rates, hold, excitation, signs, units, parameters, effects."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from gap_diagnosis.check_io import check
from gap_diagnosis.findings import Finding, lines_of, usable
from run_bag import RunError
from run_bag.command_line import described, of_a_vehicle, offer_vehicle, printable, user_arguments
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import available_sets, load_parameter_set

EXAMPLES = """
  %(prog)s runs/log --set mine.yaml
  %(prog)s runs/* --set hl && echo usable"""


def main(arguments: Sequence[str] | None = None, program: str = "check") -> int:
    """Print a line for each finding; return 0 where the runs are usable, 1 where something would be refused."""
    taken = user_arguments(arguments)
    if of_a_vehicle(taken):
        from gap_diagnosis.vehicle.cli_check_vehicle import main as of_vehicle  # loads the vehicle's model

        return of_vehicle(taken, program)
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs of one thruster")
    sets = ", ".join(available_sets())
    text = f"parameter set of the simulator: {sets} or a YAML file"
    parser.add_argument("--set", dest="set", metavar="SET", required=True, help=text)
    parser.add_argument("--thruster", type=int, default=0, help="index of the thruster (default 0)")
    offer_vehicle(parser)
    given = parser.parse_args(taken)
    return printed(lambda: check(given.runs, load_parameter_set(given.set), given.thruster))


def printed(work: Callable[[], Sequence[Finding]]) -> int:
    """Print what a check finds; return 0 where runs are usable, 1 where something is refused or cannot be read."""
    try:
        found = work()
    except (RunError, ThrusterModelError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    for line in lines_of(found):
        print(printable(line))
    return 0 if usable(found) else 1


if __name__ == "__main__":
    sys.exit(main())
