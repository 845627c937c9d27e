"""Topics that every csv gives: load, gauges; and the values at rest, recorded but not subtracted."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..topic import Topic
from .bench_files import LoadCellFile
from .decisions import Decisions
from .options import START_NS, BenchOptions
from .signals import glitches, rest_window
from .wrench import LEAST_THRUST, STANDARD_ERRORS, forward_thrust, to_thruster

Array = NDArray[np.float64]
FRAME = "thruster_0"


def stamps(time: Array, offset: float = 0.0) -> NDArray[np.int64]:
    """Return stamps [ns] for times on the csv's clock [s]."""
    return START_NS + np.round((time + offset) * 1e9).astype(np.int64)


def load_topics(
    csv: LoadCellFile,
    direction: Array,
    rest: tuple[float, float] | None,
    options: BenchOptions,
    log: Decisions,
) -> list[Topic]:
    """Return load and gauges; decides whether the fixture was turned round.

    Args:
        direction: +1, -1 or 0 (too slow to count) of the rotation, (N,).
        rest: stretch at rest [s], None if there is none.
    """
    reversed_fixture = _reversed(csv, direction, rest, options, log)
    force, torque = to_thruster(csv.force, csv.moment, reversed_fixture=reversed_fixture)
    if rest is not None:
        window = (csv.time >= rest[0]) & (csv.time <= rest[1])
        parts = zip(("force", "torque"), ("N", "N m"), (force, torque), strict=True)
        for kind, unit, values in parts:
            for axis, column in zip("xyz", values.T, strict=True):
                part = column[window]
                log.add(f"rest value of {kind}.{axis}", float(part.mean()), unit,
                        "mean over the rest window; not subtracted", float(part.std()))  # fmt: skip
    fields: dict[str, Any] = {f"wrench.force.{a}": force[:, i] for i, a in enumerate("xyz")}
    fields |= {f"wrench.torque.{a}": torque[:, i] for i, a in enumerate("xyz")}
    at = stamps(csv.time)
    gauges = {"voltage": csv.voltages, "force": csv.legs}
    return [
        Topic(name="thruster_0/load", type="geometry_msgs/WrenchStamped", stamps=at, fields=fields, frame=FRAME),
        Topic(
            name="thruster_0/gauges",
            type="thruster_msgs/LoadCellGauges",
            stamps=at,
            fields=gauges,
            frame=FRAME,
        ),
    ]


def _reversed(
    csv: LoadCellFile,
    direction: Array,
    rest: tuple[float, float] | None,
    options: BenchOptions,
    log: Decisions,
) -> bool:
    what = "load cell turned round"
    if options.load_cell != "auto":
        log.add(what, options.load_cell == "reversed", "1", "told by the user")
        return options.load_cell == "reversed"
    level = 0.0
    if rest is not None:
        window = (csv.time >= rest[0]) & (csv.time <= rest[1])
        level = float(np.mean(-csv.force[window, 1]))
    found = forward_thrust(csv.time, -csv.force[:, 1], level, direction)
    if found is None:
        log.add(what, False, "1", "taken as recorded: too little rotation above 50 rad/s to tell")
        return False
    mean, error = found
    if abs(mean) < LEAST_THRUST:
        how = f"thrust in the direction of rotation is {mean:.2f} N, too little to tell; taken as recorded"
        log.add(what, False, "1", how)
        return False
    opposite = mean < -STANDARD_ERRORS * error
    how = (
        f"thrust in the direction of rotation is {mean:.2f} +- {error:.2f} N "
        "(mean and standard error above rest); "
        + ("opposite, so the wrench is turned by half a turn about z" if opposite else "taken as recorded")
    )
    log.add(what, opposite, "1", how)
    return opposite


def describe_clock(csv: LoadCellFile, log: Decisions) -> None:
    """Note the clock and what the csv's header says."""
    log.add("stamp of the first csv sample", START_NS / 1e9, "s", "the date is not known; the clock starts at 1 s")
    for key, value in csv.header.items():
        log.add(f"csv header: {key}", value, "", "copied")


def describe_tachometer(time: Array, speed: Array, log: Decisions) -> tuple[float, float] | None:
    """Note rest window, rest value and glitches of a tachometer [rad/s]; return the rest window [s]."""
    rest = rest_window(time, speed)
    if rest is None:
        log.add("rest window", None, "s", "none: the tachometer leaves its first value within 0.3 s + margin")
    else:
        log.add("rest window", list(rest), "s", "from the first sample to 0.2 s before the tachometer moves")
        part = speed[(time >= rest[0]) & (time <= rest[1])]
        log.add("rest value of n", float(part.mean()), "rad/s", "mean over the rest window; not subtracted",
                float(part.std()))  # fmt: skip
    found = glitches(time, speed)
    value = [{"time": round(g.time, 4), "height": round(g.height, 2), "duration": round(g.duration, 4)} for g in found]
    log.add("tachometer glitches", value, "s, rad/s, s", "peaks above the running median; left in the data")
    return rest
