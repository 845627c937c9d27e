"""A synthetic identification campaign on a thruster bench: experiments simulated and seen through its sensors."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.bench_sensors import LoadCell, Tachometer, Velocimeter
from rov_sim.throttle_programmes import multisine, ramp_and_hold, staircase, with_rest
from thruster_model.flow_tank import simulate
from thruster_model.identification.experiment import SIGNALS
from thruster_model.parameter_set import ParameterSet

__all__ = ["BenchRun", "Recorded", "altered", "run_campaign", "run_programme"]

Array = NDArray[np.floating]
_STEP = 0.001  # [s] of the simulation


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
    dt = _STEP
    effects = truth.effects
    acting = effects.command(np.repeat(commands, round(period / dt)), dt)
    trajectory = simulate(truth.coefficients, acting, dt, effects=effects.plant)
    time = dt * np.arange(trajectory.n.size)
    true = {name: getattr(trajectory, signal.plant_output) for name, signal in SIGNALS.items()}
    seen_true = {name: effects.reading(name, true, dt, rng) for name in ("speed", "thrust", "torque", flow)}
    force = LoadCell(noise=0.5, rest=float(rng.normal(0.0, 0.8)), drift=float(rng.normal(0.0, 0.002)))
    moment = LoadCell(noise=0.02, rest=float(rng.normal(0.0, 0.005)), frequency=8.5)
    seen_at, seen = Velocimeter().read(seen_true[flow], dt, rng)
    speed = np.where(trajectory.n < 0.0, -1.0, 1.0) * Tachometer().read(seen_true["speed"], rng)
    recorded: dict[str, tuple[Any, Any]] = {
        "throttle": (period * np.arange(commands.size), commands),
        "speed": (time, speed),
        "thrust": (time, force.read(seen_true["thrust"], dt, rng)),
        "torque": (time, moment.read(seen_true["torque"], dt, rng)),
        flow: (seen_at, seen),
    }
    logged = {name: effects.log(name, *samples, rng) for name, samples in recorded.items()}
    return BenchRun(name=name, signals={k: Recorded(time=at, values=values) for k, (at, values) in logged.items()})
