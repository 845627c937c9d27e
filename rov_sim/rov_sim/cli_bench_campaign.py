"""Record a synthetic identification campaign of a thruster bench.

Its sensors are those of the rig, with noise and drift. The tachometer reads 1.1 rad/s too much, also at rest, and the
load cell rings at 7 Hz (force) and 8.5 Hz (moment). A diagnosis finds both beside the effects that are switched on.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from rov_sim.bench_campaign import altered, run_campaign, run_programme
from rov_sim.campaign_io import read_programme, write_bench_run
from run_bag import RunError
from run_bag.command_line import described, user_arguments
from safe_files.whole_files_io import expect_new_folder, new_folder
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import available_sets, load_parameter_set, write_parameter_set

EXAMPLES = """
  %(prog)s --set hl --spread 0 --out runs                                    # the set as it stands
  %(prog)s --set mine.yaml --effect coulomb_friction.deceleration=60 --out runs
  %(prog)s --set hl --programme throttle.csv --out runs                      # your throttle"""


def main(arguments: Sequence[str] | None = None, program: str = "bench_campaign") -> int:
    """Write the runs and the true parameters; return the exit status."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("--out", type=Path, required=True, help="new or empty folder for the runs and truth.yaml")
    parser.add_argument("--seed", type=int, default=1, help="of the random generator (default 1)")
    sets = ", ".join(available_sets())
    text = f"parameter set to alter: {sets} or a YAML file (default hq)"
    parser.add_argument("--set", "--parameters", dest="set", metavar="SET", default="hq", help=text)
    parser.add_argument("--spread", type=float, default=0.1, help="relative width of the alteration (default 0.1)")
    example = "for example coulomb_friction.deceleration=60; several times for several"
    parser.add_argument("--effect", action="append", default=[], metavar="EFFECT.PARAMETER=SIZE", help=example)
    help_programme = (
        "record this throttle instead: csv with columns time_s and throttle_V, as diagnose --experiment writes"
    )
    parser.add_argument("--programme", type=Path, metavar="FILE", help=help_programme)
    given = parser.parse_args(user_arguments(arguments))
    try:
        expect_new_folder(given.out)
        if given.seed < 0 or given.spread < 0.0:
            raise ValueError(f"expected --seed and --spread >= 0; found {given.seed} and {given.spread:g}")
        rng = np.random.default_rng(given.seed)
        truth = altered(load_parameter_set(given.set), given.spread, rng)
        truth = replace(truth, effects=truth.effects.with_words(given.effect))
        if given.programme is None:
            runs = run_campaign(truth, rng)
        else:
            runs = run_programme(truth, *read_programme(given.programme), rng)
        metadata = {"generator": "rov_sim bench_campaign", "seed": given.seed, "parameter_set": truth.source}
        with new_folder(given.out) as folder:
            names = [write_bench_run(run, folder, metadata).name for run in runs]
            write_parameter_set(truth, folder / "truth.yaml")
        print("\n".join(str(given.out / name) for name in names))
    except (RunError, ThrusterModelError, OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("interrupted: nothing was written", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
