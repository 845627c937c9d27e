"""A first look at every suspect: sizes over a grid, nuisances re-tuned to first order at each.

The cost of a trial is what is left of the whitened residuals once all that the nuisances can do, to first order
about the base fit, has been projected out (variable projection; a score test of finite steps).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.converter_steps import SPACING, TURN, likely_speed_steps, likely_steps
from gap_diagnosis.fitting import Fitted, fit, projector
from gap_diagnosis.noise import NoiseModel
from gap_diagnosis.prediction import acts_in_plant
from gap_diagnosis.problem import Problem
from gap_diagnosis.sensitivities import largest_speed
from gap_diagnosis.suspects import JAGGED, LIMIT, ROUNDED, SEARCHED, Suspect

__all__ = ["STRETCHED", "Screened", "Trials", "rated", "refined", "tried"]

Array = NDArray[np.float64]


STRETCHED = 3.5
"""Standard deviations from which on nuisances count as pulled off by an effect that is missing."""


_COARSE, _FINE = range(3), range(3, 7)
"""Rounds of the search for a size, each four times as fine as the one before: in screening, and before a fit."""
_SMALLEST_SHARE = 0.02  # of a size tried
_IMITABLE = 0.01  # share of a trace that parameters cannot make
_VISIBLE_AT = 0.35  # of the largest size, where it is asked whether an effect would be seen
_STEPS = 12  # of a coarse converter that are tried
_STEPS_OF = {SEARCHED: likely_steps, ROUNDED: likely_speed_steps}
# Shares of the largest command at which a limit is tried.
_BELOW = np.array([0.99, 0.975, 0.95, 0.9, 0.83, 0.75, 0.65, 0.55, 0.45, 0.36, 0.29, 0.2])


@dataclass(frozen=True, kw_only=True)
class Trials:
    """Predictions of a suspect over its grid, shape (G, R), the other unknowns as in the fit `anchor`."""

    suspect: Suspect
    problem: Problem
    anchor: Fitted
    predictions: NDArray[np.float32]


@dataclass(frozen=True, kw_only=True)
class Screened:
    """A suspect's best trial.

    Attributes:
        suspect, problem: what was tried.
        anchor: the fit about which it was.
        sizes: over their ranges' widths.
        gain: cost that it takes off.
        criterion: half the gain less what the choice of sizes costs.
        signature: change of the predictions there, shape (R,).
        visibility: cost that a third of the plausible size would take off in these recordings.
        own: share of the trace's energy that the anchor's unknowns, free of their priors, cannot make to first order.
    """

    suspect: Suspect
    problem: Problem
    anchor: Fitted
    sizes: Array
    gain: float
    criterion: float
    signature: Array
    visibility: float
    own: float

    @property
    def is_imitable(self) -> bool:
        """Tell whether parameters do by themselves what the effect does, if they may leave their deviations."""
        return self.own < _IMITABLE


def tried(base: Fitted, noise: NoiseModel, suspects: Sequence[Suspect]) -> list[Trials]:
    """Return the predictions of all suspects over their grids, from the unknowns of the base fit.

    Where the missing effect has pulled nuisances far off, also from nuisances as stated.
    """
    problem = base.problem
    anchors = [base]
    if np.max(np.abs(base.x[: problem.nuisances]), initial=0.0) > STRETCHED:
        anchors.append(fit(problem, noise, problem.start(base.x[problem.nuisances :]), iterations=0))
    trials = []
    for anchor in anchors:
        happened = problem.happened(anchor.x)
        for suspect in (_with_likely_sizes(each, anchor, noise) for each in suspects):
            posed = problem.with_effects((*problem.slots, *suspect.slots))
            known = None if acts_in_plant(suspect.effect) else happened
            rows = [posed.predicted(np.concatenate((anchor.x, sizes)), happened=known) for sizes in suspect.grid]
            predictions = np.array(rows, dtype=np.float32)
            trials.append(Trials(suspect=suspect, problem=posed, anchor=anchor, predictions=predictions))
    return trials


def _with_likely_sizes(suspect: Suspect, anchor: Fitted, noise: NoiseModel) -> Suspect:
    """Return a coarse converter with the steps that are worth a trial, a limit below the commands; others as are."""
    if suspect.effect == LIMIT:
        (slot,) = suspect.slots
        largest = max(float(np.max(np.abs(each.experiment.throttle))) for each in anchor.problem.recordings)
        limits = largest * _BELOW[largest * _BELOW >= slot.lower]
        return replace(suspect, grid=limits[:, None] / slot.width) if limits.size else suspect
    if suspect.effect not in _STEPS_OF:
        return suspect
    (slot,) = suspect.slots
    steps = _STEPS_OF[suspect.effect](anchor, noise, slot.upper, _STEPS)
    likely = np.append(steps, _VISIBLE_AT * slot.upper)
    return replace(suspect, grid=likely[:, None] / slot.width) if steps.size else suspect


class _View:
    """What the unknowns of an anchor can do to the whitened residuals, under one noise model."""

    def __init__(self, anchor: Fitted, noise: NoiseModel) -> None:
        self.anchor, self.noise, self.problem = anchor, noise, anchor.problem
        self.jacobian = self.problem.whitened(noise, anchor.sensitivities)
        self.basis = projector(self.jacobian, self.problem.nuisances)
        self.prediction = self.problem.predicted(anchor.x)

    @cached_property
    def _span(self) -> Array:
        """An orthonormal basis (R, K) of what the unknowns can do, free of their priors."""
        return np.asarray(np.linalg.qr(self.jacobian)[0])

    def cost(self, predictions: Array) -> Array:
        """Return the cost (G,) of predictions (G, R) once the anchor's unknowns are re-tuned to first order."""
        white = self.problem.whitened(self.noise, self.problem.measured[:, None] - predictions.T)
        prior = np.repeat(-self.anchor.x[: self.problem.nuisances, None], white.shape[1], axis=1)
        return self._left(np.vstack((white, prior)))

    def scaled_cost(self, predictions: Array, scalable: bool) -> tuple[Array, Array]:
        """Return costs (G,) of predictions (G, R) and of which share (G,) of their change from the anchor's own.

        Where the change grows in proportion to the size (`scalable`), smaller sizes than those tried are rated too: a
        small effect costs more at a large size than at none.
        """
        whole, ones = self.cost(predictions), np.ones(predictions.shape[0])
        if not scalable:
            return whole, ones
        none = float(self.cost(self.prediction[None, :])[0])
        power = np.array([self.visibility(prediction) for prediction in predictions])
        slope = 0.5 * (none + power - whole)  # of the residuals along the change
        share = np.clip(slope / np.maximum(power, 1e-12), _SMALLEST_SHARE, 1.0)
        return none - 2.0 * share * slope + share**2 * power, share

    def visibility(self, prediction: Array) -> float:
        """Return the cost of a change (R,) of the anchor's own prediction."""
        none = np.zeros(self.problem.nuisances)
        return float(self._left(np.concatenate((self._change(prediction), none))[:, None])[0])

    def own_share(self, prediction: Array) -> float:
        """Return which share of the energy of a change (R,) the unknowns, free of their priors, cannot make."""
        change = self._change(prediction)
        return 1.0 - float(np.sum((self._span.T @ change) ** 2)) / max(float(change @ change), 1e-12)

    def _change(self, prediction: Array) -> Array:
        """Return the change (R,) from the anchor's own prediction, whitened."""
        return self.problem.whitened(self.noise, np.where(self.problem.known, prediction - self.prediction, np.nan))

    def _left(self, stacked: Array) -> Array:
        return np.asarray(np.sum(stacked**2, axis=0) - np.sum((self.basis.T @ stacked) ** 2, axis=0))


