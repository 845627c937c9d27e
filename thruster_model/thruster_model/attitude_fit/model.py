r"""Attitude rates of a vehicle without measured linear velocity: the rotational part of (2.7), axis by axis.

State omega = (p, q, r) [rad/s], gamma: unit vector of gravity in body axes; input tau = lower rows of K_t times the
thrusts [N m], each axis behind a lag. Per axis i, everything over that axis' inertia (added water included):

    d omega_i/dt = - damping_i omega_i - quadratic_i omega_i |omega_i| + effectiveness_i tau_i + bias_i
                   + righting_i (-gamma_y, gamma_x, 0)_i + coupling_i(omega)
    d gamma/dt = - omega x gamma
    d tau_i/dt = (commanded_i - tau_i) / lag_i
    coupling = ((I_y - I_z) q r / I_x, (I_z - I_x) p r / I_y, (I_x - I_y) p q / I_z)

righting > 0: the centre of buoyancy lies above that of gravity. Attitude enters through gamma alone, so neither a pitch
of 90 degrees nor an angle that wraps is special, and yaw needs none. What linear velocity does (moments of drag and of
added mass in a stream, thrust lost in a stream) is missing.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.compilation import compiled, equation

__all__ = ["AXES", "DEFINITIONS", "NAMES", "Definition", "centre", "lagged", "simulate", "simulate_pieces"]

Array = NDArray[np.float64]
AXES = ("roll", "pitch", "yaw")


class Definition(NamedTuple):
    """One unknown: name, unit, bounds, and centre and width of its prior, which is wide."""

    name: str
    unit: str
    lower: float
    upper: float
    centre: float
    width: float


DEFINITIONS = (
    *(Definition(f"damping_{axis}", "1/s", 0.0, 50.0, 1.0, 5.0) for axis in AXES),
    *(Definition(f"quadratic_{axis}", "1", 0.0, 50.0, 1.0, 5.0) for axis in AXES),
    *(Definition(f"effectiveness_{axis}", "1/(kg m^2)", 0.0, 100.0, 3.0, 10.0) for axis in AXES),
    *(Definition(f"lag_{axis}", "s", 1e-3, 1.0, 0.1, 0.2) for axis in AXES),
    *(Definition(f"bias_{axis}", "rad/s^2", -10.0, 10.0, 0.0, 2.0) for axis in AXES),
    *(Definition(f"righting_{axis}", "1/s^2", 0.0, 100.0, 3.0, 10.0) for axis in AXES[:2]),
    *(Definition(f"inertia_{axis}", "1", 0.1, 10.0, 1.0, 1.0) for axis in AXES[1:]),
)
"""The unknowns in the order of their vector; `inertia` is over roll's."""
NAMES = tuple(each.name for each in DEFINITIONS)


def centre() -> Array:
    """Return the prior's centre, at which fits start."""
    return np.array([each.centre for each in DEFINITIONS])


@equation
def _rates(w, g, tau, x, out):  # type: ignore[no-untyped-def]
    """Fill `out` (6,) with the rates of (omega, gamma)."""
    p, q, r = w[0], w[1], w[2]
    I_y, I_z = x[17], x[18]
    coupling = ((I_y - I_z) * q * r, (I_z - 1.0) * p * r / I_y, (1.0 - I_y) * p * q / I_z)
    righting = (-x[15] * g[1], x[16] * g[0], 0.0)
    for i in range(3):
        drag = x[i] * w[i] + x[3 + i] * w[i] * abs(w[i])
        out[i] = x[6 + i] * tau[i] - drag + x[12 + i] + righting[i] + coupling[i]
    out[3] = r * g[1] - q * g[2]
    out[4] = p * g[2] - r * g[0]
    out[5] = q * g[0] - p * g[1]


@compiled
def lagged(commanded, dt, x):  # type: ignore[no-untyped-def]
    """Return tau (N + 1, 3) [N m] from commanded moments (N, 3) held for `dt` [s] each; it starts at zero."""
    out = np.zeros((commanded.shape[0] + 1, 3))
    for i in range(3):
        left = np.exp(-dt / x[9 + i])
        for k in range(commanded.shape[0]):
            out[k + 1, i] = commanded[k, i] + (out[k, i] - commanded[k, i]) * left
    return out


@compiled
def simulate_pieces(rates, gravity, commanded, dt, every, x):  # type: ignore[no-untyped-def]
    """Return the rates (N, 3), begun anew at every `every`-th of the measured `rates` and `gravity` (N, 3), RK4."""
    tau = lagged(commanded, dt, x)
    count = rates.shape[0]
    out = np.empty((count, 3))
    y, moved, now = np.empty(6), np.empty(6), np.empty(3)
    slope, total = np.empty(6), np.empty(6)
    for k in range(count):
        if k % every == 0:
            y[:3], y[3:] = rates[k], gravity[k]
        out[k] = y[:3]
        total[:] = 0.0
        for stage in range(4):
            share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
            for i in range(6):
                moved[i] = y[i] + share * dt * slope[i] if stage > 0 else y[i]
            for i in range(3):
                left = np.exp(-share * dt / x[9 + i])
                now[i] = commanded[k, i] + (tau[k, i] - commanded[k, i]) * left
            _rates(moved[:3], moved[3:], now, x, slope)
            weight = 2.0 if stage in (1, 2) else 1.0
            for i in range(6):
                total[i] += weight * slope[i]
        for i in range(6):
            y[i] += dt / 6.0 * total[i]
        for i in range(3):
            y[i] = min(max(y[i], -50.0), 50.0)  # what diverges stays a number
    return out


def simulate(rates: Array, gravity: Array, commanded: Array, dt: float, x: Array) -> Array:
    """Return the rates (N, 3) [rad/s] run freely from the first sample."""
    return np.asarray(simulate_pieces(rates, gravity, commanded, dt, rates.shape[0] + 1, x))
