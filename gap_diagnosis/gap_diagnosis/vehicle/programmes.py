"""What a vehicle may be made to do for a recording: programmes of throttles within limits of tilt, depth and speed.

A pulse of one thruster turns the vehicle; the pulse back turns it back. The level is the largest at which a dry run on
the model, with the worst of the parameters' deviations counted as a margin, stays within the limits.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.gains import down_of
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.rules import PULSE_MARGIN
from rov_sim.vehicle.effects.body_axes import BODY_AXES
from rov_sim.vehicle.plant import simulate
from rov_sim.vehicle.truth import at_rest

__all__ = ["PULSES", "DryRun", "Limits", "Programme", "pulses", "sweeps"]

Array = NDArray[np.float64]
PULSES = (0.2, 30.0)
"""[s] Between which a pulse may last: a rotor needs a tenth of a second."""
_SWEPT = (0.1, 0.8)
"""[1/s] From where the body follows to where its inertia holds it."""
_REACHED = 0.5
"""Share of a wrench on one axis alone that thrusters must reach, for the axis to be swept."""


@dataclass(frozen=True, kw_only=True)
class Limits:
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
    """Throttles (K, N) [V] with a period [s], what it is in words, and what a dry run of it says."""

    words: str
    throttles: Array
    period: float
    dry_run: DryRun

    @property
    def duration(self) -> float:
        """[s]."""
        return len(self.throttles) * self.period


def pulses(
    model: Model, limits: Limits, *, pulse: float = 1.0, rest: float = 3.0, period: float = 0.04
) -> Programme:  # fmt: skip
    """Return each thruster alone, both ways: the standard first recording.

    Args:
        model: of the vehicle; the dry run begins at rest, trimmed by nothing.
        limits: that the dry run keeps with `PULSE_MARGIN`.
        pulse, rest: durations of a pulse and of the rest after a thruster's four [s].
        period: of the commands [s].

    Raises:
        ValueError: even the smallest pulses, 0.3 V beyond the dead zone, leave the limits, or are beyond them.
    """
    on, off = round(pulse / period), round(rest / period)
    rows = [np.zeros((off, model.thrusters))]
    for i in range(model.thrusters):
        one = np.zeros((4 * on + off, model.thrusters))
        for k, sign in enumerate((1.0, -1.0, -1.0, 1.0)):  # forward and reverse, then at once back: no drift is left
            one[k * on : (k + 1) * on, i] = sign
        rows.append(one)
    return _within(model, "each thruster alone, both ways", np.concatenate(rows), limits, period, "shorten --pulse")


def sweeps(model: Model, limits: Limits, *, duration: float = 20.0, period: float = 0.04) -> list[Programme]:
    """Return sines of rising frequency on each axis that these thrusters move alone, and on all of them in turn.

    Axes whose sweep leaves the limits at any level are left out. Arguments as those of `pulses`.
    """
    alone = _alone(model)
    found: dict[str, Programme] = {}
    for axis, thrusts in alone.items():
        try:
            shape = np.outer(_rising(duration, period), thrusts)
            found[axis] = _within(model, f"a sweep of {axis}", shape, limits, period, "allow more")
        except ValueError:
            continue
    out = list(found.values())
    if len(found) > 1:
        rest, half = np.zeros((round(3.0 / period), model.thrusters)), _rising(0.5 * duration, period)
        parts = [
            part
            for axis, each in found.items()
            for part in (each.dry_run.level / limits.throttle * np.outer(half, alone[axis]), rest)
        ]
        with suppress(ValueError):
            words = f"sweeps of {', '.join(found)} in turn"
            out.append(_within(model, words, np.concatenate(parts), limits, period, "allow more"))
    return out


def _rising(duration: float, period: float) -> Array:
    """Return a sine of rising frequency, (K,)."""
    time, (low, high) = np.arange(0.0, duration, period), _SWEPT
    return np.sin(2.0 * np.pi * (low * time + 0.5 * (high - low) * time**2 / duration))


def _alone(model: Model) -> Mapping[str, Array]:
    """Return throttles (N,), the largest 1, that push along each axis which can be pushed alone."""
    K = model.vehicle.configuration
    inverse = np.linalg.pinv(K)
    found = {}
    for k, axis in enumerate(BODY_AXES):
        thrusts = inverse[:, k]
        if (K @ thrusts)[k] > _REACHED:
            found[axis] = np.sign(thrusts) * np.sqrt(np.abs(thrusts) / np.abs(thrusts).max())
    return found


def _within(model: Model, words: str, shape: Array, limits: Limits, period: float, advice: str) -> Programme:
    """Return a programme of this shape (K, N), the largest 1, at the highest level that keeps the limits."""
    level, least = limits.throttle, max(model.edges) + 0.3
    if level < least:
        raise ValueError(f"largest throttle: expected {least:.2g} V or more, beyond the dead zones; found {level:.2g}")
    while True:
        run = _dry(model, level * shape, period, level)
        worst = max(run.tilt / limits.tilt, run.depth / limits.depth, run.speed / limits.speed)
        if worst * PULSE_MARGIN <= 1.0:
            return Programme(words=words, throttles=level * shape, period=period, dry_run=run)
        if level <= least:
            raise ValueError(
                f"{words}: expected a tilt below {limits.tilt:g} rad, depth within {limits.depth:g} m, speed below "
                f"{limits.speed:g} m/s; found {run.tilt:.2g} rad, {run.depth:.2g} m, {run.speed:.2g} m/s at "
                f"{level:.2g} V, the smallest throttle that moves anything: {advice}"
            )
        level = max(0.9 * level, least)


def _dry(model: Model, throttles: Array, period: float, level: float) -> DryRun:
    settings = model.built({}, initial=at_rest(model.thrusters)).settings
    run = simulate(settings, throttles, period)
    free = simulate(settings, np.zeros_like(throttles), period)  # what trim alone does is not the programme's doing
    tilt = np.arccos(np.clip(down_of(run.attitude)[:, 2], -1.0, 1.0))
    return DryRun(
        tilt=float(tilt.max()), depth=float(np.abs(run.position[:, 2] - free.position[:, 2]).max()),
        speed=float(np.linalg.norm(run.velocity[:, :3] - free.velocity[:, :3], axis=1).max()), level=level,
    )  # fmt: skip
