"""What recordings are good for, said before any diagnosis: excitation, units, and which effects would show in them."""

from collections.abc import Sequence

import numpy as np

from gap_diagnosis.findings import Finding
from gap_diagnosis.plausibility import checked, problem_of, unit_problems
from gap_diagnosis.problem import Problem
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import RULES
from gap_diagnosis.suspects import found_by, suspects
from gap_diagnosis.unit_check import Likened, gains_and_likenesses
from system_identification.fitting import fit
from system_identification.left_out import FEWEST_RUNS
from system_identification.noise import whitener
from system_identification.rating import UNMOVED, rated, tried
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import SIGNALS
from thruster_model.parameter_set import ParameterSet
from thruster_model.unmoved import moved_by_effects

__all__ = ["excitation", "readiness"]

ORDINARY, ALIKE = 2.0, 0.7
"""Gain against the set, either way, and correlation with it, beyond which a channel is told of."""
BAND = 0.01
"""Share of the largest command up to which one that is measured counts as zero: it has noise."""
_STEPS = 4  # of a fit that only makes the parameters' share of a gap small


def excitation(recording: Recording, parameter_set: ParameterSet) -> Finding:
    """Return how the throttle moves: its range, its time inside the dead zone of the set, its reversals.

    What is within `BAND` of zero is at zero: a command that was measured is never 0, and its noise reverses nothing.
    """
    throttle, values = recording.experiment.throttle, parameter_set.values
    upper, lower = values.get("delta_u2", 0.0), values.get("delta_u1", 0.0)
    band = BAND * float(np.max(np.abs(throttle), initial=0.0))
    outside = throttle[(throttle > max(upper, band)) | (throttle < min(lower, -band))]
    reversals = int(np.sum(np.diff(np.sign(outside)) != 0.0)) if outside.size else 0
    inside = 1.0 - outside.size / throttle.size
    zone = f"inside the dead zone of the set ({lower:g} to {upper:g} V)" if upper > lower else "at zero"
    said = (
        f"{np.min(throttle):.3g} to {np.max(throttle):.3g} V over {recording.experiment.duration:.1f} s, "
        f"{100.0 * inside:.0f} % of the time {zone}, {reversals} reversals"
    )
    missing = [] if reversals else ["both directions in turn"]
    missing += [] if inside < 0.9 else ["more time beyond the dead zone"]
    wanted = f"; expected {' and '.join(missing)}: friction, dead zone and flow show there" if missing else ""
    return Finding(
        kind="note" if missing else "good", run=recording.name, about="throttle as simulated", sentence=said + wanted
    )


def readiness(recordings: Sequence[Recording], parameter_set: ParameterSet) -> list[Finding]:
    """Return what a diagnosis would refuse or leave out, and which effects it could see.

    Args:
        recordings: of one thruster.
        parameter_set: of the simulator.
    """
    usable, warnings, reasons = checked(recordings)
    found = [Finding(kind="note", about="channels", sentence=sentence) for sentence in warnings]
    found += [excitation(each, parameter_set) for each in recordings]
    problem = None
    if not reasons:
        problem, reasons = problem_of(usable, parameter_set)
        reasons = reasons if not problem.series else [*reasons, *unit_problems(problem)]
    found += [Finding(kind="refused", about="diagnose would refuse", sentence=sentence) for sentence in reasons]
    if problem is None or reasons:
        return found
    if len(usable) < FEWEST_RUNS:
        told = f"a quarter of each recording; from {FEWEST_RUNS} recordings on whole ones, which tell more of the next"
        found.append(Finding(kind="good", about="left out in turn by a diagnosis", sentence=told))
    return [*found, *_magnitudes(problem), *_effects(problem)]


def _magnitudes(problem: Problem) -> list[Finding]:
    """Return how large each channel is against the set, and how alike: no unit or sign is surely wrong, or all told."""
    found = []
    for channel, each in gains_and_likenesses(problem).items():
        told = f"{each.gain:.3g} times what the set says (correlation {each.likeness:.2f})"
        doubt = _doubt(each)
        found.append(
            Finding(kind="note" if doubt else "good", about=f"sign and size of {channel}", sentence=told + doubt)
        )
    return found


