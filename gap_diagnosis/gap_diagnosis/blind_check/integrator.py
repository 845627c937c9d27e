"""Integration of the blind check's thruster: Heun's method at 0.25 ms, dry friction as an event.

While |drive| is below the friction a rotor at n = 0 stays exactly there; where a step crosses n = 0 against friction it
is cut at the crossing, and what follows is stick or the start in the other direction. Delays are looked up on the fine
grid. The command goes through polarity, the driver's play, converter steps, limits, lag; then the ramp limit.
"""

import math

import numpy as np

from gap_diagnosis.blind_check.equations import Surroundings, dry_friction, rates
from thruster_model.compilation import compiled, equation

__all__ = ["CHANNELS", "GATE_PERIOD", "SUBSTEPS", "integrate"]

SUBSTEPS = 160
"""Steps within a period of 0.04 s: 0.25 ms each."""
GATE_PERIOD = 0.01
"""Period [s] of the gates of ventilation."""
CHANNELS = ("n", "ambient", "thrust", "torque", "v", "u", "tach", "tach_noisy", "load_force", "load_moment")
"""Rows of the result: true n, U at the instrument, T, Q, v, u; tachometer without and with noise; load cell."""

_STALL_TIME = 0.5
_STALL_RATE = 300.0


@equation
def _converted(u, e, o):  # type: ignore[no-untyped-def]
    """Return a command [V] after what acts on each value alone."""
    if e.thruster_polarity != 0.0:
        u = -u
    u *= 1.0 - o.throttle_cubic * u * u
    if e.command_quantization > 0.0:
        u = e.command_quantization * np.round(u / e.command_quantization)
    return min(max(u, -e.throttle_saturation), e.throttle_saturation)


@equation
def _tachometer(n, noise, e, o):  # type: ignore[no-untyped-def]
    """Return the tachometer's reading [rad/s]: scale, noise, converter."""
    y = n * (1.0 + e.tach_scale) + o.tach_periodic_error * math.sin(n / o.tach_periodic_error_period) + noise
    if e.tach_quantization > 0.0:
        y = e.tach_quantization * np.round(y / e.tach_quantization)
    return 0.0 if abs(y) < e.tach_dropout else y


@equation
def _mode(frequency, damping, h):  # type: ignore[no-untyped-def]
    """Return the exact transition (a11, a12, a21, a22) of y'' + 2 d w y' + w^2 y = 0 over h [s]."""
    w = 2.0 * math.pi * frequency
    d = min(damping, 1.0 - 1e-9)
    wd = w * math.sqrt(1.0 - d * d)
    fade, c, s = math.exp(-d * w * h), math.cos(wd * h), math.sin(wd * h) / wd
    return fade * (c + d * w * s), fade * s, -fade * w * w * s, fade * (c - d * w * s)


@equation
def _moved(y, rate, target, a):  # type: ignore[no-untyped-def]
    """Return (y, dy/dt) of a mode after a step under a constant target."""
    x = y - target
    return target + a[0] * x + a[1] * rate, a[2] * x + a[3] * rate


