r"""The noise of a disturbed system: what sensors add, what pushes the states, and residuals whitened by both.

What they are made of: `levels`; how that is learned from residuals: `learning`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.signal import lfilter

from system_identification.kalman import driven_by, gains_of, innovations_of, smoothed_of
from system_identification.levels import LEAST, Levels, plain_levels
from system_identification.moves import TakenOff
from system_identification.system import Linear, System

__all__ = ["Whitener", "white_noise", "whitener"]

Array = NDArray[np.float64]
_NO_COLOUR = 1.001 * LEAST
_LINEARISED = 2
"""How often a system is linearised anew: a third time moves evidence by as little as a second start does."""
_OUTLYING = 16.0
"""Square of a white row beyond which it tells of itself, not of the noise."""


class _Filter(NamedTuple):
    """Of one run: what pushes and colours keep over a step and their variances, which colour each sample carries (M,),
    -1 for none, gains (M, D) and deviations (M,) of innovations.
    """

    keep: Array
    variance: Array
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
            run.transition, run.push, run.unforeseen, keep, variance, run.places, run.readings, colours,
            self._own[run.rows] ** 2, self.system.known[run.rows], gains, deviation,
        )  # fmt: skip
        return _Filter(keep, variance, colours, gains, deviation)

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
        prior[system.conventions] /= self.levels.conventions**2
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
            self._through(run, each, columns, out)
        return out.T

    def followed(self, residuals: Array) -> list[Array]:
        """Return by how much the states of each run most probably are off those simulated, (N, m)."""
        columns, found = np.ascontiguousarray(residuals[None]), []
        white = np.zeros_like(columns)
        for run, each in zip(self.linear, self._filters, strict=True):
            self._through(run, each, columns, white, np.sqrt(_OUTLYING))
            found.append(np.zeros(run.transition.shape[:2]))
            smoothed_of(
                run.transition, run.push, run.unforeseen, each.keep, each.variance, run.places, run.readings,
                each.colours, self.system.known[run.rows], each.gains, each.deviation, white[0, run.rows], found[-1],
            )  # fmt: skip
        return found

    def _through(self, run: Linear, each: _Filter, columns: Array, out: Array, most: float = np.inf) -> None:
        innovations_of(
            run.transition, run.push, each.keep, run.places, run.readings, each.colours, self.system.known[run.rows],
            each.gains, each.deviation, run.rows, columns, most, out,
        )  # fmt: skip

    def scattering(self, parameters: float) -> "Whitener":
        """Return the map beside parameters that scatter so many times more widely than stated."""
        return replace(self, levels=replace(self.levels, parameters=parameters))

    def scattering_as(self, levels: Levels) -> "Whitener":
        """Return the map beside parameters and conventions that scatter as widely as these levels say."""
        return replace(self, levels=replace(self.levels, parameters=levels.parameters, conventions=levels.conventions))

    def pushing(self, place: int, times: float) -> "Whitener":
        """Return the map beside a disturbance, by its place, that pushes so many times as hard, and nothing loose."""
        pushes = tuple(level * (times if k == place else 1.0) for k, level in enumerate(self.levels.pushes))
        return replace(self, loose=None, levels=replace(self.levels, pushes=pushes))

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
            apart = np.abs(rows[places] - median_filter(rows[places], size=5, mode="mirror"))
            alone[places] = apart > np.sqrt(_OUTLYING) * self._own[places]
        return alone

    def level(self, signal: str) -> float:
        """Return the standard deviation of a signal's noise without what pushes the states, in its unit."""
        return float(self.levels.sensors[signal] * np.hypot(1.0, self.levels.colours[signal]))


def white_noise(system: System, sensors: Mapping[str, float] | None = None) -> Whitener:
    """Return the map for white noise alone, the samples' own where `sensors` does not say otherwise."""
    levels = plain_levels(system, 0, 0.0)
    levels = levels if sensors is None else replace(levels, sensors=sensors)
    return Whitener(system=system, linear=(), levels=levels, units=np.ones(0))


def whitener(system: System, x: Array, levels: Levels | None = None, level: float = 0.5) -> Whitener:
    """Return the map about what is simulated for x; `levels` None: sensors as they look, disturbances of `level`.

    Linearised half way to where the system most probably was: what pushes move by many times the noise is not small,
    and a square's slope would be wrong by half of it. Plain levels tell where, whatever was learned: sets of effects
    that are compared are linearised alike.
    """
    linear = system.linear(x)
    plain = plain_levels(system, linear[0].push.shape[2] if linear else 0, level)
    about = Whitener(system=system, linear=linear, levels=plain, units=_units(system, linear))
    if linear:
        residuals = system.residuals(x)
        for _ in range(_LINEARISED):
            about = replace(about, linear=system.linear(x, [0.5 * each for each in about.followed(residuals)]))
    return replace(about, levels=levels or plain)


def _units(system: System, linear: Sequence[Linear], memory: float = 1.5) -> Array:
    """Return the rate of each disturbance that moves the reading of what it pushes by its noise.

    Where that is not read: the one that answers most. What another sensor makes of it, a torque read to a thousandth,
    says how well it is seen, not how large it is.
    """
    own = np.array([system.single[n] for n in system.signal_names])
    if not linear:
        return np.ones(0)
    squares = np.zeros((len(linear), len(own), linear[0].push.shape[2]))
    for place, run in enumerate(linear):
        keep = np.exp(-run.dt / memory)
        moved = _moved(run, keep)  # (N, q, m) standard deviations of the states for a unit of each
        states = run.readings[:, : run.transition.shape[1], None]
        over = np.abs(moved[np.minimum(run.places, len(moved) - 1)] @ states)[..., 0]
        for signal in range(len(own)):
            here = run.signals == signal
            if np.any(here):
                squares[place, signal] = np.mean((over[here] / own[signal]) ** 2, axis=0)
    square = np.mean(np.max(squares, axis=1), axis=0)
    for k, name in enumerate(system.pushed):
        if name in system.signal_names:
            square[k] = np.mean(squares[:, system.signal_names.index(name), k])
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
