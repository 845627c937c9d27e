"""How fast the compiled plant is, against the same equations in a plain NumPy loop, in the same run."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from run_bag.benchmark_row import Row
from thruster_model.effects.stages import NEUTRAL, NO_EFFECTS
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.pipeline import derivative
from thruster_model.stepper import AT_REST, NO_GATES, NOMINAL_SUPPLY, ROWS, advance, new_memory


def rows(steps: int = 2_000_000) -> list[Row]:
    """Measure RK4 steps per second of the three-state thruster, best of three rounds."""
    p = load_parameter_set("hq").coefficients
    commands = 3.0 * np.sin(0.01 * np.arange(steps // 100))[:, None]
    out = np.empty((len(ROWS), len(commands) + 1))
    few = steps // 1000
    plain = max(_speed(lambda: _numpy_loop(few, p), few) for _ in range(3))
    found = []
    for what, e in (("plant of one thruster, RK4", NO_EFFECTS), ("the same, all effects at neutral", NEUTRAL)):
        memory = new_memory(0.1, 100, e)
        advance(AT_REST, commands[:2], 0.1, 100, p, e, NO_GATES, NOMINAL_SUPPLY, memory, out, 0)
        arguments = (AT_REST, commands, 0.1, 100, p, e, NO_GATES, NOMINAL_SUPPLY, memory, out, 0)
        ours = max(_speed(lambda a=arguments: advance(*a), steps) for _ in range(3))
        found.append(Row(what, ours, plain, "steps/s"))
    return found


def _speed(action, count: int) -> float:  # type: ignore[no-untyped-def]
    begin = time.perf_counter()
    action()
    return count / (time.perf_counter() - begin)


def _numpy_loop(steps: int, p: ThrusterCoefficients, dt: float = 1e-3) -> NDArray[np.float64]:
    """Integrate by RK4 with the state as a NumPy vector, the way one would first write it."""
    x = np.zeros(3)
    for k in range(steps):
        u = 3.0 * np.sin(1e-4 * k)
        k1 = np.array(derivative(x[0], x[1], x[2], u, p))
        y = x + 0.5 * dt * k1
        k2 = np.array(derivative(y[0], y[1], y[2], u, p))
        y = x + 0.5 * dt * k2
        k3 = np.array(derivative(y[0], y[1], y[2], u, p))
        y = x + dt * k3
        k4 = np.array(derivative(y[0], y[1], y[2], u, p))
        x = x + dt / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
    return x
