"""How large noise is: of sensors, of what pushes the states, and of what else scatters.

A level of a push says by how many times the noise of a single reading it moves the signal that reads what it pushes; a
colour is what a signal carries beside white noise, over that noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from system_identification.system import System

__all__ = ["LEAST", "Levels", "plain_levels"]

LEAST = 0.03
"""Level below which there is nothing."""
_NARROW, _HOW_FAR = 4.0, 0.5
"""What it costs, nats, that parameters scatter more widely than stated: one set in fifty states too little. By how much
these are wrong: the standard deviation of the logarithm."""


@dataclass(frozen=True, kw_only=True)
class Levels:
    """What the noise is made of.

    Attributes:
        sensors: standard deviation of each signal's white noise, in its unit.
        colours: of what it carries beside, over that of its white noise, by signal.
        colour_memory: of that [s], by signal.
        pushes: level of each disturbance.
        memory: of the disturbances [s].
        parameters: how many times wider than stated the parameters scatter.
        conventions: how many times wider than stated those do that differ from run to run.
    """

    sensors: Mapping[str, float]
    colours: Mapping[str, float]
    colour_memory: Mapping[str, float]
    pushes: tuple[float, ...]
    memory: float = 1.5
    parameters: float = 1.0
    conventions: float = 1.0

    @property
    def log_prior(self) -> float:
        """Logarithm of how probable it is that parameters scatter as widely."""
        far = float(np.log(self.parameters)) / _HOW_FAR
        return -_NARROW - 0.5 * far**2 if self.parameters > 1.0 else 0.0

    def towards(self, other: "Levels", share: float) -> "Levels":
        """Return levels a share of the way to others, in logarithms."""

        def between(a: float, b: float) -> float:
            return float(max(a, LEAST) ** (1.0 - share) * max(b, LEAST) ** share) if share < 1.0 else b

        def each(a: Mapping[str, float], b: Mapping[str, float]) -> dict[str, float]:
            return {name: between(a[name], b[name]) for name in a}

        return Levels(
            sensors={n: float(v ** (1.0 - share) * other.sensors[n] ** share) for n, v in self.sensors.items()},
            colours=each(self.colours, other.colours),
            colour_memory=each(self.colour_memory, other.colour_memory),
            pushes=tuple(between(a, b) for a, b in zip(self.pushes, other.pushes, strict=True)),
            memory=between(self.memory, other.memory),
            parameters=other.parameters,
            conventions=other.conventions,
        )


def plain_levels(system: System, pushes: int, level: float) -> Levels:
    """Return the samples' own white noise, and disturbances of a level."""
    names = system.signal_names
    return Levels(
        sensors=dict(system.levels),
        colours=dict.fromkeys(names, 0.0),
        colour_memory=dict.fromkeys(names, 1.0),
        pushes=(level,) * pushes,
    )
