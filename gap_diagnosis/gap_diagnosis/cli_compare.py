"""Where the predictions of a simulator of your own, as a run, differ from a recording, and how much.

Nothing is re-tuned and no model of the thruster is asked.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.predicted import differences, throttle_apart
from gap_diagnosis.recording_io import recordings_of
from run_bag import Run, RunError, read_run
from run_bag.command_line import described, user_arguments
from thruster_model.errors import ThrusterModelError, UnfitDataError
from thruster_model.parameter_set_io import load_parameter_set

EXAMPLES = """
  %(prog)s runs/log runs/simulated            # both with the same channels
  %(prog)s runs/log runs/simulated --set hl   # for the dead zone"""
OTHER_THROTTLE = 0.02
"""Difference of the throttles, over the largest command, from which on it is told."""


def main(arguments: Sequence[str] | None = None, program: str = "compare") -> int:
    """Print a sentence for each signal; return the exit status, 0 however far apart they are."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("run", type=Path, metavar="RUN", help="the recording")
    parser.add_argument("predicted", type=Path, metavar="PREDICTED", help="what the simulator says, as a run")
    parser.add_argument("--set", metavar="SET", help="parameter set whose dead zone counts as a regime")
    parser.add_argument("--thruster", type=int, default=0, help="index of the thruster (default 0)")
    given = parser.parse_args(user_arguments(arguments))
    try:
        values = load_parameter_set(given.set).values if given.set else {}
        edge = min(abs(values.get("delta_u1", 0.0)), abs(values.get("delta_u2", 0.0)))
        told = compared(read_run(given.run), read_run(given.predicted), given.thruster, edge)
    except (RunError, ThrusterModelError, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    print("\n".join(told))
    return 0


def compared(run: Run, predicted: Run, thruster: int = 0, edge: float = 0.0) -> list[str]:
    """Return a sentence for each signal that both runs have, and on what cannot be said.

    Args:
        run: the recording.
        predicted: the simulator's.
        thruster: index.
        edge: of the dead zone [V]; 0: not known.

    Raises:
        UnfitDataError: a run without throttle or measurement, in several parts, or no signal in both.
    """
    (one, other), told = (recordings_of(each, thruster) for each in (run, predicted)), []
    for each, parts in ((run, one), (predicted, other)):
        if len(parts) > 1:
            raise UnfitDataError([f"{each.name}: expected one throttle without silences, found {len(parts)} parts"])
    later = (predicted.start - run.start) * 1e-9
    if not -run.duration < later < run.duration:
        told.append("note: the runs' stamps do not overlap: both are taken to begin at the same instant")
        later = 0.0
    apart = throttle_apart(one[0], other[0], later)
    if apart > OTHER_THROTTLE:
        told.append(
            f"note: the throttles are {100.0 * apart:.0f} % of the largest command apart (root mean square): "
            "expected the recording's; what follows is not the simulator's doing alone"
        )
    found = differences(one[0], other[0], later=later, edge=edge)
    if not found:
        raise UnfitDataError(
            [f"{predicted.name}: expected a signal that {run.name} has too, at the same time; found none"]
        )
    told += [each.sentence for each in sorted(found, key=lambda each: -each.rms / each.noise)]
    told.append(
        "What this cannot say: whether other parameters of the simulator would close the gap, or which effect is "
        "missing. `diagnose` says that where the simulator's parameters are a set."
    )
    return told


if __name__ == "__main__":
    sys.exit(main())
