"""A synthetic identification campaign on a thruster bench: experiments simulated and seen through its sensors.

The sensors are the rig's (`rig_sensors.RECORDER`); what is here is how this recording system reads them: the tachometer
and the load cell 1000 times a second, with their readings at rest and a drift, the velocimeter 25 times.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.rig_sensors import RECORDER, disturbances, flow_read, rung
from rov_sim.throttle_programmes import multisine, ramp_and_hold, staircase, with_rest
from thruster_model.effects.chains import SENSED
from thruster_model.effects.gates import drawn_gates
from thruster_model.parameter_set import ParameterSet
from thruster_model.whole_run import readings, simulated_rows

__all__ = ["BenchRun", "Recorded", "altered", "run_campaign", "run_programme"]

Array = NDArray[np.floating]
_STEP = 0.001  # [s] of the simulation, and between samples of tachometer and load cell
_FLOW_RATE = 25.0  # Hz
_SPEED_STEP, _SPEED_AT_REST = 49.9723 * 0.001, 49.9723 * 0.023  # rad/s: 1 mV of the converter; 23 mV at rest
_TORQUE_RESONANCE, _TORQUE_NOISE = 8.5, 0.02  # Hz, N m


@dataclass(frozen=True, kw_only=True)
class Recorded:
    """Samples of one signal: instants [s], shape (N,), and values, shape (N,)."""

    time: Array
    values: Array


@dataclass(frozen=True, kw_only=True)
class BenchRun:
    """One synthetic recording: what the bench would have recorded, by signal name.

    Signals: throttle [V], speed (signed by inference) [rad/s], thrust [N], torque [N m], axial or ambient [m/s].
    """

    name: str
    signals: Mapping[str, Recorded]


def altered(parameter_set: ParameterSet, spread: float, rng: np.random.Generator) -> ParameterSet:
    """Return the set with each parameter but the ramp limit times a log-normal factor of relative width `spread`."""
    factors = {name: float(np.exp(spread * rng.standard_normal())) for name in parameter_set.values}
    factors["u_dot_max"] = 1.0
    values = {name: value * factors[name] for name, value in parameter_set.values.items()}
    return parameter_set.with_values(values, source=f"{parameter_set.name}, altered at random by {100 * spread:.0f} %")


def run_campaign(truth: ParameterSet, rng: np.random.Generator) -> list[BenchRun]:
    """Return five recordings of a thruster with the parameters and effects of `truth`: ramps, steps, a multisine."""
    period = 0.04
    steps = [1.5, -1.5, 2.0, 1.2, -2.5, -1.2, 3.0, -3.0, 2.5]
    sines = multisine(2.8, period, duration=12.0, lowest=0.1, highest=0.8, rng=rng)
    plan = {
        "ramp_forward_axial": (ramp_and_hold(3.0, period, hold=6.0), "axial"),
        "ramp_reverse_axial": (ramp_and_hold(-3.0, period, hold=6.0), "axial"),
        "ramp_forward_ambient": (ramp_and_hold(2.5, period, hold=6.0), "ambient"),
        "steps_axial": (staircase(steps, period, hold=1.6), "axial"),
        "multisine_ambient": (sines, "ambient"),
    }
    return [
        _record(name, with_rest(commands, period, before=2.0, after=2.0), period, flow, truth, rng)
        for name, (commands, flow) in plan.items()
    ]


def run_programme(truth: ParameterSet, time: Array, throttle: Array, rng: np.random.Generator) -> list[BenchRun]:
    """Return two recordings of a throttle programme, one with each place of the flow meter.

    Args:
        truth: parameters and effects of the thruster.
        time: of the commands [s], shape (N,), each held until the next one.
        throttle: the commands [V], shape (N,).
        rng: of the sensors' noise.

    Raises:
        ValueError: the commands are not evenly spaced in whole milliseconds.
    """
    gaps = np.diff(time)
    period = round(float(np.median(gaps)) / _STEP) * _STEP if gaps.size else 0.0
    if period <= 0.0 or np.max(np.abs(gaps - period)) > 1e-6:
        raise ValueError(
            f"programme: expected commands a whole number of milliseconds apart, all alike; found gaps of "
            f"{np.min(gaps, initial=np.inf):g} to {np.max(gaps, initial=0.0):g} s"
        )
    held = with_rest(np.asarray(throttle, dtype=np.float64), period, before=2.0, after=2.0)
    return [_record(f"programme_{flow}", held, period, flow, truth, rng) for flow in ("axial", "ambient")]


def _record(
    name: str, commands: Array, period: float, flow: str, truth: ParameterSet, rng: np.random.Generator
) -> BenchRun:
    dt, effects = _STEP, truth.effects
    sent = np.repeat(commands, round(period / dt))
    gates = drawn_gates(effects, sent.size + 1, dt, rng)
    rows = simulated_rows(truth.coefficients, sent, dt, effects=effects.plant, gates=gates)
    seed = int(rng.integers(1, 2**31))
    read = dict(zip(SENSED, readings(rows, dt, effects.sensors, seed), strict=True))
    time = dt * np.arange(rows.shape[1])
    flow_time = np.arange(0.0, time[-1], 1.0 / _FLOW_RATE)
    noise, flow_noise = (disturbances(RECORDER, t.size, t[1] - t[0], rng) for t in (time, flow_time))
    magnitude = np.abs(read["speed"]) + _SPEED_AT_REST + noise.speed
    speed = np.where(rows[0] < 0.0, -1.0, 1.0) * _SPEED_STEP * np.round(magnitude / _SPEED_STEP)
    force = rung(read["thrust"], dt, RECORDER.resonance, RECORDER.damping) + noise.load
    moment = rung(read["torque"], dt, _TORQUE_RESONANCE, RECORDER.damping) + _TORQUE_NOISE * rng.standard_normal(
        time.size
    )
    true_flow = np.interp(flow_time, time, read[flow])
    recorded: dict[str, tuple[Any, Any]] = {
        "throttle": (period * np.arange(commands.size), commands),
        "speed": (time, speed),
        "thrust": (time, force + rng.normal(0.0, 0.8) + rng.normal(0.0, 0.002) * time),
        "torque": (time, moment + rng.normal(0.0, 0.005)),
        flow: (flow_time, flow_read(true_flow, flow_noise.flow, flow_noise.eddies, False)),
    }
    logged = {name: effects.log(name, *samples, rng) for name, samples in recorded.items()}
    return BenchRun(name=name, signals={k: Recorded(time=at, values=values) for k, (at, values) in logged.items()})
