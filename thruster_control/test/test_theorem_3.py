r"""Theorem 3, (3.24)-(3.27): when the vehicle and its thrusters together come to rest where they shall be.

The proof sets Delta n beside (2.23), (2.24) as if neither acted on the other. They do: what moves the vehicle is T(n),
and dDnu/dt has the term M^-1 K_t (T(n) - T(n_d)) that (3.27) leaves out; and dDn/dt = -K_u Dn needs dn_d/dt, which
depends on the vehicle's acceleration, so on n. Integrated here is the whole, RK4 at 1 ms, without flow, with the
published simplified thrusters on the six-thruster vehicle:

    dn/dt = -k_n n - k_Q Q(n) + gamma(u),   u = gamma^-1(a) within +-u_max,
    a = s dn_d/dt + k_n n + k_Q Q(n) - K_u (n - n_d),   n_d by (3.6) from (2.22);   s = 1: dn_d/dt known, 0: not

Found, with V = |Dnu|^2 / 2 + 4 k_I (1 - w) at the end over V at the beginning, K_u / K_P from 0.25 to 25:

- With dn_d/dt known, as the proof has it, Delta n decays as exp(-K_u t) whatever the vehicle does, and the claim holds
  for every ratio: V falls to below 1e-7 of itself in 40 s. The first part of a cascade forgets itself.
- Without dn_d/dt the claim needs a fast inner loop: for small errors s^3 + K_u s^2 + K_u K_P s + K_u k_I, stable for
  K_u > k_I / K_P; K_u / K_P does not enter. At K_P = k_I = 1: K_u = 0.25 keeps all of V, 0.5 a fifteenth of it, 1 (the
  edge) 4e-4, 2 less than 1e-7. At K_P = k_I = 4, K_u = 4 (the same edge four times over) is as good as any.
- Limits of 5 V or 3 V change little with these gains, even from 172 degrees off.
- Where a thruster is to rest at zero thrust (the vehicle level and still: four of six), n_d jumps over the dead zone of
  the thrust map, +-sqrt(delta_T), at the slightest change of sign: Delta n jumps with it, again and again, and does not
  tend to zero, while V does.
"""

import math
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from thruster_control.allocation.configuration import inverse
from thruster_control.outer_loop.laws import law_wrench, quaternion_error
from thruster_control.outer_loop.model import model_terms
from thruster_control.outer_loop.settings import VehicleSetPoint, outer_memory, quaternion_law
from thruster_model.equations.attitude import normalised, quaternion_from_euler, quaternion_rate
from thruster_model.equations.inversion import speed_for_thrust_map
from thruster_model.equations.thruster import input_map, input_map_inverse, rotor_acceleration, thrust, torque
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

pytestmark = pytest.mark.long

Array = NDArray[np.float64]
STEP = 1e-3
AHEAD = 1e-6  # s, over which dn_d/dt is a difference
JUMP = 1e5  # rad/s^2: what is faster is a jump of n_d, which has no rate


class Ways(NamedTuple):
    """What is varied: K_u [1/s], whether dn_d/dt is known, largest throttle [V]."""

    K_u: float
    known: bool
    u_max: float


@numba.njit
def speeds(q, nu, sp, law, c, p, memory, K_inv, n_d):  # type: ignore[no-untyped-def]
    wrench = np.empty(6)
    law_wrench(q, nu, sp, 0.0, law, c, memory, wrench)
    T = K_inv @ wrench
    for i in range(6):
        n_d[i] = speed_for_thrust_map(T[i], p)


@numba.njit
def slope(x, sp, ways, law, c, p, memory, K_t, K_inv, M_inv, n_d, n_ahead):  # type: ignore[no-untyped-def]
    """Return dx/dt of x = (q, nu, n), shape (16,)."""
    q, nu, n, rate = normalised((x[0], x[1], x[2], x[3])), x[4:10], x[10:], np.empty(16)
    T, terms = np.empty(6), np.empty(6)
    for i in range(6):
        T[i] = thrust(n[i], 0.0, p)
    model_terms(c, q, nu, terms)
    rate[4:10] = M_inv @ (K_t @ T - terms)
    q_dot = quaternion_rate(q, (nu[3], nu[4], nu[5]))
    for i in range(4):
        rate[i] = q_dot[i]
    speeds(q, nu, sp, law, c, p, memory, K_inv, n_d)
    later = x + AHEAD * rate
    speeds(normalised((later[0], later[1], later[2], later[3])), later[4:10], sp, law, c, p, memory, K_inv, n_ahead)
    for i in range(6):
        n_d_dot = (n_ahead[i] - n_d[i]) / AHEAD
        if not ways.known or abs(n_d_dot) > JUMP:
            n_d_dot = 0.0
        losses = rotor_acceleration(n[i], torque(n[i], 0.0, p), 0.0, p)
        u = input_map_inverse(n_d_dot - losses - ways.K_u * (n[i] - n_d[i]), p)
        rate[10 + i] = losses + input_map(min(max(u, -ways.u_max), ways.u_max), p)
    return rate


