"""What recordings are good for, said before any diagnosis: excitation, units, and which effects would show in them."""

from collections.abc import Sequence

import numpy as np

from gap_diagnosis.findings import Finding
from gap_diagnosis.plausibility import checked, problem_of, unit_problems
from gap_diagnosis.problem import Problem
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import RULES
from gap_diagnosis.suspects import found_by, suspects
from gap_diagnosis.unit_check import gains_and_likenesses
from system_identification.fitting import fit
from system_identification.noise import whitener
from system_identification.rating import UNMOVED, rated, tried
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import SIGNALS
from thruster_model.parameter_set import ParameterSet
from thruster_model.unmoved import moved_by_effects

__all__ = ["excitation", "readiness"]

ORDINARY, ALIKE = 2.0, 0.7
"""Gain against the set, either way, and correlation with it, beyond which a channel is told of."""
_STEPS = 4  # of a fit that only makes the parameters' share of a gap small


def excitation(recording: Recording, parameter_set: ParameterSet) -> Finding:
    """Return how the throttle moves: its range, its time inside the dead zone of the set, its reversals."""
    throttle, values = recording.experiment.throttle, parameter_set.values
    upper, lower = values.get("delta_u2", 0.0), values.get("delta_u1", 0.0)
    outside = throttle[(throttle > upper) | (throttle < lower)]
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
    return [*found, *_magnitudes(problem), *_effects(problem)]


def _magnitudes(problem: Problem) -> list[Finding]:
    """Return how large each channel is against the set, and how alike: no unit or sign is surely wrong, or all told."""
    found = []
    for channel, (gain, likeness) in gains_and_likenesses(problem).items():
        told = f"{gain:.3g} times what the set says (correlation {likeness:.2f})"
        near = 1.0 / ORDINARY < gain < ORDINARY and likeness > ALIKE
        doubt = "" if near else "; another thruster than the set's, another unit or sign, or a very large gap"
        found.append(
            Finding(kind="good" if near else "note", about=f"sign and size of {channel}", sentence=told + doubt)
        )
    return found


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
    blind = {
        name: e.channel.split() for name, e in LIBRARY.items() if e.channel and not signals & set(e.channel.split())
    }
    blind |= {name: sorted(unread[name]) for name in sorted({*still.values()} & unread.keys())}
    logged = [name for name in found_by("log", "gates") if name not in blind]
    found = [
        Finding(
            kind="good" if shown else "note",
            about="effects that would show",
            sentence=f"{', '.join(shown) or 'none'} (of usual size, sensors as noisy as here, nothing else wrong); "
            f"{', '.join(logged)} are looked for in the samples themselves",
        )
    ]
    if hidden:
        told = f"{', '.join(hidden)}: they hide behind the noise or behind re-tuned parameters in these recordings"
        found.append(Finding(kind="note", about="effects that would not show", sentence=told))
    if idle:
        told = f"{', '.join(idle)}: the model has no such part, or these recordings do not reach where they begin"
        found.append(Finding(kind="note", about="effects that would change nothing", sentence=told))
    if blind:
        lacking = dict.fromkeys(s for own in blind.values() for s in own if s in SIGNALS)
        wanted = ", ".join(SIGNALS[s].title.lower() for s in lacking)
        told = f"{', '.join(blind)}: not measured is {wanted}"
        found.append(Finding(kind="note", about="effects that cannot be looked for", sentence=told))
    return found
