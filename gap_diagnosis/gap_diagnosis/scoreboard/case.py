"""A case of the scoreboard: what is hidden, what was recorded, and what a generator offers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = ["KINDS", "Generator", "Push", "Samples", "Sizes", "SyntheticRun", "Truth"]

Array = NDArray[np.float64]
Sizes = Mapping[str, Mapping[str, float]]
Push = Callable[[int, Array, float], Array]
"""How rotor (0) or water (1) is pushed, as a path of deviation 1: which of them, instants [s] since a simulation began
(M,), memory [s] -> (M,)."""

KINDS = ("none", "one", "two", "many", "outside")
"""Classes of cases: no effect, one or two of the library, three to six small ones, one of no library."""


class Samples(NamedTuple):
    """Stamps [s] and values of one signal, each (N,)."""

    time: Array
    values: Array


@dataclass(frozen=True, kw_only=True)
class SyntheticRun:
    """A recording.

    Attributes:
        name: of the run.
        throttle: commands [V].
        signals: by name (speed [rad/s], ambient [m/s], thrust [N], torque [N m]).
        hold: how the command acts between its samples, "previous" or "linear"; None: the recording does not say.
    """

    name: str
    throttle: Samples
    signals: Mapping[str, Samples]
    hold: str | None = None


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What is hidden in a case.

    Attributes:
        generator, kind, index: which case.
        model: name of the parameter set that the simulator uses.
        effects: sizes of effects of the library, by identifier and parameter.
        outside: what no library has, by identifier and parameter.
        factors: true over nominal parameter, by name.
        drawn: all else that was drawn, as the generator needs it to record the case again.
    """

    generator: str
    kind: str
    index: int
    model: str
    effects: Sizes = field(default_factory=dict)
    outside: Sizes = field(default_factory=dict)
    factors: Mapping[str, float] = field(default_factory=dict)
    drawn: Any = None

    @property
    def name(self) -> str:
        """Of the case; it tells nothing about what is hidden but its class."""
        return f"{self.generator}-{self.kind}-{self.index:05d}"


@dataclass(frozen=True, kw_only=True)
class Generator:
    """One way to make cases, which shares no code with any other.

    Attributes:
        name: identifier.
        title: what it is, in a sentence.
        draw: (kind, index, whole) -> `Truth`; the same one each time; `whole`: at the length of reported cases.
        record: `Truth` -> its recordings, the same ones each time.
        clean: (truth, effects, outside, factors, push) -> all readings without noise in units of each sensor's
            noise, (runs, R): with these effects and factors in the place of the truth's; `push`: along which path the
            case's disturbance of rotor and water goes in each run, None: undisturbed.
    """

    name: str
    title: str
    draw: Callable[[str, int, bool], Truth]
    record: Callable[[Truth], Sequence[SyntheticRun]]
    clean: Callable[[Truth, Sizes, Sizes, Mapping[str, float], Push | None], Array]
