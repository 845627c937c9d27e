"""What a parameter set predicts for an experiment: simulated and averaged over the measured cells.

The stepper runs on the experiment's throttle; sensors read it once a step, and effects of the log are undone in the
instants at which the readings are looked up, so that they are those of the recording's own stamps.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.compilation import compiled
from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.effects.chains import SENSED
from thruster_model.identification.experiment import PARTS, Experiment
from thruster_model.stepper import AT_REST, NO_GATES, NOMINAL_SUPPLY, PlantState, substeps_of
from thruster_model.whole_run import readings, simulated_rows

__all__ = ["NO_SHIFTS", "Happened", "Shifts", "happened", "predict", "relative_supply", "seen", "taken"]

Array = NDArray[np.float64]
LARGEST_STEP = 3.5e-3
"""Of what is read between the steps [s]: speed bends within longer ones by more than its noise."""


@dataclass(frozen=True, kw_only=True)
class Shifts:
    """What is uncertain about one recording beside the thruster.

    Attributes:
        throttle: by how much the throttle's clock is late [s], so that everything happens later.
        signals: by how much the clocks of signals are late [s], in the middle of their stamps.
        rates: by how much they gain [s/s].
        offsets: by how much rest values were misjudged, in the signals' units; an unsigned tachometer's counts with the
            sign of the speed.
    """

    throttle: float = 0.0
    signals: Mapping[str, float] = field(default_factory=dict)
    rates: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)


NO_SHIFTS = Shifts()


class Happened(NamedTuple):
    """What happened in the plant.

    Attributes:
        rows: of `stepper.ROWS`, each (finer N + 1,), `finer` times for every `dt` of the experiment.
        finer: 1 or more.
    """

    rows: Array
    finer: int

    @property
    def throttle(self) -> Array:
        """Acting [V], every `dt`, (N + 1,)."""
        return np.asarray(self.rows[-1, :: self.finer])

    @property
    def outputs(self) -> dict[str, Array]:
        """By signal, each (N + 1,), every `dt` of the experiment."""
        return {name: values[:: self.finer] for name, values in zip(SENSED, self.rows, strict=False)}


def happened(
    experiment: Experiment,
    coefficients: Any,
    effects: ActiveEffects = NOTHING,
    start: PlantState = AT_REST,
    gates: Array = NO_GATES,
    largest_step: float = LARGEST_STEP,
) -> Happened:
    """Return what happens in the plant under the experiment's throttle; `gates`: by period, see `stepper.advance`."""
    least = int(np.ceil(experiment.dt / largest_step - 1e-9))
    # Where an effect wants shorter steps: as few of them as will do.
    whole = [k for k in range(least, 2 * least) if experiment.parts is None or PARTS % k == 0]
    finer = min(whole, key=lambda k: k * substeps_of(experiment.dt / k, largest_step, effects.plant))
    step = experiment.dt / finer
    rows = simulated_rows(
        coefficients,
        experiment.commands(finer),
        step,
        start=start,
        largest_step=step,
        effects=effects.plant,
        gates=np.repeat(gates, finer),
        supply=np.repeat(relative_supply(experiment, coefficients), finer),
        straight=experiment.straight,
    )
    return Happened(rows, finer)


def relative_supply(experiment: Experiment, coefficients: Any) -> Array:
    """Return the measured supply over the nominal one, for classes that know their nominal one; none otherwise."""
    nominal = getattr(coefficients, "nominal_supply", None)
    return NOMINAL_SUPPLY if experiment.supply is None or nominal is None else experiment.supply / nominal


