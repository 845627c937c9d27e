r"""A vehicle's world that shares no code with the plant: momentum in place of velocity, a matrix in place of a
quaternion, forces at places in place of a configuration matrix, Heun's steps with rotors integrated exactly at the
middle of each step: all of second order, so that no error of a step passes for a late sensor.

    d a = f - w x a,   d b = m - w x b - v x a,     (a, b) = M (v, w): momentum in body axes, v relative to the water
    dR = R S(w),       f = sum e_i T_i + ...,       m = sum r_i x e_i T_i + ...

Row i of `thrusters`: r (3), e (3), c_u1, c_u2, d_1, d_2, k_n, k_Q c_Q, c_T, c_nv, c_v, k_v, k_Uv, k_w, k_Tv, hand,
then what may be wrong with it: share of thrust, of reverse thrust, delay [steps], lag [s], coulomb [rad/s^2], turning,
hull axis, hull share, cavitation share, cavitation onset [rad/s], fade share, fade time [s], torque on the vehicle
[N m s^2], when its share of thrust begins to count [s]. Last, what it draws at full: |drive n| [rad^2/s^3].
"""

import numpy as np

from thruster_model.compilation import compiled

__all__ = ["COLUMNS", "STEP", "run_world"]

STEP = 0.002  # s
STREAM, STIRRED = 0.02, 1e-3  # m/s: in which stream an idle thruster leaves v = 0, and by what
COLUMNS = (
    "rx", "ry", "rz", "ex", "ey", "ez", "c_u1", "c_u2", "d_1", "d_2", "k_n", "k_q", "c_T", "c_nv", "c_v", "k_v", "k_Uv",
    "k_w", "k_Tv", "hand", "share", "reverse", "delay", "lag", "coulomb", "turning", "hull_axis", "hull_share",
    "cav_share", "cav_onset", "fade", "fade_time", "torque", "since", "power",
)  # fmt: skip
(RX, _, _, EX, _, _, CU1, CU2, D1, D2, KN, KQ, CT, CNV, CV, KV, KUV, KW, KTV, HAND,
 SHARE, REVERSE, DELAY, LAG, COULOMB, TURNING, HULL_AXIS, HULL_SHARE, CAV_SHARE, CAV_ONSET, FADE, FADE_TIME,
 TORQUE, SINCE, POWER) = range(35)  # fmt: skip


@compiled
def _crossed(a, b):  # type: ignore[no-untyped-def]
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@compiled
def _times(A, x, out):  # type: ignore[no-untyped-def]
    """Fill out with A x."""
    for i in range(len(out)):
        total = 0.0
        for j in range(len(x)):
            total += A[i, j] * x[j]
        out[i] = total


@compiled
def _velocity_at(place, nu):  # type: ignore[no-untyped-def]
    """Return the velocity of a place on the body."""
    round_it = _crossed(nu[3:], place)
    return nu[0] + round_it[0], nu[1] + round_it[1], nu[2] + round_it[2]


@compiled
def _pull_at(place, pull, out):  # type: ignore[no-untyped-def]
    """Add a force at a place to force and moment on the body."""
    moment = _crossed(place, pull)
    for i in range(3):
        out[i] += pull[i]
        out[3 + i] += moment[i]


