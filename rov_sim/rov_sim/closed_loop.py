"""The closed loop offline: a plant with its unmodelled effects, the bench's sensors, an observer and an inner loop.

The same step functions that nodes call, at a fixed period, without ROS; a run depends on its arguments and seed alone.

Effects act on the command, in the plant and on what sensors read, each with a memory of its own, and are what they are
in an open-loop simulation. Effects on the log change no run and are left out.
"""

from dataclasses import dataclass
from math import exp, isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rov_sim.closed_loop_kernel import COLUMNS, OUTPUTS, Clock, PlantSide, Wiring, run_loop
from rov_sim.rig_sensors import Rig, disturbances, rung
from rov_sim.wandering import wandering
from thruster_control.inner_loop import AT_REST
from thruster_estimation.belief import Belief, in_numbers
from thruster_estimation.settings import BENCH, SpeedEkfSettings
from thruster_model import flow_tank
from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.effects.stages import NO_EFFECTS
from thruster_model.stepper import NO_GATES, ROWS, PlantState, new_memory, new_sensors, substeps_of

__all__ = ["CALM", "Controller", "LoopRun", "Plant", "ProcessNoise", "Timing", "scatter_seed", "simulate_loop"]

Array = NDArray[np.float64]
_LARGEST_STEP = 1e-3  # s


@dataclass(frozen=True, kw_only=True)
class ProcessNoise:
    """What pushes a plant at random, beside its equations.

    Attributes:
        rotor: standard deviation of what is added to dn/dt [rad/s^2].
        flow: of what is added to dU/dt, of the ambient flow [m/s^2].
        axial_flow: of what is added to dv/dt, of the flow through the propeller [m/s^2].
        memory: correlation time of all [s].

    Raises:
        ValueError: numbers that cannot be.
    """

    rotor: float = 0.0
    flow: float = 0.0
    axial_flow: float = 0.0
    memory: float = 1.5

    def __post_init__(self) -> None:
        given = {name: size > 0.0 if name == "memory" else size >= 0.0 for name, size in vars(self).items()}
        wrong = [name for name, fits in given.items() if not (fits and isfinite(getattr(self, name)))]
        if wrong:
            found = ", ".join(f"{name} {getattr(self, name)}" for name in wrong)
            raise ValueError(f"process noise: expected finite numbers, 0 or more, a memory above 0; found {found}")

    def drawn(self, count: int, period: float, rng: np.random.Generator) -> Array:
        """Return pushes of rotor [rad/s^2], flow and axial flow [m/s^2], each held over a period [s], (3, count)."""
        z = rng.standard_normal((3, count + 1)).T
        sizes = np.array([self.rotor, self.flow, self.axial_flow])
        return np.ascontiguousarray(wandering(z, sizes, exp(-period / self.memory))[1:].T)


CALM = ProcessNoise()
"""Nothing pushes."""


@dataclass(frozen=True, kw_only=True)
class Plant:
    """The true thruster: coefficients of any model, effects, what pushes it at random, its state at the beginning, and
    gates as `flow_tank.simulate`.
    """

    coefficients: Any
    effects: ActiveEffects = NOTHING
    process_noise: ProcessNoise = CALM
    start: flow_tank.PlantState = flow_tank.AT_REST
    gates: Any = None


@dataclass(frozen=True, kw_only=True)
class Controller:
    """An observer and a law, by their settings, the coefficients that both believe in, and the first belief."""

    observer: Any
    law: Any
    coefficients: Any
    belief: Belief


@dataclass(frozen=True, kw_only=True)
class Timing:
    """When things happen.

    Attributes:
        period: of the control [s].
        sample: instant of y_k after t_k [s], negative for before; after it only where the observer's form is the
            bench's, which uses y_k one period later.
        computation: from t_k until u_k acts [s], up to one period.
        step: of the plant's integration [s]; the other times are multiples of it.

    Raises:
        ValueError: times that cannot be.
    """

    period: float = 0.04
    sample: float = 0.0
    computation: float = 0.0
    step: float = _LARGEST_STEP

    def __post_init__(self) -> None:
        wrong = []
        if not 0.0 < self.step <= _LARGEST_STEP:
            wrong.append(f"step: expected above 0 and at most {_LARGEST_STEP:g} s; found {self.step:g} s")
        elif not (self.period > 0.0 and np.isfinite(self.period)):
            wrong.append(f"period: expected a finite time above 0 s; found {self.period:g} s")
        else:
            if not abs(self.sample) <= self.period:
                wrong.append(f"sample: expected at most one period of {self.period:g} s; found {self.sample:g} s")
            if not 0.0 <= self.computation <= self.period:
                wrong.append(f"computation: expected 0 to {self.period:g} s; found {self.computation:g} s")
            for name in ("period", "sample", "computation"):
                steps = getattr(self, name) / self.step
                if np.isfinite(steps) and abs(steps - round(steps)) > 1e-6:
                    wrong.append(f"{name}: expected a multiple of the step {self.step:g} s; found {steps:g} steps")
        if wrong:
            raise ValueError("timing: " + "; ".join(wrong))

    @property
    def clock(self) -> Clock:
        """For kernels."""
        steps = [round(x / self.step) for x in (self.period, self.sample, self.computation)]
        return Clock(float(self.period), *steps)


