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

from gap_diagnosis import sensitivities
from gap_diagnosis.linear import PUSHED, linear_run
from gap_diagnosis.prediction import (
    LARGEST_STEP,
    LOG_CHANNELS,
    NO_GATES,
    Happened,
    Situation,
    Sizes,
    acts_in_plant,
    predict,
    simulated,
)
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import RULES
from system_identification.suspects import Suspect
from system_identification.system import Linear, Series, SizeSlot
from thruster_model.effects.effect import WITH
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.prediction import Shifts
from thruster_model.parameter_set import ParameterSet

__all__ = ["CONVENTION", "DEFAULT_DEVIATION", "FARTHEST", "Problem", "Slot", "deviations_of"]

Array = NDArray[np.float64]
DEFAULT_DEVIATION = 0.05
"""Relative standard deviation of a parameter where its set states none."""
CONVENTION = 1.5e-3
"""Standard deviation [s] of what simulators and loggers disagree about within a step: whether a command holds from its
stamp on or from the step after it, whether a reading belongs to the step's start or to its end."""
QUARTZ = 5e-5
"""Standard deviation [s/s] of a clock's rate in a run: two quartzes part by 2 ms in 40 s."""
FARTHEST = 16.0
"""Deviations within which nuisances are held."""
_LATEST, _LATEST_OF_RUN = RULES.conventional / CONVENTION, 8.0
"""The same of conventions, of all recordings and of one by itself: beyond it a time is no matter of conventions, but a
delay. Within 16 they took 48 ms of a delay, all recordings alike, and left nothing to be told."""
_DIVERGED = 1e6