def _doubt(of: Likened) -> str:
    """Return what a channel that is not as the set says may be, "" where it is."""
    ordinary = 1.0 / ORDINARY < abs(of.gain) < ORDINARY
    if ordinary and of.likeness > ALIKE:
        return ""
    if ordinary and of.likeness < -ALIKE:
        return "; a sensor that is turned round (`sign: -1` in its map), or a thruster that is: then diagnose it so"
    if of.as_if:
        return (
            f", as if {of.as_if}: is the map's `unit` right? Else another thruster than the set's, or a very large gap"
        )
    return "; another thruster than the set's, another unit or sign, or a very large gap"


def _effects(problem: Problem) -> list[Finding]:
    """Return which effects would show beside re-tuned parameters, at the middle of their plausible sizes."""
    signals = {each.signal for each in problem.series}
    noise = whitener(problem, problem.start())
    base = fit(problem, noise, problem.start(), iterations=_STEPS)
    offered = suspects(signals)
    looks = rated(base, noise, tried(base, offered, lambda each: problem.tried(base.x, each)))
    # An effect that no equation has may still shorten a step, and change the last digits.
    moved = moved_by_effects(problem.parameter_set)
    without = [name for name, names in moved.items() if not names]
    unread = {name: names for name, names in moved.items() if names and not names & signals}
    quiet = (each.suspect for each in looks if each.visibility <= UNMOVED or each.suspect.effect in without)
    still = {suspect.key: suspect.effect for suspect in quiet}
    idle = sorted(key for key, effect in still.items() if effect not in unread)
    seen = {each.suspect.key: each.visibility for each in looks if each.suspect.key not in still}
    shown = sorted(key for key, visibility in seen.items() if visibility > RULES.visible)
    hidden = sorted(seen.keys() - set(shown))
    of_sensors = {name: set(e.channel.split()) for name, e in LIBRARY.items() if e.channel}
    predicted = set(problem.parameter_set.model.signals)
    partless = {name for name, read in of_sensors.items() if not read & predicted}
    partless |= {name for name, effect in LIBRARY.items() if effect.reads and effect.reads not in predicted}
    partless |= {key for key in idle if still[key] in without}
    unreached = sorted(set(idle) - partless)
    blind = {name: sorted(read) for name, read in of_sensors.items() if name not in partless and not signals & read}
    blind |= {name: sorted(unread[name]) for name in sorted({*still.values()} & unread.keys())}
    # Stretches in which thrust is lost are seen in the thrust, and are of a rotor that turns.
    untold = sorted({"thrust", "speed"} - signals)
    blind |= {name: untold for name in found_by("gates") if untold}
    logged = [name for name in found_by("log", "gates") if name not in blind and name not in partless]
    found = [
        Finding(
            kind="good" if shown else "note",
            about="effects that would show",
            sentence=f"{', '.join(shown) or 'none'} (of usual size, sensors as noisy as here, nothing else wrong)",
        ),
        Finding(kind="good", about="effects that are looked for in the samples themselves", sentence=", ".join(logged)),
    ]
    if hidden:
        told = f"{', '.join(hidden)}: they hide behind the noise or behind re-tuned parameters in these recordings"
        found.append(Finding(kind="note", about="effects that would not show", sentence=told))
    if partless:
        told = f"{', '.join(sorted(partless))}: the model has no such part"
        found.append(Finding(kind="good", about="effects that would change nothing", sentence=told))
    if unreached:
        told = f"{', '.join(unreached)}: these recordings do not reach where they begin"
        found.append(Finding(kind="note", about="effects that would not begin to act", sentence=told))
    if blind:
        lacking = predicted & {signal for own in blind.values() for signal in own}
        wanted = ", ".join(each.title.lower() for signal, each in SIGNALS.items() if signal in lacking)
        told = f"{', '.join(blind)}; not measured: {wanted}"
        found.append(Finding(kind="note", about="effects that cannot be looked for", sentence=told))
    return found
