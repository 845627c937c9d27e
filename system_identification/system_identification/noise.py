r"""The noise of a disturbed system: what sensors add, what pushes the states, and residuals whitened by both.

A level says how many times the noise of a single reading a disturbance moves the signal that answers most; a colour is
what a signal carries beside white noise, over that noise. Levels are learned from residuals by maximum likelihood.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import lfilter

from system_identification.kalman import driven_by, gains_of, innovations_of
from system_identification.moves import TakenOff
from system_identification.system import Linear, System

__all__ = ["Caps", "Levels", "Whitener", "learned", "white_noise", "whitener"]

Array = NDArray[np.float64]
_MEMORIES = (0.3, 6.0)  # [s], of disturbances
_COLOURS = (0.1, 10.0)  # [s], memories of what sensors carry
_LEAST = 0.03
"""Level below which there is nothing."""
_NO_COLOUR = 1.001 * _LEAST
_PULL = 0.02
"""Of logarithms of levels to ordinary ones: where the rows do not say."""
_OUTLYING = 16.0
"""Square of a white row beyond which it tells of itself, not of the noise."""
_NARROW, _HOW_FAR = 4.0, 0.5
"""What it costs, nats, that parameters scatter more widely than stated: one set in fifty states too little. By how much
these are wrong: the standard deviation of the logarithm."""
_STEP = 0.02
_DONE = 0.3  # of the deviance


@dataclass(frozen=True, kw_only=True)
class Levels:
    """What the noise is made of.

    Attributes:
        sensors: standard deviation of each signal's white noise, in its unit.
        colours: of what it carries beside, over that of its white noise, by signal.
        colour_memory: of that [s], by signal.
        pushes: level of each disturbance.
        memory: of the disturbances [s].
        parameters: how many times wider than stated the parameters scatter.
    """

    sensors: Mapping[str, float]
    colours: Mapping[str, float]
    colour_memory: Mapping[str, float]
    pushes: tuple[float, ...]
    memory: float = 1.5
    parameters: float = 1.0

    @property
    def log_prior(self) -> float:
        """Logarithm of how probable it is that parameters scatter as widely."""
        far = float(np.log(self.parameters)) / _HOW_FAR
        return -_NARROW - 0.5 * far**2 if self.parameters > 1.0 else 0.0

    def towards(self, other: "Levels", share: float) -> "Levels":
        """Return levels a share of the way to others, in logarithms."""

        def between(a: float, b: float) -> float:
            return float(max(a, _LEAST) ** (1.0 - share) * max(b, _LEAST) ** share) if share < 1.0 else b

        def each(a: Mapping[str, float], b: Mapping[str, float]) -> dict[str, float]:
            return {name: between(a[name], b[name]) for name in a}

        return Levels(
            sensors={n: float(v ** (1.0 - share) * other.sensors[n] ** share) for n, v in self.sensors.items()},
            colours=each(self.colours, other.colours),
            colour_memory=each(self.colour_memory, other.colour_memory),
            pushes=tuple(between(a, b) for a, b in zip(self.pushes, other.pushes, strict=True)),
            memory=between(self.memory, other.memory),
            parameters=other.parameters,
        )


@dataclass(frozen=True, kw_only=True)
class Caps:
    """What noise may be: ranges of white noise over the samples' own, of colours, and the largest level of pushes."""

    sensors: tuple[float, float] = (0.5, 30.0)
    colours: float = 30.0
    pushes: float = 5.0


