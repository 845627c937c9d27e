"""The unit of a column or field whose recording states none: from its name, from its values, or asked about.

What neither the name nor the values decide is "?", with the units in question: an import refuses it until a person has
written the unit. A speed without a unit is the usual case: 300 may be rad/s, rpm or deg/s.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from .advice import LARGE
from .conversions import COMMANDS, conversion, spelled
from .possible_units import by_gravity, exists, known_quantity, possible, possible_angles, taken_for_granted
from .recording_map import ASKED
from .sources import Array
from .unit_words import named_units, words_of

AS_RPM = "in rad/s by its type, and {} is no thruster's: is it rpm?"
"""Asked once of an array of speeds."""


OF_AN_AMPLIFIER = "write unit: {}, scale: its {} for each {}, offset: -scale times the {} without load"
"""Asked of a load cell that is recorded as a voltage."""


class Guessed(NamedTuple):
    """A unit, and what a person should know about it ("" where it was stated)."""

    unit: str
    why: str = ""


class _Range(NamedTuple):
    """The units in question for values up to `most`; where it is one, the values decide."""

    most: float
    units: tuple[str, ...]


_TIME_STEPS = (
    _Range(0.5, ("s",)), _Range(2.0, ("s", "ms")), _Range(300.0, ("ms",)), _Range(3e3, ("ms", "us")),
    _Range(3e5, ("us",)), _Range(3e6, ("us", "ns")), _Range(np.inf, ("ns",)),
)  # fmt: skip
"""Steps between two samples: a recording has 3 to 2000 of them in a second."""
_EPOCH = ((1e9, "s"), (1e12, "ms"), (1e15, "us"), (1e18, "ns"))
"""What times since 1970 are from 2001 to 2286, in each unit: the least one, ten times as many at most."""
_NOT_TIMES = ("pwm",)
"""Words for µs that say what is timed."""


def guessed_unit(
    ours: str,
    name: str,
    stated: str,
    values: Array | None,
    *,
    usual: str = "",
    command: bool = False,
    vehicle: bool = False,
    vector: Mapping[str, Array] = MappingProxyType({}),
    force: Sequence[Array] = (),
) -> Guessed:
    """Return the unit of a column or field of a channel in `ours`.

    Args:
        ours: the channel's own unit.
        name: of the column or field.
        stated: the unit that the recording states, "" where it states none.
        values: those of the column or field, None where they are no numbers.
        usual: what the format says where the recording does not, as in a vehicle's log.
        command: it is a throttle, which need not be a voltage.
        vehicle: it is one of a vehicle's inertial sensors; values are then those of all its axes.
        vector: readings of each of its parts, row by row.
        force: readings of the accelerometer's three axes, in any unit.
    """
    largest = float(np.nanmax(np.abs(values))) if values is not None else np.nan
    volts = spelled(stated) if stated else next(iter(named_units(name)[-1:]), "")
    if is_amplified(volts, ours):
        return Guessed(ASKED, OF_AN_AMPLIFIER.format(ours, ours, volts, volts))
    if stated:
        unit = spelled(stated)
        if fits(unit, ours, command=command):
            odd = not vehicle and ours == "rad/s" and unit == ours and largest > LARGE["n"]
            return Guessed(unit, f"{largest:.4g} rad/s is no thruster's: is it rpm?" if odd else "")
        if usual:
            return Guessed(usual, f"{stated!r} is not known: taken as {usual}")
        return _asked(possible(ours, largest, inertial=vehicle), f"{stated!r} is not known as a unit of it")
    if usual:
        beyond = not vehicle and ours == "rad/s" and usual == ours and largest > LARGE["n"]
        return Guessed("rpm", AS_RPM.format(f"{largest:.4g}")) if beyond else Guessed(usual)
    named = [unit for unit in named_units(name) if fits(unit, ours, command=command)]
    if named and not _contradicted(named[-1], ours, name, values, largest):
        return Guessed(named[-1], "unit by its name")
    if command:
        return _command(values, largest)
    if values is None or not known_quantity(ours):
        return Guessed(ours, "unit not stated")
    if ours == "m/s^2" and len(vector) == 3:
        size = np.linalg.norm(np.stack(list(vector.values())), axis=0)
        if units := by_gravity(size):
            usual = f"|a| is {float(np.median(size)):.4g} as a rule, as gravity at rest"
            return Guessed(units[0], f"unit by its values: {usual}") if len(units) == 1 else _asked(units, usual)
    if ours == "rad":
        units = possible_angles(vector or {"yaw": values}, force)
    else:
        units = possible(ours, largest, inertial=vehicle)
    if units == (ours,) and taken_for_granted(ours):
        return Guessed(ours, "unit not stated")
    if vehicle and ours in ("rad/s", "m/s^2"):  # counts of a converter are of any size: other sensors tell its unit
        return _asked(units, "no other sensor says which")
    return Guessed(units[0], "unit by its values") if len(units) == 1 else _asked(units, "nothing says which")


def _contradicted(unit: str, ours: str, name: str, values: Array | None, largest: float) -> bool:
    """Tell whether values deny a name's unit: no pulses, or a unit alone, which may name the quantity (VOLT)."""
    if unit == "us" and values is not None:
        return not pulses(values)
    alone = len(words_of(name)) == 1 and unit not in COMMANDS
    return alone and known_quantity(ours) and not exists(unit, ours, largest)


