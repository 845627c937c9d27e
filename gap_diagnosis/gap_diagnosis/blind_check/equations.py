r"""One thruster in a flow tank, written anew from the thesis for the blind check alone.

State n [rad/s], v, U [m/s]; acting throttle u [V]; thrust T [N], torque Q [N m].

(3.5), (4.12), (4.14)   T = c_T (n|n| - delta_T) outside its dead zone - c_nv_T |n| v - c_v_T v|v|
(3.11), (4.13), (4.15)  Q = c_Q (n|n| - delta_Q) outside its dead zone - c_nv_Q |n| v - c_v_Q v|v|
(3.9)                   gamma(u) = c_u (u - delta_u) outside the dead zone
(3.8), (4.3)            dn/dt = -k_n n - k_Q Q + gamma(u)
(4.4)                   dv/dt = -k_v v - k_Uv |v| (v - k_w U) + k_Tv T
(4.5)                   dU/dt = -k_U U - k_UU U|U| + k_TU T

Nothing here is shared with the plant of the simulator: a plant that checks itself proves nothing.
"""

import math
from typing import NamedTuple

from thruster_model.compilation import equation

__all__ = ["Known", "Outside", "Surroundings", "Thruster", "force_and_torque", "rates"]

_FULL_THROTTLE = 5.0  # [V] at which the sag of the supply is stated
_TURNING = 10.0  # [rad/s] above which a sensorless driver knows its rotor turns


class Thruster(NamedTuple):
    """Coefficients of the equations above, SI units."""

    c_u1: float
    c_u2: float
    delta_u1: float
    delta_u2: float
    u_dot_max: float
    k_n: float
    k_Q: float
    c_T1: float
    c_T2: float
    c_Q1: float
    c_Q2: float
    delta_T1: float = 0.0
    delta_T2: float = 0.0
    delta_Q1: float = 0.0
    delta_Q2: float = 0.0
    c_nv_T: float = 0.0
    c_v_T: float = 0.0
    c_nv_Q: float = 0.0
    c_v_Q: float = 0.0
    k_v: float = 0.0
    k_Uv: float = 0.0
    k_w: float = 0.0
    k_Tv: float = 0.0
    k_U: float = 0.0
    k_UU: float = 0.0
    k_TU: float = 0.0


class Known(NamedTuple):
    """Sizes of the library's effects that act inside the plant; zero (or infinite, or a time scale) is none."""

    dead_zone_shift: float = 0.0
    throttle_gain: float = 0.0
    supply_sag: float = 0.0
    thermal_fade: float = 0.0
    thermal_fade_time_constant: float = 60.0
    coulomb_friction: float = 0.0
    viscous_friction: float = 0.0
    rotor_inertia: float = 0.0
    brake_asymmetry: float = 0.0
    brake_asymmetry_onset: float = 1.0
    start_hysteresis: float = 0.0
    propeller_fouling: float = 0.0
    thrust_loss: float = 0.0
    thrust_asymmetry: float = 0.0
    axial_flow_loss: float = 0.0
    quadratic_flow_loss: float = 0.0
    flow_reversal_loss: float = 0.0
    entrained_water: float = 0.0
    oblique_inflow: float = 0.0
    ventilation: float = 0.0
    ventilation_onset: float = 60.0
    cavitation: float = 0.0
    cavitation_onset: float = 100.0
    water_unloaded: float = 0.0
    ambient_current: float = 0.0
    tank_recirculation: float = 0.0
    tank_recirculation_delay: float = 3.0
    flow_lag: float = 0.0
    command_delay: float = 0.0
    command_lag: float = 0.0
    command_lag_unevenness: float = 0.0
    command_quantization: float = 0.0
    throttle_rate_limit: float = math.inf
    throttle_saturation: float = math.inf
    thruster_polarity: float = 0.0
    tach_lag: float = 0.0
    tach_scale: float = 0.0
    tach_quantization: float = 0.0
    tach_dropout: float = 0.0
    load_cell_resonance: float = math.inf
    load_cell_resonance_damping: float = 0.05


