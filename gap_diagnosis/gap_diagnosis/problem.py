"""Unknowns of a hypothesis and the whitened residuals they leave: parameters, situations, sizes of effects.

Nuisances (parameters within their stated deviations, clocks, rest values, states at the start) have a prior of
standard deviation one in the vector of unknowns; sizes of effects are uniform over their plausible range.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.noise import NoiseModel, Series, white_noise
from gap_diagnosis.prediction import JUMPING, LOG_CHANNELS, NO_GATES, Happened, Situation, Sizes, predict, simulated
from gap_diagnosis.recording import Recording
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.prediction import Shifts
from thruster_model.parameter_set import ParameterSet

__all__ = ["CONVENTION", "DEFAULT_DEVIATION", "Problem", "SizeSlot", "Slot", "deviations_of"]

Array = NDArray[np.float64]
DEFAULT_DEVIATION = 0.05
"""Relative standard deviation of a parameter where its set states none."""
CONVENTION = 1.5e-3
"""Standard deviation [s] of what simulators and loggers disagree about within a step: whether a command holds from its
stamp on or from the step after it, whether a reading belongs to the step's start or to its end."""
_DIVERGED = 1e6


class Slot(NamedTuple):
    """One nuisance: kind "start", "clock", "offset" (of one recording) or "convention" (of all, `recording` None), of
    what, and its standard deviation.
    """

    recording: int | None
    kind: str
    of: str
    deviation: float


class SizeSlot(NamedTuple):
    """One unknown size of an effect, and its plausible range."""

    effect: str
    parameter: str
    lower: float
    upper: float

    @property
    def width(self) -> float:
        """Of the range; 1 where the size has only one value."""
        return (self.upper - self.lower) or 1.0

    @property
    def unit(self) -> str:
        """Of the size."""
        return next(p.unit for p in LIBRARY[self.effect].parameters if p.name == self.parameter)


def deviations_of(parameter_set: ParameterSet) -> dict[str, float]:
    """Return the standard deviations of the parameters that may be re-tuned: stated ones, else 5 % of the value."""
    names = parameter_set.model.parameter_names
    given = set(parameter_set.model.of_role("given"))
    result = {}
    for name in names:
        parameter = parameter_set.parameters[name]
        stated = parameter.standard_deviation
        deviation = DEFAULT_DEVIATION * abs(parameter.value) if stated is None else stated
        if name not in given and deviation > 0.0:
            result[name] = deviation
    return result