def guessed_time_unit(name: str, stated: str, values: Array | None) -> Guessed:
    """Return the unit of a table's time: that at the end of its name, or which it is, else what its steps tell.

    The name of what it times tells none: t_pwm is the time of pulses, not in µs.
    """
    if stated and conversion(stated, "s") is not None:
        return Guessed(spelled(stated))
    if not stated:
        words = [word.lower() for word in words_of(name) if not word.isdigit()]
        named = named_units(f"t_{words[-1]}") if words and words[-1] not in _NOT_TIMES else []
        if named and conversion(named[-1], "s") is not None and (len(words) > 1 or len(words[0]) > 1):
            return Guessed(named[-1], "unit by its name")
    known = values[np.isfinite(values)] if values is not None else np.empty(0)
    steps = np.diff(known)
    if not steps.size:
        return Guessed("s", "unit not stated")
    for least, unit in _EPOCH:
        if least <= known[0] < 10 * least:
            return Guessed(unit, "unit by its values")
    usual = float(np.median(steps))
    units = next(r.units for r in _TIME_STEPS if usual < r.most or r.most == np.inf)
    if len(units) > 1:
        return _asked(units, f"{usual:.4g} between two samples")
    return Guessed(units[0], "unit by its values")


def _asked(units: tuple[str, ...], why: str) -> Guessed:
    return Guessed(ASKED, f"write the unit: {' or '.join(filter(None, (', '.join(units[:-1]), units[-1])))}? {why}")


def is_amplified(unit: str, ours: str) -> bool:
    """Tell whether a force or a torque is recorded as its amplifier's voltage."""
    return ours in ("N", "N m") and conversion(unit, "V") is not None


def fits(unit: str, ours: str, *, command: bool) -> bool:
    """Tell whether a unit is one of a channel in `ours`; command: of a throttle, which need not be a voltage."""
    return conversion(unit, ours) is not None or (command and unit in COMMANDS)


_LEAST_PERCENT, _LEAST_MILLIVOLTS, _MOST_PERCENT = 20.0, 1000.0, 101.0
"""The largest command of a recording, a volt of five, is at least that, and at most so much."""
_FULL = {"us": (1500.0, 80.0), "%": (0.0, 20.0), "1": (0.0, 0.2), "counts": (0.0, 1.0)}
"""`stop` and `per_volt` of a full command of 5 V, as in the sets of thrusters with such commands."""
_HALF, _NEVER_AT_REST = 50.0, 10.0
"""[%] Rest of a command of 0 to 100 % that goes both ways, and the least one by which it is known: others rest at 0."""


def pulses(values: Array) -> bool:
    """Tell whether all values are widths of servo pulses [us]."""
    return bool(np.nanmin(values) > 700.0 and np.nanmax(values) < 2300.0)


def _command(values: Array | None, largest: float) -> Guessed:
    if values is None:
        return Guessed("V", "unit not stated")
    if pulses(values):
        return Guessed("us", "unit by its values")
    if largest <= 1.001:
        return Guessed("1", "unit by its values: -1 to 1")
    if largest < _LEAST_PERCENT:
        return Guessed("V", "unit by its values")
    known = values[np.isfinite(values)]
    sent = known[known != 0.0]  # 0 where no pulse is sent
    there = {
        "us": pulses(sent),
        "%": largest <= _MOST_PERCENT,
        "counts": bool(np.array_equal(known, np.round(known))),
        "mV": _LEAST_MILLIVOLTS < largest <= 1e3 * LARGE["commanded"],
    }
    units = tuple(unit for unit, possible_so in there.items() if possible_so) or ("counts", "V")
    return _asked(units, "nothing says which; with all but volts write stop and per_volt, too")


def rest_and_volt(unit: str, values: Array | None) -> tuple[float, float]:
    """Return the command at which a thruster likely rests, and how many of it likely make a volt of five.

    Counts rest at the commonest value, and the one farthest from it is taken for full command; % that never come
    near 0 rest at 50.
    """
    stop, per_volt = _FULL[unit]
    if values is None:
        return stop, per_volt
    known = values[np.isfinite(values)]
    if unit == "counts":
        levels, times = np.unique(known, return_counts=True)
        stop = float(levels[np.argmax(times)])
        per_volt = float(np.max(np.abs(known - stop))) / 5.0 or per_volt
    elif unit == "%" and np.min(known) > _NEVER_AT_REST:
        stop, per_volt = _HALF, _HALF / 5.0
    return stop, per_volt
