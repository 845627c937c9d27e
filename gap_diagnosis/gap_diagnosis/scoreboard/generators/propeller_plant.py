r"""The plant of the propeller's simulator: blades as airfoils (4.6) to (4.11), by the midpoint rule at 0.4 ms.

    theta = atan2(v, 0.7 R n), q = rho pi R^2 V^2 / 2, L = q C_L sin 2(p - theta), D = q C_D (1 - cos 2(p - theta))
    T = L cos theta - D sin theta, Q = 0.7 R (L sin theta + D cos theta)

over the thesis' rotor and water.
"""

import math

import numpy as np

from thruster_model.compilation import compiled

__all__ = ["SKIP", "STEP", "go"]

STEP = 4e-4  # [s]
SKIP = 5
"""Steps between stored outputs: 2 ms."""


@compiled
def go(c, e, b, t_c, u_c, straight, start, steps, shove, plug, keep):  # type: ignore[no-untyped-def]
    """Fill `keep` (4, M) from time 0 on. c: coefficients, e: effects in the plant, b: forms and what is beyond."""
    x = np.zeros(6)  # motor's and propeller's n, v, U, twist of the shaft, slosh rate
    slosh = 0.0
    warm = slow = u = run_u = high = 0.0
    if start < 0.0:
        u = run_u = slow = u_c[0]
    at = 0
    spring = b[4] > 0.0
    k_s = (2.0 * math.pi * b[4]) ** 2
    for i in range(steps + 1):
        t = start + i * STEP
        when = t - e[0]
        j = int(np.searchsorted(t_c, when + 1e-9, side="right")) - 1
        wish = u_c[0]
        if j >= 0:
            wish = u_c[j]
            if straight and j + 1 < t_c.size:
                wish += (u_c[j + 1] - u_c[j]) / (t_c[j + 1] - t_c[j]) * (when - t_c[j])
        if e[4] > 0.0:
            wish = e[4] * math.floor(wish / e[4] + 0.5)
        wish = max(-e[3], min(e[3], wish))
        run_u += max(-e[2] * STEP, min(e[2] * STEP, wish - run_u))
        slow = run_u if e[1] == 0.0 else slow + (run_u - slow) * (1.0 - math.exp(-STEP / e[1]))
        u_next = u + max(-c[4] * STEP, min(c[4] * STEP, slow - u))
        y = x.copy()
        force = moment = 0.0
        for stage in range(2):
            w = u if stage == 0 else 0.5 * (u + u_next)
            n, prop, v, U = y[0], (y[1] if spring else y[0]), y[2], y[3]
            ease = e[12] if abs(n) > b[0] else 0.0
            lo, hi = min(c[2] - e[5] + ease, 0.0), max(c[3] + e[5] - ease, 0.0)
            drive = 0.0
            if w < lo:
                drive = c[0] * (w - lo)
            elif w > hi:
                drive = c[1] * (w - hi)
            drive *= (1.0 - e[6]) * (1.0 - e[8] * warm) * (1.0 - plug[i])
            if e[7] > 0.0:
                most = max(c[1] * (5.0 - c[3]), c[0] * (5.0 + c[2]))
                drive *= max(0.0, 1.0 - e[7] * abs(drive * n) * c[5] / (most * most))
            if b[5] > 0.0 and abs(n) > b[5] and drive * n > 0.0:
                drive *= max(0.0, 1.0 - 0.15 * (abs(n) - b[5]))
            water = U + e[18]
            tip = 0.7 * c[7] * prop
            theta = math.atan2(v, tip)
            q = 0.5 * c[8] * math.pi * c[7] ** 2 * (v * v + tip * tip)
            lift, drag = q * c[10] * math.sin(2.0 * (c[9] - theta)), q * c[11] * (1.0 - math.cos(2.0 * (c[9] - theta)))
            force = lift * math.cos(theta) - drag * math.sin(theta)
            moment = 0.7 * c[7] * (lift * math.sin(theta) + drag * math.cos(theta))
            force *= (1.0 - e[13]) * (1.0 - e[15]) * (1.0 - (e[14] if prop < 0.0 else 0.0)) * (1.0 - b[7] * high)
            moment *= 1.0 + e[15]
            if e[17] > 0.0 and abs(prop) > e[20]:
                force *= max(0.0, 1.0 - e[17] * (abs(prop) - e[20]) / e[20])
            load = c[6] * moment
            rub = e[9] * (2.0 / math.pi) * math.atan(n / b[1])
            if spring:
                d0 = drive - c[5] * (1.0 + e[10]) * n - rub - 0.35 * k_s * y[4]
                d1 = (0.35 * k_s * y[4] - load) / 0.35 + 0.2 * math.sqrt(k_s) * (n - prop)
                d4 = n - prop
            else:
                d0, d1, d4 = drive - c[5] * (1.0 + e[10]) * n - rub - load, 0.0, 0.0
            d0 /= 1.0 + e[11]
            force -= e[16] * (d1 if spring else d0)
            d2 = (-c[12] * v - c[13] * abs(v) * (v - c[14] * water) + c[15] * force) / (1.0 + e[19])
            d3 = -c[16] * U - c[17] * U * abs(U) + c[18] * force + slosh
            if stage == 0:
                if t > -1e-9 and i % SKIP == 0 and at < keep.shape[1]:
                    keep[0, at], keep[1, at], keep[2, at], keep[3, at] = prop, water, force, moment
                    at += 1
                h = 0.5 * STEP
                y = x + h * np.array([d0, d1, d2, d3, d4, 0.0])
            else:
                x = x + STEP * np.array([d0 + shove[0, i], d1, d2, d3 + shove[1, i], d4, 0.0])
        if b[6] > 0.0:
            x[5] += STEP * (b[6] * force * 1.57 - 2.467 * slosh - 0.2 * x[5])
            slosh += STEP * x[5]
        warm += STEP / e[21] * ((abs(u_next) / 5.0) ** b[2] - warm)
        high += STEP / 3.0 * (min(abs(x[0]) / 100.0, 1.0) - high)
        u = u_next
