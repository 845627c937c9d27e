r"""Gains of the filter and the covariance of its innovations, from the motion, the model's slopes and the noises.

Error state x (16): turn theta of the body, nu, random wrench w, depth. With A the slope of the motion (`slopes`),

    P <- F P F^T + Q,   F = 1 + A h + (A h)^2 / 2,      w: keep = exp(-h / tau), Q_w = sigma^2 (1 - keep^2)
    S = H P H^T + R,    G = P H^T S^-1,   P <- (1 - G H) P

The rotors have a scalar filter each: their speed follows the throttle by k_n, and what disturbs it is white.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.rules import FASTEST, FLOW_TIME
from rov_sim.vehicle.innovations import CHANNELS, CORRECTED
from thruster_model.compilation import compiled
from thruster_model.vehicle_coefficients import VehicleCoefficients

__all__ = ["Gains", "Motion", "Noises", "filter_gains", "motion_of", "rotor_gains", "slopes"]

Array = NDArray[np.float64]
_UNSEEN = 1e12
_FIRST = np.array([0.05] * 3 + [0.3] * 3 + [0.1] * 3)
_DRIFT = np.array([1e-5] * 3 + [2e-4] * 3 + [2e-4] * 3)


class Noises(NamedTuple):
    """Deviations of the wrench (6,) [N, N m], its time [s], of the channels (13,), of the rotors' disturbance per
    period (N,) and of their tachometers (N,) [rad/s], of the battery's readings (2,) [V, A]."""

    wrench: Array
    time: float
    channels: Array
    rotor: Array
    speed: Array
    battery: Array


class Motion(NamedTuple):
    """How errors grow and show: F (K, 16, 16) but for the wrench's own, H (K, 13, 16), which channels tell (K, 13);
    what doubts about flows add to their variances (K, 13) and to the motion's (K, 6, 6), the period [s]."""

    F: Array
    H: Array
    there: NDArray[np.bool_]
    told: Array
    pushed: Array
    period: float

    def part(self, first: int, last: int) -> "Motion":
        """Return the instants from the first to before the last."""
        F, H, there, told, pushed, period = self
        at = slice(first, last)
        return Motion(F[at], H[at], there[at], told[at], pushed[at], period)


class Gains(NamedTuple):
    """Of one run: G (K, 16, 13); W (K, 13, 13), inverse of the factor of S; log |S|, sum over the run; spread of the
    wrench P_ww (K, 6) after correction; P (16, 16) at the end."""

    gains: Array
    whitener: Array
    log_determinant: float
    wrench_variance: Array
    last: Array


