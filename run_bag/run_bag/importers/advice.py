"""What a fit or a diagnosis would refuse or doubt in a recording, said as soon as it is imported."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..alignment import moves_between
from ..topic import Topic
from .thrusters_alike import thrusters_alike
from .vehicle_advice import advice_on_vehicle

Array = NDArray[np.float64]
SIGNALS = {"state": ("n",), "flow": ("axial", "ambient"), "load": ("wrench.force.x", "wrench.torque.x")}
LEAST = 20
"""Samples of a signal below which it is left out."""
SLOWEST = 0.1
"""[s] between samples, from which on little can be told of a thruster's dynamics."""
GAP = 0.5
"""[s] without a sample, where samples come ten times as often."""
FULL = 5.0
"""[V] of a full command, in sets, effects and the stops of devices."""
LARGE = {"commanded": 1.01 * FULL, "n": 800.0, "axial": 20.0, "ambient": 20.0, "wrench.force.x": 5000.0,
         "wrench.torque.x": 500.0}  # fmt: skip
"""Magnitudes in our units that no small thruster reaches (800 rad/s: 7600 rpm): another unit was meant."""
UNITS = {"commanded": "V", "n": "rad/s", "axial": "m/s", "ambient": "m/s", "wrench.force.x": "N",
         "wrench.torque.x": "N m"}  # fmt: skip
OPPOSITE = -0.5
BOTH = 0.2
"""Share of the largest speed that a rotor reaches to the other side, too, where it is driven both ways."""
STREAM, LOWEST = 0.2, 0.1
"""Shares of its largest reading above which a flow is a stream's: at rest before the first command, and in all but a
fiftieth of its readings. One without a sign passes 0 as it turns."""
REPEATED = 0.1
"""Share of commands that repeat the one before them, below which a log writes them as they change: a heartbeat, or
a row that closes the log, are few."""


def as_they_change(commands: Array) -> bool:
    """Tell whether a log writes commands [V] as they change: silent then while one is held, it lacks none."""
    return bool(np.mean(np.diff(commands) == 0.0) < REPEATED) if commands.size > 1 else True


def advice(topics: Sequence[Topic], holds: Mapping[str, str]) -> list[str]:
    """Return a sentence for each thing that stands in the way of a fit or a diagnosis of thrusters or the vehicle."""
    found: dict[str, dict[str, Topic]] = {}
    for topic in topics:
        thruster, _, kind = topic.name.strip("/").partition("/")
        if thruster.startswith("thruster_"):
            found.setdefault(thruster, {})[kind] = topic
    vehicle = [topic for topic in topics if topic.name.strip("/").startswith("rov/")]
    thrusters = sorted(found.items(), key=lambda each: (len(each[0]), each[0]))  # 10 is behind 9
    told = thrusters_alike(
        (name, sentence)
        for thruster, own in thrusters
        for each in _of_thruster(thruster, own, holds, alone=not vehicle)
        for name, _, sentence in [each.partition(": ")]
    )
    told += _too_large(thrusters)
    if not found:
        told = ["no thruster_<i>/... topic is in it: `fit` and `diagnose` need thruster_<i>/throttle.commanded"]
    return [*told, *advice_on_vehicle(vehicle)]


def _of_thruster(name: str, own: Mapping[str, Topic], holds: Mapping[str, str], *, alone: bool) -> list[str]:
    """`alone`: a thruster on a bench, of which nothing is known where it has no readings of its own."""
    told = []
    command = _command(own)
    if command is None:
        told.append(f"{name}: no throttle: `fit` and `diagnose` refuse a run without {name}/throttle.commanded")
    else:
        told += _of_throttle(f"{name}/throttle.commanded", *command, hold=holds.get("throttle", ""), alone=alone)
    measured = 0
    for kind, fields in SIGNALS.items():
        for field in fields:
            samples = _samples(own[kind], field) if kind in own else None
            if samples is None:
                continue
            measured += 1
            magnitude = field == "n" and not np.any(own[kind].fields.get("sign_source", 1))
            told += _of_signal(f"{name}/{kind}.{field}", field, *samples, command=command, magnitude=magnitude)
    if not measured and alone:
        wanted = ", ".join(f"{kind}.{field}" for kind, fields in SIGNALS.items() for field in fields)
        told.append(f"{name}: nothing that a model predicts is measured: expected one of {wanted}")
    return told