class _Filter(NamedTuple):
    """Of one run: what pushes and colours keep over a step, which colour each sample carries (M,), -1 for none, gains
    (M, D) and deviations (M,) of innovations.
    """

    keep: Array
    colours: NDArray[np.int64]
    gains: Array
    deviation: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Whitener:
    """A linear map of rows to white ones of standard deviation 1.

    Attributes:
        system: whose rows.
        linear: its runs, linearised.
        levels: of the noise.
        units: rate at which each disturbance of level 1 pushes.
        wild: how many times less single rows count, as they stand out, (R,); None: all count alike.
        loose: what white rows do at random beside, as it is taken off them.
    """

    system: System
    linear: Sequence[Linear]
    levels: Levels
    units: Array
    wild: Array | None = None
    loose: TakenOff | None = None

    @cached_property
    def _own(self) -> Array:
        """Standard deviation of each row's white noise, (R,)."""
        own = np.ones(self.system.known.size)
        for each in self.system.series:
            own[each.rows] = self.levels.sensors[each.signal]
        return own * self.system.spread * (1.0 if self.wild is None else self.wild)

    @cached_property
    def _filters(self) -> list[_Filter]:
        """By run."""
        return [self._filter(run) for run in self.linear]

    def _filter(self, run: Linear) -> _Filter:
        levels, names = self.levels, self.system.signal_names
        coloured = [n for n in names if levels.colours[n] > _NO_COLOUR]
        numbers = np.array([coloured.index(n) if n in coloured else -1 for n in names], dtype=np.int64)
        memories = [levels.memory] * len(levels.pushes) + [levels.colour_memory[n] for n in coloured]
        keep = np.exp(-run.dt / np.array(memories))
        pushed = [(level * unit) ** 2 for level, unit in zip(levels.pushes, self.units, strict=True)]
        variance = np.array(pushed + [(levels.colours[n] * levels.sensors[n]) ** 2 for n in coloured])
        gains = np.zeros((run.rows.size, run.transition.shape[1] + keep.size))
        deviation, colours = np.ones(run.rows.size), numbers[run.signals]
        gains_of(
            run.transition, run.push, keep, variance, run.places, run.readings, colours, self._own[run.rows] ** 2,
            self.system.known[run.rows], gains, deviation,
        )  # fmt: skip
        return _Filter(keep, colours, gains, deviation)

    @cached_property
    def deviations(self) -> Array:
        """Standard deviation of each row's innovation, (R,), without what is loose."""
        out = self._own.copy()
        for run, each in zip(self.linear, self._filters, strict=True):
            out[run.rows] = np.where(self.system.known[run.rows], each.deviation, out[run.rows])
        return out

    def prior(self, system: System) -> Array:
        """Return the inverse variances of a system's nuisances, (nuisances,)."""
        prior = np.ones(system.nuisances)
        prior[: system.parameters] /= self.levels.parameters**2
        return prior

    @cached_property
    def log_det(self) -> float:
        """Logarithm of the determinant of the covariance of the noise and of the nuisances."""
        own = 2.0 * float(np.sum(np.log(self.deviations[self.system.known])))
        own -= float(np.sum(np.log(self.prior(self.system))))
        return own + (0.0 if self.loose is None else self.loose.log_det)

    def whiten(self, rows: Array) -> Array:
        """Return rows (R,) or (R, C) as white ones of standard deviation 1; 0 where nothing counts; NaN counts as 0."""
        flat = self.filtered(rows.reshape(rows.shape[0], -1))
        return (flat if self.loose is None else self.loose(flat)).reshape(rows.shape)

    def filtered(self, rows: Array) -> Array:
        """Return rows (R, C) as they are whitened without regard to what is loose, column by column in memory."""
        columns, known = np.ascontiguousarray(rows.T), self.system.known
        if not self.linear:
            return np.where(known, np.nan_to_num(columns) / self._own, 0.0).T
        out = np.zeros_like(columns)
        for run, each in zip(self.linear, self._filters, strict=True):
            innovations_of(
                run.transition, run.push, each.keep, run.places, run.readings, each.colours, known[run.rows],
                each.gains, each.deviation, run.rows, columns, out,
            )  # fmt: skip
        return out.T

    def scattering(self, parameters: float) -> "Whitener":
        """Return the map beside parameters that scatter so many times more widely than stated."""
        return replace(self, levels=replace(self.levels, parameters=parameters))

    def tamed(self, residuals: Array) -> "Whitener":
        """Return the map in which lone rows that stand out of it by more than four deviations count by what they tell.

        As if each had a deviation of its own: beyond four, a row costs the logarithm of how far out it is. Rows that
        stand out together with their neighbours tell of the system.
        """
        rows = np.nan_to_num(residuals)
        alone, wild = replace(self, wild=None)._alone(rows), np.ones(residuals.size)
        for _ in range(2):
            out = np.abs(replace(self, wild=wild, loose=None).whiten(rows)) * wild
            alone &= out > np.sqrt(_OUTLYING)
            wild = np.where(alone, out / np.sqrt(_OUTLYING), 1.0)
        return replace(self, wild=wild if np.any(wild > 1.0) else None, loose=None)

    def _alone(self, rows: Array) -> NDArray[np.bool_]:
        """Return which rows stand out of the median of the five around them by more than four deviations, (R,)."""
        alone = np.zeros(rows.size, dtype=np.bool_)
        for each in self.system.series:
            places = each.first + np.flatnonzero(self.system.known[each.rows])
            apart = np.abs(rows[places] - median_filter(rows[places], size=5, mode="nearest"))
            alone[places] = apart > np.sqrt(_OUTLYING) * self._own[places]
        return alone

    def level(self, signal: str) -> float:
        """Return the standard deviation of a signal's noise without what pushes the states, in its unit."""
        return float(self.levels.sensors[signal] * np.hypot(1.0, self.levels.colours[signal]))


