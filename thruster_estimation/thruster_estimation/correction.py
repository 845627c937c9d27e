r"""Correction by one measurement at a time, the gate, the unsigned tachometer and the bounds of the covariance.

innovation   signed: z - n̂,   unsigned: sgn(n̂) z - n̂ with H = sgn(n̂), written here as a measurement of n itself
S = P_jj + r,   NIS = y^2 / S,   K = P e_j / S
correction   x += K y,   P <- (I - K e_j^T) P (I - K e_j^T)^T + r K K^T   (Joseph's form, for any K)

Gate. A measurement with NIS > gate is refused. After `patience` seconds of refusals in a row the belief, not the
measurement, is held to be wrong: P_jj is widened until NIS = gate, and the measurement is used.

Unsigned tachometer. It cannot tell n from -n. Where |n̂| is within its own deviation of zero, r is raised by the mean
square that a wrong sign adds under the belief, E[(sgn(n̂)|n| - n)^2]: 2 P at n̂ = 0, 0.3 P at |n̂| = sqrt(P). Farther
out the sign of the belief is trusted.

Ceilings. v is hardly observable, and near T = 0, v = 0 the linearisation grows: a deviation above its ceiling is
scaled down with its row and column, which keeps P positive semidefinite and the correlations what they are.
"""

from math import copysign, erfc, exp, isfinite, nan, pi, sqrt

from thruster_estimation.belief import Innovation
from thruster_estimation.matrices import Covariance, Matrix, congruent
from thruster_model.compilation import equation

__all__ = ["bounded", "corrected", "innovation_of", "speed_measured", "widening", "wrong_sign"]


@equation
def wrong_sign(n, P):  # type: ignore[no-untyped-def]
    """Return E[(sgn(n̂)|n| - n)^2] = 4 E[n^2; sgn n != sgn n̂] for n ~ N(n̂, P) [rad^2/s^2]."""
    m = abs(n) / sqrt(P)
    tail, density = 0.5 * erfc(m / sqrt(2.0)), exp(-0.5 * m * m) / sqrt(2.0 * pi)
    return 4.0 * P * ((1.0 + m * m) * tail - m * density)


@equation
def speed_measured(n, P, z, settings):  # type: ignore[no-untyped-def]
    """Return (y [rad/s], r [rad^2/s^2], ambiguous) of a tachometer's reading [rad/s]; y = NaN where it is unusable."""
    if not settings.unsigned:
        return (z - n if isfinite(z) else nan), settings.r_n, False
    if not (isfinite(z) and z >= 0.0):
        return nan, settings.r_n, False
    ambiguous = n * n < P
    r = settings.r_n + wrong_sign(n, P) if ambiguous else settings.r_n
    return copysign(1.0, n) * z - n, r, ambiguous


@equation
def widening(y, S, gate, shut, patience):  # type: ignore[no-untyped-def]
    """Return (used, what is added to P_jj): a gated measurement is used once the gate has been shut for too long."""
    if not isfinite(y):
        return False, 0.0
    if y * y <= gate * S:
        return True, 0.0
    if shut >= patience:
        return True, y * y / gate - S
    return False, 0.0


@equation
def corrected(n, v, U, P, y, r, of_speed, K_n, K_v, K_U):  # type: ignore[no-untyped-def]
    """Return (n, v, U, P) after a measurement of n (`of_speed`) or U with innovation y and gain K."""
    if of_speed:
        A = Matrix(1.0 - K_n, 0.0, 0.0, -K_v, 1.0, 0.0, -K_U, 0.0, 1.0)
    else:
        A = Matrix(1.0, 0.0, -K_n, 0.0, 1.0, -K_v, 0.0, 0.0, 1.0 - K_U)
    B = congruent(A, P)
    P = Covariance(
        B.nn + r * K_n * K_n,
        B.nv + r * K_n * K_v,
        B.nU + r * K_n * K_U,
        B.vv + r * K_v * K_v,
        B.vU + r * K_v * K_U,
        B.UU + r * K_U * K_U,
    )
    return n + K_n * y, v + K_v * y, U + K_U * y, P


@equation
def innovation_of(y_n, y_U, S_nn, S_nU, S_UU, used_n, used_U):  # type: ignore[no-untyped-def]
    """Return the `Innovation` of what was measured, used or not; y = NaN: not measured, S = NaN: no variance."""
    has_n, has_U = isfinite(y_n) and isfinite(S_nn), isfinite(y_U) and isfinite(S_UU)
    nis_n = y_n * y_n / S_nn if has_n else nan
    nis_U = y_U * y_U / S_UU if has_U else nan
    nis = nis_n if has_n else nis_U
    if has_n and has_U:
        rest = y_U - S_nU / S_nn * y_n
        nis = nis_n + rest * rest / (S_UU - S_nU * S_nU / S_nn)
    return Innovation(
        y_n, y_U, S_nn, S_nU, S_UU, nis_n, nis_U, nis,
        int(has_n) + int(has_U), int(used_n), int(used_U),
        int(isfinite(y_n) and not used_n), int(isfinite(y_U) and not used_U),
    )  # fmt: skip


@equation
def bounded(P, largest_n, largest_v, largest_U):  # type: ignore[no-untyped-def]
    """Return (P, whether a deviation was above its ceiling)."""
    a = largest_n / sqrt(P.nn) if P.nn > largest_n * largest_n else 1.0
    b = largest_v / sqrt(P.vv) if P.vv > largest_v * largest_v else 1.0
    c = largest_U / sqrt(P.UU) if largest_U * largest_U < P.UU else 1.0
    if a == 1.0 and b == 1.0 and c == 1.0:
        return P, False
    return Covariance(a * a * P.nn, a * b * P.nv, a * c * P.nU, b * b * P.vv, b * c * P.vU, c * c * P.UU), True
