r"""A vehicle's world that shares no code with the plant: momentum in place of velocity, a matrix in place of a
quaternion, forces at places in place of a configuration matrix, Heun's steps with rotors integrated exactly at the
middle of each step: all of second order, so that no error of a step passes for a late sensor.

    d a = f - w x a,   d b = m - w x b - v x a,     (a, b) = M (v, w): momentum in body axes, v relative to the water
    dR = R S(w),       f = sum e_i T_i + ...,       m = sum r_i x e_i T_i + ...

Row i of `thrusters`: r (3), e (3), c_u1, c_u2, d_1, d_2, k_n, k_Q c_Q, c_T, c_nv, c_v, k_v, k_Uv, k_w, k_Tv, hand,
then what may be wrong with it: share of thrust, of reverse thrust, delay [steps], lag [s], coulomb [rad/s^2], turning,
hull axis, hull share, cavitation share, cavitation onset [rad/s], fade share, fade time [s], torque on the vehicle
[N m s^2], when its share of thrust begins to count [s].
"""

import numpy as np

from thruster_model.compilation import compiled

__all__ = ["COLUMNS", "STEP", "run_world"]

STEP = 0.002  # s
COLUMNS = (
    "rx", "ry", "rz", "ex", "ey", "ez", "c_u1", "c_u2", "d_1", "d_2", "k_n", "k_q", "c_T", "c_nv", "c_v", "k_v", "k_Uv",
    "k_w", "k_Tv", "hand", "share", "reverse", "delay", "lag", "coulomb", "turning", "hull_axis", "hull_share",
    "cav_share", "cav_onset", "fade", "fade_time", "torque", "since",
)  # fmt: skip
(RX, _, _, EX, _, _, CU1, CU2, D1, D2, KN, KQ, CT, CNV, CV, KV, KUV, KW, KTV, HAND,
 SHARE, REVERSE, DELAY, LAG, COULOMB, TURNING, HULL_AXIS, HULL_SHARE, CAV_SHARE, CAV_ONSET, FADE, FADE_TIME,
 TORQUE, SINCE) = range(34)  # fmt: skip


@compiled
def _cross(a, b):  # type: ignore[no-untyped-def]
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@compiled
def _forces(  # type: ignore[no-untyped-def]
    R, v, w, T, n, thrusters, D_L, D_Q, weight, buoyancy, r_G, r_B, tether, interaction
):
    """Return (f, m) on the body."""
    down = R[2]
    nu = np.concatenate((v, w))
    held = -(D_L @ nu) - D_Q @ (np.abs(nu) * nu)
    f = held[:3] + (weight - buoyancy) * down
    m = held[3:] + _cross(r_G, weight * down) - _cross(r_B, buoyancy * down)
    for i in range(len(T)):
        row = thrusters[i]
        left = 1.0
        for j in range(len(T)):
            left -= interaction[j, i] * abs(T[j])
        push = row[EX : EX + 3] * T[i] * left
        arm = _cross(row[RX : RX + 3], push)
        whole = np.concatenate((push, arm))
        axis = int(row[HULL_AXIS])
        if axis >= 0:
            whole[axis] *= 1.0 - row[HULL_SHARE]
        f += whole[:3]
        m += whole[3:]
        m -= row[EX : EX + 3] * row[HAND] * row[TORQUE] * n[i] * abs(n[i])
    at = tether[1:4]
    here = v + _cross(w, at)
    pull = -tether[0] * np.sqrt((here * here).sum()) * here
    return f + pull, m + _cross(at, pull)


@compiled
def _push(p, n, v):  # type: ignore[no-untyped-def]
    """Return the thrust of a thruster [N], before its share, at a rotor speed [rad/s] and an axial flow [m/s]."""
    push = p[CT] * n * abs(n) - p[CNV] * abs(n) * v - p[CV] * v * abs(v)
    push *= p[REVERSE] if n < 0.0 else 1.0
    return push * (1.0 - p[CAV_SHARE] * max(0.0, abs(n) - p[CAV_ONSET]) / p[CAV_ONSET])


