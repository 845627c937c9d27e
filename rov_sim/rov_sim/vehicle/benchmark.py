"""How fast the vehicle's plant is, against the printed equations in plain NumPy, in the same run."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.kernel import advance_period
from rov_sim.vehicle.plant import VehicleSettings, sheet_of
from rov_sim.vehicle.settings_io import load_vehicle_settings
from rov_sim.vehicle_study.assumptions import Assumptions
from rov_sim.vehicle_study.experiment import run_experiment
from rov_sim.vehicle_study.plan_io import load_plan
from rov_sim.vehicle_study.results_io import contents_of, sets_of
from run_bag.benchmark_row import Row
from thruster_control.vehicle_set_points_io import load_script
from thruster_model.effects.stages import NEUTRAL
from thruster_model.equations.rigid_body import skew
from thruster_model.pipeline import derivative, outputs

__all__ = ["plain_rates", "rows"]

Array = NDArray[np.float64]
_STEP = 1e-3
_U = np.array([2.0, 1.8, 2.2, 1.6, -1.5, -2.0])


def rows(steps: int = 300_000) -> list[Row]:
    """Measure RK4 steps of 1 ms per second of the six-thruster vehicle, best of three rounds."""
    settings = load_vehicle_settings("ngs")
    neutral = VehicleSettings(
        coefficients=settings.coefficients, thrusters=settings.thrusters, effects=(NEUTRAL,) * settings.count
    )
    plain = max(_plain_speed(settings, 40) for _ in range(3))
    found = []
    for what, each in (("plant of a vehicle, six thrusters, RK4", settings), ("the same, effects at neutral", neutral)):
        _run(each, 10)
        found.append(Row(what, max(_speed(each, steps) for _ in range(3)), plain, "steps/s"))
    return [*found, _study(plain)]


def _study(plain: float) -> Row:
    """Measure the study's runs over all strategies of 5.2.2; plain: its plant alone, at its step, in plain NumPy."""
    plan = load_plan("thesis")
    given = Assumptions(**{name: assumed.value for name, assumed in plan.assumed.items()})
    sets = sets_of(contents_of(plan))
    script = load_script(given.script)
    names = next(group for group in plan.groups if "hq-ekf" in group.strategies).strategies

    def run_all(seed: int) -> None:
        for name in names:
            run_experiment(name, given, sets, script, seed, 1)

    run_all(0)  # compiles
    begin = time.perf_counter()
    for seed in (1, 2):
        run_all(seed)
    ours = 2 * len(names) * given.duration / (time.perf_counter() - begin)
    return Row("study of the vehicle, its strategies", ours, plain * given.largest_step, "x real time")


def _run(settings: VehicleSettings, steps: int) -> None:
    N = settings.count
    advance_period(sheet_of(settings), _U, steps, _STEP, np.ones(N), np.zeros(6), *settings.tables)


def _speed(settings: VehicleSettings, steps: int) -> float:
    begin = time.perf_counter()
    _run(settings, steps)
    return steps / (time.perf_counter() - begin)


def _plain_speed(settings: VehicleSettings, steps: int) -> float:
    x = np.zeros(13 + 2 * settings.count)
    x[3] = 1.0
    begin = time.perf_counter()
    for _ in range(steps):
        k1 = plain_rates(x, _U, settings)
        k2 = plain_rates(x + 0.5 * _STEP * k1, _U, settings)
        k3 = plain_rates(x + 0.5 * _STEP * k2, _U, settings)
        k4 = plain_rates(x + _STEP * k3, _U, settings)
        x = x + _STEP / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)
        x[3:7] /= np.linalg.norm(x[3:7])
    return steps / (time.perf_counter() - begin)


def plain_rates(x: Array, u: Array, settings: VehicleSettings) -> Array:
    """Return dx/dt of position, attitude, nu, n (N,), v (N,), by the matrices as they are printed, (2.1) to (2.21).

    The current's own acceleration in body axes stands with the added mass, as M_A acts on the relative motion.
    """
    c: Any = settings.coefficients
    N, (w, *xyz) = settings.count, x[3:7]
    axis, nu = np.array(xyz), x[7:13]
    J_1 = np.eye(3) + 2.0 * w * skew(axis) + 2.0 * skew(axis) @ skew(axis)
    nu_c = np.concatenate((J_1.T @ c.current, np.zeros(3)))
    nu_r, turn = nu - nu_c, skew(nu[3:])
    U = c.inflow.T @ nu_r
    flows = np.array([derivative(x[13 + i], x[13 + N + i], U[i], u[i], settings.thrusters[i])[:2] for i in range(N)])
    T = np.array([outputs(x[13 + i], x[13 + N + i], U[i], u[i], settings.thrusters[i])[2] for i in range(N)])
    m, S, I_O = c.M_RB[0, 0], skew(c.r_G), c.M_RB[3:, 3:]
    C_RB = np.block([[m * turn, -m * turn @ S], [m * S @ turn, -skew(I_O @ nu[3:])]])
    a, b = np.split(c.M_A @ nu_r, 2)
    C_A = np.block([[np.zeros((3, 3)), -skew(a)], [-skew(a), -skew(b)]])
    f_G, f_B = J_1.T @ [0.0, 0.0, c.weight], J_1.T @ [0.0, 0.0, -c.buoyancy]
    g = -np.concatenate((f_G + f_B, np.cross(c.r_G, f_G) + np.cross(c.r_B, f_B)))
    D = c.D_L + c.D_Q * np.abs(nu_r)
    nu_c_rate = np.concatenate((-turn @ nu_c[:3], np.zeros(3)))
    wrench = c.K_t @ T - C_RB @ nu - C_A @ nu_r - D @ nu_r - g + c.M_A @ nu_c_rate
    q_rate = 0.5 * np.array([-axis @ nu[3:], *(w * nu[3:] + np.cross(axis, nu[3:]))])
    nu_rate = np.linalg.solve(c.M_RB + c.M_A, wrench)
    return np.concatenate((J_1 @ nu[:3], q_rate, nu_rate, flows[:, 0], flows[:, 1]))