@compiled
def _forces(  # type: ignore[no-untyped-def]
    R, nu, T, n, thrusters, D_L, D_Q, weight, buoyancy, r_G, r_B, tether, ram, interaction, wrench, out
):  # fmt: skip
    """Fill out with force and moment on the body."""
    down = R[2]
    for i in range(6):
        held = 0.0
        for j in range(6):
            held += (D_L[i, j] + D_Q[i, j] * abs(nu[j])) * nu[j]
        out[i] = wrench[i] - held
    heavy, light = _crossed(r_G, down), _crossed(r_B, down)
    for i in range(3):
        out[i] += (weight - buoyancy) * down[i]
        out[3 + i] += weight * heavy[i] - buoyancy * light[i]
    for i in range(len(T)):
        row = thrusters[i]
        left = 1.0
        for j in range(len(T)):
            left -= interaction[j, i] * abs(T[j])
        push = T[i] * left
        torque = row[HAND] * row[TORQUE] * n[i] * abs(n[i])
        e = row[EX : EX + 3]
        arm = _crossed(row[RX : RX + 3], e)
        axis = int(row[HULL_AXIS])
        for j in range(3):
            straight, turned = push * e[j], push * arm[j]
            out[j] += straight * (1.0 - row[HULL_SHARE]) if j == axis else straight
            out[3 + j] += turned * (1.0 - row[HULL_SHARE]) if 3 + j == axis else turned
            out[3 + j] -= e[j] * torque
        if ram > 0.0:
            place = row[RX : RX + 3]
            lost = _crossed(_crossed(e, _velocity_at(place, nu)), e)  # across the axis
            size = -ram * np.sqrt(abs(push))
            _pull_at(place, (size * lost[0], size * lost[1], size * lost[2]), out)
    if tether[0] != 0.0:
        at = tether[1:4]
        here = _velocity_at(at, nu)
        size = -tether[0] * np.sqrt(here[0] ** 2 + here[1] ** 2 + here[2] ** 2)
        _pull_at(at, (size * here[0], size * here[1], size * here[2]), out)


@compiled
def _slope(nu, momentum, forces, out):  # type: ignore[no-untyped-def]
    """Fill out with the momentum's rate in turning axes under forces."""
    v, w, a, b = nu[:3], nu[3:], momentum[:3], momentum[3:]
    w_a, w_b, v_a = _crossed(w, a), _crossed(w, b), _crossed(v, a)
    for i in range(3):
        out[i] = forces[i] - w_a[i]
        out[3 + i] = forces[3 + i] - w_b[i] - v_a[i]


@compiled
def _push(p, n, v):  # type: ignore[no-untyped-def]
    """Return the thrust of a thruster [N], before its share, at a rotor speed [rad/s] and an axial flow [m/s]."""
    push = p[CT] * n * abs(n) - p[CNV] * abs(n) * v - p[CV] * v * abs(v)
    push *= p[REVERSE] if n < 0.0 else 1.0
    return push * (1.0 - p[CAV_SHARE] * max(0.0, abs(n) - p[CAV_ONSET]) / p[CAV_ONSET])


