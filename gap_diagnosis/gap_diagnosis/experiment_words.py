"""The next experiment in words, and what else would tell apart what no throttle can."""

from collections.abc import Sequence

import numpy as np

from gap_diagnosis.experiment_inputs import Programme
from thruster_model.effects.stages import LIBRARY

__all__ = ["SURE", "as_sentence", "inseparable_in_words"]

SURE = 3.0
"""Standard deviations from which on two hypotheses are told apart."""
_TOLD = 4  # pairs, the closest ones
_SETTLES = {
    "log": "stamps taken on the device beside those of the log",
    "command": "the voltage at the motor's terminals, recorded on the clock of the other channels",
    "rotor": "the rotor's drag and inertia apart from the thruster: a spin-down without propeller, a weighed rotor",
    "thrust": "a second load cell, or speed and thrust at known inflow",
    "flow": "a second velocimeter elsewhere in the tank",
    "sensor": "the sensor against a reference",
}
"""What would show an effect of a block, apart from the thruster's answer to the throttle."""
_SENSORS = {
    "tach": "a second tachometer or a stroboscope",
    "flow": "the velocimeter towed at known speeds, or a second one beside it",
    "load": "known weights on the load cell",
}


def as_sentence(
    programme: Programme | None,
    separates: Sequence[tuple[tuple[str, str], float, float]],
    inseparable: Sequence[str],
) -> str:
    """Return the proposal in words; `separates`: candidates, distance and distance now [std]."""
    parts = []
    if programme is not None:
        told = []
        for (a, b), distance, now in sorted(separates, key=lambda each: each[1]):
            text = f"{_called(a)} from {_called(b)} by {distance:.1f} standard deviations (now {now:.1f})"
            if np.hypot(distance, now) < SURE:
                times = int(np.ceil((SURE**2 - now**2) / max(distance, 1e-3) ** 2))
                text += f", played {times} times by {SURE:g} in all"
            told.append(text)
        length = programme.period * programme.throttle.size
        rest = f"; further pairs, {len(told) - _TOLD} of them, by more" if len(told) > _TOLD else ""
        parts.append(
            f"The next experiment: {programme.title}, for {length:g} s. It tells {'; '.join(told[:_TOLD])}{rest}."
        )
    return " ".join([*parts, *inseparable])


def inseparable_in_words(first: tuple[str, ...], second: tuple[str, ...]) -> str:
    """Return the sentence for two hypotheses that no throttle tells apart."""
    own = [key for key in first if key not in second]
    other = [key for key in second if key not in first]
    shows: dict[str, list[str]] = {}
    for key in (*own, *other):
        shows.setdefault(_what_shows(key), []).append(key)
    told = "; ".join(f"{' and '.join(keys)} would show in {what}" for what, keys in shows.items())
    pair = f"{_called(' + '.join(first))} from {_called(' + '.join(second))}"
    return f"No throttle experiment tells {pair}: {told}."


def _what_shows(key: str) -> str:
    effect = LIBRARY[key.split(":")[0]]
    if effect.block == "sensor":
        return next((what for start, what in _SENSORS.items() if effect.id.startswith(start)), _SETTLES["sensor"])
    return _SETTLES[effect.block]


def _called(name: str) -> str:
    return "re-tuned parameters" if name in ("none", "") else name
