"""What a parameter set predicts for an experiment: simulated from rest and averaged over the measured cells."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from thruster_model.compilation import compiled
from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.flow_tank import NOMINAL_SUPPLY, simulate
from thruster_model.identification.experiment import SIGNALS, Experiment

__all__ = ["NO_SHIFTS", "Shifts", "predict", "relative_supply", "seen"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Shifts:
    """What is uncertain about one recording beside the thruster.

    Attributes:
        throttle: by how much the throttle's clock is late [s], so that everything happens later.
        signals: by how much the clocks of signals are late [s].
        offsets: by how much rest values were misjudged, in the signals' units; an unsigned tachometer's counts with the
            sign of the speed.
    """

    throttle: float = 0.0
    signals: Mapping[str, float] = field(default_factory=dict)
    offsets: Mapping[str, float] = field(default_factory=dict)


NO_SHIFTS = Shifts()


def predict(
    experiment: Experiment,
    coefficients: ThrusterCoefficients,
    shifts: Shifts = NO_SHIFTS,
    effects: ActiveEffects = NOTHING,
) -> dict[str, Array]:
    """Return the predicted cell means of every measured signal, each of the shape of its measurement.

    `effects` act on the throttle, in the plant and on the readings; those that scatter are left out.

    The plant starts at rest and does not depend on time, so a later throttle is the same as later outputs.
    """
    throttle = effects.command(experiment.throttle, experiment.dt)
    trajectory = simulate(
        coefficients,
        throttle,
        experiment.dt,
        largest_step=experiment.dt,
        effects=effects.plant,
        supply=relative_supply(experiment, coefficients),
    )
    outputs = {name: getattr(trajectory, signal.plant_output) for name, signal in SIGNALS.items()}
    predictions = {}
    for name, measurement in experiment.measurements.items():
        output = effects.reading(name, outputs, experiment.dt, None)
        late = shifts.throttle + shifts.signals.get(name, 0.0)
        at = measurement.time - late
        predictions[name] = seen(output, experiment.dt, at, measurement.width, measurement.readings)
        offset = shifts.offsets.get(name, 0.0)
        if offset:
            # By the predicted sign: that of a measured speed near zero is its noise's.
            predictions[name] += offset * (np.clip(predictions[name], -1.0, 1.0) if name == "speed" else 1.0)
    return predictions


def relative_supply(experiment: Experiment, coefficients: ThrusterCoefficients) -> Array:
    """Return the measured supply over the nominal one, for classes that know their nominal one; none otherwise."""
    nominal = getattr(coefficients, "nominal_supply", None)
    return NOMINAL_SUPPLY if experiment.supply is None or nominal is None else experiment.supply / nominal


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
