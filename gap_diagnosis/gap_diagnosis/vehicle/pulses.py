"""The standard first recording: each thruster alone, both ways, within limits of tilt, depth and speed.

A pulse of one thruster turns the vehicle; the pulse back turns it back. The level is the largest at which a dry run on
the model, with the worst of the parameters' deviations counted as a margin, stays within the limits.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.gains import down_of
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.rules import PULSE_MARGIN
from rov_sim.vehicle.plant import simulate
from rov_sim.vehicle.truth import at_rest

__all__ = ["DryRun", "Programme", "PulseLimits", "pulses"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class PulseLimits:
    """Largest throttle [V], tilt [rad], change of depth [m] and speed [m/s]."""

    throttle: float = 2.5
    tilt: float = 0.5
    depth: float = 0.7
    speed: float = 0.6


@dataclass(frozen=True, kw_only=True)
class DryRun:
    """Largest tilt [rad], change of depth [m], speed [m/s] and level [V] of a dry run."""

    tilt: float
    depth: float
    speed: float
    level: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Programme:
    """Throttles (K, N) [V] with a period [s], and what a dry run of it says."""

    throttles: Array
    period: float
    dry_run: DryRun


def _pattern(N: int, pulse: float, rest: float, period: float) -> Array:
    """Return the pulses at 1 V: forward and reverse, then at once reverse and forward: no drift is left."""
    on, off = round(pulse / period), round(rest / period)
    rows = [np.zeros((off, N))]
    for i in range(N):
        one = np.zeros((4 * on + off, N))
        for k, sign in enumerate((1.0, -1.0, -1.0, 1.0)):
            one[k * on : (k + 1) * on, i] = sign
        rows.append(one)
    return np.concatenate(rows)


def pulses(
    model: Model, limits: PulseLimits, *, pulse: float = 1.0, rest: float = 3.0, period: float = 0.04
) -> Programme:
    """Return the programme for a vehicle.

    Args:
        model: of it; the dry run begins at rest, trimmed by nothing.
        limits: that the dry run keeps with `PULSE_MARGIN`.
        pulse, rest: durations of a pulse and of the rest after a thruster's four [s].

    Raises:
        ValueError: even the smallest pulses, half a volt beyond the dead zone, leave the limits.
    """
    shape = _pattern(model.thrusters, pulse, rest, period)
    edge = max(max(abs(getattr(s.coefficients, d, 0.0)) for d in ("delta_u1", "delta_u2")) for s in model.sets)
    level, least = limits.throttle, edge + 0.3
    while True:
        run = _dry(model, level * shape, period, level)
        worst = max(run.tilt / limits.tilt, run.depth / limits.depth, run.speed / limits.speed)
        if worst * PULSE_MARGIN <= 1.0:
            return Programme(throttles=level * shape, period=period, dry_run=run)
        if level <= least:
            raise ValueError(
                f"pulses: expected a tilt below {limits.tilt:g} rad, depth within {limits.depth:g} m, speed below "
                f"{limits.speed:g} m/s; found {run.tilt:.2g} rad, {run.depth:.2g} m, {run.speed:.2g} m/s at "
                f"{level:.2g} V, the smallest pulses that move anything: shorten --pulse"
            )
        level = max(0.9 * level, least)


def _dry(model: Model, throttles: Array, period: float, level: float) -> DryRun:
    settings = model.built({}, initial=at_rest(model.thrusters)).settings
    run = simulate(settings, throttles, period)
    free = simulate(settings, np.zeros_like(throttles), period)  # what trim alone does is not the pulses' doing
    tilt = np.arccos(np.clip(down_of(run.attitude)[:, 2], -1.0, 1.0))
    return DryRun(
        tilt=float(tilt.max()), depth=float(np.abs(run.position[:, 2] - free.position[:, 2]).max()),
        speed=float(np.linalg.norm(run.velocity[:, :3] - free.velocity[:, :3], axis=1).max()), level=level,
    )  # fmt: skip