class LoopRun(NamedTuple):
    """A run of N periods, SI units.

    Attributes:
        time: beginnings of the periods [s], T_d: wanted thrust [N], (N,).
        load: what the load cell tells as a mean over each period [N], (N,); force: the true mean [N], (N,).
        control: rows of `closed_loop_kernel.COLUMNS`, (len(COLUMNS), N), see `of`.
        instants: of `plant` [s], (M,); plant: rows of `closed_loop_kernel.OUTPUTS`, (5, M).
    """

    time: Array
    T_d: Array
    load: Array
    force: Array
    control: Array
    instants: Array
    plant: Array

    def of(self, column: str) -> Array:
        """Return a row of the controller's record, (N,)."""
        return np.asarray(self.control[COLUMNS.index(column)])

    def true(self, output: str) -> Array:
        """Return an output of the plant at the beginnings of the periods, (N,)."""
        steps = (self.instants.size - 1) // self.time.size
        return np.asarray(self.plant[OUTPUTS.index(output), :-1:steps])


def simulate_loop(
    T_d: ArrayLike,
    plant: Plant,
    controller: Controller,
    *,
    rig: Rig | None = None,
    timing: Timing | None = None,
    seed: int | tuple[int, ...] = 0,
    flow: ArrayLike | None = None,
) -> LoopRun:
    """Run a controller against a plant.

    Args:
        T_d: wanted thrust of each period [N], (N,).
        plant: the true thruster.
        controller: observer and law.
        rig: sensors and converters; None: the bench's.
        timing: None: the bench's period, samples at t_k, no computation delay.
        seed: of everything random.
        flow: readings of the ambient flow [m/s] in the place of the simulated velocimeter's, (N,), NaN: simulated.

    Raises:
        ValueError: a wanted thrust without shape (N,), or a sample that comes too late for the observer's form.
    """
    rig, timing = rig or Rig(), timing or Timing()
    wanted = np.ascontiguousarray(T_d, dtype=np.float64)
    if wanted.ndim != 1 or wanted.size == 0:
        raise ValueError(f"T_d: expected values of shape (N,), N > 0; found shape {wanted.shape}")
    bench = controller.observer.form == BENCH
    if timing.sample > 0.0 and not bench:
        expected = "expected a sample at or before the beginning of the period for an observer of the proper form"
        raise ValueError(f"timing: {expected}; found {timing.sample:g} s after it")
    clock = timing.clock
    wiring = Wiring(
        int(bench), int(isinstance(controller.observer, SpeedEkfSettings)), int(rig.load_cell_in_loop),
        int(rig.quantised),
    )  # fmt: skip
    noise = disturbances(rig, wanted.size, timing.period, np.random.default_rng(_entropy(seed, 0)))
    if flow is not None:
        told = np.ascontiguousarray(flow, dtype=np.float64)
        if told.shape != wanted.shape:
            raise ValueError(f"flow: expected a reading for each of {wanted.size} periods; found shape {told.shape}")
        noise = noise._replace(told=told)
    step = timing.period / clock.steps
    side = _plant_side(plant, step, scatter_seed(seed))
    dense = np.empty((len(ROWS), wanted.size * clock.steps + 1))
    read = dense if side.e_sensors is NO_EFFECTS else np.empty((len(OUTPUTS), dense.shape[1]))
    gates = NO_GATES if plant.gates is None else np.ascontiguousarray(plant.gates, dtype=np.float64)
    out = np.empty((len(COLUMNS), wanted.size))
    pushes = plant.process_noise.drawn(wanted.size, timing.period, np.random.default_rng(_entropy(seed, 2)))
    run_loop(
        wanted, noise, pushes, PlantState(*map(float, plant.start)), AT_REST, in_numbers(controller.belief), clock,
        wiring, controller.observer, controller.law, controller.coefficients, side, gates, dense, read, out,
    )  # fmt: skip
    told = read[OUTPUTS.index("thrust")]
    if np.isfinite(rig.resonance):
        told = rung(told, step, rig.resonance, rig.damping)
    load, force = _period_means(told, clock.steps), _period_means(dense[OUTPUTS.index("thrust")], clock.steps)
    begins: Array = np.asarray(clock.dt * np.arange(wanted.size), dtype=np.float64)
    instants: Array = np.asarray(step * np.arange(dense.shape[1]), dtype=np.float64)
    return LoopRun(begins, wanted, load + noise.load, force, out, instants, dense[: len(OUTPUTS)])


def scatter_seed(seed: int | tuple[int, ...]) -> int:
    """Return the seed of effects that scatter in a run with this seed."""
    return 1 + int(np.random.SeedSequence(_entropy(seed, 1)).generate_state(1)[0])


def _plant_side(plant: Plant, step: float, seed: int) -> PlantSide:
    e, e_sensors = plant.effects.plant, plant.effects.sensors
    substeps = substeps_of(step, step, e)
    memory, sensors = new_memory(step, substeps, e, float(plant.start.u)), new_sensors(step, e_sensors, seed)
    return PlantSide(plant.coefficients, e, substeps, memory, e_sensors, sensors)


def _entropy(seed: int | tuple[int, ...], stream: int) -> list[int]:
    return [*(seed if isinstance(seed, tuple) else (seed,)), stream]


def _period_means(values: Array, steps: int) -> Array:
    """Return means over the periods, of values at the ends of steps, by the trapezium."""
    return np.asarray((0.5 * (values[:-1] + values[1:])).reshape(-1, steps).mean(axis=1))
