r"""An effect's size over dives, and the line through it: fouling, wear, a leak.

Each dive is fitted by itself, all numbers free within their deviations and the effect on. With sizes s_i, deviations
d_i and times t_i, weights w_i = 1 / d_i^2, the line is that of least squares; where sizes scatter about it more
than their deviations say (chi^2 > n - 2), what it tells is less sure by the root of the ratio.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.log import VehicleLog, told_in
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.refining import Problem
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.settling import settled, settled_with
from gap_diagnosis.vehicle.stretches import stretches_of

__all__ = ["Line", "Size", "followed", "line_of", "size_in"]

Array = NDArray[np.float64]
SURE = 2.0
"""Deviations that a slope must have to be called one: by chance 1 in 20."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """An effect's size in one dive: when [in the trend's unit of time], how large, its deviation."""

    time: float
    size: float
    deviation: float


@dataclass(frozen=True, kw_only=True)
class Line:
    """The line: level at the middle time and slope, with deviations; scatter: of the sizes over what they should."""

    middle: float
    level: float
    level_deviation: float
    slope: float
    slope_deviation: float
    scatter: float

    @property
    def rises(self) -> bool:
        """Whether there is a slope at all."""
        return abs(self.slope) > SURE * self.slope_deviation

    def at(self, time: float) -> tuple[float, float]:
        """Return the size at a time, and its deviation."""
        away = time - self.middle
        return self.level + self.slope * away, float(np.hypot(self.level_deviation, self.slope_deviation * away))

    def reaches(self, size: float) -> float | None:
        """Return when the line has that size; None where there is no slope, or it lies behind."""
        when = self.middle + (size - self.level) / self.slope if self.rises else None
        return when if when is not None and when > self.middle else None


def line_of(sizes: Sequence[Size]) -> Line:
    """Return the line through the sizes of three dives or more.

    Raises:
        ValueError: fewer dives, or all at one time.
    """
    t, s, d = np.array([(each.time, each.size, each.deviation) for each in sizes]).reshape(-1, 3).T
    if t.size < 3 or not np.ptp(t) > 0.0:
        raise ValueError(f"trend: expected three dives or more at different times; found {t.size}")
    w = 1.0 / d**2
    middle = float(w @ t / w.sum())
    spread = float(w @ (t - middle) ** 2)
    slope, level = float(w @ ((t - middle) * s)) / spread, float(w @ s / w.sum())
    chi = float(w @ (s - level - slope * (t - middle)) ** 2)
    scatter = max(float(np.sqrt(chi / (t.size - 2))), 1.0)
    return Line(
        middle=middle, level=level, level_deviation=scatter / float(np.sqrt(w.sum())), slope=slope,
        slope_deviation=scatter / float(np.sqrt(spread)), scatter=scatter,
    )  # fmt: skip


def followed(
    model: Model, logs: Sequence[VehicleLog], effect: str, thruster: int | None, axis: str | None, *,
    every: bool = False,
) -> Hypothesis:  # fmt: skip
    """Return the effect that is to be followed; every: on all thrusters at once.

    Raises:
        ValueError: no such effect there, one without a size, one that these sensors cannot show, or one of thrusters
            where none was named.
    """
    there = told_in(logs)
    known = hypotheses(model, there)
    named = [h for h in known if h.effect == effect]
    if not named:
        raise ValueError(f"--effect: expected one of {', '.join(sorted({h.effect for h in known}))}; found {effect}")
    of_thrusters = any(h.thruster is not None for h in named)
    found = [h for h in named if (h.thruster, h.axis) == (thruster, axis)]
    if every != (of_thrusters and (thruster, axis) == (None, None)):  # "all" is said, and never meant by silence
        found = []
    if not found or found[0].switch:
        ways = list(
            dict.fromkeys(_way(h, of_thrusters) for h in named if not h.switch and None in (h.thruster, h.axis))
        )
        raise ValueError(f"--effect {effect}: expected {', '.join(ways) or 'an effect with a size'}")
    return found[0]


def _way(h: Hypothesis, of_thrusters: bool) -> str:
    """Return what names the place of an effect on the command line."""
    if h.axis is not None:
        return f"--axis {h.axis}"
    if h.thruster is not None:
        return f"--thruster {h.thruster}"
    return "--thruster all" if of_thrusters else "neither --thruster nor --axis"


def size_in(model: Model, log: VehicleLog, h: Hypothesis) -> tuple[float, float]:
    """Return the first size of an effect in one dive, and its deviation."""
    logs, _ = stretches_of([log])
    free = nuisances(model, logs)
    runs, fit = settled(model, logs, free)
    screen = Screen(model=model, runs=runs, values={})
    begun = Problem(screen=screen, nuisances=free, effects=(h,)).fit(fit.moved, [tuple(0.0 for _ in h.parameters)])
    _, fit = settled_with(begun.effects, model, logs, free, runs, begun.values)
    return fit.effects[0].sizes[0], fit.effects[0].deviations[0]
