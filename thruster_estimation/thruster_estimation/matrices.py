r"""Three by three matrices over the states n, v, U as named tuples, so that kernels keep them in registers."""

from typing import NamedTuple

from thruster_model.compilation import equation

__all__ = ["Covariance", "Matrix", "congruent", "exponential", "product"]


class Matrix(NamedTuple):
    """Entries row by row; `nv` maps v [m/s] to n [rad/s]."""

    nn: float
    nv: float
    nU: float
    vn: float
    vv: float
    vU: float
    Un: float
    Uv: float
    UU: float


class Covariance(NamedTuple):
    """Upper triangle of a symmetric matrix [rad^2/s^2, rad m/s^2, m^2/s^2]."""

    nn: float
    nv: float
    nU: float
    vv: float
    vU: float
    UU: float


@equation
def product(a, b):  # type: ignore[no-untyped-def]
    """Return the matrix A B."""
    return Matrix(
        a.nn * b.nn + a.nv * b.vn + a.nU * b.Un,
        a.nn * b.nv + a.nv * b.vv + a.nU * b.Uv,
        a.nn * b.nU + a.nv * b.vU + a.nU * b.UU,
        a.vn * b.nn + a.vv * b.vn + a.vU * b.Un,
        a.vn * b.nv + a.vv * b.vv + a.vU * b.Uv,
        a.vn * b.nU + a.vv * b.vU + a.vU * b.UU,
        a.Un * b.nn + a.Uv * b.vn + a.UU * b.Un,
        a.Un * b.nv + a.Uv * b.vv + a.UU * b.Uv,
        a.Un * b.nU + a.Uv * b.vU + a.UU * b.UU,
    )


@equation
def congruent(a, P):  # type: ignore[no-untyped-def]
    """Return A P A^T, symmetric by construction."""
    b = product(a, Matrix(P.nn, P.nv, P.nU, P.nv, P.vv, P.vU, P.nU, P.vU, P.UU))
    return Covariance(
        b.nn * a.nn + b.nv * a.nv + b.nU * a.nU,
        b.nn * a.vn + b.nv * a.vv + b.nU * a.vU,
        b.nn * a.Un + b.nv * a.Uv + b.nU * a.UU,
        b.vn * a.vn + b.vv * a.vv + b.vU * a.vU,
        b.vn * a.Un + b.vv * a.Uv + b.vU * a.UU,
        b.Un * a.Un + b.Uv * a.Uv + b.UU * a.UU,
    )


@equation
def _shifted(a, s):  # type: ignore[no-untyped-def]
    """Return I + s A."""
    return Matrix(
        1.0 + s * a.nn, s * a.nv, s * a.nU, s * a.vn, 1.0 + s * a.vv, s * a.vU, s * a.Un, s * a.Uv, 1.0 + s * a.UU
    )


@equation
def exponential(a, h):  # type: ignore[no-untyped-def]
    """Return e^{A h} by its Taylor polynomial of fourth order, the order of RK4: for |A h| well below 1."""
    q = _shifted(a, h / 4.0)
    q = _shifted(product(a, q), h / 3.0)
    q = _shifted(product(a, q), h / 2.0)
    return _shifted(product(a, q), h)
