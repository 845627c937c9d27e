"""Throttle programmes among which the next experiment is chosen: many kinds, at random, all within a rig's limits."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rov_sim.throttle_programmes import multisine

__all__ = ["KINDS", "Limits", "Programme", "programmes", "within"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What a rig may be given.

    Attributes:
        largest: magnitude of the throttle [V].
        rate: of the throttle [V/s].
        duration: of the experiment [s].
        period: of the commands [s].
        rest: zero throttle at both ends [s].
        dead_zone: (lower, upper) edges [V], as far as they are known.
    """

    largest: float
    rate: float
    duration: float
    period: float = 0.04
    rest: float = 1.0
    dead_zone: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        problems = [
            f"{name} of the next experiment: expected {expected}, found {value:g}"
            for name, value, expected, right in (
                ("largest throttle [V]", self.largest, "a positive number", self.largest > 0.0),
                ("rate [V/s]", self.rate, "a positive number", self.rate > 0.0),
                ("period [s]", self.period, "a positive number", self.period > 0.0),
                ("duration [s]", self.duration, f"{4 * self.rest:g} to 600", 4 * self.rest <= self.duration <= 600.0),
            )
            if not (np.isfinite(value) and right)
        ]
        if problems:
            raise ValueError("\n".join(problems))

    @property
    def count(self) -> int:
        """Commands in the experiment."""
        return round(self.duration / self.period)


@dataclass(frozen=True, kw_only=True)
class Programme:
    """A throttle programme: what it is in words, its kind, commands [V] every `period` [s], shape (N,)."""

    title: str
    kind: str
    throttle: Array
    period: float

    @property
    def time(self) -> Array:
        """Stamps of the commands [s], shape (N,)."""
        return np.asarray(self.period * np.arange(self.throttle.size), dtype=np.float64)


def programmes(limits: Limits, *, count: int, seed: int) -> list[Programme]:
    """Return programmes of all kinds in turn; the same ones for the same limits and seed."""
    names = list(KINDS)
    streams = np.random.default_rng(seed).spawn(count)
    result = []
    for place, rng in enumerate(streams):
        kind = names[place % len(names)]
        level = limits.largest * (1.0 if place < len(names) else float(rng.uniform(0.3, 1.0)))
        title, throttle = KINDS[kind](limits, level, rng)
        title = f"{title}, up to {np.max(np.abs(throttle)):.2g} V"
        result.append(Programme(title=title, kind=kind, throttle=within(limits, throttle), period=limits.period))
    return result


def within(limits: Limits, throttle: Array) -> Array:
    """Return commands (N,) held within the limits: the magnitude, the rate, rest at both ends."""
    step = limits.rate * limits.period
    count = throttle.size
    resting = round(limits.rest / limits.period)
    place = np.arange(count)
    away = np.clip(np.minimum(place - resting, count - resting - place), 0, None)
    most = np.minimum(limits.largest, step * away)
    wanted = np.clip(throttle, -most, most)
    result = np.zeros(count)
    for k in range(1, count):
        result[k] = min(max(wanted[k], result[k - 1] - step), result[k - 1] + step)
    return np.clip(result, -most, most)  # but for rounding they are there already


