"""Names, axes and colours that all parts of the report share."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from textwrap import wrap
from typing import Any

from gap_diagnosis.problem import Problem
from run_bag.report import Axis, Plot
from system_identification.suspects import key_of as suspect_key
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import CHANNELS, SIGNALS

__all__ = [
    "AS_STATED",
    "BLOCKS",
    "COLOURS",
    "KINDS",
    "NOISE",
    "RETUNED",
    "WITH_EFFECT",
    "axis_of",
    "key_of",
    "number",
    "percent",
    "probability",
    "roomy",
    "sentence",
    "signal_of",
    "signals_of",
    "title_of",
    "titles_of",
    "unit",
]

AS_STATED, RETUNED, WITH_EFFECT = "as stated", "re-tuned", "with effect"
KINDS = {"as_is": AS_STATED, "retuned": RETUNED, "with_effect": WITH_EFFECT}
"""Names of the predictions by their keys in a diagnosis, in the order of the reader."""
COLOURS = {AS_STATED: 1, RETUNED: 0, WITH_EFFECT: 2}
NOISE = "noise floor"
BLOCKS = {
    "log": "log: stamps and samples",
    "command": "command: throttle to drive",
    "rotor": "rotor: drive to rotor speed",
    "thrust": "thrust: rotor speed to thrust and torque",
    "flow": "flow: thrust to flow velocities",
    "sensor": "sensor: quantity to reading",
}
"""What lies in a block of the simulator."""


def axis_of(signal: str) -> Axis:
    """Return the axis of a signal."""
    found = SIGNALS[signal]
    return Axis(name=found.title, unit=found.unit, symbol=found.symbol)


def signal_of(channel: str) -> str:
    """Return the signal of a channel such as thruster_0/state.n; the channel itself where it is no signal's."""
    return next((s for s, field in CHANNELS.items() if channel.endswith(f"/{field}")), channel)


def signals_of(problem: Problem) -> list[str]:
    """Return the signals that count, in the order of the plant."""
    there = {each.signal for each in problem.series}
    return [signal for signal in SIGNALS if signal in there]


def key_of(effect: Mapping[str, Any]) -> str:
    """Return the key of a suspect among the effects of diagnosis.json."""
    return suspect_key(str(effect["id"]), effect["channel"] or "")


def title_of(key: str) -> str:
    """Return a suspect's key in words: "dry friction of the rotor", "late stamps of one channel (speed)"."""
    effect, _, channel = key.partition(":")
    if effect not in LIBRARY:
        return key
    return f"{LIBRARY[effect].title} ({channel})" if channel else LIBRARY[effect].title


def titles_of(keys: Sequence[str]) -> str:
    """Return several suspects in words."""
    return " + ".join(title_of(key) for key in keys)


def number(value: float | None, digits: int = 4) -> str | None:
    """Return a number of a table in which each row has its own unit."""
    if value is None:
        return None
    text = f"{value:#.{digits}g}" if 1e-4 <= abs(value) < 1e6 else f"{value:.{digits}g}"
    return text.rstrip(".").replace("-", "−")


def unit(text: str) -> str:
    """Return a unit with raised powers."""
    return text.replace("^2", "²").replace("^3", "³")


def probability(value: float) -> str:
    """Return a probability as text; what is small is not zero."""
    return "< 0.001" if value < 0.001 else f"{value:.3f}"


def percent(value: float | None) -> str | None:
    """Return a share as text."""
    return None if value is None else f"{100.0 * value:.0f} %".replace("-", "−")


def sentence(text: str) -> str:
    """Return a text with a capital letter at its beginning."""
    return text[:1].upper() + text[1:]


def roomy(plot: Plot, labels: Sequence[str]) -> Plot:
    """Return bars with room for labels of several lines, as the builder breaks them."""
    lines = max(len(wrap(label, 20)) for label in labels)
    return replace(plot, height=max(plot.height, len(labels) * (17 * lines + 8) + 62))
