"""Write the standard first recording's programme, each thruster alone both ways, after a dry run."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.vehicle.arguments_io import add_sets, between
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.programmes import PULSES, pulses
from gap_diagnosis.vehicle.programmes_io import add_limits, limits_of, told, write_programme
from run_bag import RunError
from run_bag.command_line import user_arguments
from thruster_model.errors import ThrusterModelError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Write a programme; return the exit status."""
    parser = argparse.ArgumentParser(prog="pulses", description=__doc__)
    add_sets(parser)
    parser.add_argument(
        "--out", type=Path, help="new folder: a run with the throttles, to be played; without: dry run only"
    )
    add_limits(parser)
    text = "length of a pulse [s] (default %(default)s)"
    parser.add_argument("--pulse", type=between(*PULSES), default=1.0, help=text)
    given = parser.parse_args(user_arguments(arguments))
    try:
        model = load_model(given.vehicle, given.set, given.sensors)
        programme = pulses(model, limits_of(given), pulse=given.pulse)
        print("\n".join(told(programme, model)))
        if given.out is None:
            print("nothing was written: name a folder with --out")
            return 0
        print(write_programme(programme, model, given.out))
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