class Outside(NamedTuple):
    """Sizes of effects that no library knows, and what else they need."""

    throttle_backlash: float = 0.0  # [V] width of the play
    throttle_cubic: float = 0.0  # [1/V^2] u -> u (1 - s u^2)
    drive_resonance: float = 0.0  # share of a lightly damped mode in what the motor gets
    drive_resonance_frequency: float = 2.0  # [Hz]
    drive_resonance_damping: float = 0.1
    gain_step: float = 0.0  # share of the drive lost from one instant on
    gain_step_time: float = 15.0  # [s]
    static_friction_peak: float = 0.0  # [rad/s^2] friction that fades with speed (Stribeck)
    growing_ripple: float = 0.0  # [rad/s^2] at 100 rad/s and 30 s
    growing_ripple_frequency: float = 2.0  # [Hz]
    low_speed_exponent: float = 0.0  # T (|n|/60)^s below 60 rad/s
    wake_stall: float = 0.0  # share of the thrust lost for 0.5 s after |dn/dt| > 300 rad/s^2
    torque_by_current: float = 0.0  # share of Q lost per 0.3 m/s of ambient flow
    tank_seiche: float = 0.0  # [m/s/N] sway of the tank's water by thrust
    tank_seiche_frequency: float = 0.2  # [Hz]
    tank_seiche_damping: float = 0.1
    load_cell_creep: float = 0.0  # share of the load that comes late
    load_cell_creep_time: float = 5.0  # [s]
    tach_periodic_error: float = 0.0  # [rad/s] times sin(n / its period)
    tach_periodic_error_period: float = 5.0  # [rad/s] over a radian


class Surroundings(NamedTuple):
    """What the equations need besides state and throttle, at one instant."""

    heat: float  # of the motor, 0 to 1
    past: float  # [m/s] ambient flow one way round the tank ago
    gate: float  # 0 while air may be drawn, else 1
    sway: float  # [m/s] of the tank's water
    stalled: float  # 1 while the wake is stalled, else 0
    push: float  # [rad/s^2] disturbance of the rotor
    stirred: float  # [m/s^2] disturbance of the ambient flow
    time: float  # [s] since the start of the run


@equation
def _banded(x, c_1, edge_1, c_2, edge_2):  # type: ignore[no-untyped-def]
    if x <= edge_1:
        return c_1 * (x - edge_1)
    return c_2 * (x - edge_2) if x >= edge_2 else 0.0


@equation
def drive(n, u, s, p, e, o):  # type: ignore[no-untyped-def]
    """Return gamma(u) [rad/s^2] as the rotor gets it."""
    narrower = e.start_hysteresis if abs(n) > _TURNING else 0.0
    lower = min(min(p.delta_u1 - e.dead_zone_shift, 0.0) + narrower, 0.0)
    upper = max(max(p.delta_u2 + e.dead_zone_shift, 0.0) - narrower, 0.0)
    gamma = _banded(u, p.c_u1, lower, p.c_u2, upper)
    gamma *= (1.0 - e.throttle_gain) * (1.0 - e.thermal_fade * s.heat)
    if s.time >= o.gain_step_time:
        gamma *= 1.0 - o.gain_step
    if e.supply_sag != 0.0:
        full = max(p.c_u2 * (_FULL_THROTTLE - p.delta_u2), p.c_u1 * (_FULL_THROTTLE + p.delta_u1))
        gamma *= max(1.0 - e.supply_sag * abs(gamma) * abs(n) * p.k_n / (full * full), 0.0)
    return gamma


