r"""The plant of the laboratory's simulator: HL or HQ by classical Runge-Kutta at 0.5 ms.

    dn/dt = gamma(u) - k_n n - k_Q Q + w_n,  dv/dt = -k_v v - k_Uv |v| (v - k_w U) + k_Tv T,
    dU/dt = -k_U U - k_UU U|U| + k_TU T + w_U,  T = c_n n|n| - c_nv |n| v - c_v v|v|,  Q alike

with random accelerations w_n, w_U of rotor and water.
"""

import math
from typing import NamedTuple

import numpy as np

from thruster_model.compilation import compiled, equation

__all__ = ["STEP", "Coefficients", "simulated"]

STEP = 5e-4  # [s]


class Coefficients(NamedTuple):
    """Coefficients, effects in the plant and forms; SI units."""

    c1: float
    c2: float
    d1: float
    d2: float
    ramp: float
    k_n: float
    k_Q: float
    cT: float
    cvT: float
    cvvT: float
    cQ: float
    cvQ: float
    cvvQ: float
    k_v: float
    k_Uv: float
    k_w: float
    k_Tv: float
    k_U: float
    k_UU: float
    k_TU: float
    delay: float = 0.0
    lag: float = 0.0
    round_to: float = 0.0
    slew: float = 1e9
    limit: float = 1e9
    edge: float = 0.0
    gain: float = 0.0
    sag: float = 0.0
    fade: float = 0.0
    fade_time: float = 30.0
    dry: float = 0.0
    viscous: float = 0.0
    inertia: float = 0.0
    brake: float = 0.0
    brake_onset: float = 1.0
    hysteresis: float = 0.0
    fouling: float = 0.0
    loss: float = 0.0
    reverse_loss: float = 0.0
    axial: float = 0.0
    quadratic: float = 0.0
    against: float = 0.0
    impulse: float = 0.0
    vapour: float = 0.0
    vapour_from: float = 80.0
    current: float = 0.0
    again: float = 0.0
    again_after: float = 3.0
    slow_flow: float = 0.0
    wake: float = 0.0
    edge_drift: float = 0.0
    cogging: float = 0.0
    curvature: float = 0.0
    half_gain: float = 0.0
    turning: float = 10.0
    heat_power: float = 1.0
    dry_width: float = 0.3
    vapour_power: float = 1.0


@equation
def _rates(n, v, U, u, heat, past, wake, weak, edge, p):  # type: ignore[no-untyped-def]
    """Return (dn/dt, dv/dt, dU/dt, T, Q) without disturbance."""
    near = p.hysteresis if abs(n) > p.turning else 0.0
    upper = max(max(p.d2 + p.edge + edge, 0.0) - near, 0.0)
    lower = min(min(p.d1 - p.edge, 0.0) + near, 0.0)
    gamma = p.c2 * (u - upper) if u > upper else p.c1 * (u - lower) if u < lower else 0.0
    gamma *= (1.0 - p.gain) * (1.0 - p.fade * heat) * (0.5 if weak > 0.0 else 1.0)
    if p.sag > 0.0:
        full = max(p.c2 * (5.0 - p.d2), p.c1 * (5.0 + p.d1))
        gamma *= max(1.0 - p.sag * abs(gamma) * abs(n) * p.k_n / full**2, 0.0)
    water = U + p.current
    thrust = p.cT * n * abs(n) - p.cvT * (1.0 + p.axial) * abs(n) * v - (p.cvvT + p.quadratic) * v * abs(v)
    torque = p.cQ * n * abs(n) - p.cvQ * abs(n) * v - p.cvvQ * v * abs(v)
    thrust *= (1.0 - p.loss) * (1.0 - p.fouling)
    torque *= 1.0 + p.fouling
    if n < 0.0:
        thrust *= 1.0 - p.reverse_loss
    if n * v < 0.0:
        thrust *= 1.0 - p.against
    if p.vapour > 0.0 and abs(n) > p.vapour_from:
        thrust *= max(1.0 - p.vapour * ((abs(n) - p.vapour_from) / p.vapour_from) ** p.vapour_power, 0.0)
    dn = gamma - p.k_n * (1.0 + p.viscous) * n - p.k_Q * torque
    if p.dry > 0.0:
        dn -= p.dry * math.tanh(n / p.dry_width)
    if p.brake != 0.0 and dn * n < 0.0:
        more = p.brake * min(abs(dn) / p.brake_onset, p.k_n * abs(n))
        slower = max(abs(dn) + more, 0.0)
        dn = -slower if n > 0.0 else slower
    dn /= 1.0 + p.inertia
    thrust = (1.0 - p.wake) * thrust + p.wake * wake - p.impulse * dn
    dv = (-p.k_v * v - p.k_Uv * abs(v) * (v - p.k_w * water) + p.k_Tv * thrust) / (1.0 + p.slow_flow)
    dU = -p.k_U * U - p.k_UU * U * abs(U) + p.k_TU * thrust + p.again * p.k_U * past
    return dn, dv, dU, thrust, torque


