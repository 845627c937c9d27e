r"""The thruster of the thesis: rotor, axial flow, ambient flow, thrust and torque, in one form.

State n [rad/s], v [m/s] (axial), U [m/s] (ambient); input u [V] (acting throttle). D is the dead zone of (3.9).

(3.5), (4.12), (4.14)   T(n, v) = D(n|n|; c_T) - c_nv_T |n| v - c_v_T v|v|            [N]
(3.11), (4.13), (4.15)  Q(n, v) = D(n|n|; c_Q) - c_nv_Q |n| v - c_v_Q v|v|            [N m]
(3.8), (4.3)            dn/dt = -k_n n - k_Q Q(n, v) + gamma(u)
(4.4)                   dv/dt = -k_v v - k_Uv |v| (v - k_w U) + k_Tv T(n, v)
(4.5)                   dU/dt = -k_U U - k_UU U|U| + k_TU T(n, v)

The three models of the thesis are this form with some coefficients at zero:
simplified   c_nv = c_v = 0 and no flow (k_v ... k_TU = 0): thrust and torque depend on n alone;
HL           c_1 = c_2 = c_n, no dead zone in n|n|, c_v = 0;
HQ           c_1 = c_2 = c_n, no dead zone in n|n|.
(3.7)                   dn/dt = -k_1 n - k_2 n|n| + k_3 u: k_n = k_1, k_Q = 0 and no dead zone in u; k_2 = 0 elsewhere
A rotor without inertia is n = gamma(u) / k_n.

Classes with other loads, another axial flow or a rotor without inertia: `thruster_model.equations.classes`.

All signs follow the thesis: positive throttle turns the propeller forward (n > 0), gives T > 0, and drives water
through the duct with v > 0 and U > 0.
"""

from typing import NamedTuple

import numpy as np

from thruster_model.compilation import equation
from thruster_model.equations.dead_zone import dead_zone, dead_zone_inverse


class ThrusterCoefficients(NamedTuple):
    """All coefficients of the common form, SI units (see `thruster_model.models` for each name's unit)."""

    c_u1: float
    c_u2: float
    delta_u1: float
    delta_u2: float
    u_dot_max: float
    k_n: float
    k_Q: float
    c_T1: float
    c_T2: float
    delta_T1: float
    delta_T2: float
    c_nv_T: float
    c_v_T: float
    c_Q1: float
    c_Q2: float
    delta_Q1: float
    delta_Q2: float
    c_nv_Q: float
    c_v_Q: float
    k_v: float
    k_Uv: float
    k_w: float
    k_Tv: float
    k_U: float
    k_UU: float
    k_TU: float
    k_2: float = 0.0
    drive_gain: float = 1.0


@equation
def input_map(u, p):  # type: ignore[no-untyped-def]
    """Return gamma(u) of (3.9) [rad/s^2] for the acting throttle u [V]."""
    return dead_zone(u, p.c_u1, p.delta_u1, p.c_u2, p.delta_u2)


@equation
def input_map_inverse(alpha, p):  # type: ignore[no-untyped-def]
    """Return gamma^-1(alpha) of (3.10) [V] for alpha [rad/s^2]."""
    return dead_zone_inverse(alpha, p.c_u1, p.delta_u1, p.c_u2, p.delta_u2)


@equation
def thrust(n, v, p):  # type: ignore[no-untyped-def]
    """Return the thrust T(n, v) [N] of (3.5), (4.12) or (4.14)."""
    return dead_zone(n * np.abs(n), p.c_T1, p.delta_T1, p.c_T2, p.delta_T2) - flow_loss(n, v, p.c_nv_T, p.c_v_T)


@equation
def torque(n, v, p):  # type: ignore[no-untyped-def]
    """Return the propeller's torque Q(n, v) [N m] of (3.11), (4.13) or (4.15), positive for n > 0."""
    return dead_zone(n * np.abs(n), p.c_Q1, p.delta_Q1, p.c_Q2, p.delta_Q2) - flow_loss(n, v, p.c_nv_Q, p.c_v_Q)


@equation
def flow_loss(n, v, c_nv, c_v):  # type: ignore[no-untyped-def]
    """Return c_nv |n| v + c_v v|v|, the loss of thrust [N] or torque [N m] by axial flow in (4.12) to (4.15)."""
    return c_nv * np.abs(n) * v + c_v * v * np.abs(v)


@equation
def rotor_acceleration(n, load_torque, drive, p):  # type: ignore[no-untyped-def]
    """Return dn/dt [rad/s^2] of (3.7), (3.8), (4.3); `drive` = gamma(u) [rad/s^2], `load_torque` = Q [N m]."""
    return -p.k_n * n - p.k_2 * n * np.abs(n) - p.k_Q * load_torque + p.drive_gain * drive


@equation
def axial_acceleration(v, ambient, force, p):  # type: ignore[no-untyped-def]
    """Return dv/dt [m/s^2] of (4.4); `ambient` = U [m/s], `force` = T [N]."""
    return -p.k_v * v - p.k_Uv * np.abs(v) * (v - p.k_w * ambient) + p.k_Tv * force


@equation
def ambient_acceleration(ambient, force, p):  # type: ignore[no-untyped-def]
    """Return dU/dt [m/s^2] of (4.5), the flow tank's; `force` = T [N]."""
    return -p.k_U * ambient - p.k_UU * ambient * np.abs(ambient) + p.k_TU * force
