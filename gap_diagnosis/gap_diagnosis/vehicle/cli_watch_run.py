"""The watch over a recorded run, as the node would have had it; said line by line."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.arguments_io import add_sets, between
from gap_diagnosis.vehicle.baseline import baseline
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.false_alarms import stated_rate
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.watching import Watch
from run_bag import RunError
from run_bag.command_line import user_arguments
from thruster_model.errors import ThrusterModelError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Watch a run; return the exit status."""
    parser = argparse.ArgumentParser(prog="watch_run", description=__doc__)
    parser.add_argument("run", type=Path, metavar="RUN")
    add_sets(parser)
    parser.add_argument(
        "--baseline", type=Path, nargs="+", required=True, metavar="RUN", help="runs of the healthy vehicle"
    )
    parser.add_argument(
        "--threshold", type=between(*rules.WATCH_THRESHOLDS), default=rules.WATCH_THRESHOLD,
        help="log likelihood ratio that is an alarm; watch_rate tells how many are false (default %(default)s)",
    )  # fmt: skip
    given = parser.parse_args(user_arguments(arguments))
    try:
        model = load_model(given.vehicle, given.set, given.sensors)
        healthy, model = read_logs(given.baseline, model)
        learned, told = baseline(model, healthy), set[str]()
        watch = Watch(model, learned, given.threshold)
        (log,), _ = read_logs([given.run], model, model.period)
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    if learned.doubt:
        print(learned.doubt)
    for note in log.notes:
        print(f"{log.name}: {note}")
    piece, stuck = max(round(1.0 / log.period), 1), set[str]()
    for first in range(0, log.count - piece + 1, piece):
        for alarm in watch.step(log.part(first, first + piece))[:1]:
            if alarm.name not in told:
                told.add(alarm.name)
                print(f"{watch.time:.1f} s: {alarm.words} (log ratio {alarm.log_ratio:.0f})")
        for name, words in watch.stuck.items():
            if name not in stuck:
                print(f"{watch.time:.1f} s: {words}")
        stuck = set(watch.stuck)
    print(f"{log.duration:.0f} s watched, {len(told)} alarms; false alarms [1/h]: {stated_rate(given.threshold)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