@compiled
def run_world(  # type: ignore[no-untyped-def]
    commands, steps, thrusters, M, D_L, D_Q, weight, buoyancy, r_G, r_B, current, tether, ram, interaction, sag,
    wiring, sign, sliding, wrench, position, R, gains, wanted, feedback_noise, rest, out, out_n, sent, supply,
):  # fmt: skip
    """Fill out (K steps + 1, 24) with position, R, v over ground, w, dv, dw at each step; out_n with rotor speeds;
    sent (K, N): commands with feedback; supply (K steps + 1, 2): relative voltage and load.

    commands (K, N) [V]; gains (N, 12): of feedback on errors of turn, rate, depth; wanted (K, 4): roll, pitch, yaw,
    depth; wiring, sign (N,): whose command each thruster gets, and +1 or -1, what it makes of it; sliding (2,):
    moment [N m] of water in the hull that slides to the lower side, per sine of a tilt, and its time [s]; rest: the
    battery's relative voltage at rest as the run begins, and by how much it falls in a second.
    """
    K, N = commands.shape
    inverse = np.linalg.inv(M)
    h = STEP
    momentum, n, va, u, heat, T = np.zeros(6), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N), np.zeros(N)
    nu, nu2, slope, later, forces, trial = (
        np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6), np.zeros(6)
    )  # fmt: skip
    R, turned, position = R.copy(), np.zeros((3, 3)), position.copy()
    past, slid, pushed = np.zeros((N, 400)), R[2, :2].copy(), np.zeros(6)
    now = 0
    for k in range(K):
        _times(inverse, momentum, nu)
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
            _times(inverse, momentum, nu)
            out_n[at] = n
            load = 0.0
            for i in range(N):
                p = thrusters[i]
                edge = p[CU2] * max(u[i] - p[D2], 0.0) + p[CU1] * max(p[D1] - u[i], 0.0)
                load += edge * (1.0 - p[FADE] * heat[i]) * abs(n[i]) / p[POWER]
            volt = max((rest[0] - rest[1] * at * h) * (1.0 - sag * load / N), 0.0)
            supply[at, 0], supply[at, 1] = volt, load / N
            for i in range(N):
                p = thrusters[i]
                past[i, now % 400] = sign[i] * sent[k, int(wiring[i])]
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
                moved = _crossed(nu[3:], p[RX : RX + 3])
                U = p[EX] * (nu[0] + moved[0]) + p[EX + 1] * (nu[1] + moved[1]) + p[EX + 2] * (nu[2] + moved[2])
                middle = 0.5 * (before + n[i])
                if n[i] == 0.0 and va[i] == 0.0 and abs(U) > STREAM:
                    va[i] = STIRRED * np.sign(U)
                flow = va[i]
                for part in (0.5 * h, h):
                    push = _push(p, middle, flow)
                    if now * h >= p[SINCE]:
                        push *= p[SHARE]
                    change = -p[KV] * flow - p[KUV] * abs(flow) * (flow - p[KW] * U) + p[KTV] * push
                    flow = va[i] + part * change
                T[i], va[i] = push, flow
            now += 1
            for i in range(3):
                out[at, i] = position[i]
                out[at, 15 + i] = nu[3 + i]
                out[at, 12 + i] = nu[i]
                for j in range(3):
                    out[at, 3 + 3 * i + j] = R[i, j]
                    out[at, 12 + i] += R[j, i] * current[j]
            for j in range(2):
                slid[j] += (R[2, j] - slid[j]) * (1.0 - np.exp(-h / sliding[1]))
            pushed[:] = wrench[k]
            pushed[3] += sliding[0] * slid[1]
            pushed[4] -= sliding[0] * slid[0]
            _forces(
                R, nu, T, n, thrusters, D_L, D_Q, weight, buoyancy, r_G, r_B, tether, ram, interaction, pushed,
                forces,
            )  # fmt: skip
            _slope(nu, momentum, forces, slope)
            for i in range(6):
                trial[i] = momentum[i] + h * slope[i]
            _times(inverse, trial, nu2)
            half = 0.5 * h
            _turn(R, half * (nu[3] + nu2[3]), half * (nu[4] + nu2[4]), half * (nu[5] + nu2[5]), turned)
            _forces(
                turned, nu2, T, n, thrusters, D_L, D_Q, weight, buoyancy, r_G, r_B, tether, ram, interaction, pushed,
                forces,
            )  # fmt: skip
            _slope(nu2, trial, forces, later)
            for i in range(6):
                momentum[i] += half * (slope[i] + later[i])
            _times(inverse, momentum, nu2)
            for i in range(3):
                for j in range(3):
                    position[i] += half * R[i, j] * (nu[j] + nu2[j])
                position[i] += h * current[i]
            R[:] = turned
            if not np.all(np.isfinite(momentum)):
                return k
    return K


@compiled
def _turn(R, x, y, z, out):  # type: ignore[no-untyped-def]
    """Fill out with a matrix after a turn about the rotation vector (x, y, z) of its own axes."""
    square = x * x + y * y + z * z
    angle = np.sqrt(square)
    a = np.sin(angle) / angle if angle > 1e-9 else 1.0
    b = (1.0 - np.cos(angle)) / square if angle > 1e-9 else 0.5
    for i in range(3):
        p, q, r = R[i, 0], R[i, 1], R[i, 2]
        along = b * (p * x + q * y + r * z)
        out[i, 0] = p * (1.0 - b * square) + along * x + a * (q * z - r * y)
        out[i, 1] = q * (1.0 - b * square) + along * y + a * (r * x - p * z)
        out[i, 2] = r * (1.0 - b * square) + along * z + a * (p * y - q * x)
