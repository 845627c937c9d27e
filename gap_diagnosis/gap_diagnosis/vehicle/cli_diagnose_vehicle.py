"""Why a vehicle and its model disagree: a thruster, the hull, a sensor, the wiring or the water."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.vehicle.arguments_io import add_longest, add_sets, told
from gap_diagnosis.vehicle.diagnosis_io import diagnosed, load_model, provenance_of, written
from gap_diagnosis.vehicle.log_io import read_logs
from gap_diagnosis.vehicle.programmes_io import add_limits, limits_of
from run_bag import RunError
from run_bag.command_line import described, user_arguments
from safe_files.whole_files_io import expect_new_folder
from thruster_model.compilation import told_of_compiling
from thruster_model.errors import ThrusterModelError

__all__ = ["main"]

EXAMPLES = """
  thruster diagnose runs/* --vehicle own.yaml --sensors mine.yaml --out vehicle_diagnosis
  thruster diagnose runs/* --vehicle ngs --experiment --tilt 0.4      # and what to record next"""


def main(arguments: Sequence[str] | None = None, program: str = "diagnose_vehicle") -> int:
    """Diagnose runs of a vehicle; return the exit status."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("runs", nargs="+", type=Path, metavar="RUN", help="recorded runs of one vehicle")
    add_sets(parser)
    parser.add_argument("--out", type=Path, default=Path("vehicle_diagnosis"), help="new or empty folder")
    parser.add_argument("--without", nargs="*", default=[], metavar="EFFECT", help="effects that are not considered")
    parser.add_argument("--period", type=float, help="of the filter [s] (default: one near 0.04 that commands keep)")
    add_longest(parser)
    group = parser.add_argument_group("the next experiment")
    text = "write the programme, within these limits, that best tells apart what these recordings cannot"
    group.add_argument("--experiment", action="store_true", help=text)
    add_limits(group)
    given = parser.parse_args(user_arguments(arguments))
    try:
        expect_new_folder(given.out)
        model = load_model(given.vehicle, given.set, given.sensors)
        logs, model = read_logs(given.runs, model, given.period)
        provenance = provenance_of(given.runs, model)
        with told_of_compiling(told):
            found = diagnosed(
                model,
                logs,
                provenance,
                told,
                lambda h: h.effect not in given.without,
                experiment=limits_of(given) if given.experiment else None,
                longest=given.longest,
            )
        paths = written(found, given.out)
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return 130
    print(found.content["verdict"])
    print(found.content["summary"])
    for path in paths:
        print(path)
    if given.experiment and found.proposed is None:
        shared = any(claim.rivals for claim in found.verdict.claims) or found.verdict.name in ("cannot_tell", "unknown")
        why = "no programme within the limits tells more" if shared else "nothing is left that a programme would settle"
        print(f"note: no next experiment: {why}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