def rated(base: Fitted, noise: NoiseModel, trials: Sequence[Trials]) -> list[Screened]:
    """Return every suspect's best trial, the most promising one first."""
    white = base.problem.whitened(noise, base.residuals)
    nuisances = base.x[: base.problem.nuisances]
    reference = float(white @ white + nuisances @ nuisances)
    views: dict[int, _View] = {}
    best: dict[str, Screened] = {}
    for each in trials:
        if id(each.anchor) not in views:
            views[id(each.anchor)] = _View(each.anchor, noise)
        view = views[id(each.anchor)]
        costs, shares = view.scaled_cost(each.predictions.astype(np.float64), _scalable(each.suspect))
        k = int(np.argmin(costs))
        gain = reference - float(costs[k])
        sizes = each.suspect.grid[k].copy()
        sizes[0] *= shares[k]
        found = Screened(
            suspect=each.suspect,
            problem=each.problem,
            anchor=each.anchor,
            sizes=sizes,
            gain=gain,
            criterion=0.5 * gain - 0.5 * len(each.suspect.slots) * np.log(max(gain, 1.0)),
            signature=shares[k] * np.nan_to_num(each.predictions[k] - view.prediction),
            visibility=view.visibility(each.predictions[_middle(each.suspect)]),
            own=view.own_share(each.predictions[_middle(each.suspect)]),
        )
        found = _searched(view, reference, found)
        if each.suspect.key not in best or gain > best[each.suspect.key].gain:
            best[each.suspect.key] = found
    return sorted(best.values(), key=lambda s: -s.criterion)