@dataclass(frozen=True, kw_only=True)
class Problem:
    """Recordings, a parameter set and suspected effects.

    Attributes:
        recordings: what was recorded.
        parameter_set: of the simulator.
        deviations: standard deviations of the parameters that may be re-tuned.
        slots: unknown sizes of effects.
        fixed: effects with known sizes.
        masks: samples left out although they are there, by (recording, signal): spikes and repeated ones.
        gates: of each recording, for effects that need them.
        observed: rows in place of the recordings' own samples, shape (R,), to ask what a hypothesis makes of another's
            predictions.
        opaque: signals whose residuals have a structure of their own (a coarse converter's) and betray nothing else.
        scales: what whitened samples are worth, shape (R,), where not all are alike.
    """

    recordings: Sequence[Recording]
    parameter_set: ParameterSet
    deviations: Mapping[str, float]
    slots: tuple[SizeSlot, ...] = ()
    fixed: Sizes = field(default_factory=dict)
    masks: Mapping[tuple[int, str], NDArray[np.bool_]] = field(default_factory=dict)
    gates: tuple[Array, ...] = ()
    observed: Array | None = None
    opaque: tuple[str, ...] = ()
    scales: Array | None = None

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Of the free parameters."""
        return tuple(self.deviations)

    @cached_property
    def situations(self) -> list[Slot]:
        """Nuisances of the recordings."""
        topics = dict.fromkeys(LOG_CHANNELS[each.signal] for each in self.series)
        slots = [Slot(None, "convention", of, CONVENTION) for of in ("throttle", *topics)]
        for index, recording in enumerate(self.recordings):
            slots += [Slot(index, "start", of, std) for of, std in recording.start_std.items()]
            if recording.experiment.throttle_shift_std > 0.0:
                slots.append(Slot(index, "clock", "throttle", recording.experiment.throttle_shift_std))
            for name in self.signals(index):
                measurement = recording.experiment.measurements[name]
                if measurement.shift_std > 0.0:
                    slots.append(Slot(index, "clock", name, measurement.shift_std))
                if 0.0 < measurement.offset_std < np.inf:
                    slots.append(Slot(index, "offset", name, measurement.offset_std))
        return slots

    @property
    def nuisances(self) -> int:
        """How many unknowns have a prior."""
        return len(self.names) + len(self.situations)

    def signals(self, index: int) -> list[str]:
        """Return the signals of a recording that the model predicts."""
        predicted = self.parameter_set.model.signals
        return [name for name in self.recordings[index].experiment.measurements if name in predicted]

    @cached_property
    def series(self) -> list[Series]:
        """Where each signal's rows stand."""
        found, first = [], 0
        for index, recording in enumerate(self.recordings):
            for name in self.signals(index):
                size = recording.experiment.measurements[name].values.size
                found.append(Series(index, name, first, first + size))
                first += size
        return found

    @cached_property
    def signal_rows(self) -> dict[str, NDArray[np.int64]]:
        """Rows of each signal in all recordings together."""
        names = dict.fromkeys(each.signal for each in self.series)
        return {n: np.concatenate([np.arange(s.first, s.last) for s in self.series if s.signal == n]) for n in names}

    @cached_property
    def sample_noise(self) -> NoiseModel:
        """White noise of each signal by its samples alone: the median over the recordings."""
        levels = {
            name: float(
                np.median(
                    [
                        self.recordings[s.recording].experiment.measurements[name].noise
                        for s in self.series
                        if s.signal == name
                    ]
                )
            )
            for name in self.signal_rows
        }
        return white_noise(levels)

    @cached_property
    def times(self) -> Array:
        """Of all samples, on the clocks of their recordings [s], shape (R,)."""
        return np.concatenate(
            [self.recordings[s.recording].experiment.measurements[s.signal].time for s in self.series]
        )

    @property
    def jumps(self) -> bool:
        """Tell whether readings jump where a state passes a threshold."""
        return any(slot.effect in JUMPING for slot in self.slots)

    @cached_property
    def measured(self) -> Array:
        """All samples in their units, NaN where missing or masked, shape (R,)."""
        if self.observed is not None:
            return self.observed
        pieces = []
        for each in self.series:
            values = self.recordings[each.recording].experiment.measurements[each.signal].values
            mask = self.masks.get((each.recording, each.signal))
            pieces.append(values if mask is None else np.where(mask, np.nan, values))
        return np.concatenate(pieces)

    @cached_property
    def known(self) -> NDArray[np.bool_]:
        """Which rows count, shape (R,)."""
        return np.isfinite(self.measured)

    def start(self, sizes: Array | None = None) -> Array:
        """Return unknowns with all nuisances as stated and these sizes (over their ranges' widths)."""
        scaled = np.zeros(len(self.slots)) if sizes is None else np.asarray(sizes, dtype=np.float64)
        return np.concatenate((np.zeros(self.nuisances), scaled))

    def values(self, x: Array) -> dict[str, float]:
        """Return all parameters, SI units, held within their admissible ranges."""
        values = self.parameter_set.values
        for name, unit in zip(self.names, x, strict=False):
            definition = self.parameter_set.model.definition(name)
            moved = values[name] + float(unit) * self.deviations[name]
            values[name] = min(max(moved, definition.lower), definition.upper)
        return values

    def sizes(self, x: Array) -> dict[str, dict[str, float]]:
        """Return the sizes of all effects, fixed ones included."""
        result = {name: dict(parameters) for name, parameters in self.fixed.items()}
        for slot, unit in zip(self.slots, x[self.nuisances :], strict=True):
            size = min(max(float(unit) * slot.width, slot.lower), slot.upper)
            result.setdefault(slot.effect, {})[slot.parameter] = size
        return result

    def situation(self, x: Array, index: int) -> Situation:
        """Return what is particular to a recording."""
        start, shifts = self.recordings[index].start, Shifts()
        for slot, unit in zip(self.situations, x[len(self.names) : self.nuisances], strict=True):
            if slot.recording not in (None, index):
                continue
            size = float(unit) * slot.deviation
            if slot.kind == "start":
                start = start._replace(**{slot.of: getattr(start, slot.of) + size})
            elif slot.kind == "offset":
                shifts = replace(shifts, offsets={**shifts.offsets, slot.of: size})
            elif slot.of == "throttle":
                shifts = replace(shifts, throttle=shifts.throttle + size)
            else:
                late = {name: shifts.signals.get(name, 0.0) + size for name in self._stamped(slot, index)}
                shifts = replace(shifts, signals={**shifts.signals, **late})
        gates = self.gates[index] if self.gates else NO_GATES
        return Situation(start=start, shifts=shifts, gates=gates)

    def _stamped(self, slot: Slot, index: int) -> list[str]:
        """Return the signals of a recording whose stamps are late by a slot: one clock's, or those of a topic."""
        return [slot.of] if slot.kind == "clock" else [s for s in self.signals(index) if LOG_CHANNELS[s] == slot.of]

    def happened(self, x: Array) -> list[Happened]:
        """Return what happens in the plant in each recording."""
        coefficients, sizes = self.parameter_set.model.coefficients(self.values(x)), self.sizes(x)
        with np.errstate(over="ignore", invalid="ignore"):
            return [simulated(r, coefficients, sizes, self.situation(x, i)) for i, r in enumerate(self.recordings)]

    def predicted(
        self,
        x: Array,
        only: int | None = None,
        happened: Sequence[Happened] | None = None,
        without: str = "",
    ) -> Array:
        """Return predictions of all rows, shape (R,).

        Args:
            x: unknowns.
            only: the recording that is wanted; rows of others are 0.
            happened: in the plant, where that is known already.
            without: an effect of a sensor that is passed over.
        """
        coefficients = self.parameter_set.model.coefficients(self.values(x))
        sizes = {effect: own for effect, own in self.sizes(x).items() if effect != without}
        out = np.zeros(self.series[-1].last)
        with np.errstate(over="ignore", invalid="ignore"):
            for index, recording in enumerate(self.recordings):
                if only is not None and index != only:
                    continue
                known = None if happened is None else happened[index]
                found = predict(recording, coefficients, sizes, self.situation(x, index), known)
                for each in self.series:
                    if each.recording == index:
                        out[each.rows] = found[each.signal]
        return np.where(np.isfinite(out), np.clip(out, -_DIVERGED, _DIVERGED), _DIVERGED)

    def residuals(self, x: Array) -> Array:
        """Return measured less predicted, NaN where nothing counts, shape (R,)."""
        return self.measured - self.predicted(x)

    def bounded(self, x: Array) -> Array:
        """Return unknowns with sizes inside their ranges and nuisances within eight deviations."""
        bounded = np.clip(x, -8.0, 8.0)
        for k, slot in enumerate(self.slots):
            bounded[self.nuisances + k] = np.clip(
                x[self.nuisances + k], slot.lower / slot.width, slot.upper / slot.width
            )
        return bounded

    def with_effects(self, slots: tuple[SizeSlot, ...], gates: tuple[Array, ...] = ()) -> "Problem":
        """Return the same problem with unknown sizes of other effects."""
        return replace(self, slots=slots, gates=gates or self.gates)

    def whitened(self, noise: NoiseModel, rows: Array) -> Array:
        """Return rows (R,) or (R, K) whitened by the noise."""
        return noise.whiten(self.series, self.scaled(rows))

    def scaled(self, rows: Array) -> Array:
        """Return rows (R,) or (R, K) by what they are worth."""
        return rows if self.scales is None else (rows.T * self.scales).T