@equation
def force_and_torque(n, v, water, s, p, e, o):  # type: ignore[no-untyped-def]
    """Return (T [N] without what depends on dn/dt, Q [N m])."""
    square = n * abs(n)
    force = _banded(square, p.c_T1, p.delta_T1, p.c_T2, p.delta_T2)
    force -= p.c_nv_T * (1.0 + e.axial_flow_loss) * abs(n) * v + (p.c_v_T + e.quadratic_flow_loss) * v * abs(v)
    moment = _banded(square, p.c_Q1, p.delta_Q1, p.c_Q2, p.delta_Q2) - p.c_nv_Q * abs(n) * v - p.c_v_Q * v * abs(v)
    left = (1.0 - e.thrust_loss) * (1.0 - e.propeller_fouling)
    if n < 0.0:
        left *= 1.0 - e.thrust_asymmetry
    if n * v < 0.0:
        left *= 1.0 - e.flow_reversal_loss
    if abs(n) > e.cavitation_onset and e.cavitation != 0.0:
        left *= max(1.0 - e.cavitation * (abs(n) - e.cavitation_onset) / e.cavitation_onset, 0.0)
    if s.gate == 0.0 and abs(n) > e.ventilation_onset:
        left *= 1.0 - e.ventilation
    if o.low_speed_exponent != 0.0 and abs(n) < 60.0:
        left *= (abs(n) / 60.0) ** o.low_speed_exponent
    left *= 1.0 - o.wake_stall * s.stalled
    moment *= (1.0 + e.propeller_fouling) * (1.0 - e.water_unloaded) * (1.0 - o.torque_by_current * water / 0.3)
    return force * left, moment


@equation
def dry_friction(n, e, o):  # type: ignore[no-untyped-def]
    """Return the largest deceleration [rad/s^2] that dry friction holds against at this speed."""
    return e.coulomb_friction + o.static_friction_peak * math.exp(-((n / 15.0) ** 2))


@equation
def rates(n, v, ambient, u, s, p, e, o):  # type: ignore[no-untyped-def]
    """Return (dn/dt, dv/dt, dU/dt, water past the instrument [m/s], T [N], Q [N m])."""
    water = ambient + e.ambient_current + s.sway
    met = water * math.cos(e.oblique_inflow)
    force, moment = force_and_torque(n, v, met, s, p, e, o)
    free = drive(n, u, s, p, e, o) - p.k_n * (1.0 + e.viscous_friction) * n - p.k_Q * moment + s.push
    if o.growing_ripple != 0.0:
        wave = math.sin(2.0 * math.pi * o.growing_ripple_frequency * s.time)
        free += o.growing_ripple * (s.time / 30.0) * (abs(n) / 100.0) * wave
    held = dry_friction(n, e, o)
    if n > 0.0 or (n == 0.0 and free > held):
        n_dot = free - held
    elif n < 0.0 or (n == 0.0 and free < -held):
        n_dot = free + held
    else:
        n_dot = 0.0
    # Braking: all of s k_n |n| where the rotor slows by the onset's share of k_n |n| or more, in proportion where less.
    slowed = -n_dot if n > 0.0 else n_dot
    if e.brake_asymmetry != 0.0 and n != 0.0 and slowed > 0.0:
        full = p.k_n * abs(n)
        share = e.brake_asymmetry * min(slowed / (e.brake_asymmetry_onset * full), 1.0)
        slowed = max(slowed + share * full, 0.0)
        n_dot = -slowed if n > 0.0 else slowed
    n_dot /= 1.0 + e.rotor_inertia
    force = (force - e.entrained_water * n_dot) * (1.0 - e.water_unloaded)
    v_dot = (-p.k_v * v - p.k_Uv * abs(v) * (v - p.k_w * met) + p.k_Tv * force) / (1.0 + e.flow_lag)
    u_dot = -p.k_U * ambient - p.k_UU * ambient * abs(ambient) + p.k_TU * force
    u_dot += e.tank_recirculation * p.k_U * s.past + s.stirred
    return n_dot, v_dot, u_dot, water, force, moment