def _skew(a: Array) -> Array:
    out = np.zeros((*a.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2] = -a[..., 2], a[..., 1]
    out[..., 1, 0], out[..., 1, 2] = a[..., 2], -a[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -a[..., 1], a[..., 0]
    return out


def down_of(q: Array) -> Array:
    """Return the earth's down in body axes (K, 3) of attitudes (K, 4)."""
    w, x, y, z = q.T
    return np.stack((2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)), axis=1)


def slopes(
    q: Array, nu: Array, thrust: Array, c: VehicleCoefficients, imu: Array, log: Array, sensor: Array
) -> tuple[Array, Array]:  # fmt: skip
    """Return A (K, 16, 16) of the motion and H (K, 13, 16) of the channels.

    Args:
        q: attitudes (K, 4); nu: (K, 6).
        thrust: slopes of `inflow` (K, N): what water under way takes off a thrust holds a vehicle more than its hull
            does, and tells an accelerometer more of its speed.
        c: of the vehicle.
        imu, log, sensor: places of IMU, velocity log, depth sensor [m].
    """
    K = len(q)
    nu = np.clip(nu, -FASTEST, FASTEST)
    M = c.mass_matrix
    inverse = np.linalg.inv(M)
    down = down_of(q)
    v, omega = nu[:, :3], nu[:, 3:]
    momentum = nu @ M.T
    a, b = momentum[:, :3], momentum[:, 3:]
    turning = np.zeros((K, 6, 6))
    So, Sv = _skew(omega), _skew(v)
    turning[:, :3] = So @ M[:3]
    turning[:, 3:] = So @ M[3:] + Sv @ M[:3]
    turning[:, :3, 3:] -= _skew(a)
    turning[:, 3:, :3] -= _skew(a)
    turning[:, 3:, 3:] -= _skew(b)
    drag = c.D_L[None] + 2.0 * c.D_Q[None] * np.abs(nu)[:, None, :]
    drag = drag - c.K_t @ (thrust[:, :, None] * c.inflow.T)
    arm = c.weight * np.asarray(c.r_G) - c.buoyancy * np.asarray(c.r_B)
    Sd = _skew(down)
    righting = np.concatenate(((c.weight - c.buoyancy) * Sd, _skew(arm) @ Sd), axis=1)
    accelerated = np.zeros((K, 6, CORRECTED))
    accelerated[:, :, :3] = inverse @ righting
    accelerated[:, :, 3:9] = -inverse @ (drag + turning)
    accelerated[:, :, 9:15] = inverse
    A = np.zeros((K, CORRECTED, CORRECTED))
    A[:, :3, :3], A[:, :3, 6:9] = -So, np.eye(3)
    A[:, 3:9] = accelerated
    A[:, 15, 3:6] = down
    A[:, 15, :3] = np.cross(v, down)
    H = np.zeros((K, CHANNELS, CORRECTED))
    H[:, :3, :3] = np.eye(3)
    H[:, 3:6, 6:9] = np.eye(3)
    H[:, 6:9] = accelerated[:, :3] - _skew(imu[None]) @ accelerated[:, 3:]
    H[:, 6:9, 3:6] += So
    H[:, 6:9, 6:9] -= Sv
    H[:, 6:9, :3] -= 9.81 * Sd
    H[:, 9, 15] = 1.0
    H[:, 9, :3] = np.cross(sensor[None], down)
    H[:, 10:13, 3:6] = np.eye(3)
    H[:, 10:13, 6:9] = -_skew(log)
    return A, H


@compiled
def _riccati(F, H, Q, keep, pushed, R, P, first, gains, whitener, wrench_variance):  # type: ignore[no-untyped-def]
    """Fill gains (K, 16, 13), whiteners (K, 13, 13) and P_ww (K, 6); return log |S| and P at the end.

    With S = L L^T of the channels that tell and B = L^-1 H P: G = B^T L^-1 and P <- P - B^T B. Loops along rows cost
    less than products of matrices as small as these; the wrench's own rows of F are numbers.
    """
    K, m, n = H.shape[0], CHANNELS, CORRECTED
    P, total = P.copy(), 0.0
    told, told_of, FP, S, B, W, across = (
        np.empty((m, n)), np.empty((n, m)), np.empty((n, n)), np.empty((m, m)), np.empty((m, n)), np.empty((m, m)),
        np.empty((n, n)),
    )  # fmt: skip
    which, row = np.empty(m, dtype=np.intp), np.empty(n)
    for k in range(K):
        count = 0
        for j in range(m):
            if R[k, j] < _UNSEEN:
                which[count] = j
                count += 1
        for a in range(count):
            for c in range(n):
                told[a, c] = told_of[c, a] = H[k, which[a], c]
        for a in range(count):
            B[a] = 0.0
            for c in range(n):
                if told[a, c] != 0.0:
                    for d in range(n):
                        B[a, d] += told[a, c] * P[c, d]
            for b in range(count):
                S[a, b] = W[a, b] = 0.0
            for c in range(n):
                for b in range(a, count):
                    S[a, b] += B[a, c] * told_of[c, b]
            S[a, a] += R[k, which[a]]
            W[a, a] = 1.0
        for a in range(count):  # S becomes the transposed L, B and W what L^-1 makes of them
            if not S[a, a] > 0.0:
                raise ValueError("innovations without a covariance")
            scale = 1.0 / np.sqrt(S[a, a])
            if k >= first[which[a]]:
                total -= 2.0 * np.log(scale)
            for b in range(a, count):
                S[a, b] *= scale
            for d in range(n):
                B[a, d] *= scale
            for b in range(a + 1):
                W[a, b] *= scale
            for c in range(a + 1, count):
                share = S[a, c]
                for b in range(c, count):
                    S[c, b] -= share * S[a, b]
                for d in range(n):
                    B[c, d] -= share * B[a, d]
                for b in range(a + 1):
                    W[c, b] -= share * W[a, b]
        gains[k] = 0.0
        whitener[k] = 0.0
        for a in range(count):
            for d in range(n):
                row[d] = 0.0
            for c in range(a, count):
                whitener[k, which[c], which[a]] = W[c, a]
                for d in range(n):
                    row[d] += W[c, a] * B[c, d]
            for d in range(n):
                gains[k, d, which[a]] = row[d]
            for c in range(n):
                for d in range(n):
                    P[c, d] -= B[a, c] * B[a, d]
        for j in range(6):
            wrench_variance[k, j] = P[9 + j, 9 + j]
        for a in range(n):
            wanders = 9 <= a < 15
            for c in range(n):
                across[c, a] = keep * (a == c) if wanders else F[k, a, c]
            for d in range(n):
                FP[a, d] = keep * P[a, d] if wanders else 0.0
            if not wanders:
                for c in range(n):
                    share = F[k, a, c]
                    if share != 0.0:
                        for d in range(n):
                            FP[a, d] += share * P[c, d]
        for a in range(n):
            for d in range(n):
                P[a, d] = Q[a, d]
            if 9 <= a < 15:
                for d in range(9, 15):
                    P[a, d] += keep * FP[a, d]
                continue
            for c in range(n):
                share = FP[a, c]
                for d in range(n):
                    P[a, d] += share * across[c, d]
            if 3 <= a < 9:
                for d in range(3, 9):
                    P[a, d] += pushed[k, a - 3, d - 3]
        for a in range(n):  # the wrench's rows from the others'
            for d in range(a):
                if not 9 <= d < 15:
                    P[a, d] = P[d, a]
                elif not 9 <= a < 15:
                    P[d, a] = P[a, d]
    return total, P


def motion_of(A: Array, H: Array, there: NDArray[np.bool_], period: float, doubts: Array) -> Motion:
    """Return what gains are made of, whatever the noises.

    Args:
        A, H: `slopes`; there: (K, 13), which channels tell at which instant.
        period: of the instants [s].
        doubts: covariance (K, 6, 6) of a wrench that changes within `FLOW_TIME`.
    """
    step = A * period
    F = np.eye(CORRECTED) + step + 0.5 * step @ step
    told = np.einsum("kij,kjl,kil->ki", H[:, :, 9:15], doubts, H[:, :, 9:15])
    pushed = A[:, 3:9, 9:15] @ doubts @ A[:, 3:9, 9:15].transpose(0, 2, 1) * (2.0 * FLOW_TIME * period)
    return Motion(F, np.ascontiguousarray(H), there, told, np.ascontiguousarray(pushed), period)


def filter_gains(
    motion: Motion, noises: Noises, before: Array | None = None, first: NDArray[np.intp] | None = None
) -> Gains:  # fmt: skip
    """Return the gains of one run.

    Args:
        motion: along which the filter goes; noises: of it.
        before: covariance at the first instant (16, 16); None: little is known.
        first: instant from which on log |S| is summed up, of each channel (13,).
    """
    K = len(motion.F)
    keep = np.exp(-motion.period / noises.time)
    Q = np.diag(np.concatenate((_DRIFT**2, noises.wrench**2 * (1.0 - keep**2), [1e-10])))
    P = np.diag(np.concatenate((_FIRST**2, noises.wrench**2, [1.0]))) if before is None else before
    deviations = np.where(np.isfinite(noises.channels), noises.channels, 1.0)
    R = np.where(motion.there, deviations**2 + motion.told, _UNSEEN)
    made = np.empty((K, CORRECTED, CHANNELS)), np.empty((K, CHANNELS, CHANNELS))
    wrench = np.empty((K, 6))
    counted = np.zeros(CHANNELS, dtype=np.intp) if first is None else first
    total, last = _riccati(
        motion.F, motion.H, Q, keep, motion.pushed, R, np.ascontiguousarray(P), counted, *made, wrench
    )
    return Gains(*made, float(total), wrench, last)


def rotor_gains(
    there: NDArray[np.bool_], decay: Array, noises: Noises, before: Array | None = None
) -> tuple[Array, Array, Array]:
    """Return gains and deviations of the innovations of the tachometers, (K, N) each, and variances at the end (N,).

    Args:
        there: (K, N), which tell at which instant; decay: (N,), share of a disturbance left after a period.
        before: variances at the first instant (N,) [rad^2/s^2]; None: little is known.
    """
    R = np.where(np.isfinite(noises.speed), noises.speed, 1.0) ** 2
    P = np.full(there.shape[1], 25.0) if before is None else before
    return _rotor_gains(there, decay**2, R, noises.rotor**2, P)  # type: ignore[no-any-return]


@compiled
def _rotor_gains(there, decay_squared, R, Q, before):  # type: ignore[no-untyped-def]
    K, N = there.shape
    gains, spread, last = np.zeros((K, N)), np.ones((K, N)), before.copy()
    for i in range(N):
        for k in range(K):
            S = last[i] + R[i]
            spread[k, i] = np.sqrt(S)
            gains[k, i] = last[i] / S if there[k, i] else 0.0
            last[i] = decay_squared[i] * (1.0 - gains[k, i]) * last[i] + Q[i]
    return gains, spread, last
