"""Write a commented vehicle's set to be edited."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from run_bag.command_line import described, user_arguments
from thruster_model.cli_new_set import written
from thruster_model.new_vehicle_io import new_vehicle
from thruster_model.vehicle_set_io import available_vehicles

EXAMPLES = """
  %(prog)s --vehicle bluerov2_heavy -o mine.yaml"""


def main(arguments: Sequence[str] | None = None, program: str = "new_vehicle") -> int:
    """Write the set; return the exit status."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    text = f"vehicle whose values it begins with: {', '.join(available_vehicles())} or a YAML file"
    parser.add_argument("--vehicle", metavar="SET", required=True, help=text)
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="file to write; must not exist")
    given = parser.parse_args(user_arguments(arguments))
    return written(lambda: new_vehicle(given.vehicle), given.out)


if __name__ == "__main__":
    sys.exit(main())
