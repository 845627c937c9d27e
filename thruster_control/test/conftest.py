"""A closed loop for the tests: the plant of thruster_model, the compiled step, one call of each in a period."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from thruster_control.inner_loop import AT_REST, Memory, compiled_step
from thruster_model import flow_tank
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.equations.vehicle_inflow import thruster_configuration
from thruster_model.flow_tank import PlantState

Array = NDArray[np.float64]
PERIOD = 0.04  # s, the rig's


class Run(NamedTuple):
    """What happened at the beginning of each period, shape (N,) each, SI units."""

    n: Array
    v: Array
    thrust: Array
    u: Array
    n_d: Array
    sigma: Array
    status: NDArray[np.int64]
    memory: Memory


def run_loop(
    T_d: Sequence[float] | Array,
    settings: Any,
    p: ThrusterCoefficients,
    truth: ThrusterCoefficients,
    *,
    noise: tuple[float, float] = (0.0, 0.0),
    valid: Sequence[bool] | None = None,
    late: bool = False,
    stop_rotor_until: float = 0.0,
    start: PlantState = flow_tank.AT_REST,
    dt: float = PERIOD,
    memory: Memory = AT_REST,
) -> Run:
    """Return the run of a law on the true thruster, whose states it knows up to noise in n [rad/s] and v [m/s]."""
    rng = np.random.default_rng(7)
    state, queue, rows = start, start.u, []
    for k, wanted in enumerate(np.asarray(T_d, dtype=np.float64)):
        n, v = state.n + noise[0] * rng.normal(), state.v + noise[1] * rng.normal()
        known = True if valid is None else bool(valid[k])
        memory, out = compiled_step(memory, float(wanted), n, v, state.ambient, known, dt, settings, p, np.nan, 0.0)
        acting, queue = (queue if late else out.u), out.u
        made = flow_tank.simulate(truth, [acting], dt, initial=state)
        rows.append((state.n, state.v, made.thrust[0], out.u, out.n_d, memory.sigma, out.status))
        held = k * dt < stop_rotor_until
        state = PlantState(0.0 if held else made.n[-1], made.v[-1], made.ambient[-1], made.u[-1])
    n, v, thrust, u, n_d, sigma, status = (np.array(column) for column in zip(*rows, strict=True))
    return Run(n, v, thrust, u, n_d, sigma, status.astype(np.int64), memory)


@pytest.fixture(scope="session")
def closed_loop() -> Callable[..., Run]:
    return run_loop


def _axis(yaw_deg: float, pitch_deg: float) -> tuple[float, float, float]:
    y, p = np.deg2rad([yaw_deg, pitch_deg])
    return float(np.cos(y) * np.cos(p)), float(np.sin(y) * np.cos(p)), float(np.sin(p))


@pytest.fixture(scope="session")
def ngs() -> Array:
    """K_t of the six-thruster vehicle, as its builders configured it in 2019."""
    positions = [
        (0.24892, -0.219202, -0.019812), (0.24892, 0.219202, -0.019812), (-0.20828, 0.2413, -0.019812),
        (-0.20828, -0.2413, -0.019812), (0.0, -0.1651, -0.05715), (0.0, 0.1651, -0.05715),
    ]  # fmt: skip
    angles = [(30, -30), (-30, -30), (30, -30), (-30, -30), (90, -85), (-90, -85)]
    return thruster_configuration(positions, [_axis(*each) for each in angles])


@pytest.fixture(scope="session")
def heavy() -> Array:
    """K_t of the BlueROV2 Heavy: four horizontal thrusters, four that push up."""
    corners = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    positions = [(0.156 * x, 0.111 * y, 0.085) for x, y in corners] + [(0.12 * x, 0.218 * y, 0.0) for x, y in corners]
    axes = [(1, -1, 0), (1, 1, 0), (-1, -1, 0), (-1, 1, 0)] + 4 * [(0, 0, -1)]
    return thruster_configuration(positions, axes)
