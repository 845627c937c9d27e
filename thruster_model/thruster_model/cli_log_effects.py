"""A finished run as it would have been logged with the effects of the log in a parameter set."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from run_bag import RunError
from run_bag.command_line import user_arguments
from thruster_model.effects.active import NOTHING
from thruster_model.effects.recorded_runs_io import with_log_effects
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the path of the run with the effects, or of the run itself where there are none; return the exit status."""
    parser = argparse.ArgumentParser(prog="log_effects", description=__doc__)
    parser.add_argument("run", type=Path, help="the run; it is not touched")
    parser.add_argument("--set", "--parameters", dest="set", metavar="SET", help="parameter set whose effects act")
    parser.add_argument("--effects", default="", help="more effects: 'EFFECT.PARAMETER=SIZE ...'")
    parser.add_argument("--seed", type=int, default=0, help="of effects that scatter (default 0)")
    parser.add_argument("--out", type=Path, required=True, help="the copy, a new folder")
    given = parser.parse_args(user_arguments(arguments))
    try:
        effects = load_parameter_set(given.set).effects if given.set else NOTHING
        effects = effects.with_words(given.effects.split())
        print(with_log_effects(given.run, given.out, effects, given.seed))
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
