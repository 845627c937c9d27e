"""Write a commented parameter set, complete or on the base of another one."""

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from run_bag.command_line import described, user_arguments
from thruster_model.errors import ThrusterModelError
from thruster_model.models import MODELS
from thruster_model.new_set_io import new_set
from thruster_model.parameter_set_io import available_sets, write_set_text

EXAMPLES = """
  %(prog)s hq -o mine.yaml                    # all parameters, to be replaced
  %(prog)s hl --base hl_bench -o mine.yaml    # what differs from the set hl_bench"""


def main(arguments: Sequence[str] | None = None, program: str = "new_set") -> int:
    """Write the set; return the exit status."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("model", metavar="MODEL", help=f"one of {', '.join(MODELS)}")
    sets = ", ".join(available_sets())
    parser.add_argument(
        "--base", metavar="SET", help=f"set to stand on: {sets} or a YAML file, from the new set's folder"
    )
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="file to write; must not exist")
    given = parser.parse_args(user_arguments(arguments))
    return written(lambda: new_set(given.model, given.base, given.out.parent), given.out)


def written(text: Callable[[], str], out: Path) -> int:
    """Write a new set's text and print where; return the exit status."""
    try:
        write_set_text(text(), out)
    except (ThrusterModelError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