def _command(own: Mapping[str, Topic]) -> tuple[Array, Array] | None:
    """Return times [s] and values of what a thruster got, None where nothing says it."""
    fields = (("throttle_sent", "sent"), ("throttle", "commanded"), ("throttle", "sent"))
    return next((s for kind, f in fields if kind in own and (s := _samples(own[kind], f)) is not None), None)


def _too_large(thrusters: Sequence[tuple[str, Mapping[str, Topic]]]) -> list[str]:
    """Return what is of another unit by its size, a channel of all thrusters at once."""
    told = []
    for kind, field in [("throttle", "commanded"), *((k, f) for k, fields in SIGNALS.items() for f in fields)]:
        large = {}
        for name, own in thrusters:
            samples = _command(own) if kind == "throttle" else _samples(own[kind], field) if kind in own else None
            largest = 0.0 if samples is None else float(np.max(np.abs(samples[1])))
            if largest > LARGE[field]:
                large[name] = largest
        doubt = "no thruster's; is `unit` that of the recording?"
        if field == "commanded":
            doubt = f"full command is {FULL:g} V; are `unit` and `per_volt` right?"
        says = f"up to {max(large.values(), default=0.0):.4g} {UNITS[field]}: {doubt}"
        told += thrusters_alike((f"{name}/{kind}.{field}", says) for name in large)
    return told


def _samples(topic: Topic, field: str) -> tuple[Array, Array] | None:
    """Return times [s] and values where measured, None where nothing is."""
    if field not in topic.fields:
        return None
    values = np.asarray(topic.fields[field], dtype=np.float64)
    known = np.isfinite(values)
    return (np.asarray(topic.stamps)[known] * 1e-9, values[known]) if known.any() else None


def _of_throttle(name: str, time: Array, values: Array, *, hold: str, alone: bool) -> list[str]:
    told = _common(name, time, held=hold == "previous" and as_they_change(values))
    steps = np.diff(time)
    if np.ptp(values) == 0.0:
        told.append(f"{name}: {values[0]:g} V throughout: a thruster that nothing moves tells nothing")
    elif alone and abs(values[0]) > 0.05 * np.max(np.abs(values)):
        told.append(
            f"{name}: does not begin at zero: a diagnosis estimates how the rotor moved then and leaves out the first "
            "second; begin the next recording with two seconds of rest"
        )
    if not hold and moves_between(time, values):
        taken = "a fit holds it, a diagnosis tries straight lines too" if alone else "it is taken as held"
        told.append(
            f"{name}: nothing says what it does in the {np.median(steps):.3g} s between two samples: "
            f"{taken}; say `hold: previous` (a command is held) or `hold: linear` (a slow record of a ramp)"
        )
    return told


def _of_signal(
    name: str, field: str, time: Array, values: Array, *, command: tuple[Array, Array] | None, magnitude: bool
) -> list[str]:  # fmt: skip
    told = _common(name, time)
    steps = np.diff(time)
    if values.size < LEAST:
        told.append(f"{name}: {values.size} samples: expected at least {LEAST}; it will be left out")
    elif np.median(steps) > 1.01 * SLOWEST:
        told.append(
            f"{name}: one sample every {np.median(steps):.3g} s: expected every {SLOWEST} s or faster, to tell dynamics"
        )
    if np.ptp(values) == 0.0:
        told.append(f"{name}: {values[0]:g} {UNITS[field]} throughout: expected readings that move")
    elif command is not None and values.size >= LEAST:
        told += _against(name, time, values, *command, magnitude=magnitude)
    return told