@compiled
def integrate(p, e, o, dt, commands, desired, gains, gates, push, noise, flow, out):  # type: ignore[no-untyped-def]
    """Simulate a run; fill `out` (rows `CHANNELS`, (10, N)) and `flow`: U on the fine grid, whose size tells the steps.

    p, e, o: `Thruster`, `Known`, `Outside`. commands: throttle (N,) [V], filled here in closed loop, that is where
    desired: speeds (N,) [rad/s] are given; gains: (forward, proportional, integral, limit) of that loop.
    gates: every `GATE_PERIOD`; push: disturbances of rotor [rad/s^2] and ambient flow [m/s^2], (2, N + 1); noise: of
    the tachometer (N,).
    """
    count = commands.size
    substeps = flow.size // count
    h = dt / substeps
    n = v = ambient = u = heat = sway = sway_rate = stall_left = 0.0
    ramped = lagged = play = ring = ring_rate = tach = integral = 0.0
    load_f = load_f_rate = creep = creep_slow = 0.0
    springy = e.load_cell_resonance < math.inf
    mode = _mode(e.load_cell_resonance if springy else 1.0, e.load_cell_resonance_damping, h)
    ringing = _mode(o.drive_resonance_frequency, o.drive_resonance_damping, h)
    swaying = _mode(o.tank_seiche_frequency, o.tank_seiche_damping, h)
    keep_rising = keep_falling = 0.0
    if e.command_lag > 0.0:
        keep_rising = math.exp(-h / (e.command_lag * (1.0 + e.command_lag_unevenness)))
        keep_falling = math.exp(-h / (e.command_lag * (1.0 - e.command_lag_unevenness)))
    keep_tach = math.exp(-h / e.tach_lag) if e.tach_lag > 0.0 else 0.0
    keep_heat = math.exp(-h / e.thermal_fade_time_constant)
    back = int(e.tank_recirculation_delay / h + 0.5)
    reached = np.zeros(count)
    for k in range(count):
        at = k * dt
        s = Surroundings(
            heat,
            0.0,
            gates[int(at / GATE_PERIOD + 1e-6)],
            sway,
            1.0 if stall_left > 0.0 else 0.0,
            push[0, k],
            push[1, k],
            at,
        )
        _, _, _, water, force, moment = rates(n, v, ambient, u, s, p, e, o)
        if k == 0:
            tach, load_f = n, force
        out[0, k], out[1, k], out[2, k], out[3, k], out[4, k], out[5, k] = n, water, force, moment, v, u
        clean = tach if e.tach_lag > 0.0 else n
        out[6, k], out[7, k] = _tachometer(clean, 0.0, e, o), _tachometer(clean, noise[k], e, o)
        late = o.load_cell_creep * (0.5 * (creep + creep_slow) - force)
        out[8, k], out[9, k] = (load_f if springy else force + late), moment
        if desired.size > 0:
            error = desired[k] - out[7, k]
            wanted = gains[0] * desired[k] + gains[1] * error + integral
            wanted += 0.8 * np.sign(desired[k])
            commands[k] = min(max(wanted, -gains[3]), gains[3])
            if commands[k] == wanted:
                integral += gains[2] * error * dt
        play = min(max(play, commands[k] - 0.5 * o.throttle_backlash), commands[k] + 0.5 * o.throttle_backlash)
        reached[k] = _converted(play, e, o)
        for j in range(substeps):
            i = k * substeps + j
            # the command over this step, averaged where it changes within
            first = i - e.command_delay / h
            old = math.floor(first / substeps + 1e-9)
            new = math.floor((first + 1.0) / substeps - 1e-9)
            share = first + 1.0 - new * substeps if new > old else 1.0
            command = share * (reached[new] if new >= 0 else 0.0)
            if share < 1.0:
                command += (1.0 - share) * (reached[old] if old >= 0 else 0.0)
            step = e.throttle_rate_limit * h
            ramped += min(max(command - ramped, -step), step)
            lagged = ramped + (lagged - ramped) * (keep_rising if abs(ramped) > abs(lagged) else keep_falling)
            ring, ring_rate = _moved(ring, ring_rate, lagged, ringing)
            target = lagged + o.drive_resonance * (ring - lagged)
            before = u
            u += min(max(target - u, -p.u_dot_max * h), p.u_dot_max * h)
            time = i * h
            flow[i] = ambient + e.ambient_current + sway
            along = push[0, k] + (push[0, k + 1] - push[0, k]) * j / substeps
            stirred = push[1, k] + (push[1, k + 1] - push[1, k]) * j / substeps
            gate = gates[int(time / GATE_PERIOD + 1e-6)]
            past = flow[i - back] - e.ambient_current if i >= back else 0.0
            s = Surroundings(heat, past, gate, sway, 1.0 if stall_left > 0.0 else 0.0, along, stirred, time)
            n1, v1, a1, _, force, _ = rates(n, v, ambient, before, s, p, e, o)
            heat = abs(u) / 5.0 + (heat - abs(u) / 5.0) * keep_heat
            past = flow[i + 1 - back] - e.ambient_current if i + 1 >= back else 0.0
            s = Surroundings(heat, past, gate, sway, 1.0 if stall_left > 0.0 else 0.0, along, stirred, time + h)
            ahead = n + h * n1
            crosses = ahead * n < 0.0 and dry_friction(0.0, e, o) > 0.0
            n2, v2, a2, _, force2, _ = rates(0.0 if crosses else ahead, v + h * v1, ambient + h * a1, u, s, p, e, o)
            arrived = n + 0.5 * h * (n1 + n2)
            if crosses:
                arrived = h * (1.0 - n / (n - ahead)) * n2
            elif arrived * n < 0.0 and dry_friction(0.0, e, o) > 0.0:
                arrived = 0.0
            lag_target = 0.5 * (n + arrived)
            n, v, ambient = arrived, v + 0.5 * h * (v1 + v2), ambient + 0.5 * h * (a1 + a2)
            tach = lag_target + (tach - lag_target) * keep_tach
            mean_force = 0.5 * (force + force2)
            if springy:
                load_f, load_f_rate = _moved(load_f, load_f_rate, mean_force, mode)
            if o.load_cell_creep != 0.0:
                creep += h / o.load_cell_creep_time * (mean_force - creep)
                creep_slow += h / (3.0 * o.load_cell_creep_time) * (mean_force - creep_slow)
            if o.tank_seiche != 0.0:
                sway, sway_rate = _moved(sway, sway_rate, o.tank_seiche * mean_force, swaying)
            stall_left = _STALL_TIME if abs(n1) > _STALL_RATE else stall_left - h
