"""Command line: write the standard first recording's programme, each thruster alone both ways, after a dry run."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.pulses import PulseLimits, pulses
from run_bag import RunError, Topic, write_run
from run_bag.command_line import user_arguments
from thruster_model.errors import ThrusterModelError

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Write a programme; return the exit status."""
    parser = argparse.ArgumentParser(prog="pulses", description=__doc__)
    parser.add_argument("--vehicle", required=True, help="its set: a name or a YAML file")
    parser.add_argument("--model", help="parameter set of its thrusters")
    parser.add_argument(
        "--out", type=Path, help="new folder: a run with the throttles, to be played; without: dry run only"
    )
    parser.add_argument("--throttle", type=float, default=2.5, help="largest [V] (default %(default)s)")
    parser.add_argument("--tilt", type=float, default=0.5, help="largest [rad] (default %(default)s)")
    parser.add_argument("--depth", type=float, default=0.7, help="largest change [m] (default %(default)s)")
    parser.add_argument("--speed", type=float, default=0.6, help="largest [m/s] (default %(default)s)")
    parser.add_argument("--pulse", type=float, default=1.0, help="length of a pulse [s] (default %(default)s)")
    given = parser.parse_args(user_arguments(arguments))
    try:
        model = load_model(given.vehicle, given.model)
        limits = PulseLimits(throttle=given.throttle, tilt=given.tilt, depth=given.depth, speed=given.speed)
        programme = pulses(model, limits, pulse=given.pulse)
        run = programme.dry_run
        time = programme.period * np.arange(len(programme.throttles))
        print(f"{len(time) * programme.period:.0f} s, {model.thrusters} thrusters in turn at {run.level:.2f} V")
        print(f"dry run: tilt to {run.tilt:.2f} rad, depth by {run.depth:.2f} m, speed to {run.speed:.2f} m/s")
        if given.out is None:
            print("nothing was written: name a folder with --out")
            return 0
        columns = {i: programme.throttles[:, i] for i in range(model.thrusters)}
        topics = [Topic.of_thruster(i, "throttle", time, {"commanded": u}) for i, u in columns.items()]
        print(
            write_run(given.out, topics, {"programme": "pulses", "vehicle": model.vehicle.name, "level_V": run.level})
        )
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
