"""Effects that are switched on: what they do to commands, to the plant and to what sensors read.

Between a command and the plant effects follow each other as in the device: the line's delay, the converter's steps,
its limits, its lag. Behind the plant each sensor has a chain: its dynamics, then scale and offset, then its converter.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.stages import LIBRARY, NO_EFFECTS, effect_values

__all__ = ["NOTHING", "ActiveEffects", "problems_of"]

Array = NDArray[np.float64]
Sizes = Mapping[str, Mapping[str, float]]


def problems_of(sizes: Sizes) -> list[str]:
    """Return what is wrong with the sizes of effects, one sentence each: unknown names, sizes beyond the range."""
    problems = []
    for name, parameters in sizes.items():
        if name not in LIBRARY:
            problems.append(f"key 'effects.{name}': expected one of {', '.join(LIBRARY)}")
            continue
        definitions = {p.name: p for p in LIBRARY[name].parameters}
        for parameter, value in parameters.items():
            if parameter not in definitions:
                found = f"found '{parameter}'"
                problems.append(f"key 'effects.{name}': expected parameters {', '.join(definitions)}; {found}")
                continue
            d = definitions[parameter]
            lowest = -d.upper if d.both_signs else d.lower
            if not (value == d.neutral or lowest <= value <= d.upper):
                expected = f"expected {d.neutral:g} or {lowest:g} to {d.upper:g} {d.unit}"
                problems.append(f"key 'effects.{name}.{parameter}': {expected}; found {value!r}")
    return problems


@dataclass(frozen=True, kw_only=True)
class ActiveEffects:
    """Effects by identifier with the sizes of their parameters; empty: none."""

    sizes: Sizes = field(default_factory=dict)

    def __post_init__(self) -> None:
        problems = problems_of(self.sizes)
        if problems:
            raise ValueError("; ".join(problems))
        frozen = {name: MappingProxyType(dict(parameters)) for name, parameters in self.sizes.items()}
        object.__setattr__(self, "sizes", MappingProxyType(frozen))

    def with_words(self, words: Iterable[str]) -> "ActiveEffects":
        """Return these effects and those of words EFFECT.PARAMETER=SIZE; ValueError says what is wrong with a word."""
        sizes = {name: dict(parameters) for name, parameters in self.sizes.items()}
        for word in words:
            effect, dot, rest = word.partition(".")
            parameter, sign, size = rest.partition("=")
            try:
                sizes.setdefault(effect, {})[parameter] = float(size)
            except ValueError:
                dot = ""
            if not (dot and sign):
                raise ValueError(f"effect {word!r}: expected EFFECT.PARAMETER=SIZE with a number as size")
        return ActiveEffects(sizes=sizes)

    def within_a_loop(self) -> "ActiveEffects":
        """Return these effects without those that no controller of speed or flow sees: of the load cell, of the log."""
        seen = {name: sizes for name, sizes in self.sizes.items() if not _beside_a_loop(LIBRARY[name])}
        return ActiveEffects(sizes=seen)

    @property
    def plant(self) -> Any:
        """For `flow_tank.simulate`: `EffectValues`, or `NO_EFFECTS` where none acts in the plant."""
        return effect_values(self.sizes) if any(LIBRARY[name].hooks for name in self.sizes) else NO_EFFECTS

    def command(self, commands: Array, dt: float) -> Array:
        """Return what reaches the plant of commands [V] held for `dt` [s] each, shape (N,)."""
        for effect in _of_block(self.sizes, "command"):
            commands = np.asarray(effect.samples(commands, dt, **_sized(effect, self.sizes)))
        return commands

    def reading(self, signal: str, outputs: Mapping[str, Array], dt: float, rng: np.random.Generator | None) -> Array:
        """Return what the sensor of a signal reads, shape (N,).

        Args:
            signal: name of the signal.
            outputs: true values of all signals every `dt` [s], each (N,).
            rng: for effects that scatter; without one they are left out.
        """
        values = outputs[signal]
        for effect in _of_block(self.sizes, "sensor"):
            if signal in effect.channel.split():
                values = np.asarray(effect.samples(values, outputs, dt, rng, **_sized(effect, self.sizes)))
        return values

    def log(self, signal: str, time: Array, values: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return (stamps [s], values) as they are written to the log, each (N,); stamps stay in order."""
        for effect in _of_block(self.sizes, "log"):
            if not effect.channel or signal in effect.channel.split():
                time, values = effect.samples(signal, time, values, rng, **_sized(effect, self.sizes))
        return time, values


def _beside_a_loop(effect: Any) -> bool:
    return effect.block == "log" or (effect.block == "sensor" and set(effect.channel.split()) <= {"thrust", "torque"})


def _of_block(sizes: Sizes, block: str) -> list[Any]:
    return sorted(
        (LIBRARY[n] for n in sizes if LIBRARY[n].samples and LIBRARY[n].block == block), key=lambda e: e.order
    )


def _sized(effect: Any, sizes: Sizes) -> dict[str, float]:
    return {p.name: float(sizes[effect.id].get(p.name, p.neutral)) for p in effect.parameters}


NOTHING = ActiveEffects()