def _steps(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    shortest = float(np.exp(rng.uniform(np.log(0.2), np.log(2.0))))
    values = _held(limits, rng, shortest, 3.0 * shortest, lambda: float(rng.uniform(-level, level)))
    return f"steps held for {shortest:.2g} to {3.0 * shortest:.2g} s", values


def _multisine(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    lowest = max(float(rng.choice([0.05, 0.1, 0.3, 1.0])), 1.0 / limits.duration)
    highest = min(lowest * float(rng.choice([6.0, 15.0, 40.0])), 0.2 / limits.period)
    duration = limits.count * limits.period
    values = multisine(level, limits.period, duration=duration, lowest=lowest, highest=highest, rng=rng)
    return f"a multisine from {lowest:.2g} to {highest:.2g} Hz", values


def _one_way(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    title, values = _multisine(limits, level, rng)
    sign = float(rng.choice([-1.0, 1.0]))
    return f"{title} in one direction", sign * 0.5 * (level + values)


def _ramps(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    length = float(np.exp(rng.uniform(np.log(0.6), np.log(6.0))))
    knots, levels, sign = [0.0], [0.0], float(rng.choice([-1.0, 1.0]))
    while knots[-1] < limits.duration:
        knots.append(knots[-1] + length * float(rng.uniform(0.7, 1.3)))
        levels.append(sign * level * float(rng.uniform(0.4, 1.0)))
        sign = -sign
    return f"ramps of {length:.2g} s through the dead zone", np.interp(_time(limits), knots, levels)


def _dead_zone(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    lower, upper = limits.dead_zone
    top = min(max(1.6 * max(-lower, upper), 0.2 * limits.largest) * float(rng.uniform(0.8, 1.5)), limits.largest)
    turns = _time(limits) / float(rng.uniform(2.0, 10.0))
    return "slow triangles about the dead zone", top * (4.0 * np.abs((turns + 0.75) % 1.0 - 0.5) - 1.0)


def _constants(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    holds = int(rng.integers(2, 6))
    shortest = limits.duration / holds
    signs = float(rng.choice([-1.0, 1.0])) * (-1.0) ** np.arange(holds + 2)
    levels = iter(signs * level * rng.uniform(0.4, 1.0, holds + 2))
    values = _held(limits, rng, 0.8 * shortest, 1.2 * shortest, lambda: float(next(levels)))
    return f"{holds} constant levels", values


def _chirp(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    lowest = float(rng.uniform(0.05, 0.3))
    highest = min(float(np.exp(rng.uniform(np.log(0.6), np.log(6.0)))), 0.2 / limits.period)
    growth = np.log(highest / lowest)
    share = _time(limits) / limits.duration
    phase = 2.0 * np.pi * lowest * limits.duration / growth * np.expm1(growth * share)
    return f"a chirp from {lowest:.2g} to {highest:.2g} Hz", level * np.sin(phase)


def _reversals(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    shortest = float(np.exp(rng.uniform(np.log(0.2), np.log(1.5))))
    sign = [float(rng.choice([-1.0, 1.0]))]

    def turned() -> float:
        sign[0] = -sign[0]
        return sign[0] * level

    return f"reversals every {shortest:.2g} to {2 * shortest:.2g} s", _held(limits, rng, shortest, 2 * shortest, turned)


def _doublets(limits: Limits, level: float, rng: np.random.Generator) -> tuple[str, Array]:
    width = float(np.exp(rng.uniform(np.log(0.12), np.log(1.0))))
    pause = width * float(rng.uniform(1.0, 4.0))
    turns = (_time(limits) - limits.rest) % (2.0 * width + pause)
    sign = float(rng.choice([-1.0, 1.0]))
    values = np.where(turns < width, sign * level, np.where(turns < 2.0 * width, -sign * level, 0.0))
    return f"doublets of {2 * width:.2g} s with pauses of {pause:.2g} s", values


KINDS: dict[str, Callable[[Limits, float, np.random.Generator], tuple[str, Array]]] = {
    "steps": _steps,
    "multisine": _multisine,
    "one_way": _one_way,
    "ramps": _ramps,
    "dead_zone": _dead_zone,
    "constants": _constants,
    "chirp": _chirp,
    "reversals": _reversals,
    "doublets": _doublets,
}
"""Kinds of programme by name: functions of limits, level [V] and generator that return (title, commands (N,))."""


def _time(limits: Limits) -> Array:
    return np.asarray(limits.period * np.arange(limits.count), dtype=np.float64)


def _held(
    limits: Limits, rng: np.random.Generator, shortest: float, longest: float, level: Callable[[], float]
) -> Array:
    pieces: list[Array] = []
    while sum(piece.size for piece in pieces) < limits.count:
        held = max(1, round(float(rng.uniform(shortest, longest)) / limits.period))
        pieces.append(np.full(held, level()))
    return np.concatenate(pieces)[: limits.count]
