"""Effects that are switched on: what they do to commands, to the plant and to what sensors read.

Those in time, up to what sensors read, are numbers in `EffectValues` for the stepper's kernels. Those of the log act on
what has been recorded, stamps and values, and never on the stamps by which a running graph goes.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.effect import Effect, size_problems
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
        problems += size_problems(name, LIBRARY[name].parameters, parameters)
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

    @property
    def plant(self) -> Any:
        """For `stepper.advance`: `EffectValues`, or `NO_EFFECTS` where none acts on commands or in the plant."""
        acting = any(LIBRARY[name].hooks or LIBRARY[name].block == "command" for name in self.sizes)
        return effect_values(self.sizes) if acting else NO_EFFECTS

    @property
    def sensors(self) -> Any:
        """For `stepper.sense`: `EffectValues`, or `NO_EFFECTS` where no sensor has any."""
        return effect_values(self.sizes) if self._any("sensor") else NO_EFFECTS

    def of_the_log(self) -> "ActiveEffects":
        """Return those of the log alone."""
        return ActiveEffects(sizes={name: own for name, own in self.sizes.items() if LIBRARY[name].block == "log"})

    def log(self, signal: str, time: Array, values: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Return (stamps [s], values) as they are written to the log, each (N,); stamps stay in order."""
        for effect in self._of_the_log(signal):
            assert effect.logged is not None
            time, values = effect.logged(signal, time, values, rng, **self._sized(effect))
        return time, values

    def taken(self, signal: str, stamps: Array) -> Array:
        """Return when samples with these stamps [s] were taken [s]; scatter is in no prediction."""
        for effect in reversed(self._of_the_log(signal)):
            if effect.taken is not None:
                stamps = effect.taken(signal, stamps, **self._sized(effect))
        return stamps

    def stamped(self, signal: str, time: Array) -> Array:
        """Return the stamps [s] of samples that were taken at these instants [s], but for scatter."""
        for effect in self._of_the_log(signal):
            if effect.taken is not None and effect.logged is not None:
                time, _ = effect.logged(signal, time, time, None, **self._sized(effect))
        return time

    def _any(self, block: str) -> bool:
        return any(LIBRARY[name].block == block for name in self.sizes)

    def _of_the_log(self, signal: str) -> list[Effect]:
        effects = [LIBRARY[name] for name in self.sizes if LIBRARY[name].block == "log"]
        concerned = [effect for effect in effects if not effect.channel or signal in effect.channel.split()]
        return sorted(concerned, key=lambda effect: effect.order)

    def _sized(self, effect: Effect) -> dict[str, float]:
        return {p.name: float(self.sizes[effect.id].get(p.name, p.neutral)) for p in effect.parameters}


NOTHING = ActiveEffects()
