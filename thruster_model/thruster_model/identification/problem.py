"""The least-squares problem of one model and several experiments: free parameters, clock shifts, weighted residuals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.identification.experiment import SIGNALS, Experiment
from thruster_model.identification.prediction import Shifts, predict
from thruster_model.models import Model
from thruster_model.parameter_set import ParameterSet

__all__ = ["Problem", "Row", "problem_of"]

Array = NDArray[np.float64]
_DIVERGED = 1e6


@dataclass(frozen=True, kw_only=True)
class Row:
    """Where a residual belongs: experiment index, signal and index of the cell within its measurement."""

    experiment: int
    signal: str
    cells: NDArray[np.int64]


class ShiftSlot(NamedTuple):
    """One shift: its experiment, whether it is a "throttle" or other "clock" [s] or an "offset", signal, deviation."""

    experiment: int
    kind: str
    signal: str
    deviation: float


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Residuals as a function of a vector of unknowns of order one.

    The unknowns are the free parameters over their prior standard deviations, then one shift per experiment with an
    uncertain throttle clock, one per measurement with an uncertain clock, one per measurement with an uncertain
    rest value, all over their standard deviations. All unknowns have a prior of standard deviation one, whose
    residuals come last: it is wide, and decides only what the data leave open.

    Attributes:
        model: whose parameters are fitted.
        experiments: what was recorded.
        free: names of the free parameters.
        fixed: values of all parameters; those of the free ones are the start.
        centre: values of the free parameters at which their prior is centred.
        prior_width: standard deviation of that prior, as a multiple of the larger of |centre| and the usual size.
        noise: of each signal's cell means, in the signal's unit.
        excess: how much larger than their noise the residuals of each signal are (1 where not given: the model is
            perfect). Real benches differ from any model by several times the noise; each signal then counts by what
            can be achieved in it, as in maximum likelihood with unknown variances.
        memory: over how many cells residuals are correlated (1: white).
        signals: the signals that count.
        effects: switched on in every prediction, not fitted.
        steady_after: where given, only cells whose throttle has been constant for that long [s] count.
    """

    model: Model
    experiments: Sequence[Experiment]
    free: tuple[str, ...]
    fixed: Mapping[str, float]
    centre: Mapping[str, float]
    noise: Mapping[str, float]
    excess: Mapping[str, float] = field(default_factory=dict)
    memory: float = 1.0
    signals: tuple[str, ...] = tuple(SIGNALS)
    steady_after: float | None = None
    prior_width: float = 1.0
    effects: ActiveEffects = NOTHING

    @cached_property
    def scales(self) -> Array:
        """Prior standard deviations of the free parameters, in their units, shape (P,)."""
        sizes = [max(self.model.definition(name).scale, abs(self.centre[name])) for name in self.free]
        return self.prior_width * np.array(sizes)

    @cached_property
    def shift_slots(self) -> list[ShiftSlot]:
        """What each shift is, shape (S,)."""
        slots = []
        for index, experiment in enumerate(self.experiments):
            if experiment.throttle_shift_std > 0:
                slots.append(ShiftSlot(index, "throttle", "", experiment.throttle_shift_std))
            for name, measurement in experiment.measurements.items():
                if measurement.shift_std > 0 and name in self.signals:
                    slots.append(ShiftSlot(index, "clock", name, measurement.shift_std))
                if measurement.offset_std > 0 and name in self.signals:
                    slots.append(ShiftSlot(index, "offset", name, measurement.offset_std))
        return slots

    @property
    def start(self) -> Array:
        """Unknowns at the start values, shape (P + S,)."""
        values = np.array([self.fixed[name] for name in self.free]) / self.scales
        return np.concatenate((values, np.zeros(len(self.shift_slots))))

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Bounds of the unknowns, each of shape (P + S,)."""
        definitions = [self.model.definition(name) for name in self.free]
        far = np.full(len(self.shift_slots), 5.0)
        lower = np.concatenate((np.array([d.lower for d in definitions]) / self.scales, -far))
        upper = np.concatenate((np.array([d.upper for d in definitions]) / self.scales, far))
        return lower, upper

    def sigma(self, signal: str) -> float:
        """Weight of a signal's residuals as a standard deviation: correlated cells share one cell's information."""
        return self.noise[signal] * self.excess.get(signal, 1.0) * float(np.sqrt(self.memory))

    def values(self, unknowns: Array) -> dict[str, float]:
        """Return all parameter values, SI units."""
        fitted = unknowns[: len(self.free)] * self.scales
        return {**self.fixed, **{name: float(v) for name, v in zip(self.free, fitted, strict=True)}}

    def shifts(self, unknowns: Array) -> list[Shifts]:
        """Return the shifts of each experiment."""
        result = [Shifts() for _ in self.experiments]
        for slot, value in zip(self.shift_slots, unknowns[len(self.free) :], strict=True):
            found, size = result[slot.experiment], float(value) * slot.deviation
            if slot.kind == "throttle":
                found = replace(found, throttle=size)
            elif slot.kind == "clock":
                found = replace(found, signals={**found.signals, slot.signal: size})
            else:
                found = replace(found, offsets={**found.offsets, slot.signal: size})
            result[slot.experiment] = found
        return result

    @cached_property
    def rows(self) -> list[Row]:
        """To which cells the residuals belong, in their order; the prior's residuals follow."""
        return [
            Row(experiment=index, signal=name, cells=np.flatnonzero(self._counts(experiment, name)))
            for index, experiment in enumerate(self.experiments)
            for name in experiment.measurements
            if name in self.signals
        ]

    def _counts(self, experiment: Experiment, name: str) -> NDArray[np.bool_]:
        measurement = experiment.measurements[name]
        counts = measurement.usable
        if self.steady_after is not None:
            changes = np.flatnonzero(np.diff(experiment.throttle) != 0.0)
            times = np.concatenate(([0.0], (changes + 1) * experiment.dt))
            latest = times[np.searchsorted(times, measurement.time, side="right") - 1]
            counts = counts & (measurement.time - latest > self.steady_after)
        return counts

    def residuals(self, unknowns: Array) -> Array:
        """Return weighted residuals, measured less predicted, then the prior's, shape (R + P + S,)."""
        pieces = [self._experiment_residuals(index, unknowns) for index in range(len(self.experiments))]
        centre = np.array([self.centre[name] for name in self.free]) / self.scales
        prior = unknowns - np.concatenate((centre, np.zeros(len(self.shift_slots))))
        return np.concatenate([*pieces, prior])

    def _experiment_residuals(self, index: int, unknowns: Array) -> Array:
        coefficients = self.model.coefficients(self.values(unknowns))
        experiment = self.experiments[index]
        predicted = predict(experiment, coefficients, self.shifts(unknowns)[index], self.effects)
        pieces = [
            (experiment.measurements[row.signal].values[row.cells] - predicted[row.signal][row.cells])
            / self.sigma(row.signal)
            for row in self.rows
            if row.experiment == index
        ]
        stacked = np.concatenate(pieces) if pieces else np.empty(0)
        return np.where(np.isfinite(stacked), stacked, _DIVERGED)

    def jacobian(self, unknowns: Array, step: float = 1e-5) -> Array:
        """Return finite differences of the residuals, shape (R + P + S, P + S); forward ones, inside the bounds."""
        sizes = [sum(row.cells.size for row in self.rows if row.experiment == i) for i in range(len(self.experiments))]
        first = np.concatenate(([0], np.cumsum(sizes)))
        jacobian = np.zeros((first[-1] + unknowns.size, unknowns.size))
        jacobian[first[-1] :] = np.eye(unknowns.size)
        here = [self._experiment_residuals(i, unknowns) for i in range(len(sizes))]
        _, upper = self.bounds
        for k in range(unknowns.size):
            size = step * max(1.0, abs(unknowns[k]))
            moved = unknowns.copy()
            moved[k] += size if unknowns[k] + size <= upper[k] else -size
            touched = range(len(sizes)) if k < len(self.free) else [self.shift_slots[k - len(self.free)].experiment]
            for i in touched:
                difference = self._experiment_residuals(i, moved) - here[i]
                jacobian[first[i] : first[i + 1], k] = difference / (moved[k] - unknowns[k])
        return jacobian


def problem_of(
    parameter_set: ParameterSet,
    experiments: Sequence[Experiment],
    noise: Mapping[str, float],
    prior_width: float = 1.0,
) -> Problem:
    """Return the problem that a parameter set poses on experiments, with all of its parameters fixed."""
    return Problem(
        model=parameter_set.model,
        experiments=tuple(experiments),
        free=(),
        fixed=parameter_set.values,
        centre=parameter_set.values,
        noise=noise,
        signals=tuple(name for name in parameter_set.model.signals if name in noise),
        prior_width=prior_width,
        effects=parameter_set.effects,
    )