def plain_levels(system: System, pushes: int, level: float) -> Levels:
    """Return the samples' own white noise, and disturbances of a level."""
    names = system.signal_names
    return Levels(
        sensors=dict(system.levels),
        colours=dict.fromkeys(names, 0.0),
        colour_memory=dict.fromkeys(names, 1.0),
        pushes=(level,) * pushes,
    )


def white_noise(system: System, sensors: Mapping[str, float] | None = None) -> Whitener:
    """Return the map for white noise alone, the samples' own where `sensors` does not say otherwise."""
    levels = plain_levels(system, 0, 0.0)
    levels = levels if sensors is None else replace(levels, sensors=sensors)
    return Whitener(system=system, linear=(), levels=levels, units=np.ones(0))


def whitener(system: System, x: Array, levels: Levels | None = None, level: float = 0.5) -> Whitener:
    """Return the map about what is simulated for x; `levels` None: sensors as they look, disturbances of `level`."""
    linear = system.linear(x)
    pushes = linear[0].push.shape[2] if linear else 0
    levels = levels or plain_levels(system, pushes, level)
    return Whitener(system=system, linear=linear, levels=levels, units=_units(system, linear))


def _units(system: System, linear: Sequence[Linear], memory: float = 1.5) -> Array:
    """Return the rate of each disturbance that moves the reading which answers most by its noise."""
    own = np.array([system.single[n] for n in system.signal_names])
    if not linear:
        return np.ones(0)
    largest = np.zeros((len(linear), linear[0].push.shape[2]))
    for place, run in enumerate(linear):
        keep = np.exp(-run.dt / memory)
        moved = _moved(run, keep)  # (N, q, m) standard deviations of the states for a unit of each
        over = np.abs(moved[np.minimum(run.places, len(moved) - 1)] @ run.readings[:, :, None])[..., 0]
        for signal in range(len(own)):
            here = run.signals == signal
            if np.any(here):
                square = np.mean((over[here] / own[signal]) ** 2, axis=0)
                largest[place] = np.maximum(largest[place], square)
    square = np.mean(largest, axis=0)
    return np.where(square > 1e-20, 1.0 / np.sqrt(np.maximum(square, 1e-20)), 0.0)


def _moved(run: Linear, keep: float) -> Array:
    """Return what the states do under each disturbance of unit deviation, in the root mean square, (N, q, m).

    By draws: a covariance has no sign with which readings could add up states.
    """
    rng = np.random.default_rng(0)
    count, m, q = run.push.shape
    shocks = rng.standard_normal((q, count + 1))[:, :count]
    fresh = np.sqrt(1.0 - keep * keep)
    walks, _ = lfilter([fresh], [1.0, -keep], shocks, zi=(1.0 - fresh) * shocks[:, :1])
    out = np.zeros((count, q, m))
    driven_by(run.transition, run.push, walks, out)
    return out