@equation
def _command_at(t, times, values, linear):  # type: ignore[no-untyped-def]
    k = np.searchsorted(times, t + 1e-9, side="right") - 1
    if k < 0:
        return values[0]
    if not linear or k + 1 >= times.size:
        return values[k]
    return values[k] + (values[k + 1] - values[k]) * (t - times[k]) / (times[k + 1] - times[k])


@compiled
def simulated(times, values, linear, first, count, push, every, p, out):  # type: ignore[no-untyped-def]
    """Fill `out` (4, M): n, U with current, T, Q from time 0 on, `every` steps apart; the run begins at `first` [s]."""
    n = v = U = heat = wake = weak = angle = 0.0
    u = slewed = lagged = 0.0 if first >= 0.0 else values[0]
    back = int(p.again_after / STEP)
    ring = np.zeros(back + 1)
    before = 0.0
    row = 0
    for i in range(count + 1):
        t = first + i * STEP
        c = _command_at(t - p.delay, times, values, linear)
        c += p.curvature * (c * abs(c) - 0.5 * c * c)
        if p.round_to > 0.0:
            c = p.round_to * np.round(c / p.round_to)
        c = min(max(c, -p.limit), p.limit)
        slewed += min(max(c - slewed, -p.slew * STEP), p.slew * STEP)
        lagged = slewed + (lagged - slewed) * math.exp(-STEP / p.lag) if p.lag > 0.0 else slewed
        end = u + min(max(lagged - u, -p.ramp * STEP), p.ramp * STEP)
        if p.half_gain > 0.0:
            if end * before < 0.0:
                weak = p.half_gain
            weak -= STEP
            before = end if end != 0.0 else before
        edge = p.edge_drift * max(t, 0.0)
        past = ring[i % (back + 1)]
        a = _rates(n, v, U, u, heat, past, wake, weak, edge, p)
        if t >= -1e-9 and row < out.shape[1] and i % every == 0:
            out[0, row], out[1, row], out[2, row], out[3, row] = n, U + p.current, a[3], a[4]
            row += 1
        m, h = 0.5 * (u + end), STEP
        b = _rates(n + 0.5 * h * a[0], v + 0.5 * h * a[1], U + 0.5 * h * a[2], m, heat, past, wake, weak, edge, p)
        d = _rates(n + 0.5 * h * b[0], v + 0.5 * h * b[1], U + 0.5 * h * b[2], m, heat, past, wake, weak, edge, p)
        e = _rates(n + h * d[0], v + h * d[1], U + h * d[2], end, heat, past, wake, weak, edge, p)
        ring[i % (back + 1)] = U
        bump = push[0, i]
        if p.cogging > 0.0:
            angle += n * h
            bump -= p.cogging * math.sin(6.0 * angle) * math.exp(-abs(n) / 25.0)
        n += h * ((a[0] + 2.0 * b[0] + 2.0 * d[0] + e[0]) / 6.0 + bump)
        v += h * (a[1] + 2.0 * b[1] + 2.0 * d[1] + e[1]) / 6.0
        U += h * ((a[2] + 2.0 * b[2] + 2.0 * d[2] + e[2]) / 6.0 + push[1, i])
        static = a[3] if p.wake == 0.0 else (a[3] - p.wake * wake) / (1.0 - p.wake)
        wake += h / 0.4 * (static - wake)
        heat += h / p.fade_time * ((abs(end) / 5.0) ** p.heat_power - heat)
        u = end