class Slot(NamedTuple):
    """One nuisance: kind "start", "clock", "rate", "offset" (of one recording) or "convention" (of one or, `recording`
    None, of all), of what, and its standard deviation.
    """

    recording: int | None
    kind: str
    of: str
    deviation: float


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
        clocks = dict.fromkeys(clock for each in self.clocks for clock in each)
        slots = [Slot(None, "convention", of, CONVENTION) for of in ("throttle", *clocks)]
        for index, recording in enumerate(self.recordings):
            if len(self.recordings) > 1:
                slots += [Slot(index, "convention", of, CONVENTION) for of in ("throttle", *self.clocks[index])]
            slots += [Slot(index, "rate", of, QUARTZ) for of in self.clocks[index]]
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

    @cached_property
    def conventions(self) -> NDArray[np.bool_]:
        """Which nuisances are conventions that differ from run to run, shape (nuisances,)."""
        return self._conventional & self.local[: self.nuisances]

    @cached_property
    def shared_conventions(self) -> NDArray[np.bool_]:
        """Which nuisances are conventions of all recordings, shape (nuisances,)."""
        return self._conventional & ~self.local[: self.nuisances]

    @property
    def _conventional(self) -> NDArray[np.bool_]:
        return np.array([*[False] * len(self.names), *(slot.kind == "convention" for slot in self.situations)])

    @cached_property
    def _farthest(self) -> Array:
        """Deviations within which each nuisance is held, shape (nuisances,)."""
        latest = [_LATEST if slot.recording is None else _LATEST_OF_RUN for slot in self.situations]
        return np.where(self._conventional, [*[FARTHEST] * len(self.names), *latest], FARTHEST)

    @property
    def nuisances(self) -> int:
        """How many unknowns have a prior."""
        return len(self.names) + len(self.situations)

    @property
    def local(self) -> NDArray[np.bool_]:
        """Which unknowns are particular to a single recording, shape (K,)."""
        own = [slot.recording is not None for slot in self.situations]
        return np.array([*[False] * len(self.names), *own, *[False] * len(self.slots)])

    def signals(self, index: int) -> list[str]:
        """Return the signals of a recording that the model predicts."""
        predicted = self.parameter_set.model.signals
        return [name for name in self.recordings[index].experiment.measurements if name in predicted]

    @cached_property
    def clocks(self) -> list[dict[str, list[str]]]:
        """The signals of each recording by what stamps them: their topic, where they are read together, else each by
        itself."""
        found: list[dict[str, list[str]]] = []
        for index, recording in enumerate(self.recordings):
            own: dict[str, list[str]] = {}
            read = recording.experiment.measurements
            for name in self.signals(index):
                first = own.get(LOG_CHANNELS[name], [name])[0]
                together = np.array_equal(read[name].time, read[first].time)
                own.setdefault(LOG_CHANNELS[name] if together else name, []).append(name)
            found.append(own)
        return found

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

    @property
    def parameters(self) -> int:
        """How many of the unknowns are parameters."""
        return len(self.names)

    @property
    def signal_names(self) -> tuple[str, ...]:
        """Of all signals."""
        return tuple(self.signal_rows)

    @cached_property
    def levels(self) -> dict[str, float]:
        """Standard deviation of each signal's noise by its samples alone: the median over the recordings."""
        found: dict[str, list[float]] = {}
        for each in self.series:
            measurement = self.recordings[each.recording].experiment.measurements[each.signal]
            found.setdefault(each.signal, []).append(measurement.noise)
        return {name: float(np.median(levels)) for name, levels in found.items()}

    @cached_property
    def single(self) -> dict[str, float]:
        """Standard deviation of the noise of a single reading, where a sample is the mean of several."""
        averaged: dict[str, float] = {}
        for each in self.series:
            recording = self.recordings[each.recording]
            width = recording.experiment.measurements[each.signal].width
            period = recording.log.period.get(each.signal, width) or width
            averaged[each.signal] = max(averaged.get(each.signal, 1.0), width / period if period else 1.0)
        return {name: level * float(np.sqrt(averaged[name])) for name, level in self.levels.items()}

    @property
    def pushed(self) -> tuple[str, ...]:
        """Signals that read the states which disturbances push."""
        return tuple(PUSHED.values())

    @property
    def spread(self) -> Array:
        """How many times noisier than its signal each row is, shape (R,)."""
        return np.ones(self.known.size) if self.scales is None else 1.0 / self.scales

    def movable(self) -> NDArray[np.bool_]:
        """Return which unknowns a slope can improve, shape (K,)."""
        return sensitivities.movable(self)

    def sensitivities(self, x: Array, columns: Sequence[int] | None = None) -> Array:
        """Return d predicted / d unknowns, shape (R, K) or those of `columns` alone; NaN where nothing counts."""
        return sensitivities.sensitivities_of(self, x, columns)

    def linear(self, x: Array, apart: Sequence[Array] | None = None) -> list[Linear]:
        """Return each recording, linearised along what is simulated for x, or states (N, 3) apart from that."""
        return [
            linear_run(self, x, index, happened, None if apart is None else apart[index])
            for index, happened in enumerate(self.happened(x))
        ]

    @cached_property
    def times(self) -> Array:
        """Of all samples, on the clocks of their recordings [s], shape (R,)."""
        return np.concatenate(
            [self.recordings[s.recording].experiment.measurements[s.signal].time for s in self.series]
        )

    @property
    def jumps(self) -> bool:
        """Tell whether readings jump where a state passes a threshold."""
        told = any(np.any(each == WITH) for each in self.gates)
        return any(
            LIBRARY[slot.effect].jumps and not (told and LIBRARY[slot.effect].search == "turns") for slot in self.slots
        )

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
        start, throttle = self.recordings[index].start, 0.0
        late: dict[str, float] = {}
        gained: dict[str, float] = {}
        offsets: dict[str, float] = {}
        for slot, unit in zip(self.situations, x[len(self.names) : self.nuisances], strict=True):
            if slot.recording not in (None, index):
                continue
            size = float(unit) * slot.deviation
            if slot.kind == "start":
                start = start._replace(**{slot.of: getattr(start, slot.of) + size})
            elif slot.kind == "offset":
                offsets[slot.of] = size
            elif slot.of == "throttle":
                throttle += size
            else:
                moved = gained if slot.kind == "rate" else late
                for name in self._stamped(slot, index):
                    moved[name] = moved.get(name, 0.0) + size
        shifts = Shifts(throttle=throttle, signals=late, rates=gained, offsets=offsets)
        gates = self.gates[index] if self.gates else NO_GATES
        return Situation(start=start, shifts=shifts, gates=gates)

    def _stamped(self, slot: Slot, index: int) -> list[str]:
        """Return the signals of a recording whose stamps are late by a slot."""
        return [slot.of] if slot.kind == "clock" else self.clocks[index].get(slot.of, [])

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
        largest_step: float = LARGEST_STEP,
    ) -> Array:
        """Return predictions of all rows, shape (R,).

        Args:
            x: unknowns.
            only: the recording that is wanted; rows of others are 0.
            happened: in the plant, where that is known already.
            without: an effect of a sensor that is passed over.
            largest_step: of what is simulated [s].
        """
        coefficients = self.parameter_set.model.coefficients(self.values(x))
        sizes = {effect: own for effect, own in self.sizes(x).items() if effect != without}
        out = np.zeros(self.series[-1].last)
        with np.errstate(over="ignore", invalid="ignore"):
            for index, recording in enumerate(self.recordings):
                if only is not None and index != only:
                    continue
                known = None if happened is None else happened[index]
                found = predict(recording, coefficients, sizes, self.situation(x, index), known, largest_step)
                for each in self.series:
                    if each.recording == index:
                        out[each.rows] = found[each.signal]
        return np.where(np.isfinite(out), np.clip(out, -_DIVERGED, _DIVERGED), _DIVERGED)

    def residuals(self, x: Array) -> Array:
        """Return measured less predicted, NaN where nothing counts, shape (R,)."""
        return self.measured - self.predicted(x)

    def bounded(self, x: Array) -> Array:
        """Return unknowns with sizes inside their ranges and nuisances within `FARTHEST` deviations."""
        bounded = np.asarray(x).copy()
        bounded[: self.nuisances] = np.clip(x[: self.nuisances], -self._farthest, self._farthest)
        for k, slot in enumerate(self.slots):
            bounded[self.nuisances + k] = np.clip(
                x[self.nuisances + k], slot.lower / slot.width, slot.upper / slot.width
            )
        return bounded

    def with_effects(self, slots: tuple[SizeSlot, ...], gates: tuple[Array, ...] = ()) -> "Problem":
        """Return the same problem with unknown sizes of other effects; gates are kept where one of them needs any."""
        needed = any(LIBRARY[slot.effect].search in ("gates", "turns") for slot in slots)
        return replace(self, slots=slots, gates=(gates or self.gates) if needed else ())

    def tried(self, x: Array, suspect: Suspect) -> Array:
        """Return the predictions (G, R) with a suspect at each size of its grid beside these effects."""
        posed = self.with_effects((*self.slots, *suspect.slots), tuple(suspect.gates))
        known = None if acts_in_plant(suspect.effect) else self.happened(x)
        return np.array([posed.predicted(np.concatenate((x, sizes)), happened=known) for sizes in suspect.grid])