def learned(base: Whitener, residuals: Array, caps: Caps, *, steps: int = 5, taken: float = 0.0) -> Whitener:
    """Return the map with levels under which residuals (R,) are most likely, within caps, by Fisher scoring.

    Args:
        base: where to start.
        residuals: measured less predicted, NaN where nothing counts.
        caps: what noise may be.
        steps: at most so many.
        taken: how many degrees of freedom fitting has used up.
    """
    system, bare = base.system, replace(base, loose=None)
    rows, known = np.nan_to_num(residuals), system.known
    share = 1.0 - min(taken / max(int(np.sum(known)), 1), 0.5)
    names, pushes = system.signal_names, len(base.levels.pushes)
    s = len(names)

    def levels_at(z: Array) -> Levels:
        values = np.exp(z)
        return replace(
            base.levels,
            sensors={n: float(system.levels[n] * v) for n, v in zip(names, values[:s], strict=True)},
            colours=dict(zip(names, values[s : 2 * s].tolist(), strict=True)),
            colour_memory=dict(zip(names, values[2 * s : 3 * s].tolist(), strict=True)),
            pushes=tuple(values[3 * s : 3 * s + pushes].tolist()),
            memory=float(values[-1]),
        )

    def seen(z: Array) -> tuple[Array, Array]:
        """Return white rows and logarithms of the innovations' variances."""
        trial = replace(bare, levels=levels_at(z))
        return trial.whiten(rows)[known], 2.0 * np.log(trial.deviations[known])

    pulled = np.concatenate((np.zeros(s), np.full(2 * s + pushes + 1, _PULL)))

    def deviance(white: Array, logs: Array, z: Array) -> float:
        return float(white @ white) / share + float(np.sum(logs)) + float(pulled @ (z - centre) ** 2)

    low = np.log([caps.sensors[0]] * s + [_LEAST] * s + [_COLOURS[0]] * s + [_LEAST] * pushes + [_MEMORIES[0]])
    high = np.log(
        [caps.sensors[1]] * s + [caps.colours] * s + [_COLOURS[1]] * s + [caps.pushes] * pushes + [_MEMORIES[1]]
    )
    centre = np.log([1.0] * s + [0.1] * s + [1.0] * s + [0.5] * pushes + [1.5])
    z = np.log(
        [
            *(base.levels.sensors[n] / system.levels[n] for n in names),
            *(max(base.levels.colours[n], 0.1) for n in names),
            *(base.levels.colour_memory[n] for n in names),
            *(max(level, 0.1) for level in base.levels.pushes),
            base.levels.memory,
        ]
    )

    def differences(z: Array) -> Array:
        """Return steps for the slopes; at its least a colour is none, and has no memory."""
        step = np.where(z + _STEP <= high, _STEP, -_STEP)
        colours, memories = slice(s, 2 * s), slice(2 * s, 3 * s)
        none = z[colours] <= low[colours]
        step[colours] = np.where(none, (centre - low)[colours], step[colours])
        step[memories] = np.where(none, 0.0, step[memories])
        return step

    z = np.clip(z, low, high)
    white, logs = seen(z)
    here, damping = deviance(white, logs, z), 1e-3
    for _ in range(steps):
        by_white, by_logs = np.zeros((white.size, z.size)), np.zeros((white.size, z.size))
        steps_of_z = differences(z)
        for k in np.flatnonzero(steps_of_z):
            there = seen(z + np.where(np.arange(z.size) == k, steps_of_z, 0.0))
            by_white[:, k], by_logs[:, k] = (there[0] - white) / steps_of_z[k], (there[1] - logs) / steps_of_z[k]
        slope = np.sum(by_logs, axis=0) + 2.0 * by_white.T @ white / share + 2.0 * pulled * (z - centre)
        innovation = by_white + 0.5 * white[:, None] * by_logs
        curvature = 2.0 * innovation.T @ innovation + by_logs.T @ by_logs + np.diag(2.0 * pulled)
        held = ((z <= low) & (slope > 0.0)) | ((z >= high) & (slope < 0.0))
        curvature[held] = curvature[:, held] = 0.0
        curvature[np.diag_indices(z.size)] += np.where(held, 1.0, 1e-6)
        slope = np.where(held, 0.0, slope)
        gained = 0.0
        for _ in range(4):
            move = np.linalg.solve(curvature + damping * np.diag(np.diag(curvature)), -slope)
            trial = np.clip(z + np.clip(move, -1.5, 1.5), low, high)
            there = seen(trial)
            value = deviance(*there, trial)
            if value < here:
                gained, z, (white, logs), here = here - value, trial, there, value
                damping = max(0.1 * damping, 1e-6)
                break
            damping = max(10.0 * damping, 1e-2)
        if gained < _DONE:
            break
    return replace(bare, levels=levels_at(z))
