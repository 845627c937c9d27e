"""Long dives, thinned: the stretches that together vary thrusters and motion most, each a recording of its own.

What is diagnosed costs time in proportion to what is simulated, and minutes of one kind of work tell little more than
one does. Stretches are added one by one, each time the one that adds most to the determinant of the products of what
varies (D-optimal design: Fedorov 1972), so that thrusters are driven apart from each other and both ways.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.log import VehicleLog

__all__ = ["stretches_of"]

Array = NDArray[np.float64]
_APART = 5.0
"""[s] between the beginnings that are compared."""


class _Stretch(NamedTuple):
    """Of log k, from instant first to before last."""

    k: int
    first: int
    last: int

    def overlaps(self, other: "_Stretch") -> bool:
        return self.k == other.k and self.first < other.last and other.first < self.last


def stretches_of(logs: Sequence[VehicleLog], longest: float | None = None) -> tuple[list[VehicleLog], list[str]]:
    """Return logs of no more than about `longest` [s] together, and a sentence of what was done, if anything was.

    longest: None: logs that are longer together than `rules.LONGEST` are thinned to `rules.THINNED`. One stretch of
    each log is taken before a second one of any.

    Raises:
        ValueError: less than one stretch is asked for.
    """
    if longest is not None and not longest >= rules.STRETCH:
        raise ValueError(f"--longest: expected {rules.STRETCH:g} s or more; found {longest:g}")
    total = sum(log.duration for log in logs)
    if total <= (longest or rules.LONGEST):
        return list(logs), []
    left = [each for k, log in enumerate(logs) for each in _stretches(k, log)]
    products = dict(zip(left, _products(logs, left), strict=True))
    product = np.eye(len(products[left[0]]))
    taken: list[_Stretch] = []
    for _ in range(int((longest or rules.THINNED) / rules.STRETCH)):
        begun = {each.k for each in taken}
        offered = [each for each in left if each.k not in begun] or left
        if not offered:
            break
        gains = np.linalg.slogdet(product + np.array([products[each] for each in offered]))[1]
        best = offered[int(np.argmax(gains))]
        taken.append(best)
        product = product + products[best]
        left = [each for each in left if not each.overlaps(best)]
    found = [_cut(logs[each.k], each) for each in sorted(taken)]
    used = sum(log.duration for log in found)
    return found, [
        f"Of {total:.0f} s recorded, {used:.0f} s are used, the {len(found)} stretches in which thrusters and motion "
        f"vary most; what changes more slowly, or goes with the place, is not seen (--longest {total:.0f} uses all)."
    ]


def _stretches(k: int, log: VehicleLog) -> list[_Stretch]:
    """Return the stretches of a log that are compared: all of a short one."""
    length = min(round(rules.STRETCH / log.period), log.count)
    firsts = range(0, log.count - length + 1, round(_APART / log.period))
    return [_Stretch(k, first, first + length) for first in firsts]


def _cut(log: VehicleLog, stretch: _Stretch) -> VehicleLog:
    part = log.part(stretch.first, stretch.last)
    return replace(part, name=f"{log.name} from {stretch.first * log.period:.0f} s")


def _products(logs: Sequence[VehicleLog], stretches: Sequence[_Stretch]) -> list[Array]:
    """Return for each stretch the products (F, F) [s] of what varies in it, over its deviation in all logs: throttles
    of either direction, rates and velocities."""
    told = [
        np.hstack((np.maximum(log.throttles, 0.0), np.minimum(log.throttles, 0.0), log.told[:, 3:6], log.told[:, 10:]))
        for log in logs
    ]
    every = np.ma.masked_invalid(np.vstack(told)).std(axis=0).filled(0.0)
    found = []
    for each in stretches:
        rows = np.ma.masked_invalid(told[each.k][each.first : each.last, every > 0.0])
        varied = ((rows - rows.mean(axis=0)) / every[every > 0.0]).filled(0.0)
        found.append(logs[each.k].period * varied.T @ varied)
    return found