def predict(
    experiment: Experiment,
    coefficients: Any,
    shifts: Shifts = NO_SHIFTS,
    effects: ActiveEffects = NOTHING,
    known: Happened | None = None,
    seed: int = 0,
) -> dict[str, Array]:
    """Return the predicted cell means of every measured signal, each of the shape of its measurement.

    Args:
        experiment: throttle and stamps.
        coefficients: of any class.
        shifts: of clocks and rest values. The plant does not depend on time, so a later throttle is the same as later
            outputs.
        effects: unmodelled ones.
        known: what happened in the plant; None: it is simulated from rest.
        seed: of effects that scatter; 0: they are in no prediction.
    """
    there = happened(experiment, coefficients, effects) if known is None else known
    step = experiment.dt / there.finer
    read = dict(zip(SENSED, readings(there.rows, step, effects.sensors, seed), strict=True))
    predictions = {}
    for name, measurement in experiment.measurements.items():
        at = taken(name, measurement.time, shifts, effects)
        predictions[name] = seen(read[name], step, at, measurement.width, measurement.readings)
        offset = shifts.offsets.get(name, 0.0)
        if offset:
            # By the predicted sign: that of a measured speed near zero is its noise's.
            predictions[name] += offset * (np.clip(predictions[name], -1.0, 1.0) if name == "speed" else 1.0)
    return predictions


def taken(signal: str, stamps: Array, shifts: Shifts, effects: ActiveEffects) -> Array:
    """Return when on the clock of the recorded throttle the samples of a signal with these stamps [s] were taken."""
    at = effects.stamped("throttle", effects.taken(signal, stamps))
    late = shifts.throttle + shifts.signals.get(signal, 0.0)
    if signal in shifts.rates:
        late = late + shifts.rates[signal] * (stamps - 0.5 * (stamps[0] + stamps[-1]))
    return np.asarray(at - late)


def seen(output: Array, dt: float, time: Array, width: float, readings: int = 0) -> Array:
    """Return means over cells of `width` [s] around `time` [s] of `output`, piecewise linear with knots every `dt` [s].

    A width of zero is the value at that instant. Before the first and after the last knot the output is held.
    `readings`: how many samples, evenly apart, make a cell's mean; 0: so many that it is that of the whole cell. The
    mean of a few is another one where the output bends.
    """
    if width == 0.0:
        return np.asarray(_at_instants(output, dt, time))
    if readings:
        offsets = width * ((np.arange(readings) + 0.5) / readings - 0.5)
        return np.asarray(np.mean([_at_instants(output, dt, time + offset) for offset in offsets], axis=0))
    return np.asarray(_cell_means(output, dt, time - 0.5 * width, width))


@compiled
def _at_instants(output, dt, time):  # type: ignore[no-untyped-def]
    """Return the piecewise-linear `output` at instants; outside, its end values."""
    last = output.size - 1
    values = np.empty(time.size)
    for i in range(time.size):
        place = min(max(time[i] / dt, 0.0), float(last))
        k = min(int(place), last - 1) if last > 0 else 0
        values[i] = output[k] + (place - k) * (output[min(k + 1, last)] - output[k])
    return values


@compiled
def _cell_means(output, dt, first_edges, width):  # type: ignore[no-untyped-def]
    """Return means of the piecewise-linear `output` over cells; outside, it holds its end values."""
    integral = np.empty(output.size)
    integral[0] = 0.0
    for k in range(1, output.size):
        integral[k] = integral[k - 1] + 0.5 * dt * (output[k - 1] + output[k])
    means = np.empty(first_edges.size)
    for k in range(first_edges.size):
        first = _integral_to(output, integral, dt, first_edges[k])
        means[k] = (_integral_to(output, integral, dt, first_edges[k] + width) - first) / width
    return means


@compiled
def _integral_to(output, integral, dt, time):  # type: ignore[no-untyped-def]
    end = dt * (output.size - 1)
    if time <= 0.0:
        return time * output[0]
    if time >= end:
        return integral[-1] + (time - end) * output[-1]
    k = min(int(time / dt), output.size - 2)
    rest = time - k * dt
    return integral[k] + rest * (output[k] + 0.5 * rest * (output[k + 1] - output[k]) / dt)