@compiled
def run_world(  # type: ignore[no-untyped-def]
    commands, steps, thrusters, M, D_L, D_Q, weight, buoyancy, r_G, r_B, current, tether, interaction, sag, wiring,
    wrench, position, R, gains, wanted, feedback_noise, out, out_n, sent, supply,
):  # fmt: skip
    """Fill out (K steps + 1, 24) with position, R, v over ground, w, dv, dw at each step; out_n with rotor speeds;
    sent (K, N): commands with feedback; supply (K steps + 1, 2): relative voltage and load.

    commands (K, N) [V]; gains (N, 12): of feedback on errors of turn, rate, depth; wanted (K, 4): roll, pitch, yaw,
    depth.
    """
    K, N = commands.shape
    inverse = np.linalg.inv(M)
    h = STEP
    momentum, n, va, u, heat, T = np.zeros(6), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N)
    past = np.zeros((N, 400))
    now = 0
    full = np.zeros(N)
    for i in range(N):
        p = thrusters[i]
        full[i] = p[CU2] * (5.0 - p[D2]) / p[KN]
    for k in range(K):
        nu = inverse @ momentum
        roll = np.arctan2(R[2, 1], R[2, 2])
        pitch = -np.arcsin(min(max(R[2, 0], -1.0), 1.0))
        yaw = np.arctan2(R[1, 0], R[0, 0])
        off = np.zeros(12)
        off[0], off[1] = wanted[k, 0] - roll, wanted[k, 1] - pitch
        off[2] = np.arctan2(np.sin(wanted[k, 2] - yaw), np.cos(wanted[k, 2] - yaw))
        off[3:6] = -nu[3:]
        off[6] = wanted[k, 3] - position[2]
        off[7] = -(R[2] * nu[:3]).sum()
        off = off + feedback_noise[k]
        for i in range(N):
            total = commands[k, i] + (gains[i] * off).sum()
            if total != 0.0:
                total += 0.85 * np.sign(total)
            sent[k, i] = min(max(total, -4.9), 4.9) if abs(total) > 0.86 else 0.0
        for s in range(steps):
            at = k * steps + s
            nu = inverse @ momentum
            v, w = nu[:3], nu[3:]
            drift = R.T @ current
            out_n[at] = n
            load = 0.0
            for i in range(N):
                p = thrusters[i]
                edge = u[i] - p[D2] if u[i] > p[D2] else (p[D1] - u[i] if u[i] < p[D1] else 0.0)
                load += p[CU2] * edge / (p[CU2] * (5.0 - p[D2])) * abs(n[i]) / full[i]
            volt = max(1.0 - sag * load / N, 0.0)
            supply[at, 0], supply[at, 1] = volt, load / N
            for i in range(N):
                p = thrusters[i]
                past[i, now % 400] = sent[k, int(wiring[i])]
                begun = u[i]
                asked = past[i, (now - int(p[DELAY])) % 400] if now >= int(p[DELAY]) else 0.0
                if p[LAG] > 0.0:
                    u[i] += (1.0 - np.exp(-h / p[LAG])) * (asked - u[i])
                else:
                    u[i] += min(max(asked - u[i], -100.0 * h), 100.0 * h)
                heat[i] += h * (abs(u[i]) / 5.0 - heat[i]) / p[FADE_TIME]
                drive = 0.0
                acting = 0.5 * (begun + u[i])
                if acting > p[D2]:
                    drive = p[CU2] * (acting - p[D2])
                elif acting < p[D1]:
                    drive = p[CU1] * (acting - p[D1])
                drive *= volt * (1.0 - p[FADE] * heat[i])
                if p[COULOMB] > 0.0:
                    if n[i] == 0.0 and abs(drive) <= p[COULOMB]:
                        drive = 0.0
                    else:
                        moving = n[i] if n[i] != 0.0 else drive
                        drive -= p[COULOMB] * np.sign(moving)
                before = n[i]
                rate = p[KN] + p[KQ] * abs(before)
                rate = p[KN] + p[KQ] * abs(drive / rate + (before - drive / rate) * np.exp(-0.5 * rate * h))
                n[i] = p[TURNING] * (drive / rate + (n[i] - drive / rate) * np.exp(-rate * h))
                if p[COULOMB] > 0.0 and before * n[i] < 0.0:
                    n[i] = 0.0
                U = (p[EX : EX + 3] * (v + _cross(w, p[RX : RX + 3]))).sum()
                middle = 0.5 * (before + n[i])
                flow = va[i]
                for part in (0.5 * h, h):
                    push = _push(p, middle, flow)
                    if now * h >= p[SINCE]:
                        push *= p[SHARE]
                    change = -p[KV] * flow - p[KUV] * abs(flow) * (flow - p[KW] * U) + p[KTV] * push
                    flow = va[i] + part * change
                T[i], va[i] = push, flow
            now += 1
            f, m = _forces(R, v, w, T, n, thrusters, D_L, D_Q, weight, buoyancy, r_G, r_B, tether, interaction)
            f, m = f + wrench[k, :3], m + wrench[k, 3:]
            a, b = momentum[:3], momentum[3:]
            slope = np.concatenate((f - _cross(w, a), m - _cross(w, b) - _cross(v, a)))
            trial = inverse @ (momentum + h * slope)
            v2, w2 = trial[:3], trial[3:]
            turned = R @ _turn(0.5 * h * (w + w2))
            f2, m2 = _forces(turned, v2, w2, T, n, thrusters, D_L, D_Q, weight, buoyancy, r_G, r_B, tether, interaction)
            f2, m2 = f2 + wrench[k, :3], m2 + wrench[k, 3:]
            a2, b2 = momentum[:3] + h * slope[:3], momentum[3:] + h * slope[3:]
            later = np.concatenate((f2 - _cross(w2, a2), m2 - _cross(w2, b2) - _cross(v2, a2)))
            out[at, :3] = position
            out[at, 3:12] = R.copy().ravel()
            out[at, 12:15], out[at, 15:18] = v + drift, w
            momentum = momentum + 0.5 * h * (slope + later)
            nu2 = inverse @ momentum
            position = position + h * (R @ (0.5 * (v + nu2[:3])) + current)
            R = turned
            if not np.all(np.isfinite(momentum)):
                return k
    return K


@compiled
def _turn(x):  # type: ignore[no-untyped-def]
    """Return the matrix of a rotation vector."""
    angle = np.sqrt((x * x).sum())
    S = np.array([[0.0, -x[2], x[1]], [x[2], 0.0, -x[0]], [-x[1], x[0], 0.0]])
    if angle < 1e-9:
        return np.eye(3) + S
    return np.eye(3) + np.sin(angle) / angle * S + (1.0 - np.cos(angle)) / angle**2 * (S @ S)