def _scalable(suspect: Suspect) -> bool:
    """Tell whether the trace of an effect grows in proportion to its first size, from nothing at zero."""
    first = suspect.slots[0]
    return first.lower <= 0.0 <= first.upper and suspect.effect not in JAGGED


def refined(screened: Screened, noise: NoiseModel) -> Screened:
    """Return a suspect whose predictions jump with its size at a size known to a hundred-thousandth; others as is."""
    if screened.suspect.effect not in JAGGED or screened.gain < 10.0:
        return screened
    view = _View(screened.anchor, noise)
    own = float(view.cost(screened.problem.predicted(np.concatenate((screened.anchor.x, screened.sizes)))[None, :])[0])
    return _searched(view, own + screened.gain, screened, rounds=_FINE)


def _searched(view: _View, reference: float, screened: Screened, rounds: range = _COARSE) -> Screened:
    """Return a suspect whose predictions jump with its size at the best of ever finer sizes; others as they are."""
    suspect, problem = screened.suspect, screened.problem
    if suspect.effect not in JAGGED or screened.gain < 10.0:
        return screened
    best, gain, signature = screened.sizes, screened.gain, screened.signature
    if suspect.effect == SEARCHED:
        spacing = SPACING * float(best[0]) * suspect.slots[0].width
    elif suspect.effect in _STEPS_OF:
        spacing = TURN * float(best[0]) * suspect.slots[0].width / largest_speed(view.problem, view.prediction)
    else:
        trials = np.sort(np.log(suspect.grid[:, 0]))
        place = min(max(int(np.searchsorted(trials, np.log(best[0]))), 1), trials.size - 1)
        spacing = float(trials[place] - trials[place - 1])
    spacing *= 0.25**rounds.start
    for _ in rounds:
        around = best * np.exp(spacing * np.linspace(-1.0, 1.0, 9))[:, None]
        for sizes in around[around[:, 0] <= suspect.slots[0].upper / suspect.slots[0].width]:
            rows = problem.predicted(np.concatenate((view.anchor.x, sizes)))
            gained = reference - float(view.cost(rows[None, :])[0])
            if gained > gain:
                best, gain, signature = sizes, gained, np.nan_to_num(rows - view.prediction)
        spacing *= 0.25
    criterion = screened.criterion + 0.5 * (gain - screened.gain)
    return replace(screened, sizes=best, gain=gain, criterion=criterion, signature=signature)


def _middle(suspect: Suspect) -> int:
    """Return the trial nearest to a third of the largest size."""
    if len(suspect.slots) > 1:
        return len(suspect.grid) // 2
    largest = suspect.slots[0].upper / suspect.slots[0].width
    return int(np.argmin(np.abs(suspect.grid[:, 0] - _VISIBLE_AT * largest)))