def _against(name: str, time: Array, values: Array, at: Array, throttle: Array, *, magnitude: bool) -> list[str]:
    """Return what contradicts the throttle; magnitude: the recording states that readings have no sign."""
    index = np.clip(np.searchsorted(at, time, side="right") - 1, 0, at.size - 1)
    asked = throttle[index]
    inside = (time >= at[0]) & (time <= at[-1])
    if not inside.any():
        return [
            f"{name}: {time[0]:.1f} to {time[-1]:.1f} s while the throttle has {at[0]:.1f} to {at[-1]:.1f} s: expected "
            "stamps on one clock; `time_offset` of its entry brings its times to the throttle's"
        ]
    u, y = asked[inside], values[inside]
    if magnitude or np.ptp(u) == 0.0 or np.ptp(y) == 0.0:
        return []
    backward = u < 0.2 * np.min(u) if np.min(u) < 0 else np.zeros(u.size, dtype=bool)
    unsigned = np.min(y) >= 0.0 and np.mean(backward) > 0.05 and np.max(y[backward]) > 0.2 * np.max(y)
    if unsigned and "/flow." in name and _in_a_stream(u, y):
        return []
    if unsigned:
        what = "speed" if name.endswith(".n") else "reading"
        mark = "; a tachometer without sign has sign_source 0" if what == "speed" else ""
        mark = mark or ("; in a stream that the thruster does not turn it is right" if "/flow." in name else "")
        return [f"{name}: no negative {what} while the throttle is negative: expected the sign of forward thrust{mark}"]
    both = min(np.max(y), -np.min(y)) > BOTH * np.max(np.abs(y))
    if name.endswith("/state.n") and both and (np.min(u) >= 0.0 or np.max(u) <= 0.0):
        return [
            f"{name}: goes to both sides while the throttle has one sign, {np.min(u):.3g} to {np.max(u):.3g} V: "
            "expected 0 V at rest; is `stop` the command at which the thruster stands still?"
        ]
    u, y = u / np.max(np.abs(u)), y / np.max(np.abs(y))  # squares of what is spoiled may be beyond all numbers
    likeness = float(u @ y) / np.sqrt(float(u @ u) * float(y @ y))
    if likeness < OPPOSITE:
        return [
            f"{name}: runs against the throttle (correlation {likeness:.2f}): where the sensor is turned round, say "
            "`sign: -1` here; where the thruster may be wired the wrong way round, leave both as they are and diagnose"
        ]
    return []


def _in_a_stream(u: Array, y: Array) -> bool:
    """Tell whether water flows past by itself, by a throttle u [V] and readings y of a flow, none below 0."""
    before = y[np.cumsum(np.abs(u) > 0.02 * np.max(np.abs(u))) == 0]
    flows = before.size >= LEAST and np.median(before) > STREAM * np.max(y)
    return bool(flows and np.quantile(y, 0.02) > LOWEST * np.max(y))


def _common(name: str, time: Array, *, held: bool = False) -> list[str]:
    """Return what may be wrong with any channel; held: one that says nothing while it stays as it is."""
    told = []
    steps = np.diff(time)
    if steps.size:
        usual = float(np.median(steps))
        holes = np.flatnonzero(steps > max(GAP, 10.0 * usual))
        if holes.size and usual < 0.2 and not held:
            places = ", ".join(f"{steps[k]:.1f} s from {time[k] - time[0]:.1f} s on" for k in holes[:3])
            more = f" and {holes.size - 3} more" if holes.size > 3 else ""
            told.append(f"{name}: gaps without samples: {places}{more}")
        if np.any(steps == 0.0):
            told.append(
                f"{name}: {int(np.sum(steps == 0.0))} samples have the stamp of the one before and are kept: of such "
                "readings a fit and a diagnosis take the mean, of such commands the last; expected finer stamps"
            )
    return told