@numba.njit
def integrated(x, sp, ways, law, c, p, memory, K_t, K_inv, M_inv, steps):  # type: ignore[no-untyped-def]
    """Return (V, the largest |Delta n|) at every step."""
    told, n_d, n_ahead = np.empty((steps, 2)), np.empty(6), np.empty(6)
    for k in range(steps):
        k_s, total = np.zeros(16), np.zeros(16)
        for stage in range(4):  # one call, that is compiled once
            share = (0.0, 0.5, 0.5, 1.0)[stage]
            k_s = slope(x + share * STEP * k_s, sp, ways, law, c, p, memory, K_t, K_inv, M_inv, n_d, n_ahead)
            total += (1.0, 2.0, 2.0, 1.0)[stage] * k_s
            if stage == 0:
                told[k, 1] = np.max(np.abs(x[10:] - n_d))
        q_e = quaternion_error((x[0], x[1], x[2], x[3]), sp)
        told[k, 0] = 4.0 * law.k_I * (1.0 - abs(q_e[0])) + 0.5 * np.sum((x[4:7] - np.array(sp.velocity)) ** 2)
        told[k, 0] += 0.5 * np.sum(x[7:10] ** 2)
        x = x + STEP / 6.0 * total
    return told


def run(
    vehicle: Any,
    ways: Ways,
    yaw: float = 0.3,
    seconds: float = 40.0,
    gain: float = 1.0,
    moving: bool = True,
) -> tuple[Array, Array]:
    """Return V and the largest |Delta n| [rad/s] from rest, `yaw` [rad] off; K_P = k_I = `gain`.

    The set point keeps all thrusters turning, or (not `moving`) is level rest, with four of them at zero thrust.
    """
    p = load_parameter_set("simplified").coefficients
    there = VehicleSetPoint((0.0, 0.3, 0.0), velocity=(0.15, 0.02, 0.02))
    sp = there if moving else VehicleSetPoint()
    x = np.r_[quaternion_from_euler((0.0, 0.0, yaw)), np.zeros(12)]
    law, M_inv = quaternion_law(gain, gain), np.linalg.inv(vehicle.M_RB + vehicle.M_A)
    K_t, steps = vehicle.K_t, round(seconds / STEP)
    told = integrated(x, sp, ways, law, vehicle, p, outer_memory(), K_t, inverse(K_t), M_inv, steps)
    return told[:, 0], told[:, 1]


@pytest.fixture(scope="module")
def vehicle() -> Any:
    return load_vehicle_set("ngs").coefficients


@pytest.mark.parametrize("K_u", [0.5, 1.0, 5.0])
def test_with_the_rate_known_speeds_forget_their_errors_at_K_u_and_the_claim_holds(vehicle: Any, K_u: float) -> None:
    V, error = run(vehicle, Ways(K_u, True, math.inf))
    middle = round(4.0 / K_u / STEP)
    assert error[middle] == pytest.approx(error[0] * math.exp(-4.0), rel=0.02)
    assert V[-1] < 1e-7 * V[0]


@pytest.mark.parametrize("gain", [1.0, 4.0])
def test_without_the_rate_the_claim_needs_an_inner_loop_faster_than_k_I_over_K_P(vehicle: Any, gain: float) -> None:
    V, _ = run(vehicle, Ways(0.25, False, math.inf), gain=gain)
    assert V[-5000:].max() > 0.1 * V[0], "k_I / K_P = 1 1/s: too slow, whatever K_P"
    V, _ = run(vehicle, Ways(2.0, False, math.inf), gain=gain)
    assert V[-1] < 1e-7 * V[0]


@pytest.mark.parametrize(("known", "K_u"), [(True, 0.5), (False, 5.0)])
def test_from_far_away_and_at_the_limits_of_the_throttle_the_claim_holds(vehicle: Any, known: bool, K_u: float) -> None:
    V, _ = run(vehicle, Ways(K_u, known, 3.0), yaw=3.0)
    assert V[-1] < 1e-7 * V[0]


def test_thrusters_that_rest_at_zero_thrust_keep_jumping_though_the_vehicle_comes_to_rest(vehicle: Any) -> None:
    V, error = run(vehicle, Ways(5.0, True, 5.0), moving=False)
    assert V[-1] < 1e-7 * V[0]
    assert error[-5000:].max() > 0.01
