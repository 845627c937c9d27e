"""One recording prepared for fitting: the throttle on the simulation's grid and measured cell means."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

__all__ = ["CHANNELS", "PARTS", "SIGNALS", "Experiment", "Measurement", "Signal"]

PARTS = 60
"""Of a period, in which commands may change: a sixth of a millisecond where it is 10 ms. Three, four or five shorter
periods have whole numbers of them."""


@dataclass(frozen=True, kw_only=True)
class Signal:
    """A quantity that models predict and benches measure."""

    name: str
    symbol: str
    title: str
    unit: str


SIGNALS: dict[str, Signal] = {
    s.name: s
    for s in (
        Signal(name="speed", symbol="n", title="Rotor speed", unit="rad/s"),
        Signal(name="axial", symbol="v", title="Axial flow", unit="m/s"),
        Signal(name="ambient", symbol="U", title="Ambient flow", unit="m/s"),
        Signal(name="thrust", symbol="T", title="Thrust", unit="N"),
        Signal(name="torque", symbol="Q", title="Torque", unit="N m"),
    )
}
CHANNELS = {
    "speed": "state.n",
    "axial": "flow.axial",
    "ambient": "flow.ambient",
    "thrust": "load.wrench.force.x",
    "torque": "load.wrench.torque.x",
}
"""Fields of a thruster's topics by signal."""


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """Means of one signal over cells of one width, NaN where masked.

    Attributes:
        time: centres of the cells [s], shape (M,), ascending, on the experiment's clock.
        values: cell means in the signal's unit, shape (M,), NaN = masked or not measured.
        width: width of the cells [s].
        readings: how many samples, evenly apart, a cell's mean is that of; 0: many.
        noise: standard deviation of a cell mean, from the data alone (see `preparation.noise_level`).
        offset_std: how far the rest value that was taken off may be off, in the signal's unit.
        shift_std: how far the clock of this signal may be off [s]; 0 where it shares the throttle's clock.
        notes: what was done to the data, one sentence each.
    """

    signal: str
    time: NDArray[np.float64]
    values: NDArray[np.float64]
    width: float
    noise: float
    readings: int = 0
    shift_std: float = 0.0
    offset_std: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def usable(self) -> NDArray[np.bool_]:
        """Where there is a value, shape (M,)."""
        return np.isfinite(self.values)


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """A recording as the fit sees it.

    Attributes:
        name: of the run.
        dt: period of the throttle samples and of the simulation [s].
        throttle: commanded throttle [V], shape (N,); the plant rests at its first sample.
        straight: it goes on straight lines and is there as each period ends; otherwise each is held for its period.
        parts: the same in `PARTS` equal parts of each period, shape (N, PARTS), where it changes within them and
            `throttle` is the mean; None: it does not.
        measurements: by signal name.
        supply: voltage of the supply at the throttle's instants [V], shape (N,); None: not measured.
        throttle_shift_std: how far the throttle's clock may be off [s]; 0 where the throttle was recorded.
        notes: what was done to the data, one sentence each.
        warnings: what the reader of the recording had to leave out or could not trust, one sentence each.
    """

    name: str
    dt: float
    throttle: NDArray[np.float64]
    measurements: Mapping[str, Measurement]
    throttle_shift_std: float = 0.0
    notes: tuple[str, ...] = field(default=())
    warnings: tuple[str, ...] = ()
    supply: NDArray[np.float64] | None = None
    parts: NDArray[np.float64] | None = None
    straight: bool = False

    def __post_init__(self) -> None:
        unknown = set(self.measurements) - set(SIGNALS)
        if unknown or not self.dt > 0 or self.throttle.ndim != 1:
            raise ValueError(f"{self.name}: unknown signals {unknown}, dt {self.dt}, throttle {self.throttle.shape}")
        object.__setattr__(self, "measurements", MappingProxyType(dict(self.measurements)))

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.dt * self.throttle.size

    def commands(self, finer: int) -> NDArray[np.float64]:
        """Return the throttle [V] in periods `finer` times as short, shape (N finer,) or (N finer, parts of it)."""
        if self.straight:
            before = np.concatenate((self.throttle[:1], self.throttle[:-1]))
            return np.linspace(before, self.throttle, finer + 1)[1:].T.ravel()
        if self.parts is None:
            return np.repeat(self.throttle, finer)
        return self.parts.reshape(self.throttle.size * finer, -1)

    def between(self, first: int, last: int) -> "Experiment":
        """Return the periods from `first` to before `last`; measurements stay as they are."""
        kept = slice(first, last)
        supply, parts = (None if each is None else each[kept] for each in (self.supply, self.parts))
        return replace(self, throttle=self.throttle[kept], supply=supply, parts=parts)

    def scaled(self, factor: float) -> "Experiment":
        """Return it with commands of `factor` times the size."""
        parts = None if self.parts is None else factor * self.parts
        return replace(self, throttle=factor * self.throttle, parts=parts)
