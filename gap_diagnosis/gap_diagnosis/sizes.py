"""Sizes of fitted effects with their standard deviations."""

from dataclasses import dataclass

import numpy as np

from gap_diagnosis.rules import RULES
from gap_diagnosis.suspects import found_by
from system_identification.fitting import Fitted
from system_identification.noise import Whitener
from system_identification.suspects import Suspect

__all__ = ["Size", "sizes_of"]

_JAGGED = found_by("stairs", "command_lattice", "reading_lattice")

IMPRECISE = 0.005
"""Share of the size that is added to its standard deviation: exact integration promises more than sizes keep."""


@dataclass(frozen=True, kw_only=True)
class Size:
    """One parameter of an effect."""

    value: float
    std: float
    unit: str


def sizes_of(fitted: Fitted, noise: Whitener, suspect: Suspect) -> dict[str, Size]:
    """Return the sizes of a suspect in a fitted hypothesis, by parameter."""
    problem = fitted.problem
    deviations = np.sqrt(np.diag(fitted.covariance))
    values = problem.sizes(fitted.x)
    result = {}
    for place, slot in enumerate(problem.slots):
        if slot in suspect.slots:
            value = values[slot.effect][slot.parameter]
            jagged = slot.effect in _JAGGED
            std = _width(fitted, noise, place) if jagged else float(deviations[problem.nuisances + place])
            result[slot.parameter] = Size(
                value=value,
                std=float(np.hypot(np.sqrt(RULES.tempered) * std * slot.width, IMPRECISE * value)),
                unit=slot.unit,
            )
    return result


def _width(fitted: Fitted, noise: Whitener, place: int) -> float:
    """Return by how much a size over its range must change for the cost to rise by one; the other unknowns stay."""
    problem = fitted.problem
    at = problem.nuisances + place
    step = 1e-5
    while step < 0.5:
        rises = []
        for sign in (-1.0, 1.0):
            moved = fitted.x.copy()
            moved[at] += sign * step
            white = noise.whiten(problem.residuals(problem.bounded(moved)))
            rises.append(float(white @ white - fitted.white @ fitted.white))
        if max(rises) > 1.0:
            break
        step *= 1.6
    return step
