"""Programmes of a vehicle's throttles: their limits on the command line; written as a run to be played, and a table."""

import argparse
from pathlib import Path

import numpy as np

from gap_diagnosis.vehicle.arguments_io import between
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.programmes import Limits, Programme
from run_bag import Topic, write_run
from safe_files.whole_files_io import write_whole

__all__ = ["TABLE", "add_limits", "limits_of", "told", "write_programme"]

TABLE = "throttles.csv"
"""Columns time_s and thruster_0_V to the last: a command holds until the next one."""

_LIMITS = {
    "throttle": (100.0, "largest [V]"), "tilt": (1.5, "largest [rad]"), "depth": (100.0, "largest change [m]"),
    "speed": (10.0, "largest [m/s]"),
}  # fmt: skip
"""Each with the most that it may be, and what it is."""


def add_limits(parser: argparse._ActionsContainer) -> None:
    """Add the limits that a programme keeps to the arguments of a command."""
    usual = Limits()
    for name, (most, what) in _LIMITS.items():
        text = f"{what} (default %(default)s)"
        parser.add_argument(f"--{name}", type=between(0.001, most), default=getattr(usual, name), help=text)


def limits_of(given: argparse.Namespace) -> Limits:
    """Return the limits that were given."""
    return Limits(throttle=given.throttle, tilt=given.tilt, depth=given.depth, speed=given.speed)


def told(programme: Programme, model: Model) -> list[str]:
    """Return what a programme is and what its dry run says, a sentence each."""
    run = programme.dry_run
    return [
        f"{programme.duration:.0f} s, {model.thrusters} thrusters, {programme.words}, at {run.level:.2f} V",
        f"dry run: tilt to {run.tilt:.2f} rad, depth by {run.depth:.2f} m, speed to {run.speed:.2f} m/s",
    ]


def write_programme(programme: Programme, model: Model, folder: Path) -> Path:
    """Write the run `folder` whose throttles are to be played, with the same as a table `TABLE` in it; return it."""
    time = programme.period * np.arange(len(programme.throttles))
    topics = [
        Topic.of_thruster(i, "throttle", time, {"commanded": programme.throttles[:, i]})
        for i in range(model.thrusters)
    ]  # fmt: skip
    about = {"programme": programme.words, "vehicle": model.vehicle.name, "level_V": programme.dry_run.level}
    run = write_run(folder, topics, about)
    heads = ("time_s", *(f"thruster_{i}_V" for i in range(model.thrusters)))
    rows = np.column_stack((time, programme.throttles))
    table = "\n".join([",".join(heads), *(",".join(f"{value:.6g}" for value in row) for row in rows)])
    write_whole(run / TABLE, f"{table}\n")
    return run
