r"""Stability of the sampled speed loop (4.24)-(4.26) about a steady speed, over delay and error of the input gain.

Rotor, linear about n_0:    d(n)/dt = -lambda n + g alpha(t - d),   lambda = k_n + k_Q dQ/dn   [1/s]
Law, every period h:        alpha_k = -(k_P + r - f lambda) n_k - k_I sigma_k,   sigma_k+1 = sigma_k + h n_k

g is the true input gain over the one that the law believes (1 where the map (3.9) is known), d the delay from the
measurement to the throttle [s], r = 1 / rate_time for the bench's dn_d/dt, else 0, f = 1 where the feed-forward takes
the measured speed. With d = m h + e, 0 <= e < h, the exact discrete form has the former throttles as states:

    n_k+1 = a n_k + g (b_0 alpha_k-m + b_1 alpha_k-m-1)
    a = e^{-lambda h},   b_0 = (1 - e^{-lambda (h - e)}) / lambda,   b_1 = (e^{-lambda (h - e)} - a) / lambda

The loop is stable while all eigenvalues lie inside the unit circle. Unlimited throttle, no change of sign of alpha.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_control.settings import Gains, RateForm
from thruster_model.equations.thruster import ThrusterCoefficients, rotor_acceleration, torque

__all__ = ["SpeedLoop", "largest_delay", "largest_gain", "spectral_radius", "speed_loop", "transition"]


class SpeedLoop(NamedTuple):
    """The linear loop: lambda [1/s], proportional gain on the measured speed [1/s], k_I [1/s^2], period h [s]."""

    rotor_rate: float
    gain: float
    k_I: float
    period: float


def speed_loop(p: ThrusterCoefficients, gains: Gains, *, n: float, period: float, v: float = 0.0) -> SpeedLoop:
    """Return the loop about the speed n [rad/s] at axial flow v [m/s], sampled every `period` [s]."""
    step = 1e-3 * max(1.0, abs(n))  # rad/s; the maps are quadratic, so that central differences are exact
    up, down = (float(rotor_acceleration(x, torque(x, v, p), 0.0, p)) for x in (n + step, n - step))
    rotor_rate = -(up - down) / (2.0 * step)
    gain = gains.k_P
    if gains.rate_form == RateForm.BENCH:
        gain += 1.0 / gains.rate_time
    if gains.on_estimate:
        gain -= rotor_rate
    return SpeedLoop(rotor_rate, gain, gains.k_I, period)


def transition(loop: SpeedLoop, *, gain: float = 1.0, delay: float = 0.0) -> NDArray[np.float64]:
    """Return the matrix that takes (n, sigma, alpha_k-1, ..., alpha_k-m-1) over one period, shape (m + 3, m + 3).

    Without sigma at k_I = 0.
    """
    if not (gain > 0.0 and 0.0 <= delay < np.inf and loop.period > 0.0):
        raise ValueError(f"expected gain > 0, delay >= 0 s and period > 0 s; found {gain}, {delay}, {loop.period}")
    h, rate = loop.period, loop.rotor_rate
    m = int(delay / h + 1e-9)
    rest = min(max(delay - m * h, 0.0), h)
    a, late = np.exp(-rate * h), np.exp(-rate * (h - rest))
    b_0, b_1 = ((1.0 - late) / rate, (late - a) / rate) if rate != 0.0 else (h - rest, rest)
    F = np.zeros((m + 3, m + 3))
    law = np.zeros(m + 3)
    law[:2] = -loop.gain, -loop.k_I
    F[0, 0] = a
    F[0] += gain * b_0 * (law if m == 0 else np.eye(m + 3)[m + 1])
    F[0, m + 2] += gain * b_1
    F[1, :2] = h, 1.0
    F[2] = law
    F[3:, 2:-1] = np.eye(m)
    if loop.k_I == 0.0:  # sigma is then not part of the loop; its eigenvalue of 1 would hide the others
        F = np.delete(np.delete(F, 1, axis=0), 1, axis=1)
    return F


def spectral_radius(loop: SpeedLoop, *, gain: float = 1.0, delay: float = 0.0) -> float:
    """Return the largest |z| of the loop; below 1 it is stable. `gain`: true over believed; `delay` [s]."""
    return float(np.max(np.abs(np.linalg.eigvals(transition(loop, gain=gain, delay=delay)))))


def largest_gain(loop: SpeedLoop, *, delay: float = 0.0, upper: float = 100.0) -> float:
    """Return the true input gain, over the believed one, from which the loop is unstable; `upper` where beyond it.

    NaN where the loop is unstable with the gain that it believes.
    """
    return _first_unstable(lambda g: spectral_radius(loop, gain=g, delay=delay), 1.0, upper, 1.02)


def largest_delay(loop: SpeedLoop, *, gain: float = 1.0, upper: float = 1.0) -> float:
    """Return the delay [s] from which the loop is unstable; `upper` where beyond it; NaN where it is without delay."""
    found = _first_unstable(lambda d: spectral_radius(loop, gain=gain, delay=d - 1.0), 1.0, 1.0 + upper, 0.0)
    return found - 1.0


def _first_unstable(radius, start, end, factor):  # type: ignore[no-untyped-def]
    """Return the first x in [start, end] with a radius of 1 or more: by a grid, then by bisection."""
    grid = (
        np.geomspace(start, end, int(np.log(end / start) / np.log(factor)) + 2)
        if factor
        else np.linspace(start, end, 401)
    )
    unstable = [i for i, x in enumerate(grid) if radius(x) >= 1.0]
    if not unstable:
        return float(end)
    if unstable[0] == 0:
        return float("nan")
    low, high = grid[unstable[0] - 1], grid[unstable[0]]
    while high - low > 1e-6 * max(1.0, high):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if radius(middle) >= 1.0 else (middle, high)
    return float(high)
