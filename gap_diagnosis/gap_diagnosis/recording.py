"""One recording as the diagnosis sees it: an experiment, how it starts, and what its log looks like by itself."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_model.flow_tank import AT_REST, PlantState
from thruster_model.identification.experiment import CHANNELS, SIGNALS, Experiment

__all__ = ["LogFindings", "Recording", "initial_state"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LogFindings:
    """What the log of one recording shows before any physics, by signal.

    Attributes:
        repeated: which samples repeat the one before them, shape (M,), by signal.
        lost: of signals whose samples are means, how many readings repeated the one before and were left out, and of
            how many.
        spikes: which samples stand out of their neighbours, shape (M,), by signal.
        lone: single samples far from all their neighbours, shape (M,), by signal.
        lattice: step of the lattice on which all values lie, in the signal's unit; 0 where there is none.
        hole: readings up to this magnitude are given as zero or noise about it, in the signal's unit; 0: there is none.
        scatter: standard deviation of the stamps about regular ones [s]; also of the "throttle".
        period: of the samples as they came [s]; also of the "throttle".
    """

    repeated: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    lost: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    spikes: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    lone: Mapping[str, NDArray[np.bool_]] = field(default_factory=dict)
    lattice: Mapping[str, float] = field(default_factory=dict)
    hole: Mapping[str, float] = field(default_factory=dict)
    scatter: Mapping[str, float] = field(default_factory=dict)
    period: Mapping[str, float] = field(default_factory=dict)

    def together(self, signal: str, width: float) -> int:
        """Return how many readings a sample is the mean of, taken over `width` [s]; one of them moves that mean."""
        return max(round(width / self.period.get(signal, np.inf)), 1)

    def of(self, signals: Collection[str]) -> "LogFindings":
        """Return what the log shows of these signals alone; about stamps nothing is left out."""

        def kept(table: Mapping[str, Any]) -> dict[str, Any]:
            return {name: found for name, found in table.items() if name in signals}

        return replace(
            self,
            repeated=kept(self.repeated),
            lost=kept(self.lost),
            spikes=kept(self.spikes),
            lone=kept(self.lone),
            lattice=kept(self.lattice),
            hole=kept(self.hole),
        )


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A recording of one thruster.

    Attributes:
        experiment: throttle and measurements; a width of 0 means samples at an instant.
        start: state at the first throttle sample.
        start_std: how uncertain that is, by field of `PlantState`; empty: the thruster rests.
        log: what the log shows.
        thruster: its index.
        regular: the same with regular stamps, where the stamps scatter.
        straight: the same with straight lines between commands, where it is not known how they act and it matters.
    """

    experiment: Experiment
    start: PlantState = AT_REST
    start_std: Mapping[str, float] = field(default_factory=dict)
    log: LogFindings = field(default_factory=LogFindings)
    thruster: int = 0
    regular: "Recording | None" = None
    straight: "Recording | None" = None

    @property
    def name(self) -> str:
        """Of the run."""
        return self.experiment.name

    @property
    def in_motion(self) -> bool:
        """Whether the rotor turns at the start."""
        return "n" in self.start_std

    def channel(self, signal: str) -> str:
        """Return the name of a signal's channel."""
        return f"thruster_{self.thruster}/{CHANNELS[signal]}"


def initial_state(
    experiment: Experiment, spikes: Mapping[str, NDArray[np.bool_]], *, idle: float = 1e-9
) -> tuple[PlantState, dict[str, float]]:
    """Return the state at the start and how uncertain it is, by field of `PlantState`.

    A thruster rests where no throttle is given for a while and its speed's first samples lie within four standard
    deviations of zero (and 3 rad/s); the water may still move, by what its meter does not see. Where commands come at
    once, it may run with the first one, or be about to after it: nothing before it tells. Without a tachometer it runs
    where it gives thrust as the first command comes.

    `spikes`: by signal the samples that tell nothing, shape (M,).
    """
    first = {
        name: _first(m.time, np.where(spikes.get(name, False), np.nan, m.values))
        for name, m in experiment.measurements.items()
    }
    moving = [
        name
        for name, (value, count) in first.items()
        if name != "torque"
        and abs(value) > 4.0 * experiment.measurements[name].noise / np.sqrt(max(count, 1)) + _TINY[name]
    ]
    noise = {name: m.noise for name, m in experiment.measurements.items()}
    given = np.flatnonzero(np.abs(experiment.throttle) > idle)
    waits = experiment.dt * float(given[0] if given.size else experiment.throttle.size)
    turns = "speed" in moving if "speed" in first else "thrust" in moving and waits < _AT_REST
    if not turns and (waits >= _AT_REST or "speed" not in first):
        # Or its meter is off zero, or there is a current: not the start's.
        water = [abs(first[name][0]) for name in ("axial", "ambient") if name in moving]
        if water:
            return AT_REST, {"v": 0.5, "ambient": max(0.1, *water)}
        return AT_REST, {"ambient": noise["ambient"]} if "ambient" in noise else {}
    u = float(experiment.throttle[0]) if experiment.throttle.size else 0.0
    ambient, axial = (first[name][0] if name in first else 0.0 for name in ("ambient", "axial"))
    if "speed" in first:
        n = first["speed"][0]
        spread = max(5.0, 5.0 * noise["speed"], 0.5 * abs(n))
    else:
        n, spread = float(np.copysign(0.5 * _ANY_SPEED, first["thrust"][0])), _ANY_SPEED
    deviations = {"n": spread, "v": 0.5, "ambient": 0.1, "u": max(0.5 * abs(u), 0.1)}
    return PlantState(n, axial, ambient, u), deviations


_AT_REST = 0.3
"""Time without a command [s] after which a rotor that does not turn rests."""
_ANY_SPEED = 100.0
"""[rad/s] Of a rotor that runs at the start while no tachometer tells: thrust says only which way it turns."""
_TINY = dict.fromkeys(SIGNALS, 1e-12) | {"speed": 3.0}


def _first(time: Array, values: Array, span: float = 0.01) -> tuple[float, int]:
    known = np.isfinite(values)
    near = values[known][time[known] <= np.min(time[known], initial=np.inf) + span]
    return (float(np.mean(near)), near.size) if near.size else (0.0, 0)
