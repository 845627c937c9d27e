"""A first look at every suspect: sizes over a grid, all other unknowns re-tuned to first order at each.

What is left of the whitened rows once all that the other unknowns can do has been projected out (variable projection; a
score test of finite steps). A trace that grows in proportion to its size is rated at the best share of each size.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted
from system_identification.noise import Whitener
from system_identification.suspects import Suspect

__all__ = ["DIVERGED", "UNMOVED", "Rated", "Trial", "rated", "standing_in", "tried"]

Array = NDArray[np.float64]
UNMOVED = 1e-12
"""Visibility of what changes nothing that is foreseen."""
_SMALLEST = 0.02
"""Share of a size tried down to which smaller ones are rated by it."""
_SAME = 0.05
"""Share of the energy of a trace, at its smallest size, beyond what parameters do, up to which it may do the same."""

DIVERGED = 1e12
"""Change of a prediction at which it is cut off."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Trial:
    """What a suspect changes of the predictions at each size of its grid, (G, R), the others as in `anchor`."""

    suspect: Suspect
    anchor: Fitted
    changes: NDArray[np.float32]


@dataclass(frozen=True, kw_only=True, eq=False)
class Rated:
    """A suspect at its best size.

    Attributes:
        suspect: which one.
        sizes: over their ranges' widths.
        gain: cost that it takes off, to first order.
        visibility: cost that the middle one of its sizes would take off, `UNMOVED` where it changes nothing.
        change: of the predictions, (R,).
        order: of the sizes of the grid, the best first.
    """

    suspect: Suspect
    sizes: Array
    gain: float
    visibility: float
    change: Array
    order: NDArray[np.int64]

    @property
    def promise(self) -> float:
        """Half the gain less what the choice of a size costs, nats."""
        return 0.5 * self.gain - 0.5 * float(np.log(max(self.gain, 1.0))) - self.suspect.price


def tried(anchor: Fitted, suspects: Sequence[Suspect], predicted: Callable[[Suspect], Array]) -> list[Trial]:
    """Return every suspect's trial; `predicted`: (G, R) predictions over its grid, beside the anchor's unknowns."""
    here = anchor.problem.predicted(anchor.x)

    def changes(each: Suspect) -> NDArray[np.float32]:
        # A prediction that diverges is a bad one, no reason to stop.
        change: Array = np.clip(np.nan_to_num(predicted(each) - here), -DIVERGED, DIVERGED)
        return change.astype(np.float32)

    return [Trial(suspect=each, anchor=anchor, changes=changes(each)) for each in suspects]


def rated(anchor: Fitted, noise: Whitener, trials: Sequence[Trial]) -> list[Rated]:
    """Return the suspects at their best sizes under a noise, the most promising first."""
    nuisances, prior = anchor.problem.nuisances, noise.prior(anchor.problem)
    jacobian = noise.whiten(anchor.sensitivities)
    white = noise.whiten(anchor.residuals)
    information = jacobian.T @ jacobian
    information[np.arange(nuisances), np.arange(nuisances)] += prior
    information += 1e-9 * np.eye(information.shape[0])
    pull = jacobian.T @ white
    pull[:nuisances] -= prior * anchor.x[:nuisances]
    moved = np.linalg.solve(information, pull)
    found = []
    for trial in trials:
        columns = noise.whiten(trial.changes.T.astype(np.float64))
        cross = jacobian.T @ columns
        power = np.sum(columns**2, axis=0) - np.sum(cross * np.linalg.solve(information, cross), axis=0)
        power = np.maximum(power, UNMOVED)
        slope = columns.T @ white - cross.T @ moved
        found.append(_at_its_best(trial, slope, power))
    return sorted(found, key=lambda each: -each.promise)


def _at_its_best(trial: Trial, slope: Array, power: Array) -> Rated:
    """Return a suspect at the share of a size of its grid that takes most off a cost with these derivatives, (G,) each:
    by share, 2 share slope - share^2 power."""
    share = np.clip(slope / power, _SMALLEST, 1.0) if trial.suspect.scalable else np.ones(power.size)
    gains = 2.0 * share * slope - share**2 * power
    best = int(np.argmax(gains))
    sizes = np.array(trial.suspect.grid[best], dtype=np.float64)
    sizes[0] *= share[best]
    return Rated(
        suspect=trial.suspect,
        sizes=sizes,
        gain=max(float(gains[best]), 0.0),
        visibility=float(np.median(power)),
        change=trial.changes[best].astype(np.float64) * share[best],
        order=np.argsort(-gains),
    )


def standing_in(anchor: Fitted, noise: Whitener, trials: Sequence[Trial]) -> list[Rated]:
    """Return suspects that do what parameters do, rated by how far these could go back to where they are stated to be.

    A look at the rows does not tell: parameters that go back by five deviations do not do so along their slopes, and
    what a trace leaves of a line is more than stated deviations say. So both are taken to go on as they begin.
    """
    nuisances, prior = anchor.problem.nuisances, noise.prior(anchor.problem)
    jacobian = noise.whiten(anchor.sensitivities)
    information = jacobian.T @ jacobian
    information[np.arange(nuisances), np.arange(nuisances)] += 1e-3 * prior
    information += 1e-9 * np.eye(information.shape[0])
    found = []
    for trial in trials:
        grid = trial.suspect.grid
        if not trial.suspect.scalable or not np.any(grid[:, 0]):
            continue
        least = int(np.argmin(np.where(grid[:, 0] == 0.0, np.inf, np.abs(grid[:, 0]))))
        trace = noise.whiten(trial.changes[least].astype(np.float64))
        shift = np.linalg.solve(information, jacobian.T @ trace)
        left = trace - jacobian @ shift
        if left @ left > _SAME * (trace @ trace):
            continue
        back = shift[:nuisances] * (grid[:, :1] / grid[least, 0])
        power = np.maximum(back**2 @ prior, 1e-12)
        found.append(_at_its_best(trial, back @ (prior * anchor.x[:nuisances]), power))
    return sorted(found, key=lambda each: -each.promise)
